//! Cuts plane polygons into triangles.

use glam::DVec3;

/// Returns the triangles of a simple polygon as indices in `corners`. They have the polygon's sense of rotation. Concave polygons are cut
/// along lines inside them.
///
/// A polygon that is not plane is cut as its projection along its mean normal. One without an area, or that crosses itself, still becomes
/// `n − 2` triangles.
pub(crate) fn triangulate(corners: &[DVec3]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len().saturating_sub(2));
    let normal = newell_normal(corners);

    // Cut ears: corners that turn with the polygon and whose triangle contains no other corner.
    while left.len() > 3 {
        let count = left.len();
        let ear = (0..count).find(|&tip| is_ear(corners, &left, tip, normal)).unwrap_or(0);
        triangles.push([left[(ear + count - 1) % count], left[ear], left[(ear + 1) % count]]);
        left.remove(ear);
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

/// Newell's normal: twice the vector area.
fn newell_normal(corners: &[DVec3]) -> DVec3 {
    let Some(first) = corners.first() else { return DVec3::ZERO };
    corners.windows(2).map(|edge| (edge[0] - *first).cross(edge[1] - *first)).sum()
}

fn is_ear(corners: &[DVec3], left: &[usize], tip: usize, normal: DVec3) -> bool {
    let count = left.len();
    let (before, after) = (left[(tip + count - 1) % count], left[(tip + 1) % count]);
    let [a, b, c] = [before, left[tip], after].map(|index| corners[index]);
    let turn = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal);
    if turn(a, b, c) <= 0.0 {
        return false;
    }
    left.iter().filter(|index| ![before, left[tip], after].contains(index)).all(|index| {
        let point = corners[*index];
        let is_corner = point == a || point == b || point == c;
        is_corner || turn(a, b, point) < 0.0 || turn(b, c, point) < 0.0 || turn(c, a, point) < 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signed_areas(corners: &[DVec3]) -> Vec<f64> {
        triangulate(corners)
            .iter()
            .map(|[a, b, c]| 0.5 * (corners[*b] - corners[*a]).cross(corners[*c] - corners[*a]).z)
            .collect()
    }

    #[test]
    fn a_concave_polygon_is_cut_inside_of_itself() {
        // An L, begun at each of its six corners: a 2×2 square less a 1×1 corner.
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
        for start in 0..6 {
            let turned: Vec<DVec3> =
                (0..6).map(|i| corners[(start + i) % 6]).map(|(x, y)| DVec3::new(x, y, 1.0)).collect();
            let areas = signed_areas(&turned);
            assert_eq!(areas.len(), 4);
            assert!(areas.iter().all(|area| *area > 0.0), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - 3.0).abs() < 1e-12);
        }
    }

    #[test]
    fn an_arrowhead_quadrilateral_is_cut_through_its_notch() {
        let corners = [(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (0.5, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let areas = signed_areas(&corners);
        assert!(areas.iter().all(|area| *area > 0.0) && (areas.iter().sum::<f64>() - 1.5).abs() < 1e-12, "{areas:?}");
    }

    #[test]
    fn a_polygon_without_area_ends_too() {
        assert_eq!(triangulate(&[DVec3::ZERO; 7]).len(), 5);
        assert!(triangulate(&[DVec3::ZERO; 2]).is_empty());
    }
}
