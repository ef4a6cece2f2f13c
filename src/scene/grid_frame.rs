//! The layout of a receiver grid in its plane, and the limit of the number of points in a scene.

use glam::DVec3;

use super::error::SceneError;
use super::limits::MOST_POINTS;
use super::model::{ReceiverLayout, ReceiverPoint};
use super::reader::Node;
use super::vectors::direction;

/// Refuses more points than a scene may have.
pub(super) fn refuse_too_many(node: &Node, points: u64) -> SceneError {
    let expected = format!("at most {MOST_POINTS} points of all grids, fans and views together");
    node.refuse_as("this receiver has too many points", format!("{points} points"), expected, "ask for fewer")
}

/// The layout of a grid before its points are made.
pub(super) struct GridFrame {
    pub columns: u32,
    pub rows: u32,
    pub origin_m: DVec3,
    pub u_m: DVec3,
    pub v_m: DVec3,
}

impl GridFrame {
    /// Returns the layout and its points, row by row. Every point stands for a cell as wide as the distance of the points. A row of one
    /// point stands for the whole of `u` (or `v`).
    pub fn points(&self) -> (ReceiverLayout, Vec<ReceiverPoint>) {
        let cells_over_span = |count: u32| if count > 1 { f64::from(count) / f64::from(count - 1) } else { 1.0 };
        let vector_area_m2 = self.u_m.cross(self.v_m);
        let area_m2 = vector_area_m2.length() * cells_over_span(self.columns) * cells_over_span(self.rows);
        let normal = direction(self.u_m).cross(direction(self.v_m)).normalize();
        let weight = area_m2 / (f64::from(self.columns) * f64::from(self.rows));
        let share = |index: u32, count: u32| if count > 1 { f64::from(index) / f64::from(count - 1) } else { 0.5 };
        // Memory for a large grid is allocated once.
        let mut points = Vec::with_capacity(self.columns as usize * self.rows as usize);
        let places = (0..self.rows).flat_map(|row| (0..self.columns).map(move |column| (column, row)));
        points.extend(places.map(|(column, row)| ReceiverPoint {
            position_m: self.origin_m + share(column, self.columns) * self.u_m + share(row, self.rows) * self.v_m,
            normal,
            weight,
            inside: false,
        }));
        let layout = ReceiverLayout::Grid {
            columns: self.columns,
            rows: self.rows,
            origin_m: self.origin_m,
            u_m: self.u_m,
            v_m: self.v_m,
            area_m2,
        };
        (layout, points)
    }
}
