//! Welds the open edges of a mesh. Programs sometimes write one point twice with different last digits.

use std::collections::HashSet;

use glam::DVec3;

use super::shapes::GeometryShape;

/// Largest distance of welded vertices, as a fraction of the mesh's size. It is a few last digits of single precision, in which most
/// programs write meshes and in which rays are traced.
const SAME_PLACE: f64 = 2e-7;

/// Merges vertices on open edges that lie practically at one point. Returns the number of removed vertices and the position of the first.
///
/// It is safe because nothing else changes. Vertices within a closed surface stay. No triangle loses its area: if two of its corners
/// would merge, they stay apart. No vertex moves farther than rays can resolve.
pub(super) fn weld(shape: &mut GeometryShape) -> Option<(usize, DVec3)> {
    let rim = rim_vertices(shape);
    let low = shape.vertices.iter().fold(DVec3::INFINITY, |low, vertex| low.min(*vertex));
    let high = shape.vertices.iter().fold(DVec3::NEG_INFINITY, |high, vertex| high.max(*vertex));
    let tolerance = SAME_PLACE * low.distance(high);
    let place = |vertex: u32| shape.vertices[vertex as usize];

    // Along one axis, each vertex is compared with the preceding vertices that are kept.
    let mut sorted = rim;
    sorted.sort_by(|one, other| place(*one).x.total_cmp(&place(*other).x).then(one.cmp(other)));
    let mut kept: Vec<u32> = Vec::new();
    let mut moved: Vec<(u32, u32)> = Vec::new();
    for vertex in sorted {
        let near = kept
            .iter()
            .rev()
            .take(MOST_NEIGHBOURS)
            .take_while(|other| place(vertex).x - place(**other).x <= tolerance)
            .find(|other| place(vertex).distance(place(**other)) <= tolerance);
        match near {
            Some(other) => moved.push((vertex, *other)),
            None => kept.push(vertex),
        }
    }
    let first_m = place(moved.first()?.0);
    let mut stands_for: Vec<u32> = (0..shape.vertices.len() as u32).collect();
    moved.iter().for_each(|(vertex, other)| stands_for[*vertex as usize] = *other);

    // Triangles that would lose a corner keep all their corners.
    let mut apart: HashSet<u32> = HashSet::new();
    for triangle in shape.parts.iter().flat_map(|part| &part.triangles) {
        let [a, b, c] = triangle.map(|vertex| stands_for[vertex as usize]);
        if a == b || b == c || c == a {
            apart.extend(triangle);
        }
    }
    apart.iter().for_each(|vertex| stands_for[*vertex as usize] = *vertex);
    let count = (0u32..).zip(&stands_for).filter(|(vertex, other)| vertex != *other).count();
    for triangle in shape.parts.iter_mut().flat_map(|part| &mut part.triangles) {
        *triangle = triangle.map(|vertex| stands_for[vertex as usize]);
    }
    (count > 0).then_some((count, first_m))
}

/// Most vertices near the sweep position that are compared. If more lie there, they do so by design, and need no welding.
const MOST_NEIGHBOURS: usize = 4096;

/// Vertices of the edges that belong to an odd number of triangles.
fn rim_vertices(shape: &GeometryShape) -> Vec<u32> {
    let triangles = || shape.parts.iter().flat_map(|part| &part.triangles);
    let mut edges: Vec<(u32, u32)> = triangles()
        .flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)])
        .map(|(from, to)| (from.min(to), from.max(to)))
        .collect();
    edges.sort_unstable();
    let odd = edges.chunk_by(|one, other| one == other).filter(|same| same.len() % 2 == 1);
    let mut vertices: Vec<u32> = odd.flat_map(|same| [same[0].0, same[0].1]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

#[cfg(test)]
mod tests {
    use super::super::shapes::ShapePart;
    use super::*;

    /// Two triangles of a square with separate corners. `gap` separates them along x.
    fn square(gap: f64) -> GeometryShape {
        let corner = DVec3::new;
        GeometryShape {
            vertices: vec![
                corner(0.0, 0.0, 0.0),
                corner(1.0, 0.0, 0.0),
                corner(1.0, 1.0, 0.0),
                corner(gap, 0.0, 0.0),
                corner(1.0 + gap, 1.0, 0.0),
                corner(0.0, 1.0, 0.0),
            ],
            parts: vec![ShapePart { name: None, triangles: vec![[0, 1, 2], [3, 4, 5]] }],
        }
    }

    #[test]
    fn corners_that_rounding_has_parted_become_one_and_others_stay() {
        let mut near = square(1e-8);
        assert_eq!(weld(&mut near).map(|(count, _)| count), Some(2));
        assert_eq!(near.parts[0].triangles, [[0, 1, 2], [0, 2, 5]]);
        let mut far = square(1e-4);
        assert_eq!(weld(&mut far), None);
        assert_eq!(far.parts[0].triangles, [[0, 1, 2], [3, 4, 5]]);
    }

    #[test]
    fn needles_keep_their_corners() {
        let corner = DVec3::new;
        let vertices = vec![corner(0.0, 0.0, 0.0), corner(1.0, 0.0, 0.0), corner(1.0, 1e-9, 0.0)];
        let mut needle = GeometryShape { vertices, parts: vec![ShapePart { name: None, triangles: vec![[0, 1, 2]] }] };
        assert_eq!(weld(&mut needle), None);
        assert_eq!(needle.parts[0].triangles, [[0, 1, 2]]);
    }
}
