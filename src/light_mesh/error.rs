//! Reasons why light meshes cannot compute a scene.

use thiserror::Error;

use crate::scene::{Quantity, Scene};

/// A part of a scene that light meshes cannot compute.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("--method light-mesh cannot compute {what}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}")]
pub struct NotForLightMesh {
    /// Description of what it cannot compute.
    pub what: String,
    /// What the scene contains.
    pub got: String,
    /// What light meshes accept.
    pub expected: String,
    /// Other methods or options that solve the problem.
    pub remedy: String,
}

/// Checks whether light meshes can compute some receiver sets of a scene, given by their indices, and its elements.
///
/// # Errors
/// Scene parts that they cannot compute: skies, bodies of spherical harmonics, illuminance on cylinders, glare ratings and intensities.
pub fn check(scene: &Scene, sets: impl Iterator<Item = usize>) -> Result<(), NotForLightMesh> {
    if let Some(sky) = scene.luminaires.iter().find(|luminaire| luminaire.emission.is_daylight()) {
        return Err(NotForLightMesh {
            what: "the light of sky and sun".to_owned(),
            got: format!("luminaire \"{}\"", sky.name),
            expected: "luminaires with a position".to_owned(),
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
