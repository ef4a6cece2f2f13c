//! The hours of a year: position and illuminance of the sun, and the luminance of each sky patch and the ground.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::sun_nodes::SunNodes;
use crate::base::perez::SkyClass;
use crate::base::sky::SkyPattern;
use crate::base::sky_patches::SkyPatches;
use crate::base::solar_position::{Moment, direction_of, solar_position_deg};
use crate::base::sun::Sun;
use crate::estimators::sunlight::Suns;
use crate::scene::{Weather, WeatherHour, WeatherLight};

/// The calendar year from which the sun's position is computed. It is midway between leap years, which suits weather averaged over
/// many years.
pub(super) const YEAR: i32 = 2026;
/// Number of parts across a patch to average its luminance, divided by the subdivision: finer patches need fewer.
const PARTS_ACROSS: u32 = 4;

/// An hour with light.
#[derive(Clone, Copy, Debug)]
pub struct YearHour {
    /// Month from 1.
    pub month: u32,
    /// Day of the month from 1.
    pub day: u32,
    /// Middle of the hour in standard time, h.
    pub middle_hours: f64,
    /// Whether the hour counts as occupied.
    pub is_occupied: bool,
    /// Unit direction of the sun.
    pub towards_sun: DVec3,
    /// Illuminance of the sun perpendicular to its rays in lx, maintenance included; 0 if the sun is below the horizon.
    pub sun_lx: f64,
    /// Illuminance of an open horizontal plane in lx, from the sky and from the sun, maintenance included.
    pub outside_lx: [f64; 2],
}

/// The skies and suns of a year.
#[derive(Clone, Debug)]
pub struct YearSky {
    /// Hours with light, in the order of the weather.
    pub hours: Vec<YearHour>,
    /// Subdivision of the sky into patches.
    pub patches: SkyPatches,
    /// Reflectance of the ground.
    pub ground_reflectance: f64,
    /// Number of occupied hours, including dark ones.
    pub occupied: usize,
    /// Number of all hours of the weather.
    pub all: usize,
    /// Suns that shine, in the order of the hours.
    pub suns: Suns,
    /// The hour of each sun.
    pub hours_of_suns: Vec<u32>,
    /// Nodes that replace the suns for light reflected by surfaces.
    pub(super) nodes: SunNodes,
    /// Luminance distribution of each hour's sky.
    pub(super) patterns: Vec<SkyPattern>,
    /// Luminances in cd/m². Each hour has those of all patches, then that of the ground.
    luminances_cd_m2: Vec<f64>,
}

impl YearSky {
    /// Builds the skies from weather data. `is_occupied` receives the middle of an hour; `maintained` is a factor on all light.
    pub fn of(
        weather: &Weather,
        subdivision: u32,
        ground_reflectance: f64,
        maintained: f64,
        is_occupied: impl Fn(f64) -> bool + Sync,
    ) -> YearSky {
        let patches = SkyPatches::new(subdivision);
        let parts = PARTS_ACROSS.div_ceil(subdivision);
        let directions: Vec<Vec<DVec3>> =
            (0..patches.count()).map(|patch| patches.directions(patch, parts).collect()).collect();
        let made: Vec<Option<(YearHour, HourSky)>> = weather
            .hours
            .par_iter()
            .map(|hour| {
                let (mut lit, mut sky) = sky_of(weather, hour, &patches, &directions)?;
                let ground = ground_reflectance / PI * (lit.outside_lx[0] + lit.outside_lx[1]);
                sky.luminances_cd_m2.push(ground);
                sky.luminances_cd_m2.iter_mut().for_each(|luminance| *luminance *= maintained);
                lit.is_occupied = is_occupied(hour.middle_hours);
                lit.sun_lx *= maintained;
                lit.outside_lx = lit.outside_lx.map(|lx| maintained * lx);
                Some((lit, sky))
            })
            .collect();
        let (hours, skies): (Vec<YearHour>, Vec<HourSky>) = made.into_iter().flatten().unzip();
        let disk = Sun::of_normal(DVec3::Z, 1.0);
        let shining = hours.iter().zip(0u32..).filter(|(hour, _)| hour.sun_lx > 0.0);
        let (towards, hours_of_suns) = shining.map(|(hour, number)| (hour.towards_sun, number)).unzip();
        let suns = Suns { towards, disk: [disk.sine(), disk.one_minus_cosine()] };
        YearSky {
            patches,
            ground_reflectance,
            occupied: weather.hours.iter().filter(|hour| is_occupied(hour.middle_hours)).count(),
            all: weather.hours.len(),
            nodes: SunNodes::of(&suns, weather.latitude_deg),
            suns,
            hours_of_suns,
            patterns: skies.iter().map(|sky| sky.pattern).collect(),
            luminances_cd_m2: skies.into_iter().flat_map(|sky| sky.luminances_cd_m2).collect(),
            hours,
        }
    }

    /// Number of patches plus one for the ground.
    pub fn columns(&self) -> usize {
        self.patches.count() + 1
    }

    /// Column of a unit direction: its patch, or the ground.
    #[inline]
    pub fn column_of(&self, towards: DVec3) -> usize {
        self.patches.patch_of(towards).unwrap_or(self.patches.count())
    }

    /// Contribution in % to the daylight factor under the overcast sky, of a direction that gives 1 lx under a uniform sky of 1
    /// cd/m². The horizontal illuminance of the overcast sky is 7 π/9 times its zenith luminance.
    #[inline]
    pub fn overcast_percent(&self, towards: DVec3) -> f64 {
        let horizontal = 7.0 * PI / 9.0;
        match towards.z > 0.0 {
            true => 100.0 / horizontal * SkyPattern::Overcast.relative_luminance(towards),
            false => 100.0 / PI * self.ground_reflectance,
        }
    }

    /// Luminances of an hour in cd/m²: all patches, then the ground.
    #[inline]
    pub fn luminances_cd_m2(&self, hour: usize) -> &[f64] {
        &self.luminances_cd_m2[hour * self.columns()..(hour + 1) * self.columns()]
    }
}

/// The sky of an hour.
struct HourSky {
    pattern: SkyPattern,
    /// Luminances of all patches, then that of the ground.
    luminances_cd_m2: Vec<f64>,
}

/// An hour with light and its sky, without the ground's luminance; `None` for a dark hour.
///
/// Patches have the mean luminance of Perez's sky, scaled so that an open horizontal plane receives the illuminance of the weather
/// data. The overcast sky replaces Perez's sky if the sun is below the horizon or Perez's sky has no light in its zenith.
fn sky_of(
    weather: &Weather,
    hour: &WeatherHour,
    patches: &SkyPatches,
    directions: &[Vec<DVec3>],
) -> Option<(YearHour, HourSky)> {
    let moment = Moment::of_date(YEAR, hour.month, hour.day, hour.middle_hours - weather.time_zone_hours);
    let [elevation_deg, azimuth_deg] = solar_position_deg(weather.latitude_deg, weather.longitude_deg, moment);
    let towards_sun = direction_of(elevation_deg, azimuth_deg);
    let (WeatherLight::Irradiance([_, diffuse]) | WeatherLight::Illuminance([_, diffuse])) = hour.light;
    if diffuse <= 0.0 {
        return None;
    }
    let is_up = elevation_deg > 0.0;
    let height_deg = elevation_deg.max(0.0);
    let (class, [direct_lx, diffuse_lx]) = match hour.light {
        WeatherLight::Irradiance([direct_w_m2, diffuse_w_m2]) => {
            let class = SkyClass::of_irradiance(height_deg, direct_w_m2, diffuse_w_m2);
            let [of_direct, of_diffuse] = class.efficacies_lm_w();
            (class, [of_direct * direct_w_m2, of_diffuse * diffuse_w_m2])
        }
        WeatherLight::Illuminance(given_lx) => {
            (SkyClass::of_illuminance(height_deg, given_lx[0], given_lx[1]), given_lx)
        }
    };
    let pattern = if is_up { SkyPattern::all_weather(&class, towards_sun) } else { None };
    let pattern = pattern.unwrap_or(SkyPattern::Overcast);
    let mut luminances: Vec<f64> = directions
        .iter()
        .map(|within| {
            within.iter().map(|towards| pattern.relative_luminance(*towards)).sum::<f64>() / within.len() as f64
        })
        .collect();
    let horizontal: f64 =
        luminances.iter().enumerate().map(|(patch, luminance)| luminance * patches.horizontal_sr(patch)).sum();
    let scale = diffuse_lx / horizontal;
    luminances.iter_mut().for_each(|luminance| *luminance *= scale);
    let sun_lx = if is_up { direct_lx } else { 0.0 };
    let lit = YearHour {
        month: hour.month,
        day: hour.day,
        middle_hours: hour.middle_hours,
        is_occupied: false,
        towards_sun,
        sun_lx,
        outside_lx: [diffuse_lx, Sun::of_normal(towards_sun, sun_lx).illuminance_lx(DVec3::Z)],
    };
    Some((lit, HourSky { pattern, luminances_cd_m2: luminances }))
}
