//! Luminaires with a measured distribution, and their luminous openings.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use super::light::{Light, SeenPart};
use super::seen::show_point;
use super::{Emitted, LightSample, Place, cosine_per_square};
use crate::sampling::importance::{Beacon, Profile};
use crate::sampling::opening::{Aperture, OpeningPoint};
use crate::sampling::random::Stream;
use crate::sampling::web::WebSampler;
use crate::scene::photometry::IntensityWeb;

/// Luminaires of one array or one file share their distribution and the tables made from it.
pub(super) type SharedWebs = HashMap<*const IntensityWeb, (Arc<WebSampler>, Profile)>;

/// A measured distribution that every part of an opening emits.
#[derive(Clone, Debug)]
pub(super) struct WebLight {
    pub position_m: DVec3,
    pub frame: [DVec3; 3],
    pub web: Arc<IntensityWeb>,
    pub sampler: Arc<WebSampler>,
    pub profile: Profile,
    pub scale: f64,
    /// The luminous opening, where it has an extent.
    pub aperture: Option<Arc<Aperture>>,
}

impl WebLight {
    /// Draws a point of the part that the opening shows in a direction of emission.
    #[inline]
    fn draw_point_towards(&self, direction: DVec3, stream: &mut Stream) -> DVec3 {
        self.aperture.as_ref().map_or(self.position_m, |aperture| aperture.draw_towards(direction, stream).position_m)
    }
}

impl Light for WebLight {
    fn beacon(&self) -> Beacon {
        Beacon {
            center_m: self.position_m,
            radius_m: self.aperture.as_ref().map_or(0.0, |aperture| aperture.radius_m()),
            axis: self.frame[2],
            intensity_cd: self.scale,
            profile: self.profile.clone(),
            parts: Arc::default(),
        }
    }

    fn emit(&self, stream: &mut Stream) -> Emitted {
        let local = self.sampler.sample(stream.pair());
        let [c0, c90, axis] = self.frame;
        let direction = c0 * local.x + c90 * local.y + axis * local.z;
        Emitted::new(Place::Sided(self.draw_point_towards(direction, stream), axis), direction)
    }

    fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        let geometry = cosine_per_square(self.position_m - point_m, normal);
        if geometry == 0.0 {
            return 0.0;
        }
        self.intensity_cd((point_m - self.position_m).normalize()) * geometry
    }

    fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        if let Some(aperture) = &self.aperture {
            let towards = |direction: DVec3| self.intensity_cd(direction);
            let (unshadowed_lx, at_m) = aperture.light_sample(point_m, normal, towards, stream)?;
            return Some(LightSample { unshadowed_lx, place: Some(self.place_of_point(at_m)) });
        }
        let unshadowed_lx = self.unshadowed_lx(point_m, normal);
        let place = Some(self.place_of_point(self.position_m));
        (unshadowed_lx > 0.0).then_some(LightSample { unshadowed_lx, place })
    }

    fn half_space(&self) -> Option<(DVec3, f64)> {
        if !self.web.shines_ahead_only() {
            return None;
        }
        let axis = self.frame[2];
        let behind_m = self.aperture.as_ref().map_or(0.0, |aperture| aperture.half_extent_m(axis));
        Some((axis, axis.dot(self.position_m) - behind_m))
    }

    fn is_met_by_no_ray(&self) -> bool {
        true
    }

    fn has_opening(&self) -> bool {
        self.aperture.is_some()
    }

    #[inline]
    fn draw_point(&self, stream: &mut Stream) -> Option<OpeningPoint> {
        let middle = OpeningPoint { position_m: self.position_m, face: None };
        Some(self.aperture.as_ref().map_or(middle, |aperture| aperture.draw(stream)))
    }

    #[inline]
    fn place_of_point(&self, point_m: DVec3) -> Place {
        Place::Sided(point_m, self.frame[2])
    }

    fn intensity_cd(&self, direction: DVec3) -> f64 {
        self.scale * self.web.intensity_towards_cd(&self.frame, direction)
    }

    fn share_from(&self, point: &OpeningPoint, direction: DVec3) -> f64 {
        self.aperture.as_ref().map_or(1.0, |aperture| aperture.share_towards(point, direction))
    }

    fn seen_from_afar(&self, direction: DVec3, stream: &mut Stream) -> Option<(f64, Place)> {
        let intensity_cd = self.intensity_cd(direction);
        if intensity_cd <= 0.0 {
            return None;
        }
        Some((intensity_cd, self.place_of_point(self.draw_point_towards(direction, stream))))
    }

    fn opening_on_sight(&self, eye_m: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let aperture = self.aperture.as_ref()?;
        let distance_m = aperture.met_at_m(eye_m, direction)?;
        Some((distance_m, self.intensity_cd(-direction) / aperture.projected_area_m2(direction)))
    }

    fn show_parts(&self, eye_m: DVec3, stream: &mut Stream, show: &mut dyn FnMut(SeenPart)) {
        let towards = (self.position_m - eye_m).normalize_or(self.frame[2]);
        let area_m2 = self.aperture.as_ref().map_or(0.0, |aperture| aperture.projected_area_m2(towards));
        show_point(self, self.position_m, self.draw_point_towards(-towards, stream), area_m2, eye_m, show);
    }
}
