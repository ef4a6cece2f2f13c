//! Beams of light paths over flat mirrors: the choice of the next facet, with an exactly known probability.
//!
//! All paths from a point over a given sequence of facets seem to come from one point, the image of the first point. In unfolded space they
//! fill a cone that each facet cuts in turn. The next facet is chosen in proportion to the solid angle of the part of it inside the cone.
//! Impossible sequences are therefore never chosen. The probability of a long sequence is about in proportion to the solid angle of the
//! beam.

use std::ops::Range;

use arrayvec::ArrayVec;
use glam::DVec3;

use crate::scene::{Scene, Side};

/// Maximum number of flat facets in which images are searched. Each search tests all of them.
pub const MOST_FACETS: usize = 128;

/// Largest number of corners of a polygon. Cuts that would give more corners are left out. This makes the polygon larger than the beam, not
/// smaller, and the caller checks a path facet by facet.
const MOST_CORNERS: usize = 16;

/// Two triangles lie in one plane if no corner is farther off it than this, relative to the length of an edge.
const FLAT: f64 = 1e-12;

/// A triangle of the scene.
#[derive(Clone, Copy, Debug)]
struct FacetTriangle {
    triangle: u32,
    corners_m: [DVec3; 3],
}

impl FacetTriangle {
    fn of(scene: &Scene, triangle: u32) -> FacetTriangle {
        FacetTriangle { triangle, corners_m: scene.corners_m(triangle) }
    }

    /// Returns the weights of the second and third corner at a point of the plane; `None` outside the triangle.
    fn weights(&self, point_m: DVec3) -> Option<[f64; 2]> {
        let [a, b, c] = self.corners_m;
        let twice_area = (b - a).cross(c - a);
        let scale = 1.0 / twice_area.length_squared();
        let u = (point_m - a).cross(c - a).dot(twice_area) * scale;
        let v = (b - a).cross(point_m - a).dot(twice_area) * scale;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some([u, v])
    }
}

/// A flat piece that reflects like a mirror on one side: a triangle, or two triangles that form a quadrilateral. One facet for both halves
/// of a rectangle needs no random choice between them.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// The side that reflects.
    pub side: Side,
    /// Unit normal of that side.
    pub normal: DVec3,
    part: FacetTriangle,
    other: Option<FacetTriangle>,
    /// Its outline, counter-clockwise as seen from that side.
    corners_m: [DVec3; 4],
    count: usize,
}

/// The point where a line crosses a facet.
#[derive(Clone, Copy, Debug)]
pub struct MirrorPlace {
    /// The point in m.
    pub point_m: DVec3,
    /// Triangle of the scene.
    pub triangle: u32,
    /// Weights of its second and third corner.
    pub weights: [f64; 2],
}

impl Facet {
    /// Makes a facet of one side of a triangle.
    pub fn new(scene: &Scene, triangle: u32, side: Side) -> Facet {
        let part = FacetTriangle::of(scene, triangle);
        let [a, b, c] = part.corners_m;
        let front = scene.triangle_normal(triangle);
        let (normal, outline) = if side == Side::Front { (front, [a, b, c, c]) } else { (-front, [a, c, b, b]) };
        Facet { side, normal, part, other: None, corners_m: outline, count: 3 }
    }

    /// Makes the facets of one side of some triangles. The two halves of a rectangle make one facet.
    pub fn all_of(scene: &Scene, triangles: Range<u32>, side: Side) -> Vec<Facet> {
        let mut facets: Vec<Facet> = Vec::new();
        for triangle in triangles {
            match facets.last().and_then(|last| last.joined(scene, triangle)) {
                Some(joined) => *facets.last_mut().expect("one to join") = joined,
                None => facets.push(Facet::new(scene, triangle, side)),
            }
        }
        facets
    }

    /// Adds a second triangle, with its same side, if both together form a flat convex quadrilateral.
    pub fn joined(&self, scene: &Scene, triangle: u32) -> Option<Facet> {
        let part = FacetTriangle::of(scene, triangle);
        let is_own = |corner_m: &DVec3| self.corners_m[..3].contains(corner_m);
        let mut new = part.corners_m.iter().filter(|corner_m| !is_own(corner_m));
        let (Some(fourth_m), None) = (new.next(), new.next()) else { return None };
        let alone = (0..3).find(|i| !part.corners_m.contains(&self.corners_m[*i]))?;
        // The new corner lies beyond the shared edge.
        let [a, b, c] = [0, 1, 2].map(|i| self.corners_m[(alone + i) % 3]);
        let outline = [a, b, *fourth_m, c];
        let turns_left = |i: usize| {
            let [before, here, after] = [0, 1, 2].map(|k| outline[(i + k) % 4]);
            (here - before).cross(after - here).dot(self.normal) > 0.0
        };
        let is_flat = self.height_m(*fourth_m).abs() <= FLAT * (*fourth_m - a).length();
        let front = scene.triangle_normal(triangle);
        let is_alike = (if self.side == Side::Front { front } else { -front }).dot(self.normal) > 0.0;
        (self.other.is_none() && is_alike && is_flat && (0..4).all(turns_left)).then_some(Facet {
            other: Some(part),
            corners_m: outline,
            count: 4,
            ..*self
        })
    }

    /// Returns one of its triangles in the scene.
    pub fn triangle(&self) -> u32 {
        self.part.triangle
    }

    /// Returns its triangles in the scene, one or two.
    pub fn triangles(&self) -> impl Iterator<Item = u32> {
        [Some(self.part), self.other].into_iter().flatten().map(|part| part.triangle)
    }

    /// Returns its area in m².
    pub fn area_m2(&self) -> f64 {
        let area_m2 = |part: FacetTriangle| {
            let [a, b, c] = part.corners_m;
            0.5 * (b - a).cross(c - a).length()
        };
        [Some(self.part), self.other].into_iter().flatten().map(area_m2).sum()
    }

    /// Height of a point above the facet in m.
    pub fn height_m(&self, point_m: DVec3) -> f64 {
        (point_m - self.corners_m[0]).dot(self.normal)
    }

    /// Returns the mirror image of a point.
    pub fn image_m(&self, point_m: DVec3) -> DVec3 {
        point_m - self.normal * (2.0 * self.height_m(point_m))
    }

    /// Whether a ray from a point in front of the facet meets it, if nothing is in between.
    pub fn is_met(&self, from_m: DVec3, direction: DVec3) -> bool {
        let (height_m, towards) = (self.height_m(from_m), -self.normal.dot(direction));
        towards > 0.0 && self.crossing(from_m, from_m + direction * (2.0 * height_m / towards)).is_some()
    }

    /// Returns the point where a line crosses the facet; `None` outside the facet.
    pub fn crossing(&self, from_m: DVec3, to_m: DVec3) -> Option<MirrorPlace> {
        let (below, above) = (self.height_m(from_m), self.height_m(to_m));
        let point_m = from_m + (to_m - from_m) * (below / (below - above));
        let within = |part: &FacetTriangle| {
            Some(MirrorPlace { point_m, triangle: part.triangle, weights: part.weights(point_m)? })
        };
        within(&self.part).or_else(|| within(self.other.as_ref()?))
    }
}

/// Corners of a flat convex polygon in m.
type Polygon = ArrayVec<DVec3, MOST_CORNERS>;

/// Puts the part of a polygon on the inner side of a plane into `kept`, and returns whether the plane cut anything off. If not, `kept` does
/// not change.
fn cut(corners_m: &[DVec3], point_m: DVec3, inward: DVec3, kept: &mut Polygon) -> bool {
    let height_m = |corner_m: &DVec3| (corner_m - point_m).dot(inward);
    if corners_m.len() == MOST_CORNERS || corners_m.iter().all(|corner_m| height_m(corner_m) >= 0.0) {
        return false;
    }
    kept.clear();
    let mut before_m = corners_m[corners_m.len() - 1];
    let mut before = height_m(&before_m);
    for corner_m in corners_m {
        let here = height_m(corner_m);
        if (before >= 0.0) != (here >= 0.0) {
            kept.push(before_m + before / (before - here) * (corner_m - before_m));
        }
        if here >= 0.0 {
            kept.push(*corner_m);
        }
        (before_m, before) = (*corner_m, here);
    }
    true
}

/// Returns the solid angle in sr as seen from a point, from a fan of triangles. The tangent of half of a triangle's solid angle is a
/// quotient (A. van Oosterom, J. Strackee, 1983). A product of complex numbers therefore has half of the whole solid angle as its
/// angle.
fn polygon_solid_angle_sr(corners_m: &[DVec3], from_m: DVec3) -> f64 {
    let seen = |i: usize| (corners_m[i] - from_m).normalize_or_zero();
    let (first, mut before) = (seen(0), seen(1));
    let mut product = [1.0, 0.0];
    for i in 2..corners_m.len() {
        let here = seen(i);
        let real = 1.0 + first.dot(before) + before.dot(here) + here.dot(first);
        let imaginary = first.dot((before - first).cross(here - first)).abs();
        product = [product[0] * real - product[1] * imaginary, product[0] * imaginary + product[1] * real];
        before = here;
    }
    // A flat polygon never covers more than half of the sphere.
    if product[1] == 0.0 { 0.0 } else { 2.0 * product[1].atan2(product[0]).abs() }
}

/// All paths from a point over some facets.
#[derive(Clone, Debug)]
pub struct Beam {
    /// The point from which the paths seem to come, in m.
    pub apex_m: DVec3,
    /// Inward normals of planes through the apex.
    walls: [DVec3; MOST_CORNERS],
    wall_count: usize,
    /// A point of the last facet and the facet's normal. The beam begins there.
    base: Option<(DVec3, DVec3)>,
}

/// How a beam meets its next facet.
#[derive(Clone, Debug)]
pub struct Step {
    /// Cosine of incidence of the middle of the beam.
    pub cosine: f64,
    /// Part of the facet inside the beam.
    part: Polygon,
}

impl Beam {
    /// Makes the beam of all directions above a point with a unit normal.
    pub fn above(point_m: DVec3, normal: DVec3) -> Beam {
        let mut walls = [DVec3::ZERO; MOST_CORNERS];
        walls[0] = normal;
        Beam { apex_m: point_m, walls, wall_count: 1, base: None }
    }

    fn walls(&self) -> &[DVec3] {
        &self.walls[..self.wall_count]
    }

    /// Chooses the next facet by a variate in [0, 1), in proportion to the solid angle of the part of each facet inside the beam. Returns its
    /// index and the probability of the choice.
    pub fn choose(&self, facets: &[Facet], variate: f64) -> Option<(usize, f64)> {
        let seen = self.seen(facets);
        let (last, others) = seen.split_last()?;
        let total_sr: f64 = seen.iter().map(|(_, sr)| sr).sum();
        let mut rest = variate * total_sr;
        let chosen = others.iter().find(|(_, sr)| {
            let found = rest < *sr;
            rest -= sr;
            found
        });
        let (facet, sr) = *chosen.unwrap_or(last);
        Some((usize::from(facet), sr / total_sr))
    }

    /// Returns the probability with which [`Beam::choose`] chooses a facet; `None` where no path leads to it.
    pub fn probability(&self, facets: &[Facet], facet: usize) -> Option<f64> {
        let seen = self.seen(facets);
        let (_, sr) = seen.iter().find(|(seen, _)| usize::from(*seen) == facet)?;
        Some(sr / seen.iter().map(|(_, sr)| sr).sum::<f64>())
    }

    /// Returns the facets with a part inside the beam, and the solid angles of these parts in sr. A facet alone has 1 sr, since its choice
    /// is certain.
    fn seen(&self, facets: &[Facet]) -> ArrayVec<(u16, f64), MOST_FACETS> {
        let mut room = <[Polygon; 2]>::default();
        let mut seen_sr = |facet: &Facet| Some(polygon_solid_angle_sr(self.part_of(facet, &mut room)?, self.apex_m));
        let mut seen = ArrayVec::<(u16, f64), MOST_FACETS>::new();
        for (facet, number) in facets.iter().zip(0..) {
            if seen.is_empty() {
                let is_seen = self.part_of(facet, &mut Default::default()).is_some();
                seen.extend(is_seen.then_some((number, 1.0)));
            } else {
                seen.extend(seen_sr(facet).map(|sr| (number, sr)));
            }
        }
        if let [(first, sr), _, ..] = &mut seen[..] {
            *sr = seen_sr(&facets[usize::from(*first)]).unwrap_or(0.0);
            seen.retain(|(_, sr)| *sr > 0.0);
        }
        seen
    }

    /// Returns the step to a facet; `None` where no path leads there.
    pub fn step_to(&self, facet: &Facet) -> Option<Step> {
        let mut room = <[Polygon; 2]>::default();
        let corners_m = self.part_of(facet, &mut room)?;
        let middle_m = corners_m.iter().sum::<DVec3>() / corners_m.len() as f64;
        let cosine = (self.apex_m - middle_m).normalize_or_zero().dot(facet.normal).abs();
        Some(Step { cosine, part: corners_m.iter().copied().collect() })
    }

    /// Continues the beam by one step.
    pub fn reflect(&mut self, facet: &Facet, step: &Step) {
        self.apex_m = facet.image_m(self.apex_m);
        self.base = Some((facet.corners_m[0], facet.normal));
        let corners = &step.part;
        let mut before = corners[corners.len() - 1] - self.apex_m;
        for (wall, corner_m) in self.walls.iter_mut().zip(corners) {
            let here = corner_m - self.apex_m;
            *wall = before.cross(here);
            before = here;
        }
        self.wall_count = corners.len();
    }

    /// Whether a point lies in the beam.
    pub fn holds(&self, point_m: DVec3) -> bool {
        self.base.is_none_or(|(base_m, normal)| (point_m - base_m).dot(normal) > 0.0)
            && self.walls().iter().all(|wall| (point_m - self.apex_m).dot(*wall) >= 0.0)
    }

    /// Returns the part of a facet inside the beam, with `room` as storage for parts that are cut.
    fn part_of<'a>(&self, facet: &'a Facet, room: &'a mut [Polygon; 2]) -> Option<&'a [DVec3]> {
        if facet.height_m(self.apex_m) <= 0.0 {
            return None;
        }
        let [mut part, mut kept] = room.each_mut();
        let whole = &facet.corners_m[..facet.count];
        let mut is_whole = true;
        let walls = self.walls().iter().map(|wall| (self.apex_m, *wall));
        for (point_m, inward) in self.base.into_iter().chain(walls) {
            if cut(if is_whole { whole } else { part }, point_m, inward, kept) {
                (part, kept) = (kept, part);
                is_whole = false;
            }
            if !is_whole && part.len() < 3 {
                return None;
            }
        }
        Some(if is_whole { whole } else { part })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::solid_angle::triangle_solid_angle_sr;

    /// A rectangle of 2 m × 1 m on the floor, in two triangles, as one facet.
    fn facet() -> Facet {
        let [a, b, c, d] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let [part, other] =
            [(0, [a, b, c]), (1, [a, c, d])].map(|(triangle, corners_m)| FacetTriangle { triangle, corners_m });
        Facet { side: Side::Front, normal: DVec3::Z, part, other: Some(other), corners_m: [a, b, c, d], count: 4 }
    }

    #[test]
    fn a_facet_covers_what_its_triangles_do() {
        let facet = facet();
        for apex_m in [DVec3::new(0.3, 0.2, 0.7), DVec3::new(-4.0, 3.0, 0.1), DVec3::new(1.0, 0.5, 1e-3)] {
            let mut room = Default::default();
            let part = Beam::above(apex_m, -DVec3::Z).part_of(&facet, &mut room).expect("seen");
            let of_parts: f64 = [facet.part, facet.other.expect("two")]
                .map(|part| part.corners_m.map(|corner_m| corner_m - apex_m))
                .iter()
                .map(|[a, b, c]| triangle_solid_angle_sr(*a, *b, *c))
                .sum();
            assert!((polygon_solid_angle_sr(part, apex_m) / of_parts - 1.0).abs() < 1e-9, "{of_parts}");
        }
    }

    #[test]
    fn a_line_crosses_the_triangle_where_it_passes() {
        let facet = facet();
        let from_m = DVec3::new(1.0, 0.5, -1.0);
        for (x, y, triangle) in [(1.5, 0.2, 0), (0.5, 0.8, 1)] {
            let place_m = DVec3::new(x, y, 0.0);
            let crossed = facet.crossing(from_m, 2.0 * place_m - from_m).expect("it passes");
            let part = [facet.part, facet.other.expect("two")][triangle as usize];
            let ([a, b, c], [u, v]) = (part.corners_m, crossed.weights);
            assert_eq!(crossed.triangle, triangle);
            assert!((a + u * (b - a) + v * (c - a) - place_m).length() < 1e-12);
        }
        assert!(facet.crossing(from_m, DVec3::new(5.0, 0.5, 1.0)).is_none());
    }
}
