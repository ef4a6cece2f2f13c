//! Luminaires as the chain and the estimators see them: a flat list of emitting points, triangles and balls.
//!
//! Every emitter has its four faces here: `emit` draws a packet in proportion to what leaves it, `draw_towards` draws
//! the point of it that a receiver sees in proportion to what it brings there, `unshadowed_lx` is the exact value of
//! what it brings where nothing stands between, and `luminous_flux_lm` its total.

mod seen;

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use super::emitter_tree::{Cut, EmitterTree};
use super::importance::{Beacon, Profile};
use super::opening::Aperture;
use super::random::Stream;
use super::triangle::SeenTriangle;
use super::warp::{cosine_hemisphere, uniform_cone, uniform_sphere, uniform_triangle};
use super::web::WebSampler;
use crate::base::ball::ball_illuminance_factor;
use crate::base::polygon::triangle_illuminance_factor;
use crate::scene::photometry::IntensityWeb;
use crate::scene::{Emission, Scene, Side};

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

/// One emitting point, triangle side or ball.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// The luminaire it belongs to.
    pub luminaire: u32,
    /// Maintained flux in lm.
    pub luminous_flux_lm: f64,
    shape: Shape,
    beacon: Beacon,
}

#[derive(Clone, Debug)]
enum Shape {
    Isotropic { position_m: DVec3, intensity_cd: f64 },
    Lambertian { position_m: DVec3, axis: DVec3, intensity_cd: f64 },
    Web(WebEmitter),
    Triangle(TriangleEmitter),
    Ball { center_m: DVec3, radius_m: f64, exitance_lm_m2: f64 },
}

#[derive(Clone, Debug)]
struct WebEmitter {
    position_m: DVec3,
    frame: [DVec3; 3],
    web: Arc<IntensityWeb>,
    sampler: Arc<WebSampler>,
    profile: Profile,
    scale: f64,
    /// The luminous opening, where it has an extent.
    aperture: Option<Arc<Aperture>>,
}

impl WebEmitter {
    fn intensity_cd(&self, direction: DVec3) -> f64 {
        self.scale * self.web.intensity_towards_cd(&self.frame, direction)
    }

    #[inline]
    fn draw_point(&self, stream: &mut Stream) -> DVec3 {
        self.aperture.as_ref().map_or(self.position_m, |aperture| aperture.draw(stream))
    }
}

#[derive(Clone, Copy, Debug)]
struct TriangleEmitter {
    triangle: u32,
    side: Side,
    /// Counter-clockwise as seen from the emitting side.
    corners_m: [DVec3; 3],
    normal: DVec3,
    centroid_m: DVec3,
    radius_m: f64,
    area_m2: f64,
    exitance_lm_m2: f64,
}

/// A packet's start.
#[derive(Clone, Copy, Debug)]
pub struct Emitted {
    /// Where it leaves.
    pub place: Place,
    /// Its unit direction.
    pub direction: DVec3,
}

/// What a receiver sees of an emitter in one look.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Illuminance in lx if nothing stands between.
    pub unshadowed_lx: f64,
    /// The point looked at; `None` where numbers cannot tell one, so little of the emitter is above the horizon.
    pub place: Option<Place>,
}

/// All emitters of a scene that give light.
#[derive(Clone, Debug)]
pub struct Emitters {
    list: Vec<Emitter>,
    /// Emitting sides of triangles with their emitters, in order.
    on_surfaces: Vec<((u32, Side), u32)>,
    /// Flux of all emitters up to and including each, in lm.
    cumulative_flux_lm: Vec<f64>,
    tree: Option<EmitterTree>,
}

impl Emitters {
    /// Lists the emitters of a scene; luminaires without flux have none.
    pub fn of(scene: &Scene) -> Emitters {
        let mut list = Vec::new();
        // Luminaires of one array share their distribution and what is made of it.
        let mut webs: HashMap<*const IntensityWeb, (Arc<WebSampler>, Profile)> = HashMap::new();
        for (luminaire, source) in scene.luminaires.iter().enumerate() {
            let luminaire = luminaire as u32;
            let mut push = |luminous_flux_lm: f64, shape: Shape| {
                if luminous_flux_lm > 0.0 {
                    let beacon = shape.beacon();
                    list.push(Emitter { luminaire, luminous_flux_lm, shape, beacon });
                }
            };
            match &source.emission {
                Emission::Isotropic { position_m, intensity_cd } => push(
                    source.luminous_flux_lm,
                    Shape::Isotropic { position_m: *position_m, intensity_cd: *intensity_cd },
                ),
                Emission::Lambertian { position_m, axis, intensity_cd } => push(
                    source.luminous_flux_lm,
                    Shape::Lambertian { position_m: *position_m, axis: *axis, intensity_cd: *intensity_cd },
                ),
                Emission::Photometric { position_m, frame, web, opening, scale } => {
                    let (sampler, profile) = webs
                        .entry(Arc::as_ptr(web))
                        .or_insert_with(|| (Arc::new(WebSampler::new(web)), Profile::of(web)))
                        .clone();
                    let (web, aperture) = (web.clone(), Aperture::new(opening, *position_m, frame).map(Arc::new));
                    let (position_m, frame, scale) = (*position_m, *frame, *scale);
                    let emitter = WebEmitter { position_m, frame, web, sampler, profile, scale, aperture };
                    push(source.luminous_flux_lm, Shape::Web(emitter));
                }
                Emission::Sphere { center_m, radius_m, exitance_lm_m2 } => push(
                    source.luminous_flux_lm,
                    Shape::Ball { center_m: *center_m, radius_m: *radius_m, exitance_lm_m2: *exitance_lm_m2 },
                ),
                Emission::Area { surfaces, front, back, exitance_lm_m2 } => {
                    let sides = [(Side::Front, *front), (Side::Back, *back)];
                    for surface in surfaces {
                        for triangle in scene.surfaces[*surface as usize].triangles.clone() {
                            for (side, _) in sides.iter().filter(|(_, emits)| *emits) {
                                let emitter = TriangleEmitter::new(scene, triangle, *side, *exitance_lm_m2);
                                push(scene.triangle_area_m2(triangle) * exitance_lm_m2, Shape::Triangle(emitter));
                            }
                        }
                    }
                }
            }
        }
        let cumulative_flux_lm = list
            .iter()
            .scan(0.0, |sum, emitter: &Emitter| {
                *sum += emitter.luminous_flux_lm;
                Some(*sum)
            })
            .collect();
        let beacons: Vec<&Beacon> = list.iter().map(|emitter| &emitter.beacon).collect();
        let tree = EmitterTree::of(&beacons);
        let mut on_surfaces: Vec<((u32, Side), u32)> = list
            .iter()
            .enumerate()
            .filter_map(|(index, emitter)| match &emitter.shape {
                Shape::Triangle(triangle) => Some(((triangle.triangle, triangle.side), index as u32)),
                _ => None,
            })
            .collect();
        on_surfaces.sort_unstable();
        Emitters { list, on_surfaces, cumulative_flux_lm, tree }
    }

    /// The point-like emitters by themselves, if there are any.
    pub fn points(&self) -> Option<PointEmitters> {
        let list: Vec<Emitter> = self.list.iter().filter(|emitter| emitter.is_point()).cloned().collect();
        let beacons: Vec<&Beacon> = list.iter().map(|emitter| &emitter.beacon).collect();
        let tree = EmitterTree::of(&beacons)?;
        Some(PointEmitters { list, tree })
    }

    /// Numbers of the emitters on a side of a triangle.
    pub fn on_surface(&self, triangle: u32, side: Side) -> impl Iterator<Item = u32> + '_ {
        let first = self.on_surfaces.partition_point(|(place, _)| *place < (triangle, side));
        let here = self.on_surfaces[first..].iter().take_while(move |(place, _)| *place == (triangle, side));
        here.map(|(_, emitter)| *emitter)
    }

    /// Number of the emitter that is a luminaire's ball.
    pub fn of_ball(&self, luminaire: u32) -> Option<u32> {
        let first = self.list.partition_point(|emitter| emitter.luminaire < luminaire);
        self.list.get(first).filter(|emitter| emitter.luminaire == luminaire).map(|_| first as u32)
    }

    /// Probability with which [`Emitters::choose_for`] chooses an emitter.
    pub fn probability_for(&self, emitter: u32, point_m: DVec3, normal: DVec3, cut: &mut Cut) -> f64 {
        self.tree.as_ref().map_or(0.0, |tree| tree.probability(emitter, point_m, normal, cut))
    }

    /// The emitters.
    pub fn list(&self) -> &[Emitter] {
        &self.list
    }

    /// Flux of all emitters in lm.
    pub fn luminous_flux_lm(&self) -> f64 {
        self.cumulative_flux_lm.last().copied().unwrap_or(0.0)
    }

    /// Chooses one emitter for a point with a unit normal, about in proportion to what it brings there; returns it with
    /// the probability of the choice. `None`: this choice brings nothing.
    pub fn choose_for(&self, point_m: DVec3, normal: DVec3, variate: f64, cut: &mut Cut) -> Option<(&Emitter, f64)> {
        let (emitter, probability) = self.tree.as_ref()?.choose(point_m, normal, variate, cut)?;
        Some((&self.list[emitter as usize], probability))
    }

    /// Draws a packet: the emitter in proportion to flux by `choice` in [0, 1), then its point and direction.
    pub fn emit(&self, choice: f64, stream: &mut Stream) -> Emitted {
        let aim = choice * self.luminous_flux_lm();
        let index = self.cumulative_flux_lm.partition_point(|sum| *sum <= aim).min(self.list.len() - 1);
        self.list[index].emit(stream)
    }
}

/// The emitters that are points.
#[derive(Clone, Debug)]
pub struct PointEmitters {
    list: Vec<Emitter>,
    tree: EmitterTree,
}

/// A point of a point-like emitter.
#[derive(Clone, Copy, Debug)]
pub struct PointLook<'a> {
    /// The emitter.
    pub emitter: &'a Emitter,
    /// The point in m.
    pub position_m: DVec3,
    /// The same for the geometry.
    pub place: Place,
}

impl PointEmitters {
    /// Chooses a point-like emitter as [`Emitters::choose_for`] does, and a point of it; returns both with the
    /// probability of the choice.
    pub fn choose(
        &self,
        point_m: DVec3,
        normal: DVec3,
        variate: f64,
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> Option<(PointLook<'_>, f64)> {
        let (index, probability) = self.tree.choose(point_m, normal, variate, cut)?;
        let emitter = &self.list[index as usize];
        let position_m = emitter.draw_point(stream)?;
        Some((PointLook { emitter, position_m, place: emitter.place_of_point(position_m) }, probability))
    }
}

impl Shape {
    fn beacon(&self) -> Beacon {
        let point = |position_m: &DVec3, axis: DVec3, intensity_cd: f64, profile: Profile| Beacon {
            center_m: *position_m,
            radius_m: 0.0,
            axis,
            intensity_cd,
            profile,
        };
        match self {
            Shape::Isotropic { position_m, intensity_cd } => {
                point(position_m, DVec3::Z, *intensity_cd, Profile::Uniform)
            }
            Shape::Lambertian { position_m, axis, intensity_cd } => {
                point(position_m, *axis, *intensity_cd, Profile::Cosine)
            }
            Shape::Web(web) => Beacon {
                center_m: web.position_m,
                radius_m: web.aperture.as_ref().map_or(0.0, |aperture| aperture.radius_m()),
                axis: web.frame[2],
                intensity_cd: web.scale,
                profile: web.profile.clone(),
            },
            Shape::Triangle(triangle) => Beacon {
                center_m: triangle.centroid_m,
                radius_m: triangle.radius_m,
                axis: triangle.normal,
                intensity_cd: triangle.exitance_lm_m2 * triangle.area_m2 / PI,
                profile: Profile::Cosine,
            },
            Shape::Ball { center_m, radius_m, exitance_lm_m2 } => Beacon {
                center_m: *center_m,
                radius_m: *radius_m,
                axis: DVec3::Z,
                intensity_cd: exitance_lm_m2 * radius_m * radius_m,
                profile: Profile::Uniform,
            },
        }
    }
}

impl TriangleEmitter {
    fn new(scene: &Scene, triangle: u32, side: Side, exitance_lm_m2: f64) -> TriangleEmitter {
        let [a, b, c] = scene.corners_m(triangle);
        let corners_m = if side == Side::Front { [a, b, c] } else { [a, c, b] };
        let centroid_m = (a + b + c) / 3.0;
        let radius_m = [a, b, c].iter().map(|corner| corner.distance(centroid_m)).fold(0.0, f64::max);
        let front = scene.triangle_normal(triangle);
        let normal = if side == Side::Front { front } else { -front };
        let area_m2 = scene.triangle_area_m2(triangle);
        TriangleEmitter { triangle, side, corners_m, normal, centroid_m, radius_m, area_m2, exitance_lm_m2 }
    }

    /// The barycentric coordinates of the scene's triangle for those of this one (whose turn depends on the side).
    fn place(&self, [u, v]: [f64; 2]) -> Place {
        let barycentric = if self.side == Side::Front { [u, v] } else { [v, u] };
        Place::Surface { triangle: self.triangle, barycentric, side: self.side }
    }

    fn seen_from(&self, point_m: DVec3) -> [DVec3; 3] {
        self.corners_m.map(|corner| corner - point_m)
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
    /// Whether it is a point, or emits from points that no ray meets.
    pub fn is_point(&self) -> bool {
        !matches!(self.shape, Shape::Triangle(_) | Shape::Ball { .. })
    }

    /// A point of a point-like emitter in m, its only one or one of its opening; `None` for the others.
    #[inline]
    pub fn draw_point(&self, stream: &mut Stream) -> Option<DVec3> {
        match &self.shape {
            Shape::Isotropic { position_m, .. } | Shape::Lambertian { position_m, .. } => Some(*position_m),
            Shape::Web(web) => Some(web.draw_point(stream)),
            Shape::Triangle(_) | Shape::Ball { .. } => None,
        }
    }

    /// A point of a point-like emitter for the geometry; a directed one belongs to the side it aims at.
    #[inline]
    pub fn place_of_point(&self, point_m: DVec3) -> Place {
        match &self.shape {
            Shape::Lambertian { axis, .. } => Place::Sided(point_m, *axis),
            Shape::Web(web) => Place::Sided(point_m, web.frame[2]),
            _ => Place::Free(point_m),
        }
    }

    /// Intensity of a point emitter in cd towards a unit direction; 0 for the others, which have none.
    pub fn intensity_cd(&self, direction: DVec3) -> f64 {
        match &self.shape {
            Shape::Isotropic { intensity_cd, .. } => *intensity_cd,
            Shape::Lambertian { axis, intensity_cd, .. } => intensity_cd * axis.dot(direction).max(0.0),
            Shape::Web(web) => web.intensity_cd(direction),
            Shape::Triangle(_) | Shape::Ball { .. } => 0.0,
        }
    }

    /// Draws a packet in proportion to the flux that leaves.
    pub fn emit(&self, stream: &mut Stream) -> Emitted {
        match &self.shape {
            Shape::Isotropic { position_m, .. } => {
                Emitted { place: Place::Free(*position_m), direction: uniform_sphere(stream.pair()) }
            }
            Shape::Lambertian { position_m, axis, .. } => {
                Emitted { place: Place::Sided(*position_m, *axis), direction: cosine_hemisphere(*axis, stream.pair()) }
            }
            Shape::Web(web) => {
                let local = web.sampler.sample(stream.pair());
                let [c0, c90, axis] = web.frame;
                let direction = c0 * local.x + c90 * local.y + axis * local.z;
                Emitted { place: Place::Sided(web.draw_point(stream), axis), direction }
            }
            Shape::Triangle(triangle) => Emitted {
                place: triangle.place(uniform_triangle(stream.pair())),
                direction: cosine_hemisphere(triangle.normal, stream.pair()),
            },
            Shape::Ball { center_m, radius_m, .. } => {
                let outward = uniform_sphere(stream.pair());
                let place = Place::Ball { luminaire: self.luminaire, position_m: *center_m + outward * *radius_m };
                Emitted { place, direction: cosine_hemisphere(outward, stream.pair()) }
            }
        }
    }

    /// Illuminance in lx at a point with a unit normal, as if nothing stood between: exact, but for an opening with an
    /// extent, which counts as its centre (its looks know better).
    pub fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        match &self.shape {
            Shape::Isotropic { position_m, intensity_cd } => {
                intensity_cd * cosine_per_square(*position_m - point_m, normal)
            }
            Shape::Lambertian { position_m, .. } | Shape::Web(WebEmitter { position_m, .. }) => {
                let geometry = cosine_per_square(*position_m - point_m, normal);
                if geometry == 0.0 {
                    return 0.0;
                }
                self.intensity_cd((point_m - *position_m).normalize()) * geometry
            }
            Shape::Triangle(triangle) => {
                triangle.exitance_lm_m2 * triangle_illuminance_factor(point_m, normal, triangle.corners_m)
            }
            Shape::Ball { center_m, radius_m, exitance_lm_m2 } => {
                let offset = *center_m - point_m;
                let distance = offset.length();
                exitance_lm_m2 * ball_illuminance_factor(offset.dot(normal) / distance, distance / radius_m)
            }
        }
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
    pub fn look(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Look> {
        if let Shape::Web(web) = &self.shape
            && let Some(aperture) = &web.aperture
        {
            let towards = |direction: DVec3| web.intensity_cd(direction);
            let (unshadowed_lx, at_m) = aperture.look(point_m, normal, towards, stream)?;
            return Some(Look { unshadowed_lx, place: Some(self.place_of_point(at_m)) });
        }
        let unshadowed_lx = self.unshadowed_lx(point_m, normal);
        if unshadowed_lx <= 0.0 {
            return None;
        }
        let place = match &self.shape {
            Shape::Triangle(triangle) => {
                let seen = SeenTriangle::new(triangle.seen_from(point_m));
                seen.draw_projected(normal, stream).map(|(_, barycentric)| triangle.place(barycentric))
            }
            Shape::Ball { center_m, radius_m, .. } => {
                draw_ball(self.luminaire, *center_m, *radius_m, point_m, normal, stream)
            }
            Shape::Isotropic { position_m, .. }
            | Shape::Lambertian { position_m, .. }
            | Shape::Web(WebEmitter { position_m, .. }) => Some(self.place_of_point(*position_m)),
        };
        Some(Look { unshadowed_lx, place })
    }

    /// Exitance in lm/m² of an emitter that rays can meet; `None` for points.
    pub fn exitance_lm_m2(&self) -> Option<f64> {
        match &self.shape {
            Shape::Triangle(triangle) => Some(triangle.exitance_lm_m2),
            Shape::Ball { exitance_lm_m2, .. } => Some(*exitance_lm_m2),
            _ => None,
        }
    }
}

/// Draws that thinning by the cosine may take; see [`super::triangle`] for the reasoning.
const MOST_DRAWS: u32 = 2000;

fn draw_ball(
    luminaire: u32,
    center_m: DVec3,
    radius_m: f64,
    point_m: DVec3,
    normal: DVec3,
    stream: &mut Stream,
) -> Option<Place> {
    let offset = center_m - point_m;
    let distance = offset.length();
    let axis = offset / distance;
    let sin_max = radius_m / distance;
    if sin_max >= 1.0 {
        return None;
    }
    // 1 − cos without the cancellation that a far ball would bring.
    let one_minus_cos = sin_max * sin_max / (1.0 + (1.0 - sin_max * sin_max).sqrt());
    let largest = (axis.dot(normal).clamp(-1.0, 1.0).acos() - sin_max.asin()).max(0.0).cos();
    for _ in 0..MOST_DRAWS {
        let direction = uniform_cone(axis, one_minus_cos, stream.pair());
        if stream.unit() * largest < direction.dot(normal) {
            let along = direction.dot(offset);
            let miss_squared = (offset - along * direction).length_squared();
            let reach = along - (radius_m * radius_m - miss_squared).max(0.0).sqrt();
            return Some(Place::Ball { luminaire, position_m: point_m + direction * reach });
        }
    }
    None
}
