//! Reads luminaires that are skies.

use glam::DVec3;

use super::error::SceneError;
use super::keys::{ABOVE_ZERO, FROM_ZERO, Form, NUMBER, SHARE, ValueShape, form, from_to, needed, optional};
use super::luminaire_reading::COMMON;
use super::reader::Fields;
use super::sun;
use crate::base::perez::SkyClass;
use crate::base::sky::{Sky, SkyPattern};

/// A sky.
#[rustfmt::skip]
pub(super) const FORM: Form = form("sky",
    "The sky, and the ground below the horizon; either `zenith_luminance_cd_m2` or `horizontal_illuminance_lx`, but neither for Perez's sky.",
    &[COMMON, &[
    needed("luminance_distribution", ValueShape::Choice(&DISTRIBUTIONS), "\"overcast\"",
        "Uniform, the traditional overcast sky, one of the general skies of ISO 15469, or the all-weather sky of Perez."),
    optional("sun_elevation_deg", from_to(0.0, 90.0), "Elevation of the sun in degrees, for skies that depend on it.").such_as("35"),
    optional("sun_azimuth_deg", NUMBER, "Azimuth of the sun in degrees, from +y (north) towards +x (east); 180 by default."),
], sun::PLACE_AND_TIME, &[
    optional("zenith_luminance_cd_m2", FROM_ZERO, "Luminance of the zenith in cd/m²."),
    optional("horizontal_illuminance_lx", FROM_ZERO, "Horizontal illuminance in lx on an open plane from the sky alone."),
    optional(PEREZ_KEYS[0], FROM_ZERO,
        "Direct normal illuminance in lx, for Perez's sky; the sun itself is not part of that sky.").such_as("60000"),
    optional(PEREZ_KEYS[1], ABOVE_ZERO,
        "Diffuse horizontal illuminance in lx on an open plane from the sky alone, for Perez's sky.").such_as("18000"),
    optional("ground_reflectance", SHARE, "Reflectance of the ground, which fills everything below the horizon; 0 by default."),
    optional("median_diffuse_illuminance_lx", ABOVE_ZERO,
        "Median diffuse horizontal illuminance of the site in lx, for the daylight factors that EN 17037 requires; 15,000 by default."),
]]).either(&[&["zenith_luminance_cd_m2"], &["horizontal_illuminance_lx"], &PEREZ_KEYS]);

/// Values of `luminance_distribution`. The general skies follow the first two; the all-weather sky is last.
const DISTRIBUTIONS: [&str; 18] = [
    "uniform", "overcast", "CIE 1", "CIE 2", "CIE 3", "CIE 4", "CIE 5", "CIE 6", "CIE 7", "CIE 8", "CIE 9", "CIE 10",
    "CIE 11", "CIE 12", "CIE 13", "CIE 14", "CIE 15", "Perez",
];

/// Default median diffuse horizontal illuminance of a site in lx: about that of London or Berlin.
const MEDIAN_DIFFUSE_LX: f64 = 15_000.0;

/// Daylight factors that EN 17037 requires in spaces with daylight openings in walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DaylightTargets {
    /// D_T in %. It gives 300 lx for half of the daylight hours.
    pub target_percent: f64,
    /// D_TM in %. It gives 100 lx for half of the daylight hours.
    pub minimum_percent: f64,
}

impl DaylightTargets {
    /// Targets of a site, from its median diffuse horizontal illuminance in lx.
    pub fn of_site(median_diffuse_lx: f64) -> DaylightTargets {
        let percent = |inside_lx: f64| 100.0 * inside_lx / median_diffuse_lx;
        DaylightTargets { target_percent: percent(300.0), minimum_percent: percent(100.0) }
    }
}

/// Reads a sky. Openings and flux follow once the whole scene is read.
pub(super) fn read(fields: &Fields, maintained: f64) -> Result<(f64, Sky, DaylightTargets), SceneError> {
    let distribution = fields.need("luminance_distribution")?.choice()?;
    let is_all_weather = DISTRIBUTIONS[distribution] == "Perez";
    let of_others: &[&str] =
        if is_all_weather { &["zenith_luminance_cd_m2", "horizontal_illuminance_lx"] } else { &PEREZ_KEYS };
    if let Some(node) = of_others.iter().find_map(|key| fields.get(key)) {
        let expected = if is_all_weather { PEREZ_KEYS.join(" and ") } else { "a \"Perez\" sky".to_owned() };
        return Err(node.refuse("this key belongs to other skies", expected, "leave the key out"));
    }
    let ground_reflectance =
        fields.get("ground_reflectance").map_or(Ok(0.0), |node| node.amount("the ground's reflectance"))?;
    let sky = if is_all_weather {
        all_weather(fields, maintained, ground_reflectance)?
    } else {
        let pattern = pattern(fields, distribution)?;
        let (which, node) = fields.one_of(["zenith_luminance_cd_m2", "horizontal_illuminance_lx"])?;
        let given = maintained * node.amount(["the zenith's luminance", "the horizontal illuminance"][which])?;
        match which {
            0 => Sky::of_zenith(pattern, given, ground_reflectance),
            _ => Sky::of_horizontal(pattern, given, ground_reflectance),
        }
    };
    let site = fields.get("median_diffuse_illuminance_lx");
    let median_lx = site.map_or(Ok(MEDIAN_DIFFUSE_LX), |node| node.amount("the median diffuse illuminance"))?;
    let targets = DaylightTargets::of_site(median_lx);
    // The returned luminous flux is a placeholder: it only shows whether there is light.
    Ok((sky.horizontal_lx(), sky, targets))
}

/// Keys that only the all-weather sky has.
const PEREZ_KEYS: [&str; 2] = ["direct_normal_illuminance_lx", "diffuse_horizontal_illuminance_lx"];

/// Luminance pattern of a sky. `distribution` is its index in [`DISTRIBUTIONS`]; the all-weather sky is excluded.
fn pattern(fields: &Fields, distribution: usize) -> Result<SkyPattern, SceneError> {
    if distribution > 1 {
        return Ok(SkyPattern::general(distribution - 1, sun_above(fields)?));
    }
    for key in sun::POSITION_KEYS {
        if let Some(node) = fields.get(key) {
            let expected = "a sun's position only where the sky depends on it: \"CIE 1\" to \"CIE 15\" and \"Perez\"";
            return Err(node.refuse("this sky does not depend on the sun", expected, "leave the key out"));
        }
    }
    Ok([SkyPattern::Uniform, SkyPattern::Overcast][distribution])
}

/// The all-weather sky, from the illuminance by the sun (which is not part of it) and by the sky.
fn all_weather(fields: &Fields, maintained: f64, ground_reflectance: f64) -> Result<Sky, SceneError> {
    let sun = sun_above(fields)?;
    let direct_node = fields.need(PEREZ_KEYS[0])?;
    let direct_lx = direct_node.amount("the direct normal illuminance")?;
    let diffuse_lx = fields.need(PEREZ_KEYS[1])?.amount("the diffuse horizontal illuminance")?;
    let class = SkyClass::of_illuminance(sun.z.clamp(0.0, 1.0).asin().to_degrees(), direct_lx, diffuse_lx);
    let Some(pattern) = SkyPattern::all_weather(&class, sun) else {
        return Err(direct_node.refuse(
            "the all-weather sky has no light in the zenith for this sun",
            "illuminances that belong together",
            "check both illuminances and the sun's position",
        ));
    };
    Ok(Sky::of_horizontal(pattern, maintained * diffuse_lx, ground_reflectance))
}

/// Unit direction of a sky's sun. It must be above the horizon.
fn sun_above(fields: &Fields) -> Result<DVec3, SceneError> {
    let towards = sun::direction(fields)?;
    if towards.z < 0.0 {
        let node = ["sun_elevation_deg", "date_time"].iter().find_map(|key| fields.get(key));
        let elevation_deg = towards.z.asin().to_degrees();
        return Err(node.unwrap_or_else(|| fields.node().clone()).refuse_as(
            "the sun of a sky must be above the horizon",
            format!("a sun at {elevation_deg:.2} degrees"),
            "0 to 90 degrees",
            "at night choose another sky, or leave it out",
        ));
    }
    Ok(towards)
}
