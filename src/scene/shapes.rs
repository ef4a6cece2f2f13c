//! Boxes, rectangles and spheres as triangles.

use std::collections::HashMap;

use glam::DVec3;

use super::limits::SPHERE_FREQUENCY;

/// Triangles over a list of vertices, in parts. Lengths are in the file's unit until the shape is placed.
#[derive(Clone, Debug, Default)]
pub(crate) struct GeometryShape {
    pub vertices: Vec<DVec3>,
    pub parts: Vec<ShapePart>,
}

/// A named part of a shape. A shape without parts has one part without a name.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShapePart {
    pub name: Option<String>,
    pub triangles: Vec<[u32; 3]>,
}

/// Names of a box's faces, in the order of its parts.
pub(super) const BOX_FACES: [&str; 6] = ["floor", "ceiling", "x_min", "x_max", "y_min", "y_max"];

/// A box parallel to the axes. Its faces share the eight vertices.
pub(super) fn cuboid(min: DVec3, max: DVec3, inward: bool) -> GeometryShape {
    let vertices = (0..8)
        .map(|corner| {
            let pick = |bit: usize, axis: usize| if corner & bit == 0 { min[axis] } else { max[axis] };
            DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2))
        })
        .collect();

    // Corners counter-clockwise, as seen from outside.
    let faces: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]];
    let parts = BOX_FACES
        .iter()
        .zip(faces)
        .map(|(name, [a, b, c, d])| {
            let triangles = if inward { vec![[a, d, c], [a, c, b]] } else { vec![[a, b, c], [a, c, d]] };
            ShapePart { name: Some((*name).into()), triangles }
        })
        .collect();
    GeometryShape { vertices, parts }
}

/// A parallelogram with the normal u × v.
pub(super) fn parallelogram(origin: DVec3, u: DVec3, v: DVec3) -> GeometryShape {
    let vertices = vec![origin, origin + u, origin + u + v, origin + v];
    GeometryShape { vertices, parts: vec![ShapePart { name: None, triangles: vec![[0, 1, 2], [0, 2, 3]] }] }
}

/// Frequency at which no edge of an inscribed icosphere is longer than `longest_edge`; at least the default.
pub(super) fn sphere_frequency(radius: f64, longest_edge: Option<f64>) -> f64 {
    // The flat edge of a subdivided icosahedron is 1.0515/f radii. Its points lie at least 0.7946 radii from the centre. Lifting two
    // points from there onto the sphere stretches their distance by at most 1/0.7946.
    const LIFTED_EDGE: f64 = 1.3232;
    let needed = longest_edge.map_or(0.0, |edge| (LIFTED_EDGE * radius / edge).ceil());
    needed.max(f64::from(SPHERE_FREQUENCY))
}

/// An icosahedron with every edge cut into `frequency` parts and all vertices on the sphere.
pub(crate) fn icosphere(center: DVec3, radius: f64, inward: bool, frequency: u32) -> GeometryShape {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut corners = Vec::with_capacity(12);
    for long in [golden, -golden] {
        for short in [1.0, -1.0] {
            corners.push(DVec3::new(0.0, short, long));
            corners.push(DVec3::new(short, long, 0.0));
            corners.push(DVec3::new(long, 0.0, short));
        }
    }

    // Three corners at distance 2 from each other (the edge length) form a face.
    let is_edge = |i: usize, j: usize| (corners[i].distance_squared(corners[j]) - 4.0).abs() < 1.0;
    let mut sphere = Subdivision { vertices: Vec::new(), numbers: HashMap::new(), frequency };
    let mut triangles = Vec::with_capacity(20 * (frequency * frequency) as usize);
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if !(is_edge(i, j) && is_edge(j, k) && is_edge(i, k)) {
                    continue;
                }
                let outward = (corners[j] - corners[i]).cross(corners[k] - corners[i]).dot(corners[i]) > 0.0;
                let face = if outward != inward { [i, j, k] } else { [i, k, j] };
                sphere.divide(face, &corners, &mut triangles);
            }
        }
    }
    let vertices = sphere.vertices.iter().map(|direction| center + radius * direction.normalize()).collect();
    GeometryShape { vertices, parts: vec![ShapePart { name: None, triangles }] }
}

/// Cuts the faces of an icosahedron. Points on shared edges have one number.
struct Subdivision {
    vertices: Vec<DVec3>,
    numbers: HashMap<[(usize, u32); 3], u32>,
    frequency: u32,
}

impl Subdivision {
    fn divide(&mut self, [a, b, c]: [usize; 3], corners: &[DVec3], triangles: &mut Vec<[u32; 3]>) {
        let n = self.frequency;
        for row in 0..n {
            for column in 0..n - row {
                let [first, right, above] = [(column, row), (column + 1, row), (column, row + 1)]
                    .map(|(i, j)| self.number([(a, n - i - j), (b, i), (c, j)], corners));
                triangles.push([first, right, above]);
                if column + row + 1 < n {
                    let across = self.number([(a, n - column - row - 2), (b, column + 1), (c, row + 1)], corners);
                    triangles.push([right, across, above]);
                }
            }
        }
    }

    /// Returns the vertex at whole-number weights of three corners. Corners of weight 0 are ignored, so both faces at an edge get the
    /// same vertex.
    fn number(&mut self, mut weights: [(usize, u32); 3], corners: &[DVec3]) -> u32 {
        for weight in &mut weights {
            if weight.1 == 0 {
                *weight = (usize::MAX, 0);
            }
        }
        weights.sort_unstable();
        let vertices = &mut self.vertices;
        *self.numbers.entry(weights).or_insert_with(|| {
            let point = weights
                .iter()
                .filter(|(_, weight)| *weight > 0)
                .map(|(corner, weight)| corners[*corner] * f64::from(*weight))
                .sum();
            vertices.push(point);
            (vertices.len() - 1) as u32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_and_volume(shape: &GeometryShape) -> (f64, f64) {
        let mut sums = (0.0, 0.0);
        for triangle in shape.parts.iter().flat_map(|part| &part.triangles) {
            let [a, b, c] = triangle.map(|vertex| shape.vertices[vertex as usize]);
            sums.0 += 0.5 * (b - a).cross(c - a).length();
            sums.1 += a.dot(b.cross(c)) / 6.0;
        }
        sums
    }

    #[test]
    fn a_box_has_its_area_and_its_volume_and_each_face_its_normal() {
        let shape = cuboid(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 6.0), false);
        let (area, volume) = area_and_volume(&shape);
        assert!((area - 2.0 * (6.0 + 8.0 + 12.0)).abs() < 1e-12);
        assert!((volume - 24.0).abs() < 1e-12);
        let normals = [-DVec3::Z, DVec3::Z, -DVec3::X, DVec3::X, -DVec3::Y, DVec3::Y];
        for (part, normal) in shape.parts.iter().zip(normals) {
            for triangle in &part.triangles {
                let [a, b, c] = triangle.map(|vertex| shape.vertices[vertex as usize]);
                assert_eq!((b - a).cross(c - a).normalize(), normal, "{:?}", part.name);
            }
        }
        let (_, volume) = area_and_volume(&cuboid(DVec3::ZERO, DVec3::ONE, true));
        assert!((volume + 1.0).abs() < 1e-12);
    }

    #[test]
    fn an_icosphere_is_closed_and_comes_near_the_sphere() {
        for frequency in [1, 2, 5, 16] {
            let shape = icosphere(DVec3::new(0.3, 0.2, 0.1), 2.0, false, frequency);
            let triangles = 20 * frequency * frequency;
            assert_eq!(shape.parts[0].triangles.len() as u32, triangles);
            // Euler: V − E + F = 2 with E = 3F/2, so no vertex of a shared edge exists twice.
            assert_eq!(shape.vertices.len() as u32, triangles / 2 + 2);
        }
        let (area, volume) = area_and_volume(&icosphere(DVec3::ZERO, 1.0, false, 16));
        let (exact_area, exact_volume) = (4.0 * std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI);
        assert!(area < exact_area && area > 0.996 * exact_area, "{area}");
        assert!(volume < exact_volume && volume > 0.993 * exact_volume, "{volume}");
        assert!(area_and_volume(&icosphere(DVec3::ZERO, 1.0, true, 4)).1 < 0.0);
    }

    #[test]
    fn a_sphere_has_no_edge_longer_than_asked() {
        for longest in [0.5, 0.05, 0.031] {
            let frequency = sphere_frequency(1.0, Some(longest)) as u32;
            let shape = icosphere(DVec3::ZERO, 1.0, false, frequency);
            for triangle in &shape.parts[0].triangles {
                let [a, b, c] = triangle.map(|vertex| shape.vertices[vertex as usize]);
                for edge in [a.distance(b), b.distance(c), c.distance(a)] {
                    assert!(edge <= longest, "{edge} > {longest}");
                }
            }
        }
    }
}
