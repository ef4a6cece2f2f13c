//! Reads luminaires that are skies.

use std::sync::Arc;

use glam::DVec3;

use super::error::SceneError;
use super::model::{DaylightTargets, Emission, Luminaire, Quantity, ReceiverSet};
use super::openings::Openings;
use super::reader::{Fields, Node};
use crate::base::sky::{Sky, SkyPattern};

/// Keys of a sky alone.
pub(super) const KEYS: [&str; 7] = [
    "luminance_distribution",
    "sun_elevation_deg",
    "sun_azimuth_deg",
    "zenith_luminance_cd_m2",
    "horizontal_illuminance_lx",
    "ground_reflectance",
    "median_diffuse_illuminance_lx",
];

/// Values of `luminance_distribution`; the general skies follow the first two.
pub(super) const DISTRIBUTIONS: [&str; 17] = [
    "uniform", "overcast", "CIE 1", "CIE 2", "CIE 3", "CIE 4", "CIE 5", "CIE 6", "CIE 7", "CIE 8", "CIE 9", "CIE 10",
    "CIE 11", "CIE 12", "CIE 13", "CIE 14", "CIE 15",
];

/// Median diffuse horizontal illuminance in lx of a site that is not told: about that of London or Berlin.
const MEDIAN_DIFFUSE_LX: f64 = 15_000.0;

/// Reads a sky; openings and flux are found when the whole scene is known.
pub(super) fn read(fields: &Fields, maintained: f64) -> Result<(f64, Emission), SceneError> {
    let distribution = fields.need("luminance_distribution", "\"overcast\"")?.choice(&DISTRIBUTIONS)?;
    let pattern = match distribution {
        0 | 1 => {
            for key in ["sun_elevation_deg", "sun_azimuth_deg"] {
                if let Some(node) = fields.get(key) {
                    let expected = "a sun where the sky has one: \"CIE 1\" to \"CIE 15\"";
                    return Err(node.refuse("this sky has no sun", expected, "leave the key out"));
                }
            }
            [SkyPattern::Uniform, SkyPattern::Overcast][distribution]
        }
        kind => SkyPattern::general(kind - 1, sun(fields)?),
    };
    let ground_reflectance =
        fields.get("ground_reflectance").map_or(Ok(0.0), |node| node.fraction("the ground's reflectance"))?;
    let (which, node) = fields.one_of(["zenith_luminance_cd_m2", "horizontal_illuminance_lx"])?;
    let given = maintained * node.at_least_zero(["the zenith's luminance", "the horizontal illuminance"][which])?;
    let sky = match which {
        0 => Sky::of_zenith(pattern, given, ground_reflectance),
        _ => Sky::of_horizontal(pattern, given, ground_reflectance),
    };
    let site = fields.get("median_diffuse_illuminance_lx");
    let median_lx = site.map_or(Ok(MEDIAN_DIFFUSE_LX), |node| node.above_zero("the median diffuse illuminance"))?;
    let targets = DaylightTargets::of_site(median_lx);
    // The luminous flux that is read stands for whether there is any.
    let (horizontal_lx, openings) = (sky.horizontal_lx(), Arc::new(Openings::default()));
    Ok((horizontal_lx, Emission::Sky { sky: Arc::new(sky), openings, targets }))
}

/// Unit direction of the sun: its azimuth counts from +y (north) towards +x (east).
fn sun(fields: &Fields) -> Result<DVec3, SceneError> {
    let node = fields.need("sun_elevation_deg", "35")?;
    let elevation_deg = node.number()?;
    if !(0.0..=90.0).contains(&elevation_deg) {
        return Err(node.refuse(
            "the sun of a sky stands above the horizon",
            "0 to 90 degrees",
            "at night choose another sky, or leave it out",
        ));
    }
    let azimuth_deg = fields.get("sun_azimuth_deg").map_or(Ok(180.0), |node| node.number())?;
    let ((height, flat), (east, north)) = (elevation_deg.to_radians().sin_cos(), azimuth_deg.to_radians().sin_cos());
    Ok(DVec3::new(flat * east, flat * north, height))
}

/// Refuses a second sky.
pub(super) fn only_one(node: &Node, luminaires: &[Luminaire]) -> Result<(), SceneError> {
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

/// Refuses glare ratings in a scene with a sky: the unified glare rating is not made for windows.
pub(super) fn refuse_glare(root: &Node, luminaires: &[Luminaire], receivers: &[ReceiverSet]) -> Result<(), SceneError> {
    let has_sky = luminaires.iter().any(|luminaire| matches!(luminaire.emission, Emission::Sky { .. }));
    let rated = receivers.iter().find(|set| matches!(set.quantity, Quantity::Glare(_)));
    if let Some(set) = receivers.iter().find(|set| has_sky && set.is_far_field()) {
        return Err(root.refuse_as(
            "the light of a sky comes from afar and has no far-field intensity",
            format!("receivers {:?} in a scene with a sky", set.name),
            "receivers of type \"intensity\" in scenes without a sky",
            "ask for the intensities of a luminaire in a scene of its own",
        ));
    }
    match rated.filter(|_| has_sky) {
        Some(set) => Err(root.refuse_as(
            "the unified glare rating is for electric light",
            format!("receivers {:?} in a scene with a sky", set.name),
            "glare ratings in scenes without a sky",
            "rate glare in a scene of its own, without the sky",
        )),
        None => Ok(()),
    }
}
