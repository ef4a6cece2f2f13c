//! Emitting points with uniform intensity or with I = I₀ cos γ.

use std::sync::Arc;

use glam::DVec3;

use super::light::{Light, SeenPart};
use super::seen::show_point;
use super::{Emitted, LightSample, Place, cosine_per_square};
use crate::sampling::importance::{Beacon, Profile};
use crate::sampling::opening::OpeningPoint;
use crate::sampling::random::Stream;
use crate::sampling::warp::{cosine_hemisphere, uniform_sphere};

/// An emitting point.
#[derive(Clone, Debug)]
pub(super) struct PointLight {
    pub position_m: DVec3,
    /// Unit vector of γ = 0, if the intensity follows the cosine.
    pub axis: Option<DVec3>,
    /// Intensity in cd; on the axis if there is one.
    pub intensity_cd: f64,
}

impl Light for PointLight {
    fn beacon(&self) -> Beacon {
        Beacon {
            center_m: self.position_m,
            radius_m: 0.0,
            axis: self.axis.unwrap_or(DVec3::Z),
            intensity_cd: self.intensity_cd,
            profile: if self.axis.is_some() { Profile::Cosine } else { Profile::Uniform },
            parts: Arc::default(),
        }
    }

    fn emit(&self, stream: &mut Stream) -> Emitted {
        let direction = match self.axis {
            Some(axis) => cosine_hemisphere(axis, stream.pair()),
            None => uniform_sphere(stream.pair()),
        };
        Emitted::new(self.place_of_point(self.position_m), direction)
    }

    fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        let geometry = cosine_per_square(self.position_m - point_m, normal);
        if geometry == 0.0 {
            return 0.0;
        }
        match self.axis {
            Some(_) => self.intensity_cd((point_m - self.position_m).normalize()) * geometry,
            None => self.intensity_cd * geometry,
        }
    }

    fn light_sample(&self, point_m: DVec3, normal: DVec3, _: &mut Stream) -> Option<LightSample> {
        let unshadowed_lx = self.unshadowed_lx(point_m, normal);
        let place = Some(self.place_of_point(self.position_m));
        (unshadowed_lx > 0.0).then_some(LightSample { unshadowed_lx, place })
    }

    fn half_space(&self) -> Option<(DVec3, f64)> {
        self.axis.map(|axis| (axis, axis.dot(self.position_m)))
    }

    fn is_met_by_no_ray(&self) -> bool {
        true
    }

    #[inline]
    fn draw_point(&self, _: &mut Stream) -> Option<OpeningPoint> {
        Some(OpeningPoint { position_m: self.position_m, face: None })
    }

    #[inline]
    fn place_of_point(&self, point_m: DVec3) -> Place {
        self.axis.map_or(Place::Free(point_m), |axis| Place::Sided(point_m, axis))
    }

    fn intensity_cd(&self, direction: DVec3) -> f64 {
        self.axis.map_or(self.intensity_cd, |axis| self.intensity_cd * axis.dot(direction).max(0.0))
    }

    fn seen_from_afar(&self, direction: DVec3, _: &mut Stream) -> Option<(f64, Place)> {
        Some((self.intensity_cd(direction), self.place_of_point(self.position_m)))
    }

    fn show_parts(&self, eye_m: DVec3, _: &mut Stream, show: &mut dyn FnMut(SeenPart)) {
        show_point(self, self.position_m, self.position_m, 0.0, eye_m, show);
    }
}
