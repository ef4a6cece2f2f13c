//! Solid angles.

use glam::DVec3;

/// Returns the signed solid angle of a triangle with the corners `a`, `b`, `c`, as seen from the origin.
///
/// The value is positive where the corners run counter-clockwise as seen from the origin (its front is seen). It is negative where they run
/// clockwise. It is 0 where the origin lies on a corner, or in the triangle's plane outside the triangle.
///
/// Units: sr. Range: −2π to 2π.
/// Accuracy: a few units in the last place of the exact angle of the given corners, unless the origin is near the triangle's plane. There
/// the absolute error is of the size that the coordinates' own rounding causes.
/// Source: A. van Oosterom, J. Strackee, "The solid angle of a plane triangle", 1983.
#[inline]
pub fn signed_triangle_solid_angle_sr(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    // The triple product uses edges instead of corners. In exact numbers this is equal, and it keeps its digits for a small triangle far
    // away.
    let triple = -a.dot((b - a).cross(c - a));
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let projected = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    if triple == 0.0 && projected >= 0.0 {
        return 0.0;
    }
    2.0 * triple.atan2(projected)
}

/// Returns the solid angle of a triangle with the corners `a`, `b`, `c`, as seen from the origin on either side.
///
/// The corners are relative to the viewing point. A point source of intensity I there sends I·Ω through the triangle. The mean illuminance
/// that it causes on the triangle is I·Ω/A.
///
/// Units: sr. Range: 0 to 2π. Accuracy and source: see [`signed_triangle_solid_angle_sr`].
///
/// ```
/// use glam::DVec3;
/// use luxmc::base::solid_angle::triangle_solid_angle_sr;
///
/// let octant = triangle_solid_angle_sr(DVec3::X, DVec3::Y, DVec3::Z);
/// assert!((octant - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
/// ```
#[inline]
pub fn triangle_solid_angle_sr(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    signed_triangle_solid_angle_sr(a, b, c).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn an_octant_is_half_pi_and_its_sign_follows_the_front() {
        // Seen from the origin, X, Y, Z run clockwise: their normal (1,1,1) points away from it.
        assert!((signed_triangle_solid_angle_sr(DVec3::X, DVec3::Y, DVec3::Z) + FRAC_PI_2).abs() < 1e-15);
        assert!((signed_triangle_solid_angle_sr(DVec3::X, DVec3::Z, DVec3::Y) - FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn a_tetrahedron_closes_to_four_pi_from_any_inner_point() {
        let corners = [
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(1.0, 0.0, 0.0),
            DVec3::new(0.2, 1.3, 0.0),
            DVec3::new(0.3, 0.2, 0.9),
        ];
        for point in [DVec3::new(0.3, 0.2, 0.1), DVec3::new(0.25, 0.25, 1e-9), DVec3::new(1e-6, 1e-6, 1e-6)] {
            let total: f64 = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
                .iter()
                .map(|f| triangle_solid_angle_sr(corners[f[0]] - point, corners[f[1]] - point, corners[f[2]] - point))
                .sum();
            assert!((total - 4.0 * PI).abs() < 1e-14, "{point}: {total}");
        }
    }

    #[test]
    fn a_small_far_triangle_is_area_over_distance_squared() {
        // A right-angled triangle with legs 2^-20 at distance 2^10 that faces the origin. The next term of the series is 2^-60 smaller.
        let (s, d) = (2f64.powi(-20), 1024.0);
        let omega = triangle_solid_angle_sr(DVec3::new(0.0, 0.0, d), DVec3::new(s, 0.0, d), DVec3::new(0.0, s, d));
        let exact = 0.5 * s * s / (d * d);
        assert!((omega / exact - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_point_in_the_plane_or_on_a_corner_sees_nothing_outside_it() {
        assert_eq!(triangle_solid_angle_sr(DVec3::X, 2.0 * DVec3::X, DVec3::new(1.0, 1.0, 0.0)), 0.0);
        assert_eq!(triangle_solid_angle_sr(DVec3::ZERO, DVec3::X, DVec3::Y), 0.0);
    }
}
