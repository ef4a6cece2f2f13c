//! Exact form factors between rectangles whose edges run along the axes, and from a point to one of these rectangles.
//!
//! Each form factor is a difference of one corner function, taken over the distances between the corners. The corner functions are public
//! too, so that a mesh of rectangles can share their values.

use std::f64::consts::TAU;

/// Returns the corner function of two parallel rectangles at distance `z`, at the corner distances `u` and `v` along their edges.
///
/// Its fourfold difference over the corners of both rectangles is A₁F₁₂. Units: m². Source: A. Ehlert, T. F. Smith, "View factors for
/// perpendicular and parallel rectangular plates", 1993.
#[inline]
pub fn parallel_corner_m2(u: f64, v: f64, z: f64) -> f64 {
    let (pu, pv) = ((u * u + z * z).sqrt(), (v * v + z * z).sqrt());
    let along = |length: f64, across: f64| if across > 0.0 { length * across * (length / across).atan() } else { 0.0 };
    let squares = u * u + v * v + z * z;
    let logarithm = if z > 0.0 { 0.5 * z * z * squares.ln() } else { 0.0 };
    (along(v, pu) + along(u, pv) - logarithm) / TAU
}

/// Returns the corner function of two perpendicular rectangles. `s2` is the sum of the squared distances of the two corners from the
/// planes' common line. `y` is the distance of the corners along that line.
///
/// Its fourfold difference over the corners of both rectangles is A₁F₁₂. Units: m². Source: as [`parallel_corner_m2`].
#[inline]
pub fn perpendicular_corner_m2(s2: f64, y: f64) -> f64 {
    let across = s2.sqrt();
    let angle = if across > 0.0 { y * across * (y / across).atan() } else { 0.0 };
    let squares = s2 + y * y;
    let logarithm = if squares > 0.0 { 0.25 * (s2 - y * y) * squares.ln() } else { 0.0 };
    (angle - logarithm) / TAU
}

/// Returns the corner function of a point and a parallel rectangle at distance `z` > 0. Its twofold difference over the corners is the form
/// factor from a small patch at the point to the rectangle. Units: none.
#[inline]
pub fn point_parallel_corner(u: f64, v: f64, z: f64) -> f64 {
    let (pu, pv) = ((u * u + z * z).sqrt(), (v * v + z * z).sqrt());
    (u / pu * (v / pu).atan() + v / pv * (u / pv).atan()) / TAU
}

/// Returns the corner function of a point and a perpendicular rectangle. The rectangle's plane stands at distance `x` ≥ 0 from the point.
/// The corner lies at `height` ≥ 0 above the point's plane and at `y` along it. The twofold difference over the corners is the form factor
/// from a small patch at the point. At `x` = 0 it is the limit from in front of the plane. Units: none.
#[inline]
pub fn point_perpendicular_corner(x: f64, height: f64, y: f64) -> f64 {
    let across = (x * x + height * height).sqrt();
    if across == 0.0 {
        return if y == 0.0 { 0.0 } else { -0.25 * y.signum() };
    }
    -x / across * (y / across).atan() / TAU
}

/// Returns the fourfold difference of a function of four corner coordinates, over two stretches of each of two rectangles.
fn fourfold(first: [[f64; 2]; 2], second: [[f64; 2]; 2], corner: impl Fn(f64, f64, f64, f64) -> f64) -> f64 {
    let mut sum = super::sum::CompensatedSum::new();
    for i in 0..16usize {
        let sign = if i.count_ones() % 2 == 0 { 1.0 } else { -1.0 };
        let (a, b, c, d) = (i & 1, i >> 1 & 1, i >> 2 & 1, i >> 3);
        sum.add(sign * corner(first[0][a], first[1][b], second[0][c], second[1][d]));
    }
    sum.value()
}

/// A rectangle with its edges along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisRectangle {
    /// Axis of its normal: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Coordinate of its plane on that axis, m.
    pub at_m: f64,
    /// Whether the normal points in the positive direction of the axis; otherwise it points in the negative direction.
    pub faces_up: bool,
    /// Stretches along the other two axes, in the axes' order. Each runs from its lower to its upper end, in m.
    pub stretches_m: [[f64; 2]; 2],
}

impl AxisRectangle {
    /// Area, m².
    pub fn area_m2(&self) -> f64 {
        self.stretches_m.iter().map(|s| s[1] - s[0]).product()
    }

    /// Returns the stretch along an axis other than the normal's.
    fn along(&self, axis: usize) -> [f64; 2] {
        let after = if axis > self.axis { axis - 1 } else { axis };
        self.stretches_m[after]
    }

    /// Returns the distances of a stretch's ends from this rectangle's plane, on its front side. The part behind the plane is cut off.
    fn in_front(&self, stretch: [f64; 2]) -> [f64; 2] {
        let [a, b] = stretch.map(|x| if self.faces_up { x - self.at_m } else { self.at_m - x }.max(0.0));
        [a.min(b), a.max(b)]
    }
}

/// Returns A₁F₁₂ = A₂F₂₁ of two rectangles with nothing between them: the flux from the first to the second per unit of exitance.
///
/// The part of either rectangle that lies behind the other is cut off. Units: m².
/// Accuracy: about 1e-15 of the squared distance between their farthest corners.
///
/// ```
/// use luxmc::base::form_factors::{AxisRectangle, exchange_m2};
///
/// let floor = AxisRectangle { axis: 2, at_m: 0.0, faces_up: true, stretches_m: [[0.0, 6.0], [0.0, 4.0]] };
/// let ceiling = AxisRectangle { axis: 2, at_m: 3.0, faces_up: false, ..floor };
/// assert!((exchange_m2(&floor, &ceiling) / floor.area_m2() - 0.3416939135).abs() < 1e-10);
/// ```
pub fn exchange_m2(first: &AxisRectangle, second: &AxisRectangle) -> f64 {
    if first.axis == second.axis {
        let gap = if first.faces_up { second.at_m - first.at_m } else { first.at_m - second.at_m };
        if gap <= 0.0 || first.faces_up == second.faces_up {
            return 0.0;
        }
        let corner = |x: f64, y: f64, xi: f64, eta: f64| parallel_corner_m2((x - xi).abs(), (y - eta).abs(), gap);
        return fourfold(first.stretches_m, second.stretches_m, corner).max(0.0);
    }
    let common = 3 - first.axis - second.axis;
    let one = [second.in_front(first.along(second.axis)), first.along(common)];
    let two = [first.in_front(second.along(first.axis)), second.along(common)];
    let corner = |x: f64, y: f64, xi: f64, eta: f64| perpendicular_corner_m2(x * x + xi * xi, (y - eta).abs());
    fourfold(one, two, corner).max(0.0)
}

/// Returns the form factor between two equal rectangles a × b that face each other at distance `c`. Inputs in m; the result has no unit.
pub fn opposite_rectangles_factor(a: f64, b: f64, c: f64) -> f64 {
    let floor = AxisRectangle { axis: 2, at_m: 0.0, faces_up: true, stretches_m: [[0.0, a], [0.0, b]] };
    exchange_m2(&floor, &AxisRectangle { at_m: c, faces_up: false, ..floor }) / (a * b)
}

/// Returns the form factor from a rectangle `common` × `from` to a perpendicular one `common` × `to` that share an edge. Inputs in m; the
/// result has no unit.
pub fn adjacent_rectangles_factor(common: f64, from: f64, to: f64) -> f64 {
    let floor = AxisRectangle { axis: 2, at_m: 0.0, faces_up: true, stretches_m: [[0.0, from], [0.0, common]] };
    let wall = AxisRectangle { axis: 0, at_m: 0.0, faces_up: true, stretches_m: [[0.0, common], [0.0, to]] };
    exchange_m2(&floor, &wall) / (common * from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::polygon::polygon_illuminance_factor;
    use crate::base::quadrature::GaussLegendre;
    use glam::DVec3;

    #[test]
    fn the_published_factors_of_a_cube_and_a_room_are_met() {
        assert!((opposite_rectangles_factor(1.0, 1.0, 1.0) - 0.1998248957).abs() < 1e-10);
        assert!((adjacent_rectangles_factor(1.0, 1.0, 1.0) - 0.2000437761).abs() < 1e-10);
        assert!((opposite_rectangles_factor(6.0, 4.0, 3.0) - 0.3416939135).abs() < 1e-10);
        assert!((adjacent_rectangles_factor(6.0, 4.0, 3.0) - 0.1995370333).abs() < 1e-10);
        assert!((adjacent_rectangles_factor(4.0, 6.0, 3.0) - 0.1296160100).abs() < 1e-10);
    }

    #[test]
    fn arbitrary_rectangles_agree_with_integrated_polygons() {
        let wall = AxisRectangle { axis: 1, at_m: 3.0, faces_up: false, stretches_m: [[0.5, 1.5], [0.5, 2.0]] };
        let patch = AxisRectangle { axis: 2, at_m: -0.5, faces_up: true, stretches_m: [[0.2, 2.0], [-1.0, 1.0]] };
        let ceiling = AxisRectangle { axis: 2, at_m: 1.5, faces_up: false, stretches_m: [[-1.0, 0.7], [0.3, 0.9]] };
        let corners_of = |r: &AxisRectangle| {
            let [u, v] = r.stretches_m;
            let place = |u: f64, v: f64| match r.axis {
                0 => DVec3::new(r.at_m, u, v),
                1 => DVec3::new(u, r.at_m, v),
                _ => DVec3::new(u, v, r.at_m),
            };
            // (u, v) run counter-clockwise as seen from the positive side of the axis. For y they run clockwise, because its two axes are
            // swapped.
            let mut corners = vec![place(u[0], v[0]), place(u[1], v[0]), place(u[1], v[1]), place(u[0], v[1])];
            if r.faces_up == (r.axis == 1) {
                corners.reverse();
            }
            corners
        };
        let rule = GaussLegendre::new(24);
        for other in [wall, ceiling] {
            let corners = corners_of(&other);
            let integral = rule.integrate(0.2, 2.0, |x| {
                rule.integrate(-1.0, 1.0, |y| polygon_illuminance_factor(DVec3::new(x, y, -0.5), DVec3::Z, &corners))
            });
            assert!((exchange_m2(&patch, &other) / integral - 1.0).abs() < 1e-10, "{other:?} {integral}");
            assert_eq!(exchange_m2(&patch, &other), exchange_m2(&other, &patch));
        }
        let away = AxisRectangle { faces_up: true, ..ceiling };
        assert_eq!(exchange_m2(&patch, &away), 0.0);
    }

    #[test]
    fn points_agree_with_the_polygon_formula() {
        let corners = [(1.0, -0.5), (1.0, 2.0), (3.0, 2.0), (3.0, -0.5)];
        let parallel = |u: usize, v: usize| point_parallel_corner([1.0, 3.0][u], [-0.5, 2.0][v], 1.5);
        let factor = parallel(1, 1) - parallel(1, 0) - parallel(0, 1) + parallel(0, 0);
        let above = corners.map(|(x, y)| DVec3::new(x, y, 1.5));
        assert!((factor - polygon_illuminance_factor(DVec3::ZERO, DVec3::Z, &above)).abs() < 1e-15);

        // A wall at x = 0.7, from y = −0.5 to 2, from z = 1 to 3.
        let upright = |h: usize, y: usize| point_perpendicular_corner(0.7, [1.0, 3.0][h], [-0.5, 2.0][y]);
        let factor = upright(1, 1) - upright(1, 0) - upright(0, 1) + upright(0, 0);
        let mut wall = corners.map(|(z, y)| DVec3::new(0.7, y, z));
        wall.reverse();
        let polygon = polygon_illuminance_factor(DVec3::ZERO, DVec3::Z, &wall).max({
            wall.reverse();
            polygon_illuminance_factor(DVec3::ZERO, DVec3::Z, &wall)
        });
        assert!((factor - polygon).abs() < 1e-15, "{factor} {polygon}");
    }
}
