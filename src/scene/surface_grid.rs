//! Grids on a surface: the surface's rectangle, the EN 12464-1 rule, and the points.

use glam::DVec3;

use super::grid_frame::GridFrame;
use super::model::SurfaceId;
use super::surfaces::Surfaces;
use super::vectors::direction;

/// Tolerance of a rectangle: of its vertices' distance from a plane as a fraction of the surface's size, and of its area as a fraction of
/// the rectangle's area. It is far above rounding and far below what affects a result.
const FLATNESS: f64 = 1e-6;

/// Largest distance of points that EN 12464-1 allows, in m.
const EN_12464_LARGEST_M: f64 = 10.0;

/// Distance of the points of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PointSpacing {
    /// By the rule of EN 12464-1.
    En12464,
    /// As near as possible to this distance in m.
    Distance(f64),
}

/// A flat rectangle: a corner and its sides. The normal of its front is u × v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    corner_m: DVec3,
    u: DVec3,
    v: DVec3,
    width_m: f64,
    depth_m: f64,
}

impl Rectangle {
    /// The rectangle that some surfaces form together. The error says why they form none.
    pub fn of(surfaces: &Surfaces, ids: &[SurfaceId]) -> Result<Rectangle, String> {
        let triangles: Vec<[u32; 3]> = ids
            .iter()
            .flat_map(|id| surfaces.surfaces[*id as usize].triangles.clone())
            .map(|triangle| surfaces.triangles[triangle as usize])
            .collect();
        let (rectangle, area_m2) = Rectangle::around(&surfaces.vertices_m, &triangles)?;
        let [width_m, depth_m] = [rectangle.width_m, rectangle.depth_m];
        if (area_m2 - width_m * depth_m).abs() > FLATNESS * width_m * depth_m {
            return Err(format!("its area of {area_m2:.6} m² does not fill {width_m:.4} m × {depth_m:.4} m"));
        }
        Ok(rectangle)
    }

    /// The rectangle about flat triangles that face one way, along their longest boundary edge, and the area in m² of the triangles. The
    /// error says why they are not flat.
    pub fn around(vertices_m: &[DVec3], triangles: &[[u32; 3]]) -> Result<(Rectangle, f64), String> {
        let at = |vertex: u32| vertices_m[vertex as usize];
        let twice_areas_m2: Vec<DVec3> =
            triangles.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a))).collect();
        let area_m2 = 0.5 * twice_areas_m2.iter().map(|area| area.length()).sum::<f64>();
        let normal = direction(twice_areas_m2.iter().sum());
        if twice_areas_m2.iter().any(|area| area.normalize().dot(normal) < 1.0 - FLATNESS) {
            return Err("it is not flat".into());
        }

        // The sides follow the longest boundary edge. A boundary edge belongs to one triangle only.
        let mut edges: Vec<[u32; 2]> = triangles
            .iter()
            .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]])
            .map(|[from, to]| [from.min(to), from.max(to)])
            .collect();
        edges.sort_unstable();
        let longest = edges
            .chunk_by(|one, other| one == other)
            .filter(|same| same.len() == 1)
            .map(|same| at(same[0][1]) - at(same[0][0]))
            .max_by(|one, other| one.length().total_cmp(&other.length()))
            .ok_or("it has no boundary")?;
        let along = direction(longest - longest.dot(normal) * normal);
        let (u, v) = readable_axes(along, normal);

        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for vertex in triangles.iter().flatten() {
            for (axis, direction) in [u, v, normal].into_iter().enumerate() {
                low[axis] = low[axis].min(at(*vertex).dot(direction));
                high[axis] = high[axis].max(at(*vertex).dot(direction));
            }
        }
        let [width_m, depth_m, thickness_m] = [0, 1, 2].map(|axis| high[axis] - low[axis]);
        if thickness_m > FLATNESS * width_m.max(depth_m) {
            return Err("it is not flat".into());
        }
        Ok((Rectangle { corner_m: u * low[0] + v * low[1] + normal * low[2], u, v, width_m, depth_m }, area_m2))
    }

    /// The longer and the shorter side in m.
    pub fn sides_m(&self) -> [f64; 2] {
        [self.width_m.max(self.depth_m), self.width_m.min(self.depth_m)]
    }

    /// Unit normal of the front.
    pub fn normal(&self) -> DVec3 {
        self.u.cross(self.v)
    }

    /// The rectangle without a strip along its boundary; `None` if nothing is left.
    pub fn shrunk(&self, margin_m: f64) -> Option<Rectangle> {
        let (width_m, depth_m) = (self.width_m - 2.0 * margin_m, self.depth_m - 2.0 * margin_m);
        let corner_m = self.corner_m + margin_m * (self.u + self.v);
        (width_m > 0.0 && depth_m > 0.0).then_some(Rectangle { corner_m, width_m, depth_m, ..*self })
    }

    /// Numbers of columns and rows. They are floats, because a tiny spacing makes them huge.
    pub fn counts(&self, spacing: PointSpacing) -> [f64; 2] {
        let near = |length_m: f64, distance_m: f64| (length_m / distance_m).round().max(1.0);
        let distance_m = match spacing {
            PointSpacing::Distance(distance_m) => distance_m,
            PointSpacing::En12464 => en_12464_distance_m(self.sides_m()),
        };
        let [mut columns, mut rows] = [near(self.width_m, distance_m), near(self.depth_m, distance_m)];

        // EN 12464-1 also requires cells that are nearly square: ratios of their sides from 0.5 to 2.
        if spacing == PointSpacing::En12464 {
            columns = columns.max((self.width_m / (2.0 * self.depth_m / rows) * (1.0 - FLATNESS)).ceil());
            rows = rows.max((self.depth_m / (2.0 * self.width_m / columns) * (1.0 - FLATNESS)).ceil());
        }
        [columns, rows]
    }

    /// Position of a point in the rectangle, as fractions of its sides.
    pub fn place(&self, point_m: DVec3) -> [f64; 2] {
        let from_corner_m = point_m - self.corner_m;
        [from_corner_m.dot(self.u) / self.width_m, from_corner_m.dot(self.v) / self.depth_m]
    }

    /// The grid of cell centres, at a height above the front.
    pub fn grid(&self, columns: u32, rows: u32, height_m: f64) -> GridFrame {
        // From the first to the last centre. A single centre lies in the middle of its whole cell.
        let span = |length_m: f64, count: u32| {
            let cell_m = length_m / f64::from(count);
            if count > 1 { (0.5 * cell_m, length_m - cell_m) } else { (0.0, length_m) }
        };
        let ((first_u_m, u_m), (first_v_m, v_m)) = (span(self.width_m, columns), span(self.depth_m, rows));
        let normal = self.u.cross(self.v);
        let origin_m = self.corner_m + first_u_m * self.u + first_v_m * self.v + height_m * normal;
        GridFrame { columns, rows, origin_m, u_m: u_m * self.u, v_m: v_m * self.v }
    }
}

/// Distance of points in m for a field with a longer and a shorter side: p = 0.2·5^(log₁₀ d), at most 10 m.
///
/// Source: EN 12464-1, calculation points; d is the longer side, or the shorter one from a ratio of 2 on.
pub(super) fn en_12464_distance_m([long_m, short_m]: [f64; 2]) -> f64 {
    let d_m = if long_m >= 2.0 * short_m { short_m } else { long_m };
    (0.2 * 5f64.powf(d_m.log10())).min(EN_12464_LARGEST_M)
}

/// Of the four rotations of a rectangle's axes, the most readable: v up on walls, u along +x (else +y) elsewhere.
fn readable_axes(along: DVec3, normal: DVec3) -> (DVec3, DVec3) {
    let across = normal.cross(along);
    let reads = |(u, v): &(DVec3, DVec3)| 2.0 * v.z + u.dot(DVec3::new(1.0, 0.5, 0.25));
    [(along, across), (across, -along), (-along, -across), (-across, along)]
        .into_iter()
        .max_by(|one, other| reads(one).total_cmp(&reads(other)))
        .unwrap_or((along, across))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(width_m: f64, depth_m: f64) -> Rectangle {
        Rectangle { corner_m: DVec3::ZERO, u: DVec3::X, v: DVec3::Y, width_m, depth_m }
    }

    #[test]
    fn the_grid_rule_gives_the_standards_table() {
        // EN 12464-1's table: length of the area, distance (rounded in print), number of points.
        for (length_m, distance_m, count) in
            [(1.0, 0.2, 5.0), (2.0, 0.3, 6.0), (5.0, 0.6, 8.0), (10.0, 1.0, 10.0), (100.0, 5.0, 20.0)]
        {
            let p_m = en_12464_distance_m([length_m, length_m]);
            assert!((p_m - distance_m).abs() < 0.05, "{length_m}: {p_m}");
            assert_eq!(rectangle(length_m, length_m).counts(PointSpacing::En12464), [count, count], "{length_m}");
        }
        assert!((en_12464_distance_m([25.0, 25.0]) - 1.897).abs() < 5e-4);
        assert_eq!(en_12464_distance_m([1e4, 1e4]), 10.0);
    }

    #[test]
    fn long_fields_take_the_shorter_side_and_cells_stay_near_squares() {
        assert!((en_12464_distance_m([20.0, 2.0]) - 0.3247).abs() < 5e-5);
        for (width_m, depth_m) in [(20.0, 2.0), (0.01, 0.0199), (0.003, 7.0), (8.0, 6.0), (3.0, 1.51), (0.02, 0.02)] {
            let [columns, rows] = rectangle(width_m, depth_m).counts(PointSpacing::En12464);
            let ratio = (width_m / columns) / (depth_m / rows);
            assert!((0.499_999..=2.000_01).contains(&ratio), "{width_m} × {depth_m}: {columns} × {rows}");
        }
    }

    #[test]
    fn points_are_cell_centres_at_the_height() {
        let frame = rectangle(8.0, 6.0).shrunk(0.5).expect("something is left").grid(7, 1, 0.8);
        assert!(frame.origin_m.distance(DVec3::new(1.0, 0.5, 0.8)) < 1e-15);
        assert!(frame.u_m.distance(DVec3::new(6.0, 0.0, 0.0)) < 1e-15 && frame.v_m == DVec3::new(0.0, 5.0, 0.0));
        assert!(rectangle(8.0, 6.0).shrunk(3.0).is_none());
    }

    #[test]
    fn axes_read_well_whatever_edge_was_longest() {
        for along in [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y] {
            assert_eq!(readable_axes(along, DVec3::Z), (DVec3::X, DVec3::Y));
            assert_eq!(readable_axes(along, -DVec3::Z), (DVec3::X, -DVec3::Y));
        }
        for along in [DVec3::X, DVec3::Z, -DVec3::X, -DVec3::Z] {
            assert_eq!(readable_axes(along, -DVec3::Y), (DVec3::X, DVec3::Z));
        }
    }
}
