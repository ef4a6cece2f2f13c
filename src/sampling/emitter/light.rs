//! What every kind of light can do, each kind in a file of its own.

use glam::DVec3;

use super::triangle_view::TriangleView;
use super::{Emitted, LightSample, Place};
use crate::base::sky::Sky;
use crate::base::sun::Sun;
use crate::sampling::importance::Beacon;
use crate::sampling::opening::OpeningPoint;
use crate::sampling::random::Stream;
use crate::scene::Side;

/// A part of a luminaire as an eye sees it where nothing stands between.
#[derive(Clone, Copy, Debug)]
pub struct SeenPart {
    /// Unit direction of its middle from the eye.
    pub towards: DVec3,
    /// Luminance towards the eye, squared, times solid angle, in cd²·sr/m⁴.
    pub squared_luminance_sr: f64,
    /// A point of it drawn at random.
    pub place: Place,
}

/// One emitting point, opening, triangle side or ball, or what comes from afar. Faces that most kinds do not have answer here for them.
pub(super) trait Light {
    /// The ball with an axis by which it is weighed among others: a cheap upper bound of what it brings.
    fn beacon(&self) -> Beacon;

    /// Draws a packet in proportion to the flux that leaves.
    fn emit(&self, stream: &mut Stream) -> Emitted;

    /// See [`super::Emitter::unshadowed_lx`].
    fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64;

    /// A light sample: see [`super::Emitter::light_sample`].
    fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample>;

    /// A triangle as a place sees it: see [`super::Emitter::view`].
    fn triangle_view(&self, _point_m: DVec3, _normal: DVec3) -> Option<TriangleView> {
        None
    }

    /// A light sample that takes less time: see [`super::Emitter::cheap_light_sample`].
    #[inline]
    fn cheap_light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        self.light_sample(point_m, normal, stream)
    }

    /// The half space into which all its light goes, if there is one: its unit normal, and where its plane stands along that in m, at the
    /// hindmost point of the light.
    fn ahead(&self) -> Option<(DVec3, f64)> {
        None
    }

    /// See [`super::Emitter::is_met_by_no_ray`].
    fn is_met_by_no_ray(&self) -> bool {
        false
    }

    /// See [`super::Emitter::has_opening`].
    fn has_opening(&self) -> bool {
        false
    }

    /// Whether its beacon tells where it is: not of what comes from everywhere, or from infinity.
    fn is_placed(&self) -> bool {
        true
    }

    /// One of the points from which it emits and that no ray meets.
    #[inline]
    fn draw_point(&self, _: &mut Stream) -> Option<OpeningPoint> {
        None
    }

    /// Such a point for the geometry.
    #[inline]
    fn place_of_point(&self, point_m: DVec3) -> Place {
        Place::Free(point_m)
    }

    /// Intensity in cd of all such points towards a unit direction.
    fn intensity_cd(&self, _direction: DVec3) -> f64 {
        0.0
    }

    /// What one drawn point sends in that direction over the mean of all of them: see [`super::Emitter::intensity_from_cd`].
    fn share_from(&self, _: &OpeningPoint, _direction: DVec3) -> f64 {
        1.0
    }

    /// See [`super::Emitter::seen_from_afar`]; the intensity may be 0.
    fn seen_from_afar(&self, _direction: DVec3, _: &mut Stream) -> Option<(f64, Place)> {
        None
    }

    /// See [`super::Emitter::point_seen_from`].
    fn point_seen_from(&self, _place_m: DVec3, _variates: [f64; 2]) -> Option<Place> {
        None
    }

    /// Where a line of sight meets an opening that is no obstacle: distance in m, and luminance in cd/m².
    fn opening_on_sight(&self, _eye_m: DVec3, _direction: DVec3) -> Option<(f64, f64)> {
        None
    }

    /// Shows the parts that an eye would see.
    fn show_parts(&self, _eye_m: DVec3, _: &mut Stream, _show: &mut dyn FnMut(SeenPart)) {}

    /// Exitance in lm/m² of a light that rays can meet. One that no ray meets has none here: its light samples would leave a share to rays.
    fn exitance_lm_m2(&self) -> Option<f64> {
        None
    }

    /// The side of a triangle that it is.
    fn side(&self) -> Option<(u32, Side)> {
        None
    }

    /// Cosine between that side and a unit direction, 0 behind it.
    fn cosine_towards(&self, _direction: DVec3) -> f64 {
        0.0
    }

    /// Distance in m at which a line of sight that meets its ball meets it; `None` for what is no ball.
    fn ball_at_m(&self, _eye_m: DVec3, _direction: DVec3) -> Option<f64> {
        None
    }

    /// The sky that it is, or is a part of.
    fn sky(&self) -> Option<&Sky> {
        None
    }

    /// The sun that it is.
    fn sun(&self) -> Option<&Sun> {
        None
    }
}
