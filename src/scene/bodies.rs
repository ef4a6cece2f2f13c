//! Smooth closed bodies: a series of spherical harmonics gives the radius by direction.
//!
//! A body is divided into leaves of equal solid angle between parallels and meridians. Each leaf is a triangle of the scene, and its
//! corners lie on the body. Everything that counts, names or draws triangles therefore handles leaves as well. Two weights give a point
//! on a leaf, as on any triangle. Equal areas in these weights are equal solid angles. Positions, normals and areas come from the series.

use std::f64::consts::PI;
use std::ops::Range;

use glam::{DMat3, DVec3};

use crate::base::harmonics::{HarmonicSeries, RadialBounds, direction};
use crate::base::quadrature::GaussLegendre;

/// Number of rings of corners between the poles, and number of leaves around.
const RINGS: usize = 16;
const COLUMNS: usize = 24;
/// Height of a band in cos θ; a cap has half of it.
const BAND: f64 = 2.0 / RINGS as f64;
/// Angle between two meridians in rad.
const COLUMN_RAD: f64 = 2.0 * PI / COLUMNS as f64;
/// Solid angle of a leaf in sr.
const LEAF_SR: f64 = 0.5 * BAND * COLUMN_RAD;

/// Largest angle in rad that a triangle of the quadrature spans, multiplied by the degree of the series.
const QUADRATURE_STEP_RAD: f64 = 1.5;
/// Number of cuts of a leaf along an edge for the search of the largest density.
const CUTS: u32 = 12;

/// A closed body r(θ, φ) = Σ c_lm Y_lm about its centre.
#[derive(Clone, Debug)]
pub struct Body {
    /// The radius in m, by direction in the body's own axes.
    pub series: HarmonicSeries,
    /// Bounds of the radius in m.
    pub bounds: RadialBounds,
    /// Centre in m.
    pub center_m: DVec3,
    /// Rotation from the body's own axes to the scene's axes.
    pub turn: DMat3,
    /// Whether the front is the inside.
    pub inward: bool,
    /// The leaves, as a range of the scene's triangles.
    pub triangles: Range<u32>,
    areas_m2: Vec<f64>,
    /// Largest area per solid angle on each leaf, in m²/sr.
    densest_m2_sr: Vec<f64>,
}

/// Number of a corner by ring and column. The poles come first, then the corners ring by ring.
fn corner(ring: usize, column: usize) -> u32 {
    (2 + ring * COLUMNS + column % COLUMNS) as u32
}

/// Leaves of a body: three corners each, counter-clockwise seen from outside.
pub(super) fn leaves(inward: bool) -> Vec<[u32; 3]> {
    let mut leaves = Vec::with_capacity(2 * COLUMNS * RINGS);
    leaves.extend((0..COLUMNS).map(|column| [0, corner(0, column), corner(0, column + 1)]));
    for ring in 0..RINGS - 1 {
        for column in 0..COLUMNS {
            let [upper, lower] = [ring, ring + 1].map(|ring| [corner(ring, column), corner(ring, column + 1)]);
            leaves.push([lower[0], lower[1], upper[1]]);
            leaves.push([lower[0], upper[1], upper[0]]);
        }
    }
    leaves.extend((0..COLUMNS).map(|column| [1, corner(RINGS - 1, column + 1), corner(RINGS - 1, column)]));
    if inward {
        leaves.iter_mut().for_each(|leaf| leaf.swap(1, 2));
    }
    leaves
}

/// Unit directions of the corners, in the order of their numbers.
pub(super) fn corner_directions() -> Vec<DVec3> {
    let rings = (0..RINGS).map(|ring| 1.0 - BAND * (ring as f64 + 0.5));
    let on_rings = rings.flat_map(|z| (0..COLUMNS).map(move |column| direction(z, COLUMN_RAD * column as f64)));
    [DVec3::Z, -DVec3::Z].into_iter().chain(on_rings).collect()
}

/// Direction of a point on a leaf, from the weights of the second and third corner, seen from outside.
fn direction_on(leaf: usize, [u, v]: [f64; 2]) -> DVec3 {
    let q = u + v;
    let share = |part: f64| if q > 0.0 { part / q } else { 0.5 };
    if leaf < COLUMNS {
        return cap_direction(q, (leaf as f64 + share(v)) * COLUMN_RAD);
    }
    let Some(inner) = leaf.checked_sub(COLUMNS).filter(|inner| *inner < 2 * COLUMNS * (RINGS - 1)) else {
        let column = leaf - COLUMNS - 2 * COLUMNS * (RINGS - 1);
        return cap_direction(q, (column as f64 + share(u)) * COLUMN_RAD) * DVec3::new(1.0, 1.0, -1.0);
    };
    let (ring, column, is_upper) = (inner / (2 * COLUMNS), inner / 2 % COLUMNS, inner % 2 == 1);
    let below = 1.0 - BAND * (ring as f64 + 1.5);
    let [along, up] = if is_upper { [u, q] } else { [q, v] };
    direction(below + BAND * up, (column as f64 + along) * COLUMN_RAD)
}

/// Direction in the cap about +z. The square of `q` is the share of the cap's solid angle up to that direction.
fn cap_direction(q: f64, azimuth: f64) -> DVec3 {
    let depth = 0.5 * BAND * q * q;
    let across = (depth * (2.0 - depth)).sqrt();
    DVec3::new(across * azimuth.cos(), across * azimuth.sin(), 1.0 - depth)
}

/// Returns the leaf in a unit direction, and the weights of its second and third corner, seen from outside.
fn leaf_in(d: DVec3) -> (usize, [f64; 2]) {
    let turns = (d.y.atan2(d.x) / COLUMN_RAD).rem_euclid(COLUMNS as f64);
    let column = (turns as usize).min(COLUMNS - 1);
    let along = (turns - column as f64).clamp(0.0, 1.0);
    // 1 − |z| without cancellation.
    let depth = (d.x * d.x + d.y * d.y) / (1.0 + d.z.abs());
    let cap = 0.5 * BAND;
    if depth < cap {
        let q = (depth / cap).sqrt();
        let [near, far] = [(1.0 - along) * q, along * q];
        return if d.z > 0.0 {
            (column, [near, far])
        } else {
            (COLUMNS + 2 * COLUMNS * (RINGS - 1) + column, [far, near])
        };
    }
    let down = (1.0 - d.z) / BAND - 0.5;
    let ring = (down.max(0.0) as usize).min(RINGS - 2);
    let up = (ring as f64 + 1.0 - down).clamp(0.0, 1.0);
    let first = COLUMNS + 2 * (ring * COLUMNS + column);
    if up <= along { (first, [along - up, up]) } else { (first + 1, [along, up - along]) }
}

impl Body {
    /// Makes a body from its series. `triangles` are its leaves in the scene.
    pub fn new(series: HarmonicSeries, center_m: DVec3, turn: DMat3, inward: bool, triangles: Range<u32>) -> Body {
        let bounds = series.bounds();
        let (areas_m2, densest_m2_sr) = (Vec::new(), Vec::new());
        let mut body = Body { series, bounds, center_m, turn, inward, triangles, areas_m2, densest_m2_sr };
        let all = body.triangles.clone();
        body.areas_m2 =
            all.clone().map(|triangle| body.part_area_m2(triangle, [[0.0; 2], [1.0, 0.0], [0.0, 1.0]])).collect();
        body.densest_m2_sr = all.map(|triangle| body.find_densest_m2_sr(triangle)).collect();
        body
    }

    /// Converts weights to those seen from outside, for both kinds of front. A second call converts them back.
    #[inline]
    fn turned(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        if self.inward { [v, u] } else { [u, v] }
    }

    /// Unit direction of a point on a leaf, in the body's own axes.
    #[inline]
    pub fn direction(&self, triangle: u32, at: [f64; 2]) -> DVec3 {
        direction_on((triangle - self.triangles.start) as usize, self.turned(at))
    }

    /// Returns the leaf in a direction of the body's own axes, and the weights of its second and third corner.
    #[inline]
    pub fn leaf_at(&self, direction: DVec3) -> (u32, [f64; 2]) {
        let (leaf, at) = leaf_in(direction);
        (self.triangles.start + leaf as u32, self.turned(at))
    }

    /// Returns the position in m in a direction of the body's own axes, and the unit normal of the outside there.
    ///
    /// Source: docs/methods.md (31), (32).
    #[inline]
    pub fn place_in(&self, direction: DVec3) -> (DVec3, DVec3) {
        let (radius_m, slope_m) = self.series.value_and_slope(direction);
        let normal = (radius_m * direction - slope_m).normalize();
        (self.center_m + self.turn * (radius_m * direction), self.turn * normal)
    }

    /// Returns the position of a point on a leaf in m, and the unit normal of the front there.
    #[inline]
    pub fn place(&self, triangle: u32, at: [f64; 2]) -> (DVec3, DVec3) {
        let (place_m, normal) = self.place_in(self.direction(triangle, at));
        (place_m, if self.inward { -normal } else { normal })
    }

    /// Area per solid angle at a point on a leaf, in m²/sr: r √(r² + |∇r|²).
    ///
    /// Source: docs/methods.md (33).
    #[inline]
    pub fn density_m2_sr(&self, triangle: u32, at: [f64; 2]) -> f64 {
        density_m2_sr(&self.series, self.direction(triangle, at))
    }

    /// Probability of keeping a point that was drawn evenly over a leaf's solid angle. The kept points are even over the area.
    pub fn keeping(&self, triangle: u32, at: [f64; 2]) -> f64 {
        self.density_m2_sr(triangle, at) / self.densest_m2_sr[(triangle - self.triangles.start) as usize]
    }

    /// Area of a leaf in m².
    pub fn leaf_area_m2(&self, triangle: u32) -> f64 {
        self.areas_m2[(triangle - self.triangles.start) as usize]
    }

    /// Area in m² of the part of a leaf between three points.
    ///
    /// Accuracy: a relative error of some 1e-6.
    pub fn part_area_m2(&self, triangle: u32, [a, b, c]: [[f64; 2]; 3]) -> f64 {
        let share = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        // Leaves are widest between the cap and the first band. There they span √(2 BAND).
        let span = share.sqrt() * (2.0 * BAND).sqrt();
        let cuts = (span * self.series.degree().max(1) as f64 / QUADRATURE_STEP_RAD).ceil().max(2.0) as usize;
        let rule = GaussLegendre::new(4);
        let step = 1.0 / cuts as f64;
        let mut sum = 0.0;
        // The squares are collapsed to triangles. Lines of equal weight meet in the first corner, as meridians do at a pole.
        for i in 0..cuts {
            for (q, weight) in rule.on(i as f64 * step, (i + 1) as f64 * step) {
                for j in 0..cuts {
                    for (s, other_weight) in rule.on(j as f64 * step, (j + 1) as f64 * step) {
                        let at = [0, 1].map(|k| a[k] + q * (1.0 - s) * (b[k] - a[k]) + q * s * (c[k] - a[k]));
                        sum += weight * other_weight * q * self.density_m2_sr(triangle, at);
                    }
                }
            }
        }
        2.0 * LEAF_SR * share * sum
    }

    fn find_densest_m2_sr(&self, triangle: u32) -> f64 {
        let step = 1.0 / f64::from(CUTS);
        let row = |j: u32| -> Vec<f64> {
            (0..=CUTS - j).map(|i| self.density_m2_sr(triangle, [f64::from(i) * step, f64::from(j) * step])).collect()
        };
        let rows: Vec<Vec<f64>> = (0..=CUTS).map(row).collect();
        let largest = rows.iter().flatten().copied().fold(0.0, f64::max);
        // The density varies slowly. Between the sampled points it exceeds them by no more than the difference of neighbours.
        let change =
            rows.iter().flat_map(|row| row.windows(2).map(|pair| (pair[1] - pair[0]).abs())).fold(0.0, f64::max);
        largest + change
    }

    /// Area in m² by quadrature over the sphere.
    pub fn area_m2(&self) -> f64 {
        self.over_sphere(|d| density_m2_sr(&self.series, d))
    }

    /// Volume in m³: ∫ r³/3 dω, exact except for rounding.
    pub fn volume_m3(&self) -> f64 {
        self.over_sphere(|d| self.series.value_and_slope(d).0.powi(3) / 3.0)
    }

    fn over_sphere(&self, f: impl Fn(DVec3) -> f64) -> f64 {
        let nodes = 4 * self.series.degree() + 24;
        let azimuths = 2 * nodes;
        let mean = |z: f64| {
            let sum: f64 = (0..azimuths).map(|k| f(direction(z, 2.0 * PI * k as f64 / azimuths as f64))).sum();
            sum / azimuths as f64
        };
        2.0 * PI * GaussLegendre::new(nodes).integrate(-1.0, 1.0, mean)
    }
}

fn density_m2_sr(series: &HarmonicSeries, direction: DVec3) -> f64 {
    let (radius_m, slope_m) = series.value_and_slope(direction);
    radius_m * (radius_m * radius_m + slope_m.length_squared()).sqrt()
}

/// Returns the body that has a triangle as a leaf. `bodies` are in the order of their leaves.
#[inline]
pub fn body_of<B: AsRef<Body>>(bodies: &[B], triangle: u32) -> Option<&B> {
    let begun = bodies.partition_point(|body| body.as_ref().triangles.start <= triangle);
    bodies[..begun].last().filter(|body| body.as_ref().triangles.contains(&triangle))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(coefficients: Vec<f64>, inward: bool) -> Body {
        Body::new(
            HarmonicSeries::new(coefficients),
            DVec3::ZERO,
            DMat3::IDENTITY,
            inward,
            10..10 + 2 * (COLUMNS * RINGS) as u32,
        )
    }

    #[test]
    fn leaves_tile_the_sphere_in_equal_solid_angles_and_are_found_again() {
        for inward in [false, true] {
            let ball = body(vec![3.0 * (4.0 * PI).sqrt()], inward);
            let (corners, leaves) = (corner_directions(), leaves(inward));
            assert_eq!(leaves.len(), ball.triangles.len());
            for (index, leaf) in leaves.iter().enumerate() {
                let triangle = 10 + index as u32;
                assert!((ball.leaf_area_m2(triangle) - 36.0 * PI / leaves.len() as f64).abs() < 1e-12);
                for at in [[0.2, 0.3], [0.9, 0.05], [0.01, 0.01], [0.3, 0.69]] {
                    let (found, again) = ball.leaf_at(ball.direction(triangle, at));
                    assert_eq!(found, triangle);
                    assert!((again[0] - at[0]).abs() < 1e-9 && (again[1] - at[1]).abs() < 1e-9, "{again:?} {at:?}");
                }
                let [a, b, c] = leaf.map(|corner| corners[corner as usize]);
                for (at, corner) in [([1.0, 0.0], b), ([0.0, 1.0], c)] {
                    assert!(ball.direction(triangle, at).distance(corner) < 1e-12);
                }
                let front = (b - a).cross(c - a).dot(a + b + c);
                assert!(if inward { front < 0.0 } else { front > 0.0 });
            }
        }
    }

    #[test]
    fn parts_of_leaves_add_up_to_the_area_of_the_body_and_bounds_on_densities_hold() {
        let lumpy = |k: i32| if k == 0 { 4.0 } else { 0.25 * f64::sin(7.3 * f64::from(k)) / f64::from(k).sqrt() };
        let body = body((0..64).map(lumpy).collect(), false);
        let by_leaves: f64 = body.triangles.clone().map(|triangle| body.leaf_area_m2(triangle)).sum();
        assert!((by_leaves / body.area_m2() - 1.0).abs() < 1e-7, "{by_leaves} {}", body.area_m2());
        let triangle = body.triangles.start + 301;
        let quarters = [
            [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]],
            [[0.5, 0.0], [1.0, 0.0], [0.5, 0.5]],
            [[0.0, 0.5], [0.5, 0.5], [0.0, 1.0]],
            [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]],
        ];
        let parts: f64 = quarters.iter().map(|part| body.part_area_m2(triangle, *part)).sum();
        assert!((parts / body.leaf_area_m2(triangle) - 1.0).abs() < 1e-7);
        for triangle in body.triangles.clone() {
            for k in 0..200 {
                let at = [f64::from(k) * 0.618_034 % 1.0, f64::from(k) * 0.754_878 % 1.0];
                let at = if at[0] + at[1] > 1.0 { [1.0 - at[0], 1.0 - at[1]] } else { at };
                assert!(body.keeping(triangle, at) <= 1.0);
            }
        }
    }
}
