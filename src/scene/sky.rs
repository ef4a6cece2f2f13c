//! Reads luminaires that are skies.

use std::sync::Arc;

use glam::DVec3;

use super::error::SceneError;
use super::model::{DaylightTargets, Emission, Luminaire, Quantity, ReceiverSet};
use super::openings::Openings;
use super::reader::{Fields, Node};
use super::sun;
use crate::base::perez::SkyClass;
use crate::base::sky::{Sky, SkyPattern};

/// Keys of a sky alone.
pub(super) const KEYS: [&str; 12] = [
    "luminance_distribution",
    "sun_elevation_deg",
    "sun_azimuth_deg",
    "latitude_deg",
    "longitude_deg",
    "date_time",
    "zenith_luminance_cd_m2",
    "horizontal_illuminance_lx",
    "direct_normal_illuminance_lx",
    "diffuse_horizontal_illuminance_lx",
    "ground_reflectance",
    "median_diffuse_illuminance_lx",
];

/// Values of `luminance_distribution`; the general skies follow the first two, the all-weather sky comes last.
pub(super) const DISTRIBUTIONS: [&str; 18] = [
    "uniform", "overcast", "CIE 1", "CIE 2", "CIE 3", "CIE 4", "CIE 5", "CIE 6", "CIE 7", "CIE 8", "CIE 9", "CIE 10",
    "CIE 11", "CIE 12", "CIE 13", "CIE 14", "CIE 15", "Perez",
];

/// Median diffuse horizontal illuminance in lx of a site that is not told: about that of London or Berlin.
const MEDIAN_DIFFUSE_LX: f64 = 15_000.0;

/// Reads a sky; openings and flux are found when the whole scene is known.
pub(super) fn read(fields: &Fields, maintained: f64) -> Result<(f64, Emission), SceneError> {
    let distribution = fields.need("luminance_distribution", "\"overcast\"")?.choice(&DISTRIBUTIONS)?;
    let is_all_weather = DISTRIBUTIONS[distribution] == "Perez";
    let of_others: &[&str] =
        if is_all_weather { &["zenith_luminance_cd_m2", "horizontal_illuminance_lx"] } else { &PEREZ_KEYS };
    if let Some(node) = of_others.iter().find_map(|key| fields.get(key)) {
        let expected = if is_all_weather { PEREZ_KEYS.join(" and ") } else { "a \"Perez\" sky".to_owned() };
        return Err(node.refuse("this key is of other skies", expected, "leave the key out"));
    }
    let ground_reflectance =
        fields.get("ground_reflectance").map_or(Ok(0.0), |node| node.fraction("the ground's reflectance"))?;
    let sky = if is_all_weather {
        all_weather(fields, maintained, ground_reflectance)?
    } else {
        let pattern = pattern(fields, distribution)?;
        let (which, node) = fields.one_of(["zenith_luminance_cd_m2", "horizontal_illuminance_lx"])?;
        let given = maintained * node.at_least_zero(["the zenith's luminance", "the horizontal illuminance"][which])?;
        match which {
            0 => Sky::of_zenith(pattern, given, ground_reflectance),
            _ => Sky::of_horizontal(pattern, given, ground_reflectance),
        }
    };
    let site = fields.get("median_diffuse_illuminance_lx");
    let median_lx = site.map_or(Ok(MEDIAN_DIFFUSE_LX), |node| node.above_zero("the median diffuse illuminance"))?;
    let targets = DaylightTargets::of_site(median_lx);
    // The luminous flux that is read stands for whether there is any.
    let (horizontal_lx, openings) = (sky.horizontal_lx(), Arc::new(Openings::default()));
    Ok((horizontal_lx, Emission::Sky { sky: Arc::new(sky), openings, targets }))
}

/// Keys of the all-weather sky alone.
const PEREZ_KEYS: [&str; 2] = ["direct_normal_illuminance_lx", "diffuse_horizontal_illuminance_lx"];

/// How a sky's luminance is spread by its number among [`DISTRIBUTIONS`], the all-weather sky's left out.
fn pattern(fields: &Fields, distribution: usize) -> Result<SkyPattern, SceneError> {
    if distribution > 1 {
        return Ok(SkyPattern::general(distribution - 1, sun_above(fields)?));
    }
    for key in sun::POSITION_KEYS {
        if let Some(node) = fields.get(key) {
            let expected = "a sun where the sky has one: \"CIE 1\" to \"CIE 15\" and \"Perez\"";
            return Err(node.refuse("this sky has no sun", expected, "leave the key out"));
        }
    }
    Ok([SkyPattern::Uniform, SkyPattern::Overcast][distribution])
}

/// The all-weather sky by what comes from the sun, which is not in it, and from the sky.
fn all_weather(fields: &Fields, maintained: f64, ground_reflectance: f64) -> Result<Sky, SceneError> {
    let sun = sun_above(fields)?;
    let direct_node = fields.need(PEREZ_KEYS[0], "60000")?;
    let direct_lx = direct_node.at_least_zero("the direct normal illuminance")?;
    let diffuse_lx = fields.need(PEREZ_KEYS[1], "18000")?.above_zero("the diffuse horizontal illuminance")?;
    let class = SkyClass::of_illuminance(sun.z.clamp(0.0, 1.0).asin().to_degrees(), direct_lx, diffuse_lx);
    let Some(pattern) = SkyPattern::all_weather(&class, sun) else {
        return Err(direct_node.refuse(
            "the all-weather sky has no light in the zenith for this sun",
            "illuminances that belong together",
            "check both illuminances and where the sun stands",
        ));
    };
    Ok(Sky::of_horizontal(pattern, maintained * diffuse_lx, ground_reflectance))
}

/// Unit direction of a sky's sun, which stands above the horizon.
fn sun_above(fields: &Fields) -> Result<DVec3, SceneError> {
    let towards = sun::direction(fields)?;
    if towards.z < 0.0 {
        let node = ["sun_elevation_deg", "date_time"].iter().find_map(|key| fields.get(key));
        let elevation_deg = towards.z.asin().to_degrees();
        return Err(node.unwrap_or_else(|| fields.node().clone()).refuse_as(
            "the sun of a sky stands above the horizon",
            format!("a sun at {elevation_deg:.2} degrees"),
            "0 to 90 degrees",
            "at night choose another sky, or leave it out",
        ));
    }
    Ok(towards)
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
    let has_sky = luminaires.iter().any(|luminaire| luminaire.emission.is_daylight());
    let rated = receivers.iter().find(|set| matches!(set.quantity, Quantity::Glare(_)));
    if let Some(set) = receivers.iter().find(|set| has_sky && set.is_far_field()) {
        return Err(root.refuse_as(
            "the light of sky and sun comes from afar and has no far-field intensity",
            format!("receivers {:?} in a scene with daylight", set.name),
            "receivers of type \"intensity\" in scenes without sky and sun",
            "ask for the intensities of a luminaire in a scene of its own",
        ));
    }
    match rated.filter(|_| has_sky) {
        Some(set) => Err(root.refuse_as(
            "the unified glare rating is for electric light",
            format!("receivers {:?} in a scene with daylight", set.name),
            "glare ratings in scenes without sky and sun",
            "rate glare in a scene of its own, without sky and sun",
        )),
        None => Ok(()),
    }
}
