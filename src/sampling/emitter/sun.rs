//! The sun as an emitter: one for all light samples, which see it as they see the open sky, and with all openings for the packets.

use std::sync::Arc;

use glam::DVec3;

use super::ball::draw_in_cone;
use super::light::Light;
use super::sky::{enter_past, enter_through};
use super::{Emitted, LightSample, Place};
use crate::base::sun::Sun;
use crate::sampling::importance::{Beacon, Profile};
use crate::sampling::random::Stream;
use crate::sampling::warp::{uniform_cone, uniform_triangle};
use crate::scene::Openings;

/// The beacon stands this many radii of the scene away. From everywhere its direction is the same, to within rounding of the sun's disk.
const BEACON: f64 = 1e6;
/// Rays to the sun are longer than the point's distance from the scene's centre by this many radii of the scene, so they end outside of it.
const OUTSIDE: f64 = 1.2;

/// The sun.
#[derive(Clone, Debug)]
pub(super) struct SunEmitter {
    pub sun: Arc<Sun>,
    openings: Arc<Openings>,
    /// Cumulative flux in lm through the openings, each included, and in the last entry also the flux past all of them.
    cumulative_flux_lm: Arc<[f64]>,
}

impl SunEmitter {
    /// Makes the sun that shines through openings.
    pub fn new(sun: &Arc<Sun>, openings: &Arc<Openings>) -> SunEmitter {
        let through_lm = openings.fluxes_lm(|normal| sun.illuminance_lx(normal));
        let fluxes_lm = through_lm.chain([openings.open_flux_lm(sun.total_cd_sr_m2())]);
        let cumulative_flux_lm = fluxes_lm.scan(0.0, |sum_lm, lm| {
            *sum_lm += lm;
            Some(*sum_lm)
        });
        SunEmitter { sun: sun.clone(), openings: openings.clone(), cumulative_flux_lm: cumulative_flux_lm.collect() }
    }
}

impl Light for SunEmitter {
    fn beacon(&self) -> Beacon {
        let distance_m = BEACON * self.openings.radius_m;
        Beacon {
            center_m: self.openings.center_m + distance_m * self.sun.towards(),
            radius_m: 1.001 * distance_m * self.sun.sine(),
            axis: -self.sun.towards(),
            intensity_cd: self.sun.normal_lx() * distance_m * distance_m,
            profile: Profile::Uniform,
            parts: Arc::default(),
        }
    }

    /// Draws a light sample towards a direction of the disk, in proportion to its cosine.
    fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        let unshadowed_lx = self.sun.illuminance_lx(normal);
        if unshadowed_lx <= 0.0 {
            return None;
        }
        let towards = draw_in_cone(self.sun.towards(), self.sun.sine(), normal, stream);
        // The ground hides the part below the horizon. The point may lie anywhere, because mirror images of points lie far outside.
        let end_m = (point_m - self.openings.center_m).length() + OUTSIDE * self.openings.radius_m;
        let above = towards.filter(|towards| towards.z > 0.0);
        Some(LightSample { unshadowed_lx, place: above.map(|towards| Place::Free(point_m + end_m * towards)) })
    }

    /// Draws a packet in proportion to the flux that enters.
    fn emit(&self, stream: &mut Stream) -> Emitted {
        let last = self.cumulative_flux_lm.len() - 1;
        let aim_lm = stream.fine_unit() * self.cumulative_flux_lm[last];
        let number = self.cumulative_flux_lm.partition_point(|sum_lm| *sum_lm <= aim_lm).min(last);
        let (towards, mut emitted) = match self.openings.fronts_m.get(number) {
            None => {
                let variates = stream.pair();
                let towards = uniform_cone(self.sun.towards(), self.sun.one_minus_cosine(), stream.pair());
                (towards, enter_past(&self.openings, towards, variates))
            }
            Some([a, b, c]) => {
                let within = uniform_triangle(stream.pair());
                let outward = -(b - a).cross(c - a).normalize_or_zero();
                let towards = draw_in_cone(self.sun.towards(), self.sun.sine(), outward, stream);
                let towards = towards.unwrap_or(self.sun.towards());
                (towards, enter_through(&self.openings, Some(number as u32), towards, within))
            }
        };
        if towards.z <= 0.0 {
            emitted.reach_m = 0.0;
        }
        emitted
    }

    fn unshadowed_lx(&self, _: DVec3, normal: DVec3) -> f64 {
        self.sun.illuminance_lx(normal)
    }

    fn is_placed(&self) -> bool {
        false
    }

    fn sun(&self) -> Option<&Sun> {
        Some(&self.sun)
    }
}
