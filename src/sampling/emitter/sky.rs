//! The sky as emitters: one for each opening of the scene, and one for the light that passes all of them.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use super::light::Light;
use super::{Emitted, LightSample, Place};
use crate::base::polygon::triangle_illuminance_factor;
use crate::base::sky::Sky;
use crate::sampling::importance::{Beacon, Profile};
use crate::sampling::random::Stream;
use crate::sampling::sky_openings::{belongs_to, reach_m};
use crate::sampling::triangle::RisenTriangle;
use crate::sampling::warp::{cosine_hemisphere, tangents, uniform_sphere, uniform_triangle};
use crate::scene::Openings;

/// Length of rays to the sky in radii of the scene. From any point inside, they end outside the ball that contains the scene.
const OUTSIDE: f64 = 2.2;
/// A packet starts this far inside its opening, relative to the radius of the scene: clearly on the inner side of a pane.
const WITHIN: f64 = 2e-5;
/// Least cosine for this distance: packets that enter at a flatter angle start no farther inside.
const FLATTEST: f64 = 0.05;
/// Assumed share of the open sky's light that passes all openings. It decides how often that emitter is sampled.
const SHARE_PAST_OPENINGS: f64 = 0.05;
/// Largest number of draws for a direction by luminance. Even with the brightest skies, about one draw in some hundred is kept.
const MOST_DRAWS: u32 = 100_000;

/// The sky through an opening, or past all of them.
#[derive(Clone, Debug)]
pub(super) struct SkyEmitter {
    pub sky: Arc<Sky>,
    pub openings: Arc<Openings>,
    /// Number of the opening; `None` for the light past all openings.
    pub opening: Option<u32>,
}

impl SkyEmitter {
    /// Returns the emitters of a sky, each with its flux in lm.
    pub fn all(sky: &Arc<Sky>, openings: &Arc<Openings>) -> Vec<(f64, SkyEmitter)> {
        let emitter = |opening| SkyEmitter { sky: sky.clone(), openings: openings.clone(), opening };
        let fluxes_lm = openings.fluxes_lm(|normal| sky.illuminance_lx(normal));
        let through = fluxes_lm.zip(0u32..).map(|(flux_lm, number)| (flux_lm, emitter(Some(number))));
        let past = (!openings.are_all).then(|| (openings.open_flux_lm(sky.total_cd_sr_m2()), emitter(None)));
        through.chain(past).collect()
    }

    /// Returns the corners of its opening in m.
    pub fn front_m(&self) -> Option<[DVec3; 3]> {
        self.opening.map(|number| self.openings.fronts_m[number as usize])
    }

    /// Returns the unit normal of its opening, into the room, and a point of the opening.
    fn inward(&self) -> Option<(DVec3, DVec3)> {
        self.front_m().map(|[a, b, c]| ((b - a).cross(c - a).normalize_or_zero(), a))
    }
}

impl Light for SkyEmitter {
    fn beacon(&self) -> Beacon {
        let Some([a, b, c]) = self.front_m() else {
            // All points lie inside its ball, so its importance is the same everywhere.
            let radius_m = OUTSIDE * self.openings.radius_m;
            let share = if self.openings.fronts_m.is_empty() { 1.0 } else { SHARE_PAST_OPENINGS };
            return Beacon {
                center_m: self.openings.center_m,
                radius_m,
                axis: DVec3::Z,
                intensity_cd: share * 0.25 * self.sky.total_cd_sr_m2() * radius_m * radius_m,
                profile: Profile::Uniform,
                parts: Arc::default(),
            };
        };
        let center_m = (a + b + c) / 3.0;
        let radius_m = [a, b, c].iter().map(|corner| corner.distance(center_m)).fold(0.0, f64::max);
        let twice_area = (b - a).cross(c - a);
        let axis = twice_area.normalize_or_zero();
        let area_m2 = 0.5 * twice_area.length();
        let intensity_cd = self.sky.illuminance_lx(-axis) / PI * area_m2;
        Beacon { center_m, radius_m, axis, intensity_cd, profile: Profile::Flat, parts: Arc::default() }
    }

    /// Returns about the illuminance in lx at a point with a unit normal where nothing stands between; 0 only where there is no light.
    fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        match self.front_m() {
            Some(corners_m) => {
                let middle_m = corners_m.iter().sum::<DVec3>() / 3.0;
                // Parts that are not seen through the middle may be bright.
                let least_cd_m2 = 1e-3 * self.sky.largest_cd_m2();
                let luminance_cd_m2 = self.sky.luminance_cd_m2((middle_m - point_m).normalize_or_zero());
                PI * luminance_cd_m2.max(least_cd_m2) * triangle_illuminance_factor(point_m, normal, corners_m)
            }
            None => 0.25 * self.sky.total_cd_sr_m2(),
        }
    }

    /// Draws a light sample towards a direction of the sky.
    ///
    /// Directions are drawn in proportion to their cosine; for an opening, among the directions that it shows.
    fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        let (factor, towards, distance_m) = match self.front_m() {
            Some(corners_m) => {
                let factor = triangle_illuminance_factor(point_m, normal, corners_m);
                if factor <= 0.0 {
                    return None;
                }
                let [a, b, c] = corners_m.map(|corner_m| corner_m - point_m);
                let (towards, _) = RisenTriangle::new([a, b, c], normal)?.draw(stream)?;
                let twice_area = (b - a).cross(c - a);
                (factor, towards, twice_area.dot(a) / twice_area.dot(towards))
            }
            None => (1.0, cosine_hemisphere(normal, stream.pair()), f64::INFINITY),
        };
        let unshadowed_lx = PI * self.sky.luminance_cd_m2(towards) * factor;
        if unshadowed_lx <= 0.0 || !belongs_to(&self.openings, self.opening, point_m, towards, distance_m) {
            return None;
        }
        let end_m = point_m + OUTSIDE * self.openings.radius_m * towards;
        Some(LightSample { unshadowed_lx, place: Some(Place::Free(end_m)) })
    }

    /// Draws a packet in proportion to the flux that enters.
    fn emit(&self, stream: &mut Stream) -> Emitted {
        let largest_cd_m2 = self.sky.largest_cd_m2();
        let mut towards = DVec3::Z;
        let thinned = |towards: &mut DVec3, stream: &mut Stream, draw: &dyn Fn(&mut Stream) -> DVec3| {
            for _ in 0..MOST_DRAWS {
                *towards = draw(stream);
                if stream.unit() * largest_cd_m2 < self.sky.luminance_cd_m2(*towards) {
                    break;
                }
            }
        };
        let Some((inward, _)) = self.inward() else {
            let [u, v] = stream.pair();
            thinned(&mut towards, stream, &|stream| uniform_sphere(stream.pair()));
            return enter_past(&self.openings, towards, [u, v]);
        };
        let within = uniform_triangle(stream.pair());
        thinned(&mut towards, stream, &|stream| cosine_hemisphere(-inward, stream.pair()));
        enter_through(&self.openings, self.opening, towards, within)
    }

    fn half_space(&self) -> Option<(DVec3, f64)> {
        self.inward().map(|(axis, at_m)| (axis, axis.dot(at_m)))
    }

    fn is_placed(&self) -> bool {
        self.opening.is_some()
    }

    fn sky(&self) -> Option<&Sky> {
        Some(&self.sky)
    }
}

/// Makes a packet that enters past all openings from a unit direction. Two variates in [0, 1) choose a point of the disk across the
/// direction.
pub(super) fn enter_past(openings: &Openings, towards: DVec3, [u, v]: [f64; 2]) -> Emitted {
    let radius_m = openings.radius_m;
    let [first, second] = tangents(towards);
    let (sine, cosine) = (std::f64::consts::TAU * v).sin_cos();
    let aside_m = radius_m * u.sqrt() * (cosine * first + sine * second);
    let start_m = openings.center_m + 1.01 * radius_m * towards + aside_m;
    let reach_m = reach_m(openings, None, start_m, -towards);
    Emitted { place: Place::Free(start_m), direction: -towards, behind: None, reach_m }
}

/// Makes a packet that enters through an opening from a unit direction, at a point given by the weights of the second and third corner.
pub(super) fn enter_through(openings: &Openings, opening: Option<u32>, towards: DVec3, [u, v]: [f64; 2]) -> Emitted {
    let radius_m = openings.radius_m;
    let [a, b, c] = opening.map(|number| openings.fronts_m[number as usize]).unwrap_or_default();
    let inward = (b - a).cross(c - a).normalize_or_zero();
    let entry_m = a + u * (b - a) + v * (c - a);
    let within_m = WITHIN * radius_m / (-towards.dot(inward)).max(FLATTEST);
    let start_m = entry_m - within_m * towards;
    let behind = Some(Place::Free(entry_m + OUTSIDE * radius_m * towards));
    let reach_m = reach_m(openings, opening, entry_m, -towards) - within_m;
    Emitted { place: Place::Free(start_m), direction: -towards, behind, reach_m }
}
