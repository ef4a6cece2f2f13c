//! The interface of the geometry: metres and f64 outside, the scaled f32 coordinates inside.

use std::sync::Arc;

use glam::{DVec3, Vec3, Vec3A};
use serde::{Deserialize, Serialize};

use super::ball::Ball;
use super::body::LocalBody;
use super::clear_boxes::ClearBoxes;
use super::frame::Frame;
use super::hull::Hull;
use super::origin::{Anchor, LIFT, Origin, PULL, RESOLUTION, pull_in};
use super::tree::{Found, Tree};
use super::triangle::{Ray, Slot};
use crate::scene::{Scene, Side, body_of};

/// Upper limit of a corner's least weight for pulling points off the edges, so that small triangles do not shrink to a point.
const LARGEST_PULL: f64 = 0.25;

/// Factors by which a point is pulled further off the edges if a ray from it found nothing.
const SECOND_TRIES: [f32; 2] = [16.0, 256.0];

/// Distances by which a point is moved aside, in scaled coordinates, if a ray from it met a back. A solid that stands on a surface without
/// sharing its vertices leaves a crack of about 2⁻²⁴ below its edge. A flat ray may have entered the solid this far through the crack.
const STEPS_ASIDE: [f64; 3] = [4.0 * PULL, 32.0 * PULL, 256.0 * PULL];

/// Share of a corner below which a crossing may lie on an edge. For triangles with heights of at least 2⁻⁹, rounding (2⁻²³) stays below it.
const EDGE_SHARE: f32 = 1.0 / (1u32 << 14) as f32;

/// Distance in scaled coordinates within which rounding may have exchanged two fronts, one of them seen edge-on.
const LONGEST_EXCHANGE: f32 = 1.0 / (1u32 << 14) as f32;

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceHit {
    /// Number of the triangle in the scene.
    pub triangle: u32,
    /// Weights of its second and third corner, 0 to 1.
    pub barycentric: [f64; 2],
    /// The side that the ray came from.
    pub side: Side,
    /// Distance from the ray's origin in m, 0 or more.
    pub distance_m: f64,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meeting {
    /// A triangle.
    Surface(SurfaceHit),
    /// The ball of the luminaire with this number in the scene, a [`crate::scene::Emission::Sphere`].
    Ball(u32),
    /// Nothing: the ray leaves the scene.
    Nothing,
}

/// The data of a triangle that a surface origin needs.
#[derive(Clone, Copy, Debug)]
struct Footing {
    /// A slot of the triangle in the tree.
    slot: u32,
    /// Unit normal of the front.
    normal: Vec3,
    /// Least weights of the corners that keep a point off the edges.
    least: Vec3,
    /// Whether its back counts as a side like its front.
    two_sided: bool,
}

/// Finds what rays meet among the triangles and balls of one scene.
///
/// It is built once and shared between threads. A closed room of triangles that share their vertices has no leaks: no ray escapes through
/// its edges and corners, and none meets a back. Answers do not depend on the processor's vector instructions, nor on the order in which
/// the tree is walked.
///
/// Accuracy: [`Tracer::position_accuracy_m`].
pub struct Tracer {
    frame: Frame,
    pub(super) tree: Tree,
    /// The planes of a convex scene, in which nothing can stand between two points.
    pub(super) hull: Option<Hull>,
    /// Boxes of any other scene in which nothing stands between two points, once they are found.
    pub(super) clear: ClearBoxes,
    footings: Vec<Footing>,
    /// Index of each luminaire's ball in the tree's list.
    balls: Vec<Option<u32>>,
}

/// Returns [`Tracer::position_accuracy_m`] of a scene's tracer without building the tracer.
pub fn position_accuracy_m(scene: &Scene) -> f64 {
    position_accuracy_in_m(Frame::of(scene))
}

fn position_accuracy_in_m(frame: Frame) -> f64 {
    frame.metres(LIFT + 2.0 * RESOLUTION)
}

impl Tracer {
    /// Builds the tree of a scene's triangles and of the balls among its luminaires. The balls are black and opaque, and rays meet them
    /// exactly.
    pub fn new(scene: &Scene) -> Tracer {
        let frame = Frame::of(scene);
        let mut balls = Vec::new();
        let mut balls_of_luminaires = Vec::with_capacity(scene.luminaires.len());
        for (index, luminaire) in scene.luminaires.iter().enumerate() {
            let Some((center_m, radius_m)) = luminaire.emission.black_ball_m() else {
                balls_of_luminaires.push(None);
                continue;
            };
            balls_of_luminaires.push(Some(balls.len() as u32));
            let (center, radius) = (frame.to_local(center_m), frame.length(radius_m));
            balls.push(Ball { center, radius, luminaire: index as u32 });
        }
        let round = |vertex: u32| frame.round(scene.vertices_m[vertex as usize]);
        let corners = |triangle: u32| scene.triangles[triangle as usize].map(round);
        let bodies = scene.bodies.iter().map(|body| LocalBody { body: Arc::clone(body), frame }).collect();
        let tree = Tree::new(scene.triangles.len() as u32, corners, balls, bodies);
        let mut footings =
            vec![Footing { slot: 0, normal: Vec3::ZERO, least: Vec3::ZERO, two_sided: false }; scene.triangles.len()];
        for (slot, primitive) in tree.slots() {
            if let Some(footing) = footings.get_mut(primitive as usize) {
                *footing = footing_of(slot as u32, tree.slot(slot), scene.surface_of(primitive).two_sided);
            }
        }
        let hull = Hull::of(&tree);
        Tracer { frame, tree, hull, clear: ClearBoxes::default(), footings, balls: balls_of_luminaires }
    }

    /// Finds boxes in which nothing stands between two points, so that no ray is traced between them. `sight_lines` holds the ends of rays
    /// that show where light passes; the first few of them visit all parts of the scene.
    pub fn find_clear_boxes(&mut self, sight_lines: Vec<[Origin; 2]>) {
        if self.hull.is_none() {
            self.clear = ClearBoxes::of(&self.tree, sight_lines);
        }
    }

    /// Makes an origin in free space, for example a point luminaire or an observer.
    pub fn free_origin(&self, point_m: DVec3) -> Origin {
        Origin { point: self.frame.round(point_m).into(), normal: Vec3::ZERO, anchor: Anchor::Free }
    }

    /// Makes an origin for a receiver or luminaire that may lie on a surface. It belongs to the side that its unit normal points to, and
    /// the surface that it lies on does not shadow it.
    pub fn side_origin(&self, point_m: DVec3, normal: DVec3) -> Origin {
        Origin::lifted(self.frame.to_local(point_m), normal, Anchor::Side)
    }

    /// Makes an origin at a point of a triangle, given by the weights of its second and third corner, on one of its sides. The point is a
    /// hit or a sampled point of an element or area luminaire.
    ///
    /// The point is lifted off its surface and pulled off the edges of its triangle by some millionths of the scene's size
    /// ([`Tracer::position_accuracy_m`]).
    #[inline]
    pub fn surface_origin(&self, triangle: u32, barycentric: [f64; 2], side: Side) -> Origin {
        self.surface_origin_pulled(triangle, barycentric, side, 1.0)
    }

    /// Makes an origin at a point of a luminaire's ball, on its outside.
    ///
    /// The luminaire must be a [`crate::scene::Emission::Sphere`]; for any other kind the point counts as free.
    pub fn ball_origin(&self, luminaire: u32, point_m: DVec3) -> Origin {
        let Some(ball) = self.balls.get(luminaire as usize).copied().flatten() else {
            return self.free_origin(point_m);
        };
        let point = self.frame.to_local(point_m);
        let normal = (point - self.tree.balls[ball as usize].center).normalize_or_zero();
        Origin::lifted(point, normal, Anchor::Ball { luminaire })
    }

    /// Returns what a ray with this unit direction meets first. There is no smallest distance: a wall that nearly touches the origin stops
    /// the ray.
    ///
    /// The direction must leave the side that the origin lies on. The ray never meets the origin's own triangle.
    #[inline]
    pub fn first_hit(&self, origin: &Origin, direction: DVec3) -> Meeting {
        let along = direction.as_vec3a();
        let ray = Ray::new(origin.point, along);
        match self.tree.closest(&ray, origin) {
            Some(found) if self.is_plain(&found) => self.meeting(&found),
            Some(_) => self.settle(&ray, origin),
            None => self.hit_from_further_in(origin, along),
        }
    }

    /// Returns the same as `first_hit`, but never tries again from beside the origin. If the ray leaves the surface inside a solid that
    /// goes through this surface, the ray meets the inside of the solid. It is not treated as a ray that slipped below the solid's edge.
    #[inline]
    pub fn first_hit_from_there(&self, origin: &Origin, direction: DVec3) -> Meeting {
        let ray = Ray::new(origin.point, direction.as_vec3a());
        self.tree.closest(&ray, origin).map_or_else(|| self.first_hit(origin, direction), |found| self.meeting(&found))
    }

    /// Returns a triangle whose front touches the surface at the origin's position: that of a solid that stands on it, or that of another
    /// room's wall in the same plane.
    pub fn pressing_triangle(&self, origin: &Origin) -> Option<u32> {
        self.tree.pressed(&Ray::new(origin.point, origin.normal.into()), origin).map(|found| found.primitive)
    }

    /// Whether anything stands between two origins. In a convex scene no ray is needed.
    #[inline]
    pub fn is_occluded(&self, from: &Origin, to: &Origin) -> bool {
        let difference = to.point - from.point;
        if difference == Vec3A::ZERO {
            return false;
        }
        from.has_below(difference)
            || to.has_below(-difference)
            || !self.is_within_hull(from, to)
                && !self.clear.hold(from, to)
                && self.tree.blocks(&Ray::new(from.point, difference), from, to)
    }

    /// Whether both origins lie inside a convex scene.
    #[inline]
    fn is_within_hull(&self, from: &Origin, to: &Origin) -> bool {
        self.hull.as_ref().is_some_and(|hull| hull.holds(from) && hull.holds(to))
    }

    /// Whether anything stands within a distance along a unit direction. The far end is a point in free space.
    #[inline]
    pub fn is_occluded_towards(&self, from: &Origin, direction: DVec3, distance_m: f64) -> bool {
        let difference = direction * self.frame.length(distance_m);
        let end = from.point.as_dvec3() + difference;
        let to = Origin { point: end.as_vec3a(), normal: Vec3::ZERO, anchor: Anchor::Free };
        let along = difference.as_vec3a();
        along != Vec3A::ZERO && (from.has_below(along) || self.tree.blocks(&Ray::new(from.point, along), from, &to))
    }

    /// Returns the position of an origin in m, as rounded to f32.
    #[inline]
    pub fn position_m(&self, origin: &Origin) -> DVec3 {
        self.frame.to_metres(origin.point.as_dvec3())
    }

    /// Returns the position accuracy of f32 in m. Points are rounded, lifted and distinguished from a surface within this length, so wider
    /// gaps are seen. (Next to edges a surface point moves within its surface by up to eight times this length, and more in sharp corners.)
    pub fn position_accuracy_m(&self) -> f64 {
        position_accuracy_in_m(self.frame)
    }

    /// Returns the corners of a cube that contains the scene, in m.
    pub fn bounds_m(&self) -> [DVec3; 2] {
        [-1.0, 1.0].map(|corner| self.frame.to_metres(DVec3::splat(corner)))
    }

    /// Returns an upper bound of the distance between two points of the scene, in m.
    pub fn longest_m(&self) -> f64 {
        self.frame.metres(12f64.sqrt())
    }

    /// Converts a length of the tracer's coordinates to m.
    pub(super) fn metres(&self, length: f64) -> f64 {
        self.frame.metres(length)
    }

    #[inline]
    fn surface_origin_pulled(&self, triangle: u32, barycentric: [f64; 2], side: Side, times: f32) -> Origin {
        let barycentric_f32 = [barycentric[0] as f32, barycentric[1] as f32];
        let anchor = Anchor::Triangle { triangle, side, barycentric: barycentric_f32 };
        if let Some(of) = body_of(&self.tree.bodies, triangle) {
            let (place_m, front) = of.body.place(triangle, barycentric);
            let normal = if side == Side::Front { front } else { -front };
            return Origin::lifted(self.frame.to_local(place_m), normal, anchor);
        }
        let footing = &self.footings[triangle as usize];
        let least = (footing.least * times).min(Vec3::splat(LARGEST_PULL as f32));
        let [second, third] = pull_in(barycentric, least);
        let [a, b, c] = self.tree.slot(footing.slot as usize).corners();
        let point = a + second * (b - a) + third * (c - a);
        let normal = match side {
            Side::Front => footing.normal,
            Side::Back => -footing.normal,
        };
        Origin::lifted(point, normal.as_dvec3(), anchor)
    }

    #[inline]
    fn meeting(&self, found: &Found) -> Meeting {
        if let Some(luminaire) = self.tree.luminaire(found.primitive) {
            return Meeting::Ball(luminaire);
        }
        let crossing = &found.crossing;
        if let Some(of) = self.tree.body(found.primitive) {
            let (triangle, barycentric) = of.body.leaf_at(crossing.weights.as_dvec3().normalize());
            let side = if crossing.sum > 0.0 { Side::Front } else { Side::Back };
            let distance_m = self.frame.metres(f64::from(crossing.t.max(0.0)));
            return Meeting::Surface(SurfaceHit { triangle, barycentric, side, distance_m });
        }
        let share = |weight: f32| f64::from(weight) / f64::from(crossing.sum);
        Meeting::Surface(SurfaceHit {
            triangle: found.primitive,
            barycentric: [share(crossing.weights.y), share(crossing.weights.z)],
            side: if crossing.sum > 0.0 { Side::Front } else { Side::Back },
            distance_m: self.frame.metres(f64::from(crossing.t.max(0.0))),
        })
    }

    /// Whether a ray met a ball, a front, or the back of a two-sided surface.
    #[inline]
    fn is_side(&self, found: &Found) -> bool {
        found.crossing.sum > 0.0 || self.footings.get(found.primitive as usize).is_none_or(|footing| footing.two_sided)
    }

    /// Whether a crossing is certain: it lies off the edges and is not a one-sided back.
    #[inline]
    fn is_plain(&self, found: &Found) -> bool {
        let crossing = &found.crossing;
        if self.tree.body(found.primitive).is_some() {
            return true;
        }
        let shares = crossing.weights.abs();
        shares.min_element() >= EDGE_SHARE * crossing.sum.abs() && self.is_side(found)
    }

    /// Decides which triangle a ray meets first where several cross it within rounding, for example at edges. A front goes before a back,
    /// but a front on the far side of a back does not.
    #[cold]
    fn settle(&self, ray: &Ray, origin: &Origin) -> Meeting {
        // The rounding of a height moves the crossing more for a flatter ray. Balls are exact.
        let noise = |one: &Found| {
            let cosine = |footing: &Footing| ray.direction.dot(footing.normal.into()).abs().max(RESOLUTION as f32);
            RESOLUTION as f32 / self.footings.get(one.primitive as usize).map_or(1.0, cosine)
        };
        let mut all = self.tree.crossings(ray, origin);
        all.sort_by(|one, other| {
            one.crossing.rank().total_cmp(&other.crossing.rank()).then(one.primitive.cmp(&other.primitive))
        });
        let Some(nearest) = all.first().copied() else {
            return self.hit_from_further_in(origin, ray.direction);
        };
        let tied = |one: &&Found| (one.crossing.t - nearest.crossing.t).abs() <= noise(one) + noise(&nearest);
        let (fronts, backs): (Vec<&Found>, Vec<&Found>) =
            all.iter().filter(tied).partition(|one| one.crossing.sum >= 0.0);
        let on_this_side = |front: &&&Found| !backs.iter().any(|back| self.is_beyond(front, back));
        if let Some(first) = fronts.iter().find(on_this_side).or(fronts.first()) {
            // The distance to a front seen edge-on is inaccurate, so a steeper front beside it goes first.
            let beside = |front: &&&Found| (front.crossing.t - first.crossing.t).abs() <= LONGEST_EXCHANGE;
            let steepest = fronts.iter().filter(on_this_side).filter(beside);
            let steepest = steepest.min_by(|one, other| noise(one).total_cmp(&noise(other)));
            return self.meeting(steepest.unwrap_or(first));
        }
        if self.is_side(&nearest) {
            self.meeting(&nearest)
        } else {
            self.hit_from_aside(origin, ray.direction, &nearest)
        }
    }

    /// Whether a triangle lies wholly in front of another's plane.
    fn is_beyond(&self, one: &Found, other: &Found) -> bool {
        let footing = |found: &Found| self.footings.get(found.primitive as usize);
        let (Some(one), Some(other)) = (footing(one), footing(other)) else {
            return false;
        };
        let [base, ..] = self.tree.slot(other.slot as usize).corners();
        let heights =
            self.tree.slot(one.slot as usize).corners().map(|corner| other.normal.as_dvec3().dot(corner - base));
        heights.iter().all(|height| *height > -RESOLUTION) && heights.iter().any(|height| *height > RESOLUTION)
    }

    /// Repeats a ray that found nothing. It may have started in a corner too tight for f32. If its origin lies near an edge of its
    /// triangle, it is traced again from further inside the triangle.
    #[cold]
    fn hit_from_further_in(&self, origin: &Origin, along: Vec3A) -> Meeting {
        let Anchor::Triangle { triangle, side, barycentric } = origin.anchor else {
            return Meeting::Nothing;
        };
        let barycentric = barycentric.map(f64::from);
        for times in SECOND_TRIES {
            let further_in = self.surface_origin_pulled(triangle, barycentric, side, times);
            if further_in.point == origin.point {
                continue;
            }
            if let Some(found) = self.tree.closest(&Ray::new(further_in.point, along), &further_in) {
                return self.meeting(&found);
            }
        }
        self.tree.pressed(&Ray::new(origin.point, along), origin).map_or(Meeting::Nothing, |found| self.meeting(&found))
    }

    /// Repeats a ray from a surface that met the back of a one-sided surface. It may have started in the crack below a solid that stands
    /// there. It is traced again from points around its origin, in search of a front.
    #[cold]
    fn hit_from_aside(&self, origin: &Origin, along: Vec3A, found: &Found) -> Meeting {
        let Anchor::Triangle { .. } = origin.anchor else {
            return self.meeting(found);
        };
        let (first, second) = origin.normal.as_dvec3().any_orthonormal_pair();
        for step in STEPS_ASIDE {
            for aside in [first, second, -first, -second] {
                let point = (origin.point.as_dvec3() + step * aside).as_vec3a();
                let beside = Origin { point, ..*origin };
                let again = self.tree.closest(&Ray::new(point, along), &beside);
                if let Some(again) = again.filter(|again| self.is_side(again)) {
                    return self.meeting(&again);
                }
            }
        }
        // Deep in a crack, light goes back and forth between the two surfaces until they absorb it.
        match self.tree.pressed(&Ray::new(origin.point, along), origin) {
            Some(pressed) => self.meeting(&pressed),
            None => self.meeting(found),
        }
    }
}

fn footing_of(slot: u32, corners: Slot, two_sided: bool) -> Footing {
    let [a, b, c] = corners.corners();
    let twice_area_vector = (b - a).cross(c - a);
    // The weight of a corner is the height above the opposite edge, divided by the height of the corner.
    let edges = DVec3::new(b.distance(c), c.distance(a), a.distance(b));
    let least = PULL * edges / twice_area_vector.length().max(f64::MIN_POSITIVE);
    Footing {
        slot,
        normal: twice_area_vector.normalize_or_zero().as_vec3(),
        least: least.min(DVec3::splat(LARGEST_PULL)).as_vec3(),
        two_sided,
    }
}
