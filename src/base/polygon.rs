//! Illuminance from a Lambertian polygon: Lambert's closed form, with the polygon cut by the receiver's horizon.

use std::f64::consts::TAU;

use glam::DVec3;

/// Triangles below this ratio of size to distance use the series of [`far_sum`]; the others use angles.
///
/// At this ratio the three angles cancel to about 1/40 of their size, which costs less than two decimal digits. The first dropped term of
/// the series is below 1e-20.
const FAR_SIZE_OVER_DISTANCE: f64 = 0.025;

/// Returns the illuminance that a uniform Lambertian triangle causes at a point, as a fraction of the triangle's exitance.
///
/// The triangle emits from its front, the side from which its corners run counter-clockwise. A point behind it or in its plane gets 0. The
/// part below the receiver's horizon is cut off. Nothing stands between triangle and point. The value is also the form factor from a small
/// patch at the point to the triangle.
///
/// Units: none (lx per lm/m²); `normal` is a unit vector. Range: 0 to 1.
/// Accuracy: about 1e-15 absolute. The relative accuracy is the same for a small far triangle that is seen neither edge-on nor at the
/// horizon.
/// Source: J. H. Lambert, "Photometria", 1760.
///
/// ```
/// use glam::DVec3;
/// use luxmc::base::polygon::triangle_illuminance_factor;
///
/// // The four octants above a floor give equal shares, so the triangle of one octant gives a quarter.
/// let factor = triangle_illuminance_factor(DVec3::ZERO, DVec3::Z, [DVec3::X, DVec3::Z, DVec3::Y]);
/// assert!((factor - 0.25).abs() < 1e-15);
/// ```
#[inline]
pub fn triangle_illuminance_factor(point: DVec3, normal: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = [corners[0] - point, corners[1] - point, corners[2] - point];
    let edge_ab = corners[1] - corners[0];
    let edge_bc = corners[2] - corners[1];
    let edge_ca = corners[0] - corners[2];
    let twice_area = edge_ab.cross(-edge_ca);

    // The point sees the front if the triangle's normal has a component towards the point.
    if twice_area.dot(a) >= 0.0 {
        return 0.0;
    }
    let height = [normal.dot(a), normal.dot(b), normal.dot(c)];
    if height.iter().all(|h| *h <= 0.0) {
        return 0.0;
    }

    let size2 = edge_ab.length_squared().max(edge_bc.length_squared()).max(edge_ca.length_squared());
    let far = size2 < FAR_SIZE_OVER_DISTANCE * FAR_SIZE_OVER_DISTANCE * a.length_squared();
    if height.iter().all(|h| *h >= 0.0) {
        let sum = if far {
            far_sum(normal, [a, b, c], [edge_ab, edge_bc, edge_ca], twice_area)
        } else {
            edge_sum(normal, a, b) + edge_sum(normal, b, c) + edge_sum(normal, c, a)
        };
        return (-sum / TAU).clamp(0.0, 1.0);
    }
    clipped_factor(normal, [a, b, c], height, far)
}

/// Returns the factor of a triangle that the horizon cuts.
#[cold]
fn clipped_factor(normal: DVec3, corners: [DVec3; 3], height: [f64; 3], far: bool) -> f64 {
    // The remaining part of a triangle has three or four corners.
    let mut left = [DVec3::ZERO; 4];
    let mut count = 0;
    for i in 0..3 {
        let j = (i + 1) % 3;
        if height[i] >= 0.0 {
            left[count] = corners[i];
            count += 1;
        }
        if (height[i] > 0.0 && height[j] < 0.0) || (height[i] < 0.0 && height[j] > 0.0) {
            // Weighting both corners keeps the digits of a near corner. Moving along the edge from the other corner would lose them.
            let span = height[i] - height[j];
            left[count] = corners[i] * (-height[j] / span) + corners[j] * (height[i] / span);
            count += 1;
        }
    }
    let sum: f64 = if far {
        (2..count)
            .map(|k| {
                let [a, b, c] = [left[0], left[k - 1], left[k]];
                far_sum(normal, [a, b, c], [b - a, c - b, a - c], (b - a).cross(c - a))
            })
            .sum()
    } else {
        (0..count).map(|k| edge_sum(normal, left[k], left[(k + 1) % count])).sum()
    };
    (-sum / TAU).clamp(0.0, 1.0)
}

/// Returns one edge's term of Lambert's sum: the angle of the edge as seen from the point, times the cosine between the receiver's normal
/// and the normal of the plane through edge and point.
#[inline]
fn edge_sum(normal: DVec3, from: DVec3, to: DVec3) -> f64 {
    let cross = from.cross(to);
    let sine = cross.length();
    // An edge that lies on a line through the point has no angle.
    if sine == 0.0 {
        return 0.0;
    }
    sine.atan2(from.dot(to)) * normal.dot(cross) / sine
}

/// Returns Lambert's sum for a small far triangle, where the terms of the edges nearly cancel.
///
/// With a weight w = θ/|r×r′| for each edge, the sum is N·Σ w r×r′. The cross products alone add up to twice the area. Only the differences
/// of the weights are needed in addition, and they follow from the edges without cancellation.
#[inline]
fn far_sum(normal: DVec3, [a, b, c]: [DVec3; 3], [ab, bc, ca]: [DVec3; 3], twice_area: DVec3) -> f64 {
    let (cross_ab, cross_bc, cross_ca) = (a.cross(ab), b.cross(bc), c.cross(ca));
    let (dot_ab, dot_bc, dot_ca) = (a.dot(b), b.dot(c), c.dot(a));
    let shrink = |cross: DVec3, dot: f64| arctangent_shrink(cross.length_squared() / (dot * dot));
    let (shrink_ab, shrink_bc, shrink_ca) =
        (shrink(cross_ab, dot_ab), shrink(cross_bc, dot_bc), shrink(cross_ca, dot_ca));

    // w = (1 + shrink)/dot, so w′ − w = [(shrink′ − shrink)·dot + (1 + shrink)(dot − dot′)]/(dot·dot′). The difference dot − dot′ is an
    // edge's projection on the corner that both edges share.
    let weight_ab = (1.0 + shrink_ab) / dot_ab;
    let more_bc = ((shrink_bc - shrink_ab) * dot_ab + (1.0 + shrink_ab) * b.dot(ca)) / (dot_ab * dot_bc);
    let more_ca = ((shrink_ca - shrink_ab) * dot_ab - (1.0 + shrink_ab) * a.dot(bc)) / (dot_ab * dot_ca);
    weight_ab * normal.dot(twice_area) + more_bc * normal.dot(cross_bc) + more_ca * normal.dot(cross_ca)
}

/// Returns arctan(T)/T − 1 from T², for T² up to [`FAR_SIZE_OVER_DISTANCE`]² and a little more.
#[inline]
fn arctangent_shrink(t2: f64) -> f64 {
    t2 * (-1.0 / 3.0 + t2 * (1.0 / 5.0 + t2 * (-1.0 / 7.0 + t2 * (1.0 / 9.0 + t2 * (-1.0 / 11.0 + t2 / 13.0)))))
}

/// Returns the illuminance that a uniform Lambertian polygon causes at a point.
///
/// The corners belong to a plane simple polygon, convex or not. They run counter-clockwise as seen from its front, which emits. A point
/// behind it or in its plane gets 0. The part below the receiver's horizon is cut off. Nothing stands between polygon and point. Fewer than
/// three corners give 0.
///
/// Units: positions in one length unit, `normal` a unit vector, exitance in lm/m², result in lx.
/// Accuracy: about 1e-15 of the exitance; see [`triangle_illuminance_factor`].
/// Source: J. H. Lambert, "Photometria", 1760.
///
/// ```
/// use glam::DVec3;
/// use luxmc::base::polygon::polygon_illuminance_lx;
///
/// // CIE 171:2006 case 5.6: a 4 m × 4 m floor, seen from 3 m above its centre's edge line.
/// let floor = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(4.0, 4.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];
/// let illuminance_lx = polygon_illuminance_lx(DVec3::new(2.0, 1.75, 3.0), DVec3::NEG_Z, &floor, 100.0);
/// assert!((illuminance_lx - 35.5666).abs() < 1e-4);
/// ```
pub fn polygon_illuminance_lx(point: DVec3, normal: DVec3, corners: &[DVec3], exitance_lm_m2: f64) -> f64 {
    exitance_lm_m2 * polygon_illuminance_factor(point, normal, corners)
}

/// Returns the illuminance that a uniform Lambertian polygon causes at a point, as a fraction of its exitance.
///
/// Units: none (lx per lm/m²). Everything else as in [`polygon_illuminance_lx`].
pub fn polygon_illuminance_factor(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let fan = || (2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]);
    let twice_area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
    let front = fan().map(twice_area).sum::<DVec3>();
    // At a concave corner a triangle of the fan is turned over. It is subtracted.
    let factor: f64 = fan()
        .map(|triangle| match twice_area(triangle).dot(front) >= 0.0 {
            true => triangle_illuminance_factor(point, normal, triangle),
            false => -triangle_illuminance_factor(point, normal, [triangle[0], triangle[2], triangle[1]]),
        })
        .sum();
    factor.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn rectangle(x: [f64; 2], y: [f64; 2], z: f64) -> [DVec3; 4] {
        [DVec3::new(x[0], y[0], z), DVec3::new(x[1], y[0], z), DVec3::new(x[1], y[1], z), DVec3::new(x[0], y[1], z)]
    }

    fn reversed(mut corners: [DVec3; 4]) -> [DVec3; 4] {
        corners.reverse();
        corners
    }

    #[test]
    fn cie_171_case_5_3_area_source() {
        // L = 1000 cd/m², so M = 1000π; 1 m × 1 m at (2,2,3), facing down.
        let source = reversed(rectangle([1.5, 2.5], [1.5, 2.5], 3.0));
        let exitance = 1000.0 * PI;
        let on_wall =
            [(2.75, 32.6769), (2.25, 75.1939), (1.75, 81.3232), (1.25, 69.0606), (0.75, 53.4035), (0.25, 40.0019)];
        for (z, exact) in on_wall {
            let lx = polygon_illuminance_lx(DVec3::new(2.0, 0.0, z), DVec3::Y, &source, exitance);
            assert!((lx - exact).abs() < 6e-5, "z {z}: {lx} against {exact}");
        }
        for (y, exact) in [(0.25, 61.4241), (0.75, 79.2552), (1.25, 95.6673), (1.75, 105.7782), (3.75, 61.4241)] {
            let lx = polygon_illuminance_lx(DVec3::new(2.0, y, 0.0), DVec3::Z, &source, exitance);
            assert!((lx - exact).abs() < 6e-5, "y {y}: {lx} against {exact}");
        }
    }

    #[test]
    fn the_back_and_the_plane_get_nothing() {
        let up = rectangle([-1.0, 1.0], [-1.0, 1.0], 0.0);
        assert_eq!(polygon_illuminance_factor(DVec3::new(0.0, 0.0, -1.0), DVec3::Z, &up), 0.0);
        assert_eq!(polygon_illuminance_factor(DVec3::new(3.0, 0.0, 0.0), DVec3::NEG_X, &up), 0.0);
        assert_eq!(polygon_illuminance_factor(DVec3::new(1.0, 0.0, 0.0), DVec3::NEG_X, &up), 0.0);
        assert_eq!(polygon_illuminance_factor(up[0], DVec3::NEG_X, &up), 0.0);
        assert_eq!(polygon_illuminance_factor(DVec3::Z, DVec3::Z, &up), 0.0);
        assert!(polygon_illuminance_factor(DVec3::Z, DVec3::NEG_Z, &up) > 0.5);
        assert_eq!(polygon_illuminance_factor(DVec3::Z, DVec3::NEG_Z, &up[..2]), 0.0);
    }

    #[test]
    fn the_factors_of_a_closed_box_add_up_to_one() {
        let (lo, hi) = (DVec3::ZERO, DVec3::new(6.0, 4.0, 3.0));
        // Eight corners, six inward faces of two triangles.
        let at = |i: usize| {
            DVec3::new(
                if i & 1 == 0 { lo.x } else { hi.x },
                if i & 2 == 0 { lo.y } else { hi.y },
                if i & 4 == 0 { lo.z } else { hi.z },
            )
        };
        let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let normals =
            [DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, 2.0, -3.0).normalize(), DVec3::new(-3.0, 0.1, 0.2).normalize()];
        let points = [
            DVec3::new(3.0, 2.0, 1.0),
            DVec3::new(1e-3, 1.0, 1.0),
            DVec3::new(1e-9, 1e-9, 1e-9),
            DVec3::new(5.999, 3.999, 2.9999),
        ];
        for normal in normals {
            for point in points {
                let total: f64 = faces.iter().map(|f| polygon_illuminance_factor(point, normal, &f.map(at))).sum();
                assert!((total - 1.0).abs() < 4e-15, "{point} {normal}: {total}");
            }
        }
    }

    #[test]
    fn cutting_a_polygon_changes_nothing_near_or_far_above_or_across_the_horizon() {
        let corners = [DVec3::new(0.3, -0.2, 1.0), DVec3::new(0.1, 0.9, 1.4), DVec3::new(-0.8, 0.1, 0.7)];
        for scale in [1.0, 0.1, 0.051, 0.02, 1e-3, 1e-6] {
            for (direction, normal) in [
                (DVec3::new(0.2, 0.1, 1.0), DVec3::Z),
                (DVec3::new(1.0, 0.3, -0.1), DVec3::X),
                (DVec3::new(0.0, 0.0, 1.0), DVec3::X),
            ] {
                let triangle = corners.map(|corner| direction * 2.0 + (corner - DVec3::Z) * scale);
                let [a, b, c] = triangle;
                let (ab, bc, ca) = ((a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0);
                let factor = |t: [DVec3; 3]| {
                    triangle_illuminance_factor(DVec3::ZERO, normal, t)
                        + triangle_illuminance_factor(DVec3::ZERO, normal, [t[0], t[2], t[1]])
                };
                let whole = factor(triangle);
                let parts = factor([a, ab, ca]) + factor([ab, b, bc]) + factor([ca, bc, c]) + factor([ab, bc, ca]);
                // The angle of each edge, about `scale` large, is rounded. So are the corners of the parts, to 1e-16 of the distance, which
                // is 2/scale of the triangle's size.
                let tolerance = 3e-16 * scale + 4e-15 / scale * whole;
                assert!(whole > 0.0 && (parts - whole).abs() < tolerance, "{scale} {normal}: {whole} {parts}");
            }
        }
    }

    #[test]
    fn a_small_far_triangle_is_the_inverse_square_law() {
        // Legs s at distance d off the normal by 60°, facing the point: F = cos 60° · (s²/2)/(π d²) (1 + O(s/d)).
        let (s, d) = (1e-9, 2.0);
        let to = DVec3::new(3f64.sqrt() / 2.0, 0.0, 0.5);
        let (u, v) = (DVec3::Y, to.cross(DVec3::Y));
        let triangle = [to * d, to * d + v * s, to * d + u * s];
        let exact = 0.5 * 0.5 * (s * s) / (PI * d * d);
        let factor = triangle_illuminance_factor(DVec3::ZERO, DVec3::Z, triangle);
        // The rounded corners hold s to 1e-16·d/s = 2e-7.
        assert!((factor / exact - 1.0).abs() < 1e-6, "{factor} {exact}");
    }

    #[test]
    fn a_hollow_polygon_is_the_difference_of_two() {
        let whole = reversed(rectangle([0.0, 2.0], [0.0, 2.0], 1.0));
        let notch = reversed(rectangle([1.0, 2.0], [1.0, 2.0], 1.0));
        let hollow: Vec<DVec3> = [(0.0, 0.0), (0.0, 2.0), (1.0, 2.0), (1.0, 1.0), (2.0, 1.0), (2.0, 0.0)]
            .iter()
            .map(|(x, y)| DVec3::new(*x, *y, 1.0))
            .collect();
        for start in 0..hollow.len() {
            let mut corners = hollow.clone();
            corners.rotate_left(start);
            for (point, normal) in [(DVec3::ZERO, DVec3::Z), (DVec3::new(3.0, 0.0, 0.5), DVec3::new(-0.8, 0.0, 0.6))] {
                let factor = |corners: &[DVec3]| polygon_illuminance_factor(point, normal, corners);
                assert!((factor(&corners) - (factor(&whole) - factor(&notch))).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn half_a_plane_gives_half() {
        // A wall at x = 0 up to 1e8 m, seen from the floor 1e-6 m in front of it.
        let wall = [
            DVec3::new(0.0, -1e8, 0.0),
            DVec3::new(0.0, 1e8, 0.0),
            DVec3::new(0.0, 1e8, 1e8),
            DVec3::new(0.0, -1e8, 1e8),
        ];
        let factor = polygon_illuminance_factor(DVec3::new(1e-6, 0.0, 0.0), DVec3::Z, &wall);
        assert!((factor - 0.5).abs() < 1e-14, "{factor}");
    }
}
