//! Why a scene is not for light meshes.

use thiserror::Error;

use crate::scene::{Quantity, Scene};

/// What of a scene light meshes cannot compute.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("--method light-mesh cannot compute {what}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}")]
pub struct NotForLightMesh {
    /// What it cannot compute, in words.
    pub what: String,
    /// What stands there.
    pub got: String,
    /// What it takes.
    pub expected: String,
    /// Which method can.
    pub remedy: String,
}

/// Whether light meshes can compute some receiver sets of a scene, by their numbers, and its elements.
///
/// # Errors
/// What they cannot: skies, bodies of spherical harmonics, illuminance on cylinders, glare ratings and intensities.
pub fn check(scene: &Scene, sets: impl Iterator<Item = usize>) -> Result<(), NotForLightMesh> {
    if let Some(sky) = scene.luminaires.iter().find(|luminaire| luminaire.emission.is_daylight()) {
        return Err(NotForLightMesh {
            what: "the light of sky and sun".to_owned(),
            got: format!("luminaire \"{}\"", sky.name),
            expected: "luminaires that stand somewhere".to_owned(),
            remedy: "use --method auto, gather or collision".to_owned(),
        });
    }
    if let Some(body) = scene.bodies.first() {
        return Err(NotForLightMesh {
            what: "scenes with bodies of spherical harmonics".to_owned(),
            got: format!("geometry \"{}\"", scene.surface_of(body.triangles.start).geometry),
            expected: "boxes, rectangles, meshes and spheres".to_owned(),
            remedy: "use --method auto, gather, local or collision".to_owned(),
        });
    }
    for set in sets {
        let set = &scene.receivers[set];
        let got = format!("receivers \"{}\", {}", set.name, set.quantity.name());
        match set.quantity {
            quantity if quantity.has_one_hemisphere() => {}
            Quantity::Luminance => {}
            Quantity::Glare(_) => {
                return Err(NotForLightMesh {
                    what: "glare ratings".to_owned(),
                    got,
                    expected: "receivers that are planes, or luminance".to_owned(),
                    remedy: "use --method collision, which rates glare, or leave them out with --maps".to_owned(),
                });
            }
            Quantity::Intensity { .. } => {
                return Err(NotForLightMesh {
                    what: "intensities of the far field".to_owned(),
                    got,
                    expected: "receivers that are planes, or luminance".to_owned(),
                    remedy:
                        "use --method collision, which follows light out of the scene, or leave them out with --maps"
                            .to_owned(),
                });
            }
            _ => {
                return Err(NotForLightMesh {
                    what: "illuminance on cylinders and other bodies".to_owned(),
                    got,
                    expected: "receivers that are planes, or luminance".to_owned(),
                    remedy: "use --method collision, which computes every scene, or leave them out with --maps"
                        .to_owned(),
                });
            }
        }
    }
    Ok(())
}
