//! The six faces of a room and points on them.

use std::sync::LazyLock;

use glam::DVec3;

use crate::base::form_factors::AxisRectangle;
use crate::base::quadrature::GaussLegendre;

/// A face of the room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoomFace {
    /// At x = 0.
    XLow,
    /// At x = the room's length.
    XHigh,
    /// At y = 0.
    YLow,
    /// At y = the room's length.
    YHigh,
    /// At z = 0.
    Floor,
    /// At z = the room's height.
    Ceiling,
}

impl RoomFace {
    /// The faces in the order of their reflectances.
    pub const ALL: [RoomFace; 6] =
        [RoomFace::XLow, RoomFace::XHigh, RoomFace::YLow, RoomFace::YHigh, RoomFace::Floor, RoomFace::Ceiling];

    /// Index in [`RoomFace::ALL`].
    pub fn index(self) -> usize {
        self as usize
    }

    /// Axis of the face's normal.
    pub fn axis(self) -> usize {
        self.index() / 2
    }

    /// Returns whether the face is at the far end of its axis.
    pub fn is_high(self) -> bool {
        self.index() % 2 == 1
    }

    /// The two axes along the face, in order.
    pub fn other_axes(self) -> [usize; 2] {
        [[1, 2], [0, 2], [0, 1]][self.axis()]
    }

    /// Normal into the room.
    pub fn normal(self) -> DVec3 {
        DVec3::AXES[self.axis()] * if self.is_high() { -1.0 } else { 1.0 }
    }

    /// Coordinate of the face on its axis, m.
    pub fn at(self, size_m: [f64; 3]) -> f64 {
        if self.is_high() { size_m[self.axis()] } else { 0.0 }
    }

    /// The position of a point of the face in the room's coordinates, m. `place` is its coordinates along the face.
    pub fn position(self, size_m: [f64; 3], place: [f64; 2]) -> DVec3 {
        let mut position = [0.0; 3];
        position[self.axis()] = self.at(size_m);
        for (axis, coordinate) in self.other_axes().iter().zip(place) {
            position[*axis] = coordinate;
        }
        DVec3::from_array(position)
    }

    /// Corners of a rectangle of the face, counter-clockwise as seen from within the room.
    pub fn corners(self, size_m: [f64; 3], [u, v]: [[f64; 2]; 2]) -> [DVec3; 4] {
        let mut corners =
            [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]].map(|place| self.position(size_m, place));
        // For an axis along y the other two axes come in the opposite order of rotation.
        if self.is_high() != (self.axis() == 1) {
            corners.reverse();
        }
        corners
    }

    /// A rectangle of the face, seen from within.
    pub fn rectangle(self, size_m: [f64; 3], stretches: [[f64; 2]; 2]) -> AxisRectangle {
        AxisRectangle { axis: self.axis(), at_m: self.at(size_m), faces_up: !self.is_high(), stretches_m: stretches }
    }

    /// A position's coordinates along the face.
    pub fn place(self, position: DVec3) -> [f64; 2] {
        self.other_axes().map(|axis| position[axis])
    }
}

/// Distance from a face's plane, relative to the room's size, within which a corner counts as on the face. Files write coordinates
/// with six or more digits.
pub const ON_FACE: f64 = 1e-6;

/// The face on which all corners lie, if there is one.
pub fn common_face(size_m: [f64; 3], corners: &[DVec3]) -> Option<RoomFace> {
    let room = DVec3::from_array(size_m);
    let tolerance = ON_FACE * room.max_element();
    let within = |p: &DVec3| (0..3).all(|axis| p[axis] >= -tolerance && p[axis] <= size_m[axis] + tolerance);
    let on =
        |face: &RoomFace| corners.iter().all(|p| (p[face.axis()] - face.at(size_m)).abs() <= tolerance && within(p));
    RoomFace::ALL.into_iter().find(on)
}

/// A point in the unit square, and its weight.
pub type TriangleNode = ([f64; 2], f64);

/// Gauss–Legendre rule over a triangle collapsed to a square: along from the first corner, across between the other two. It is
/// exact to degree 6.
pub fn triangle_rule() -> &'static [TriangleNode] {
    static RULE: LazyLock<Vec<TriangleNode>> = LazyLock::new(|| {
        let rule = GaussLegendre::new(4);
        let along: Vec<(f64, f64)> = rule.on(0.0, 1.0).collect();
        along.iter().flat_map(|(s, w)| along.iter().map(move |(t, v)| ([*s, *t], 2.0 * s * w * v))).collect()
    });
    &RULE
}
