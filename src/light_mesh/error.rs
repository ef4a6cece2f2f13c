//! Why a scene is not for light meshes.

use thiserror::Error;

use crate::scene::{Quantity, ReflectionLaw, Scene};

/// What of a scene light meshes cannot compute.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "--method light-mesh cannot compute {what}\n  got:      {got}\n  expected: {expected}\n  remedy:   use --method collision, which computes every scene"
)]
pub struct NotForLightMesh {
    /// What it cannot compute, in words.
    pub what: String,
    /// What stands there.
    pub got: String,
    /// What it takes.
    pub expected: String,
}

/// Whether light meshes can compute some receiver sets of a scene, by their numbers, and its elements.
///
/// # Errors
/// What they cannot: mirrors and glass, which pass light on unscattered, and receivers that are no planes.
pub fn check(scene: &Scene, sets: impl Iterator<Item = usize>) -> Result<(), NotForLightMesh> {
    for surface in &scene.surfaces {
        let material = &scene.materials[surface.material as usize];
        if matches!(material.law, ReflectionLaw::Mirror { .. } | ReflectionLaw::Glass { .. }) {
            return Err(NotForLightMesh {
                what: "mirrors and glass: a mesh point knows luminaires in plain sight".to_owned(),
                got: format!("surface \"{}\" of material \"{}\"", surface.name, material.name),
                expected: "surfaces that scatter: diffuse, phong or translucent".to_owned(),
            });
        }
    }
    for set in sets {
        let set = &scene.receivers[set];
        if set.quantity != Quantity::Perpendicular {
            return Err(NotForLightMesh {
                what: "illuminance on cylinders".to_owned(),
                got: format!("receivers \"{}\", {}", set.name, set.quantity.name()),
                expected: "receivers that are planes".to_owned(),
            });
        }
    }
    Ok(())
}
