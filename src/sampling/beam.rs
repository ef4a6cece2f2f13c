//! Beams of light paths by way of flat mirrors: which facet comes next, with a probability that is known exactly.
//!
//! All paths from a point by way of a given sequence of facets seem to come from one point, the image of the first; in
//! straightened space they fill a cone, cut by each facet in turn. The next facet is chosen in proportion to the solid
//! angle of what the cone leaves of it: sequences that no path can take are never chosen, and long ones are about as
//! probable as the beam is wide.

use glam::DVec3;

use crate::base::solid_angle::triangle_solid_angle_sr;
use crate::scene::{Scene, Side};

/// Corners of a polygon at most: cuts that would give more are left out, which makes the polygon larger than the beam,
/// not smaller; whoever follows a path checks it facet by facet.
const MOST_CORNERS: usize = 16;

/// A flat triangle that reflects as a mirror on one of its sides.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Triangle of the scene.
    pub triangle: u32,
    /// The side that reflects.
    pub side: Side,
    /// Unit normal of that side.
    pub normal: DVec3,
    /// Counter-clockwise as seen from that side.
    corners_m: [DVec3; 3],
}

impl Facet {
    /// A side of a triangle.
    pub fn new(scene: &Scene, triangle: u32, side: Side) -> Facet {
        let [a, b, c] = scene.corners_m(triangle);
        let front = scene.triangle_normal(triangle);
        let (normal, corners_m) = if side == Side::Front { (front, [a, b, c]) } else { (-front, [a, c, b]) };
        Facet { triangle, side, normal, corners_m }
    }

    /// Height of a point above the facet in m.
    pub fn height_m(&self, point_m: DVec3) -> f64 {
        (point_m - self.corners_m[0]).dot(self.normal)
    }

    /// The image of a point.
    pub fn image_m(&self, point_m: DVec3) -> DVec3 {
        point_m - self.normal * (2.0 * self.height_m(point_m))
    }

    /// Where a line crosses the facet, as a point and as weights of the second and third corner of the scene's
    /// triangle; `None` outside of it.
    pub fn crossing(&self, from_m: DVec3, to_m: DVec3) -> Option<(DVec3, [f64; 2])> {
        let (below, above) = (self.height_m(from_m), self.height_m(to_m));
        let point_m = from_m + (to_m - from_m) * (below / (below - above));
        let [a, b, c] = self.corners_m;
        let twice_area = (b - a).cross(c - a);
        let scale = 1.0 / twice_area.length_squared();
        let u = (point_m - a).cross(c - a).dot(twice_area) * scale;
        let v = (b - a).cross(point_m - a).dot(twice_area) * scale;
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        inside.then_some((point_m, if self.side == Side::Front { [u, v] } else { [v, u] }))
    }
}

/// A flat convex polygon.
#[derive(Clone, Copy, Debug)]
struct Polygon {
    corners_m: [DVec3; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    fn corners(&self) -> &[DVec3] {
        &self.corners_m[..self.count]
    }

    /// Keeps the part on the inner side of a plane.
    fn cut(&mut self, point_m: DVec3, inward: DVec3) {
        let mut heights = [0.0; MOST_CORNERS];
        let mut all_inside = true;
        for (height, corner_m) in heights.iter_mut().zip(self.corners()) {
            *height = (corner_m - point_m).dot(inward);
            all_inside &= *height >= 0.0;
        }
        if all_inside || self.count == MOST_CORNERS {
            return;
        }
        let whole = *self;
        self.count = 0;
        for i in 0..whole.count {
            let j = (i + 1) % whole.count;
            if heights[i] >= 0.0 {
                self.push(whole.corners_m[i]);
            }
            if (heights[i] >= 0.0) != (heights[j] >= 0.0) {
                let t = heights[i] / (heights[i] - heights[j]);
                self.push(whole.corners_m[i] + t * (whole.corners_m[j] - whole.corners_m[i]));
            }
        }
    }

    fn push(&mut self, corner_m: DVec3) {
        self.corners_m[self.count] = corner_m;
        self.count += 1;
    }

    fn solid_angle_sr(&self, from_m: DVec3) -> f64 {
        let seen = |i: usize| self.corners_m[i] - from_m;
        (2..self.count).map(|i| triangle_solid_angle_sr(seen(0), seen(i - 1), seen(i))).sum()
    }
}

/// All paths from a point by way of some facets.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Where the paths seem to come from, in m.
    pub apex_m: DVec3,
    /// Inward normals of planes through the apex.
    walls: Vec<DVec3>,
    /// A point of the last facet and its normal: the beam begins there.
    base: Option<(DVec3, DVec3)>,
}

/// The next facet of a beam.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Its place in the list.
    pub facet: usize,
    /// Probability of the choice.
    pub probability: f64,
    /// Cosine under which the middle of the beam meets it.
    pub cosine: f64,
    polygon: Polygon,
}

impl Beam {
    /// All directions above a point with a unit normal.
    pub fn above(point_m: DVec3, normal: DVec3) -> Beam {
        Beam { apex_m: point_m, walls: vec![normal], base: None }
    }

    /// Chooses the next facet by a variate in [0, 1), in proportion to the solid angle that the beam leaves of it.
    pub fn choose(&self, facets: &[Facet], variate: f64) -> Option<Step> {
        let seen_sr = self.seen_sr(facets);
        let total_sr: f64 = seen_sr.iter().sum();
        let mut rest = variate * total_sr;
        let last = seen_sr.iter().rposition(|sr| *sr > 0.0)?;
        let chosen = seen_sr[..last].iter().position(|sr| {
            let found = rest < *sr;
            rest -= sr;
            found
        });
        let facet = chosen.unwrap_or(last);
        self.step(facets, facet, seen_sr[facet] / total_sr)
    }

    /// The step to a facet, with the probability that it would be chosen with; `None` where no path leads there.
    pub fn step_to(&self, facets: &[Facet], facet: usize) -> Option<Step> {
        let seen_sr = self.seen_sr(facets);
        let probability = seen_sr[facet] / seen_sr.iter().sum::<f64>();
        if seen_sr[facet] > 0.0 { self.step(facets, facet, probability) } else { None }
    }

    /// Solid angles that the beam leaves of facets, in sr.
    fn seen_sr(&self, facets: &[Facet]) -> Vec<f64> {
        let solid_angle_sr = |facet: &Facet| self.part_of(facet).map_or(0.0, |part| part.solid_angle_sr(self.apex_m));
        facets.iter().map(solid_angle_sr).collect()
    }

    fn step(&self, facets: &[Facet], facet: usize, probability: f64) -> Option<Step> {
        let polygon = self.part_of(&facets[facet])?;
        let middle_m = polygon.corners().iter().sum::<DVec3>() / polygon.count as f64;
        let cosine = (self.apex_m - middle_m).normalize_or_zero().dot(facets[facet].normal).abs();
        Some(Step { facet, probability, cosine, polygon })
    }

    /// The beam after a step.
    pub fn reflected(&self, facet: &Facet, step: &Step) -> Beam {
        let apex_m = facet.image_m(self.apex_m);
        let corners = step.polygon.corners();
        let walls = (0..corners.len())
            .map(|i| (corners[i] - apex_m).cross(corners[(i + 1) % corners.len()] - apex_m))
            .collect();
        Beam { apex_m, walls, base: Some((facet.corners_m[0], facet.normal)) }
    }

    /// Whether a point lies in the beam.
    pub fn holds(&self, point_m: DVec3) -> bool {
        self.base.is_none_or(|(base_m, normal)| (point_m - base_m).dot(normal) > 0.0)
            && self.walls.iter().all(|wall| (point_m - self.apex_m).dot(*wall) >= 0.0)
    }

    fn part_of(&self, facet: &Facet) -> Option<Polygon> {
        if facet.height_m(self.apex_m) <= 0.0 {
            return None;
        }
        let mut part = Polygon { corners_m: [DVec3::ZERO; MOST_CORNERS], count: 3 };
        part.corners_m[..3].copy_from_slice(&facet.corners_m);
        if let Some((base_m, normal)) = self.base {
            part.cut(base_m, normal);
        }
        for wall in &self.walls {
            if part.count < 3 {
                return None;
            }
            part.cut(self.apex_m, *wall);
        }
        (part.count >= 3).then_some(part)
    }
}
