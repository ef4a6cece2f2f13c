//! The trait of every kind of light. Each kind has its own file.

use glam::DVec3;

use super::triangle_view::TriangleView;
use super::{Emitted, LightSample, Place};
use crate::base::sky::Sky;
use crate::base::sun::Sun;
use crate::sampling::importance::Beacon;
use crate::sampling::opening::OpeningPoint;
use crate::sampling::random::Stream;
use crate::scene::Side;

/// A part of a luminaire as an eye sees it if nothing stands between.
#[derive(Clone, Copy, Debug)]
pub struct SeenPart {
    /// Unit direction of its middle from the eye.
    pub towards: DVec3,
    /// Luminance towards the eye, squared, times solid angle, in cd²·sr/m⁴.
    pub squared_luminance_sr: f64,
    /// A point of it drawn at random.
    pub place: Place,
}

/// One emitting point, opening, triangle side or ball, or sky or sun. The default methods serve the kinds that lack a feature.
pub(super) trait Light {
    /// Returns the ball with an axis that gives its weight among other lights: a cheap upper bound of its illuminance.
    fn beacon(&self) -> Beacon;

    /// Draws a packet in proportion to the flux that leaves.
    fn emit(&self, stream: &mut Stream) -> Emitted;

    /// See [`super::Emitter::unshadowed_lx`].
    fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64;

    /// A light sample: see [`super::Emitter::light_sample`].
    ///
    /// It draws its point from the first variates of the stream, the same way at every call, and never by [`Stream::happens`]: control variates
    /// give each light sample a part of the square of these variates. Its mean without shadows is `unshadowed_lx`. `None`: nothing can arrive.
    fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample>;

    /// A triangle prepared for one point: see [`super::Emitter::view`].
    fn triangle_view(&self, _point_m: DVec3, _normal: DVec3) -> Option<TriangleView> {
        None
    }

    /// A light sample that takes less time: see [`super::Emitter::cheap_light_sample`].
    #[inline]
    fn cheap_light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        self.light_sample(point_m, normal, stream)
    }

    /// Returns the half space that receives all its light, if there is one: the unit normal, and the coordinate of its plane along that
    /// normal in m. The plane goes through the rearmost point of the light.
    fn half_space(&self) -> Option<(DVec3, f64)> {
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

    /// Whether its beacon shows its position. False for light that comes from everywhere or from infinity.
    fn is_placed(&self) -> bool {
        true
    }

    /// Draws one of the points from which it emits and that no ray meets.
    #[inline]
    fn draw_point(&self, _: &mut Stream) -> Option<OpeningPoint> {
        None
    }

    /// Returns the `Place` of such a point.
    #[inline]
    fn place_of_point(&self, point_m: DVec3) -> Place {
        Place::Free(point_m)
    }

    /// Returns the intensity in cd of all such points together towards a unit direction.
    fn intensity_cd(&self, _direction: DVec3) -> f64 {
        0.0
    }

    /// Returns what one drawn point sends in a direction, relative to the mean of all points: see [`super::Emitter::intensity_from_cd`].
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

    /// Returns the distance in m at which a line of sight meets an opening that does not block rays, and its luminance in cd/m².
    fn opening_on_sight(&self, _eye_m: DVec3, _direction: DVec3) -> Option<(f64, f64)> {
        None
    }

    /// Shows the parts that an eye would see if nothing stood between.
    fn show_parts(&self, _eye_m: DVec3, _: &mut Stream, _show: &mut dyn FnMut(SeenPart)) {}

    /// Returns the exitance in lm/m² of a light that rays can meet. A light that no ray meets must return `None`; otherwise its light
    /// samples would leave a share to rays.
    fn exitance_lm_m2(&self) -> Option<f64> {
        None
    }

    /// Returns the triangle side that it is, if it is one.
    fn side(&self) -> Option<(u32, Side)> {
        None
    }

    /// Returns the cosine between that side and a unit direction, 0 behind it.
    fn cosine_towards(&self, _direction: DVec3) -> f64 {
        0.0
    }

    /// Returns the distance in m at which a line of sight meets its ball; the line must meet it. `None` for other kinds.
    fn ball_at_m(&self, _eye_m: DVec3, _direction: DVec3) -> Option<f64> {
        None
    }

    /// Returns the sky that it is or belongs to.
    fn sky(&self) -> Option<&Sky> {
        None
    }

    /// Returns the sun, if it is the sun.
    fn sun(&self) -> Option<&Sun> {
        None
    }
}
