//! Points of a triangle seen from another point, drawn in proportion to solid angle or to projected solid angle.

use glam::DVec3;

use super::random::Stream;
use super::warp::uniform_triangle;
use crate::base::solid_angle::triangle_solid_angle_sr;

/// Below this ratio of the triangle's radius to its distance, points are drawn by area and rejected to follow solid angle. This is cheaper
/// than the spherical formula and has no cancellation. At this ratio, 1/d³ varies by (1.25/0.75)³ = 4.6 over the triangle, so at least a
/// fifth of the draws are kept.
const FAR_RADIUS_PER_DISTANCE: f64 = 0.25;

/// Largest number of draws of a rejection loop; reaching it means a numerical fault. At least one draw in 30 is accepted (5% for triangles),
/// so 2000 failures in a row have a probability below 1e-29.
pub(super) const MOST_DRAWS: u32 = 2000;

/// A triangle seen from the origin, prepared for drawing its points by (projected) solid angle.
#[derive(Clone, Copy, Debug)]
pub struct SeenTriangle {
    corners: [DVec3; 3],
    spherical: [DVec3; 3],
    solid_angle_sr: f64,
    drawing: Drawing,
}

/// How points of a triangle are drawn.
#[derive(Clone, Copy, Debug)]
enum Drawing {
    /// By area with rejection; holds the largest 1/d³ over the triangle.
    Thinned(f64),
    /// By the spherical formula.
    Spherical(SphericalTriangle),
}

/// The values that the spherical formula needs of a triangle.
#[derive(Clone, Copy, Debug)]
struct SphericalTriangle {
    /// The angle at the first corner, with its sine and cosine.
    alpha: f64,
    sin_cos_alpha: (f64, f64),
    /// Cosine of the arc from the first corner to the second.
    cos_ab: f64,
    /// Unit tangent at the first corner towards the third.
    towards_c: DVec3,
    plane: TrianglePlane,
}

impl SphericalTriangle {
    fn of(corners: [DVec3; 3], [a, b, c]: [DVec3; 3]) -> SphericalTriangle {
        let towards_c = tangent(a, c);
        let alpha = tangent(a, b).angle_between(towards_c);
        SphericalTriangle {
            alpha,
            sin_cos_alpha: alpha.sin_cos(),
            cos_ab: a.dot(b),
            towards_c,
            plane: TrianglePlane::of(corners),
        }
    }
}

/// Returns the unit tangent of the sphere at one direction towards another.
fn tangent(from: DVec3, to: DVec3) -> DVec3 {
    (to - from * from.dot(to)).normalize_or_zero()
}

/// The plane of a triangle, prepared for barycentric coordinates.
#[derive(Clone, Copy, Debug)]
struct TrianglePlane {
    first_corner: DVec3,
    /// (b − a) × (c − a): twice the area, along the front normal.
    twice_area: DVec3,
    /// Dot products of these with (point − first corner) are the barycentric coordinates.
    weighing: [DVec3; 2],
}

impl TrianglePlane {
    fn of([a, b, c]: [DVec3; 3]) -> TrianglePlane {
        let twice_area = (b - a).cross(c - a);
        let across = [(c - a).cross(twice_area), twice_area.cross(b - a)];
        let weighing = across.map(|across| across / twice_area.length_squared());
        TrianglePlane { first_corner: a, twice_area, weighing }
    }

    /// Returns the barycentric coordinates where a direction from the origin meets the plane, clamped to the triangle.
    fn barycentric(&self, direction: DVec3) -> Option<[f64; 2]> {
        let slope = self.twice_area.dot(direction);
        if slope == 0.0 {
            return None;
        }
        let offset = direction * (self.twice_area.dot(self.first_corner) / slope) - self.first_corner;
        let [u, v] = self.weighing.map(|weighing| weighing.dot(offset).clamp(0.0, 1.0));
        let over = (u + v).max(1.0);
        Some([u / over, v / over])
    }
}

impl SeenTriangle {
    /// Prepares a triangle whose corners are relative to the viewing point, in m.
    pub fn new(corners: [DVec3; 3]) -> SeenTriangle {
        let [a, b, c] = corners;
        let centroid = (a + b + c) / 3.0;
        let radius = (a - centroid)
            .length_squared()
            .max((b - centroid).length_squared())
            .max((c - centroid).length_squared())
            .sqrt();
        let distance = centroid.length();
        let spherical = [a.normalize_or_zero(), b.normalize_or_zero(), c.normalize_or_zero()];
        let drawing = match radius < FAR_RADIUS_PER_DISTANCE * distance {
            true => Drawing::Thinned((distance - radius).powi(-3)),
            false => Drawing::Spherical(SphericalTriangle::of(corners, spherical)),
        };
        SeenTriangle { corners, spherical, solid_angle_sr: triangle_solid_angle_sr(a, b, c).abs(), drawing }
    }

    /// Solid angle in sr, 0 to 2π.
    pub fn solid_angle_sr(&self) -> f64 {
        self.solid_angle_sr
    }

    /// Draws a direction to the triangle in proportion to solid angle. Returns it with the barycentric coordinates of its point.
    pub fn draw(&self, stream: &mut Stream) -> Option<(DVec3, [f64; 2])> {
        let largest = match &self.drawing {
            Drawing::Thinned(largest) => largest,
            Drawing::Spherical(spherical) => {
                let direction = self.draw_spherical(spherical, stream.pair());
                return Some((direction, spherical.plane.barycentric(direction)?));
            }
        };
        for _ in 0..MOST_DRAWS {
            let [u, v] = uniform_triangle(stream.pair());
            let [a, b, c] = self.corners;
            let point = a + u * (b - a) + v * (c - a);
            let distance_squared = point.length_squared();
            let kept = 1.0 / (distance_squared * distance_squared.sqrt() * largest);
            if stream.unit() < kept {
                return Some((point / distance_squared.sqrt(), [u, v]));
            }
        }
        None
    }

    /// Draws a direction uniformly in the spherical triangle (Arvo, 1995, "Stratified sampling of spherical triangles").
    fn draw_spherical(&self, triangle: &SphericalTriangle, [u, v]: [f64; 2]) -> DVec3 {
        let [a, b, _] = self.spherical;
        let SphericalTriangle { alpha, sin_cos_alpha: (sin_alpha, cos_alpha), cos_ab, towards_c, .. } = *triangle;
        let (s, t) = (u * self.solid_angle_sr - alpha).sin_cos();
        let p = t - cos_alpha;
        let q = s + sin_alpha * cos_ab;
        let denominator = (q * s + p * t) * sin_alpha;
        let cos_arc =
            if denominator == 0.0 { 1.0 } else { (((q * t - p * s) * cos_alpha - q) / denominator).clamp(-1.0, 1.0) };
        let c_moved = a * cos_arc + towards_c * (1.0 - cos_arc * cos_arc).max(0.0).sqrt();
        let z = 1.0 - v * (1.0 - c_moved.dot(b));
        b * z + tangent(b, c_moved) * (1.0 - z * z).max(0.0).sqrt()
    }
}

/// The part of a triangle above a horizon, as seen from the origin. It is prepared for drawing points in proportion to solid angle times
/// the cosine from the horizon's normal.
#[derive(Clone, Copy, Debug)]
pub struct RisenTriangle {
    above: AboveHorizon,
    normal: DVec3,
    largest_cosine: f64,
}

/// The part of a triangle that the horizon leaves.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "walks make it at every light sample, and allocate nothing")]
enum AboveHorizon {
    Whole(SeenTriangle),
    /// One or two triangles, and the plane of the whole triangle.
    Parts([Option<SeenTriangle>; 2], TrianglePlane),
}

impl RisenTriangle {
    /// Prepares a triangle whose corners are relative to the viewing point, in m, for a unit normal. `None` if no corner is above the
    /// horizon.
    pub fn new(corners: [DVec3; 3], normal: DVec3) -> Option<RisenTriangle> {
        let heights = [corners[0].dot(normal), corners[1].dot(normal), corners[2].dot(normal)];
        match heights.iter().filter(|height| **height > 0.0).count() {
            0 => None,
            3 => {
                let whole = SeenTriangle::new(corners);
                let largest_cosine = largest_cosine(&whole.spherical, normal);
                Some(RisenTriangle { above: AboveHorizon::Whole(whole), normal, largest_cosine })
            }
            _ => {
                let parts = cut_at_horizon(corners, heights);
                let largest_cosine =
                    parts.iter().flatten().map(|part| largest_cosine(&part.spherical, normal)).fold(0.0, f64::max);
                let above = AboveHorizon::Parts(parts, TrianglePlane::of(corners));
                Some(RisenTriangle { above, normal, largest_cosine })
            }
        }
    }

    /// Draws a direction to the triangle. Returns it with the barycentric coordinates of its point.
    ///
    /// `None` where the part above the horizon is too small for floating-point numbers.
    pub fn draw(&self, stream: &mut Stream) -> Option<(DVec3, [f64; 2])> {
        for _ in 0..MOST_DRAWS {
            let (direction, barycentric) = match &self.above {
                AboveHorizon::Whole(whole) => whole.draw(stream)?,
                AboveHorizon::Parts(parts, _) => {
                    let total: f64 = parts.iter().flatten().map(|part| part.solid_angle_sr).sum();
                    let choice = stream.unit() * total;
                    let part = match parts {
                        [Some(first), Some(second)] if choice >= first.solid_angle_sr => second,
                        [Some(first), _] => first,
                        _ => return None,
                    };
                    part.draw(stream)?
                }
            };
            if stream.unit() * self.largest_cosine < direction.dot(self.normal) {
                return match &self.above {
                    AboveHorizon::Whole(_) => Some((direction, barycentric)),
                    AboveHorizon::Parts(_, plane) => Some((direction, plane.barycentric(direction)?)),
                };
            }
        }
        None
    }
}

/// Cuts a triangle at the horizon into one or two triangles above it. At least one corner has a height above 0.
fn cut_at_horizon(corners: [DVec3; 3], heights: [f64; 3]) -> [Option<SeenTriangle>; 2] {
    let mut above = [DVec3::ZERO; 4];
    let mut count = 0;
    for i in 0..3 {
        let j = (i + 1) % 3;
        if heights[i] > 0.0 {
            above[count] = corners[i];
            count += 1;
        }
        if (heights[i] > 0.0) != (heights[j] > 0.0) {
            let t = heights[i] / (heights[i] - heights[j]);
            above[count] = corners[i] + t * (corners[j] - corners[i]);
            count += 1;
        }
    }
    let parts = [[above[0], above[1], above[2]], [above[0], above[2], above[3]]];
    std::array::from_fn(|i| parts[..count - 2].get(i).map(|part| SeenTriangle::new(*part)))
}

/// Returns the largest cosine between a unit normal and the directions of a spherical triangle. It occurs at a corner or within an edge, or
/// is 1 where the normal itself points into the triangle.
fn largest_cosine(corners: &[DVec3; 3], normal: DVec3) -> f64 {
    let mut largest = corners.iter().map(|corner| corner.dot(normal)).fold(0.0, f64::max);
    let mut sides = 0.0;
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let pole = a.cross(b);
        let length_squared = pole.length_squared();
        sides += pole.dot(normal).signum();
        if length_squared == 0.0 {
            continue;
        }
        let on_circle = normal - pole * (normal.dot(pole) / length_squared);
        let in_arc = a.cross(on_circle).dot(pole) >= 0.0 && on_circle.cross(b).dot(pole) >= 0.0;
        if in_arc {
            largest = largest.max(on_circle.length());
        }
    }
    if sides.abs() == 3.0 && corners[0].dot(normal) > 0.0 { 1.0 } else { largest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square::chi_square_p;
    use crate::sampling::random::Purpose;

    /// Probability that a test rejects a correct sampler.
    const ALPHA: f64 = 1e-4;

    /// Returns the p-value of N = 160,000 draws (seed 5) over the n² parts of a triangle. The expected counts follow from the weight of each
    /// part's own directions.
    fn p_of_draws(corners: [DVec3; 3], normal: Option<DVec3>, tilt: f64) -> f64 {
        const PARTS: usize = 6;
        const N: u32 = 160_000;
        let seen = SeenTriangle::new(corners);
        let mut stream = Stream::new(5, Purpose::Pilot, 0, 0);
        let part_of = |[u, v]: [f64; 2]| {
            let at = |x: f64| ((x * PARTS as f64) as usize).min(PARTS - 1);
            at(u) * PARTS + at(v)
        };
        let mut counts = vec![0.0; PARTS * PARTS];
        for index in 0..N {
            stream.seek(u64::from(index));
            let drawn = match normal {
                Some(normal) => RisenTriangle::new(corners, normal).and_then(|risen| risen.draw(&mut stream)),
                None => seen.draw(&mut stream),
            };
            let (direction, barycentric) = drawn.expect("the triangle can be seen");
            let [a, b, c] = corners;
            let point = a + barycentric[0] * (b - a) + barycentric[1] * (c - a);
            assert!((point.normalize() - direction).length() < 1e-6, "direction and point disagree");
            counts[part_of(barycentric)] += 1.0;
        }
        // Independent expectation by a fine midpoint rule over the triangle's area.
        const FINE: usize = 600;
        let mut expected = vec![0.0; PARTS * PARTS];
        let [a, b, c] = corners;
        let front = (b - a).cross(c - a);
        for i in 0..FINE {
            for j in 0..FINE - i {
                let uv = [(i as f64 + 1.0 / 3.0) / FINE as f64, (j as f64 + 1.0 / 3.0) / FINE as f64];
                let point = a + uv[0] * (b - a) + uv[1] * (c - a);
                let distance = point.length();
                let cosine = normal.map_or(1.0, |normal| (point.dot(normal) / distance).max(0.0));
                expected[part_of(uv)] += front.dot(point).abs() / distance.powi(3) * cosine * (1.0 + tilt * uv[0]);
            }
        }
        let total: f64 = expected.iter().sum();
        let expected: Vec<f64> = expected.iter().map(|share| share / total * f64::from(N)).collect();
        chi_square_p(&counts, &expected)
    }

    #[test]
    fn points_are_drawn_in_proportion_to_what_they_bring() {
        let near = [DVec3::new(-1.0, -1.0, 0.5), DVec3::new(2.0, -0.5, 0.6), DVec3::new(0.0, 1.5, 0.4)];
        let far = near.map(|corner| corner + DVec3::new(3.0, 4.0, 9.0));
        let across = [DVec3::new(1.0, -1.0, -0.8), DVec3::new(1.2, 1.0, -0.5), DVec3::new(1.0, 0.2, 1.5)];
        let up = Some(DVec3::Z);
        for (name, corners, normal) in [
            ("near, solid angle", near, None),
            ("far, solid angle", far, None),
            ("near, projected", near, up),
            ("far, projected", far, up),
            ("across the horizon", across, up),
            ("two corners below", across.map(|corner| corner - DVec3::Z * 0.3), up),
        ] {
            let right = p_of_draws(corners, normal, 0.0);
            assert!(right > ALPHA, "{name}: p = {right}");
            let wrong = p_of_draws(corners, normal, 0.3);
            assert!(wrong < ALPHA, "{name}: a planted fault passed, p = {wrong}");
        }
    }
}
