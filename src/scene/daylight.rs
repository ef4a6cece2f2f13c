//! Checks for what a scene with a sky or a sun must not have.

use super::emission::Emission;
use super::error::SceneError;
use super::model::{Luminaire, ReceiverSet};
use super::quantity::Quantity;
use super::reader::Node;

/// Refuses a second sky and a second sun.
pub(super) fn only_one_each(node: &Node, luminaires: &[Luminaire]) -> Result<(), SceneError> {
    only_one_sky(node, luminaires)?;
    only_one_sun(node, luminaires)
}

fn only_one_sky(node: &Node, luminaires: &[Luminaire]) -> Result<(), SceneError> {
    let is_sky = |luminaire: &&Luminaire| matches!(luminaire.emission, Emission::Sky { .. });
    let skies = luminaires.iter().filter(is_sky).count();
    if skies > 1 {
        return Err(node.refuse_as(
            "the scene has more than one sky",
            format!("{skies} luminaires of type \"sky\""),
            "one, or none",
            "keep one of them",
        ));
    }
    Ok(())
}

fn only_one_sun(node: &Node, luminaires: &[Luminaire]) -> Result<(), SceneError> {
    let suns = luminaires.iter().filter(|luminaire| matches!(luminaire.emission, Emission::Sun { .. })).count();
    if suns > 1 {
        return Err(node.refuse_as(
            "the scene has more than one sun",
            format!("{suns} luminaires of type \"sun\""),
            "one, or none",
            "keep one of them",
        ));
    }
    Ok(())
}

/// Refuses glare ratings in a scene with daylight: the unified glare rating is not made for windows.
pub(super) fn refuse_glare(root: &Node, luminaires: &[Luminaire], receivers: &[ReceiverSet]) -> Result<(), SceneError> {
    let has_sky = luminaires.iter().any(|luminaire| luminaire.emission.is_daylight());
    let rated = receivers.iter().find(|set| matches!(set.quantity, Quantity::Glare(_)));
    if let Some(set) = receivers.iter().find(|set| has_sky && set.is_far_field()) {
        return Err(root.refuse_as(
            "sky and sun are infinitely far away and have no far-field intensity",
            format!("receivers {:?} in a scene with daylight", set.name),
            "receivers of type \"intensity\" in scenes without sky and sun",
            "compute the intensities of a luminaire in a separate scene",
        ));
    }
    match rated.filter(|_| has_sky) {
        Some(set) => Err(root.refuse_as(
            "the unified glare rating is for electric light",
            format!("receivers {:?} in a scene with daylight", set.name),
            "glare ratings in scenes without sky and sun",
            "rate glare in a separate scene, without sky and sun",
        )),
        None => Ok(()),
    }
}
