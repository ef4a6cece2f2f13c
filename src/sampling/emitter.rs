//! Luminaires as the chain and the estimators see them: a flat list of points, openings, triangle sides, balls, rings, sky and sun.
//!
//! Every kind of light has a file of its own and stands behind one trait, `light::Light`; this file lists them all, once, in the call of
//! `lights!`, and tells in `lights_of` what a luminaire of the scene becomes. Four faces are those of every emitter: `emit` draws a
//! packet in proportion to what leaves it, `light_sample` draws a point of it in proportion to what that brings to a receiver,
//! `unshadowed_lx` is the exact value of what it brings where nothing stands between, and `luminous_flux_lm` its total.

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
pub use list::{Emitters, PointEmitters, PointLook};
use point::PointLight;
pub use reach::Reach;
use ring::RingLight;
use sky::SkyEmitter;
use sun::SunEmitter;
use triangle::TriangleEmitter;
use triangle_view::TriangleView;
use web::{SharedWebs, WebLight};

/// Makes the list of lights, and `of_light!`, which calls the same method of whichever it is.
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

/// What a luminaire emits from: each light with its flux in lm.
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

/// Where light leaves a luminaire, for the geometry to find its place.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// A point in free space, in m.
    Free(DVec3),
    /// A point that may lie on a surface and then belongs to the side its normal points to.
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

/// One light of the list: a luminaire is one, or as many as it has emitting triangle sides.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// The luminaire it belongs to.
    pub luminaire: u32,
    /// Maintained flux in lm.
    pub luminous_flux_lm: f64,
    shape: EmitterShape,
    beacon: Beacon,
}

/// A packet's start.
#[derive(Clone, Copy, Debug)]
pub struct Emitted {
    /// Where it leaves.
    pub place: Place,
    /// Its unit direction.
    pub direction: DVec3,
    /// Light of sky and sun: where it comes from. Without a free way from there it is none.
    pub behind: Option<Place>,
    /// Light of sky and sun counts from here as far as this, in m, until it is scattered; beyond it is another emitter's.
    pub reach_m: f64,
}

impl Emitted {
    /// A packet that is there, whatever lies about.
    fn new(place: Place, direction: DVec3) -> Emitted {
        Emitted { place, direction, behind: None, reach_m: f64::INFINITY }
    }
}

/// One point of an emitter, drawn for a receiver, and what the emitter brings there if that point is in sight.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Illuminance in lx if nothing stands between.
    pub unshadowed_lx: f64,
    /// The point, to which a shadow ray goes; `None` where rounding leaves none, so little of the emitter is above the horizon.
    pub place: Option<Place>,
}

/// An emitter as one place sees it.
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

/// Cosine law and inverse square at a point: E/I.
#[inline]
fn cosine_per_square(offset: DVec3, normal: DVec3) -> f64 {
    let distance_squared = offset.length_squared();
    let height = offset.dot(normal);
    if height <= 0.0 { 0.0 } else { height / (distance_squared * distance_squared.sqrt()) }
}

impl Emitter {
    /// Whether no ray can meet it: a point, or an opening or a ring, which is no obstacle. Light samples alone find what it brings.
    pub fn is_met_by_no_ray(&self) -> bool {
        of_light!(&self.shape, light => light.is_met_by_no_ray())
    }

    /// Whether it is one point: every look from one place then says the same.
    pub fn is_single_point(&self) -> bool {
        self.is_met_by_no_ray() && !self.has_opening()
    }

    /// Whether any part of it lies within a distance of a point, in m.
    pub fn is_within(&self, point_m: DVec3, distance_m: f64) -> bool {
        if !of_light!(&self.shape, light => light.is_placed()) {
            return false;
        }
        let reach_m = distance_m + self.beacon.radius_m;
        self.beacon.center_m.distance_squared(point_m) < reach_m * reach_m
    }

    /// Its middle in m; of the sky some place.
    pub fn center_m(&self) -> DVec3 {
        self.beacon.center_m
    }

    /// Whether it is a ball.
    pub fn is_ball(&self) -> bool {
        matches!(self.shape, EmitterShape::Ball(_))
    }

    /// The side of a triangle that it is.
    fn side(&self) -> Option<(u32, Side)> {
        of_light!(&self.shape, light => light.side())
    }

    /// The sky that it is, or is a part of.
    fn sky(&self) -> Option<&Sky> {
        of_light!(&self.shape, light => light.sky())
    }

    /// The sun that it is.
    fn sun(&self) -> Option<&Sun> {
        of_light!(&self.shape, light => light.sun())
    }

    /// Whether it is the sun, or the sky, or what an opening shows of it.
    pub fn is_far(&self) -> bool {
        self.sky().is_some() || self.is_sun()
    }

    /// Whether it is the sun.
    pub fn is_sun(&self) -> bool {
        self.sun().is_some()
    }

    /// Cosine between a triangle's emitting side and a unit direction, 0 behind it; 0 for the others.
    pub fn cosine_towards(&self, direction: DVec3) -> f64 {
        of_light!(&self.shape, light => light.cosine_towards(direction))
    }

    /// Whether it emits from many points that no ray meets: a photometric opening with an extent, or a ring.
    pub fn has_opening(&self) -> bool {
        of_light!(&self.shape, light => light.has_opening())
    }

    /// A point of an emitter without a body: its only one, one of its opening or of its ring; `None` for the others.
    #[inline]
    pub fn draw_point(&self, stream: &mut Stream) -> Option<OpeningPoint> {
        of_light!(&self.shape, light => light.draw_point(stream))
    }

    /// A point of an emitter without a body for the geometry; a directed one belongs to the side it aims at.
    #[inline]
    pub fn place_of_point(&self, point_m: DVec3) -> Place {
        of_light!(&self.shape, light => light.place_of_point(point_m))
    }

    /// Intensity in cd of an emitter without a body towards a unit direction; 0 for the others, which have none.
    pub fn intensity_cd(&self, direction: DVec3) -> f64 {
        of_light!(&self.shape, light => light.intensity_cd(direction))
    }

    /// Intensity in cd that one of its points stands for, if [`Emitter::draw_point`] drew it: the mean over all points is `intensity_cd`,
    /// but a point of a solid opening shines only to where its face looks.
    pub fn intensity_from_cd(&self, point: &OpeningPoint, direction: DVec3) -> f64 {
        let share = of_light!(&self.shape, light => light.share_from(point, direction));
        if share > 0.0 { share * self.intensity_cd(direction) } else { 0.0 }
    }

    /// Draws a packet in proportion to the flux that leaves.
    pub fn emit(&self, stream: &mut Stream) -> Emitted {
        of_light!(&self.shape, light => light.emit(stream))
    }

    /// Intensity in cd that it sends in a unit direction as seen from afar, with one of the points that this comes from; `None` where
    /// it sends nothing there, and for the sky, which lies afar itself.
    pub fn seen_from_afar(&self, direction: DVec3, stream: &mut Stream) -> Option<(f64, Place)> {
        of_light!(&self.shape, light => light.seen_from_afar(direction, stream))
            .filter(|(intensity_cd, _)| *intensity_cd > 0.0)
    }

    /// A point of a triangle by two variates in [0, 1), of a ball on the disk that a place sees of it; `None` for
    /// point-like emitters, and for a ball with the place inside.
    pub fn point_seen_from(&self, place_m: DVec3, variates: [f64; 2]) -> Option<Place> {
        of_light!(&self.shape, light => light.point_seen_from(place_m, variates))
    }

    /// Illuminance in lx at a point with a unit normal, as if nothing stood between: exact, but for an opening with an
    /// extent, which counts as its centre, and the sky, of which openings show the part in their middle (their looks know better).
    pub fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        of_light!(&self.shape, light => light.unshadowed_lx(point_m, normal))
    }

    /// A cheap stand-in for [`Emitter::unshadowed_lx`], 0 only where that is 0: its share decides how often the
    /// emitter is looked at.
    #[inline]
    pub fn importance(&self, point_m: DVec3, normal: DVec3) -> f64 {
        self.beacon.importance(point_m, normal)
    }

    /// One look at the emitter from a point with a unit normal; `None` where it brings nothing.
    ///
    /// The point looked at is drawn in proportion to what it brings there unshadowed: the estimate of the illuminance
    /// is what the look says times visibility.
    pub fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        of_light!(&self.shape, light => light.light_sample(point_m, normal, stream))
    }

    /// The emitter as a point with a unit normal sees it: where many looks follow, what they share is found but once.
    pub fn view(&self, point_m: DVec3, normal: DVec3) -> EmitterView<'_> {
        let triangle = of_light!(&self.shape, light => light.triangle_view(point_m, normal));
        EmitterView { emitter: self, point_m, normal, triangle }
    }

    /// A look that takes less time and has more chance, for the vertices of walks: what one of many emitters, one of many
    /// walks and its visibility bring by chance is far more.
    ///
    /// A far triangle's point is drawn by area; all else is looked at as ever.
    #[inline]
    pub fn cheap_light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        of_light!(&self.shape, light => light.cheap_light_sample(point_m, normal, stream))
    }

    /// Exitance in lm/m² of an emitter that rays can meet; `None` for points, openings and rings, which light samples alone
    /// find, and for sky and sun.
    pub fn exitance_lm_m2(&self) -> Option<f64> {
        of_light!(&self.shape, light => light.exitance_lm_m2())
    }
}
