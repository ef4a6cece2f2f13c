//! Luminaires for the chains and the estimators: a flat list of points, openings, triangle sides, balls, rings, sky and sun.
//!
//! Every kind of light has its own file and implements one trait, `light::Light`. This file lists the kinds once, in the call of `lights!`.
//! `lights_of` converts a luminaire of the scene to lights. Every emitter has four functions. `emit` draws a packet in proportion to the
//! emitted flux. `light_sample` draws a point of the emitter in proportion to its contribution at a receiver. `unshadowed_lx` is the exact
//! illuminance where nothing stands between. `luminous_flux_lm` is the total flux.

mod ball;
mod light;
mod list;
mod point;
mod reach;
mod ring;
mod seen;
mod sky;
mod sun;
mod triangle;
mod triangle_view;
mod web;

use std::sync::Arc;

use glam::DVec3;

use super::importance::{Beacon, Profile};
use super::opening::{Aperture, OpeningPoint};
use super::random::Stream;
use super::web::WebSampler;
use crate::base::sky::Sky;
use crate::base::sun::Sun;
use crate::scene::{Emission, Luminaire, Scene, Side};

use ball::BallLight;
use light::Light;
pub use list::{Emitters, PointEmitters, PointSample};
use point::PointLight;
pub use reach::Reach;
use ring::RingLight;
use sky::SkyEmitter;
use sun::SunEmitter;
use triangle::TriangleEmitter;
use triangle_view::TriangleView;
use web::{SharedWebs, WebLight};

/// Makes the list of lights and the macro `of_light!`, which calls one method of whichever kind a light is.
macro_rules! lights {
    ($($kind:ident($light:ty)),* $(,)?) => {
        #[derive(Clone, Debug)]
        enum EmitterShape {
            $($kind($light),)*
        }

        macro_rules! of_light {
            ($any:expr, $one:ident => $call:expr) => {
                match $any {
                    $(EmitterShape::$kind($one) => $call,)*
                }
            };
        }
        use of_light;
    };
}

lights! {
    Point(PointLight),
    Web(WebLight),
    Triangle(TriangleEmitter),
    Ball(BallLight),
    Ring(RingLight),
    Sky(SkyEmitter),
    Sun(SunEmitter),
}

/// Passes the lights of a luminaire to `push`, each with its flux in lm.
fn lights_of(
    scene: &Scene,
    luminaire: u32,
    source: &Luminaire,
    webs: &mut SharedWebs,
    push: &mut impl FnMut(f64, EmitterShape),
) {
    let flux_lm = source.luminous_flux_lm;
    match &source.emission {
        Emission::Isotropic { position_m, intensity_cd } => {
            let light = PointLight { position_m: *position_m, axis: None, intensity_cd: *intensity_cd };
            push(flux_lm, EmitterShape::Point(light));
        }
        Emission::Lambertian { position_m, axis, intensity_cd } => {
            let light = PointLight { position_m: *position_m, axis: Some(*axis), intensity_cd: *intensity_cd };
            push(flux_lm, EmitterShape::Point(light));
        }
        Emission::Photometric { position_m, frame, web, opening, scale } => {
            let (sampler, profile) = webs
                .entry(Arc::as_ptr(web))
                .or_insert_with(|| (Arc::new(WebSampler::new(web)), Profile::of(web)))
                .clone();
            let (web, aperture) = (web.clone(), Aperture::new(opening, *position_m, frame).map(Arc::new));
            let (position_m, frame, scale) = (*position_m, *frame, *scale);
            let light = WebLight { position_m, frame, web, sampler, profile, scale, aperture };
            push(flux_lm, EmitterShape::Web(light));
        }
        Emission::Sphere { center_m, radius_m, exitance_lm_m2 } => {
            let (center_m, radius_m, exitance_lm_m2) = (*center_m, *radius_m, *exitance_lm_m2);
            push(flux_lm, EmitterShape::Ball(BallLight { luminaire, center_m, radius_m, exitance_lm_m2 }));
        }
        Emission::Ring { center_m, axis, radii_m, exitance_lm_m2 } => {
            push(flux_lm, EmitterShape::Ring(RingLight::new(*center_m, *axis, *radii_m, *exitance_lm_m2)));
        }
        Emission::Sky { sky, openings, .. } => {
            for (flux_lm, light) in SkyEmitter::all(sky, openings) {
                push(flux_lm, EmitterShape::Sky(light));
            }
        }
        Emission::Sun { sun, openings } => push(flux_lm, EmitterShape::Sun(SunEmitter::new(sun, openings))),
        Emission::Area { surfaces, front, back, exitance_lm_m2 } => {
            let sides = [(Side::Front, *front), (Side::Back, *back)];
            for triangle in surfaces.iter().flat_map(|id| scene.surfaces[*id as usize].triangles.clone()) {
                for (side, _) in sides.iter().filter(|(_, emits)| *emits) {
                    let light = TriangleEmitter::new(scene, triangle, *side, *exitance_lm_m2);
                    push(scene.triangle_area_m2(triangle) * exitance_lm_m2, EmitterShape::Triangle(light));
                }
            }
        }
    }
}

/// A point where light leaves a luminaire, described so that the geometry can find it.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// A point in free space, in m.
    Free(DVec3),
    /// A point that may lie on a surface, with a unit normal. It then belongs to the side that its normal points to.
    Sided(DVec3, DVec3),
    /// A point of a triangle's side.
    Surface {
        /// Triangle of the scene.
        triangle: u32,
        /// Weights of its second and third corner.
        barycentric: [f64; 2],
        /// Emitting side.
        side: Side,
    },
    /// A point of a ball's surface.
    Ball {
        /// The luminaire.
        luminaire: u32,
        /// The point in m.
        position_m: DVec3,
    },
}

/// One light of the list. A luminaire has one, or one for each of its emitting triangle sides.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// The luminaire it belongs to.
    pub luminaire: u32,
    /// Maintained flux in lm.
    pub luminous_flux_lm: f64,
    shape: EmitterShape,
    beacon: Beacon,
}

/// The start of a packet.
#[derive(Clone, Copy, Debug)]
pub struct Emitted {
    /// Where it starts.
    pub place: Place,
    /// Its unit direction.
    pub direction: DVec3,
    /// For light of sky and sun, the point from which it comes. If the path from there is blocked, the packet carries no light.
    pub behind: Option<Place>,
    /// Light of sky and sun counts up to this distance from the start, in m, until it is scattered. Beyond, it belongs to another emitter.
    pub reach_m: f64,
}

impl Emitted {
    /// Makes a packet that needs no check of its origin and has no limit of distance.
    fn new(place: Place, direction: DVec3) -> Emitted {
        Emitted { place, direction, behind: None, reach_m: f64::INFINITY }
    }
}

/// One point of an emitter, drawn for a receiver, and the illuminance from the emitter if that point is visible.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Illuminance in lx if nothing stands between.
    pub unshadowed_lx: f64,
    /// The point to which a shadow ray goes. `None` where rounding leaves no point, because too little of the emitter is above the horizon.
    pub place: Option<Place>,
}

/// An emitter as seen from one point.
#[derive(Clone, Copy, Debug)]
pub struct EmitterView<'a> {
    emitter: &'a Emitter,
    point_m: DVec3,
    normal: DVec3,
    triangle: Option<TriangleView>,
}

impl EmitterView<'_> {
    /// See [`Emitter::light_sample`].
    pub fn light_sample(&self, stream: &mut Stream) -> Option<LightSample> {
        match &self.triangle {
            Some(triangle) => triangle.light_sample(stream),
            None => self.emitter.light_sample(self.point_m, self.normal, stream),
        }
    }
}

/// Returns E/I at a point from the cosine law and the inverse square.
#[inline]
fn cosine_per_square(offset: DVec3, normal: DVec3) -> f64 {
    let distance_squared = offset.length_squared();
    let height = offset.dot(normal);
    if height <= 0.0 { 0.0 } else { height / (distance_squared * distance_squared.sqrt()) }
}

impl Emitter {
    /// Whether no ray can meet it: a point, or an opening or ring, which does not block rays. Only light samples find its contribution.
    pub fn is_met_by_no_ray(&self) -> bool {
        of_light!(&self.shape, light => light.is_met_by_no_ray())
    }

    /// Whether it is a single point. All light samples from one place are then equal.
    pub fn is_single_point(&self) -> bool {
        self.is_met_by_no_ray() && !self.has_opening()
    }

    /// Returns centre and radius in m of a ball that holds it.
    pub fn bounding_ball(&self) -> (DVec3, f64) {
        (self.beacon.center_m, self.beacon.radius_m)
    }

    /// Whether any part of it lies within a distance of a point, in m.
    pub fn is_within(&self, point_m: DVec3, distance_m: f64) -> bool {
        if !of_light!(&self.shape, light => light.is_placed()) {
            return false;
        }
        let reach_m = distance_m + self.beacon.radius_m;
        self.beacon.center_m.distance_squared(point_m) < reach_m * reach_m
    }

    /// Returns its centre in m; for the sky an arbitrary point.
    pub fn center_m(&self) -> DVec3 {
        self.beacon.center_m
    }

    /// Whether it is a ball.
    pub fn is_ball(&self) -> bool {
        matches!(self.shape, EmitterShape::Ball(_))
    }

    /// Returns the triangle side that it is, if it is one.
    fn side(&self) -> Option<(u32, Side)> {
        of_light!(&self.shape, light => light.side())
    }

    /// Returns the sky that it is or belongs to.
    fn sky(&self) -> Option<&Sky> {
        of_light!(&self.shape, light => light.sky())
    }

    /// Returns the sun, if it is the sun.
    fn sun(&self) -> Option<&Sun> {
        of_light!(&self.shape, light => light.sun())
    }

    /// Whether it is the sun, the sky, or the part of the sky that an opening shows.
    pub fn is_far(&self) -> bool {
        self.sky().is_some() || self.is_sun()
    }

    /// Whether it is the sun.
    pub fn is_sun(&self) -> bool {
        self.sun().is_some()
    }

    /// Returns the cosine between a triangle's emitting side and a unit direction. It is 0 behind that side, and 0 for other kinds.
    pub fn cosine_towards(&self, direction: DVec3) -> f64 {
        of_light!(&self.shape, light => light.cosine_towards(direction))
    }

    /// Whether it emits from many points that no ray meets: a photometric opening with an extent, or a ring.
    pub fn has_opening(&self) -> bool {
        of_light!(&self.shape, light => light.has_opening())
    }

    /// Draws a point of an emitter that has no body: its only point, or a point of its opening or ring. `None` for other kinds.
    #[inline]
    pub fn draw_point(&self, stream: &mut Stream) -> Option<OpeningPoint> {
        of_light!(&self.shape, light => light.draw_point(stream))
    }

    /// Returns the `Place` of a point of an emitter without a body. If the emitter has an axis, the point belongs to the side it aims at.
    #[inline]
    pub fn place_of_point(&self, point_m: DVec3) -> Place {
        of_light!(&self.shape, light => light.place_of_point(point_m))
    }

    /// Returns the intensity in cd of an emitter without a body towards a unit direction; 0 for other kinds, which have none.
    pub fn intensity_cd(&self, direction: DVec3) -> f64 {
        of_light!(&self.shape, light => light.intensity_cd(direction))
    }

    /// Returns the intensity in cd that a point drawn by [`Emitter::draw_point`] represents. The mean over all points is `intensity_cd`. A
    /// point of a solid opening emits only to the directions that its face points to.
    pub fn intensity_from_cd(&self, point: &OpeningPoint, direction: DVec3) -> f64 {
        let share = of_light!(&self.shape, light => light.share_from(point, direction));
        if share > 0.0 { share * self.intensity_cd(direction) } else { 0.0 }
    }

    /// Draws a packet in proportion to the flux that leaves.
    pub fn emit(&self, stream: &mut Stream) -> Emitted {
        of_light!(&self.shape, light => light.emit(stream))
    }

    /// Returns the intensity in cd in a unit direction as seen from afar, and one of the points that the light comes from. `None` where
    /// there is no light in that direction, and for the sky, which is itself infinitely far.
    pub fn seen_from_afar(&self, direction: DVec3, stream: &mut Stream) -> Option<(f64, Place)> {
        of_light!(&self.shape, light => light.seen_from_afar(direction, stream))
            .filter(|(intensity_cd, _)| *intensity_cd > 0.0)
    }

    /// Returns a point by two variates in [0, 1): of a triangle any point, of a ball a point of the disk that is visible from `place_m`.
    /// `None` for point-like emitters, and for a ball around `place_m`.
    pub fn point_seen_from(&self, place_m: DVec3, variates: [f64; 2]) -> Option<Place> {
        of_light!(&self.shape, light => light.point_seen_from(place_m, variates))
    }

    /// Returns the illuminance in lx at a point with a unit normal as if nothing stood between. It is exact with two exceptions. An opening
    /// with an extent counts as its centre. The sky counts in each opening with the luminance seen in the opening's middle; light samples
    /// are more accurate.
    pub fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        of_light!(&self.shape, light => light.unshadowed_lx(point_m, normal))
    }

    /// Returns a cheap substitute for [`Emitter::unshadowed_lx`], 0 only where that is 0. Its share decides how often the emitter is
    /// sampled.
    #[inline]
    pub fn importance_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        self.beacon.importance_lx(point_m, normal)
    }

    /// Draws one light sample of the emitter from a point with a unit normal; `None` where it gives no light.
    ///
    /// The point of the emitter is drawn in proportion to its unshadowed contribution. The estimate of the illuminance is the sample's
    /// `unshadowed_lx` times visibility.
    pub fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        of_light!(&self.shape, light => light.light_sample(point_m, normal, stream))
    }

    /// Prepares the emitter as seen from a point with a unit normal. The work that many light samples share is then done only once.
    pub fn view(&self, point_m: DVec3, normal: DVec3) -> EmitterView<'_> {
        let triangle = of_light!(&self.shape, light => light.triangle_view(point_m, normal));
        EmitterView { emitter: self, point_m, normal, triangle }
    }

    /// Draws a light sample that takes less time and has more variance, for the vertices of walks. The variance from choosing one of many
    /// emitters, one of many walks and from visibility is far larger.
    ///
    /// For a far triangle the point is drawn by area; all else is sampled as usual.
    #[inline]
    pub fn cheap_light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        of_light!(&self.shape, light => light.cheap_light_sample(point_m, normal, stream))
    }

    /// Returns the exitance in lm/m² of an emitter that rays can meet. `None` for points, openings and rings, which only light samples
    /// find, and for sky and sun.
    pub fn exitance_lm_m2(&self) -> Option<f64> {
        of_light!(&self.shape, light => light.exitance_lm_m2())
    }
}
