//! Rectangular rooms with diffuse faces, by radiosity with exact form factors.
//!
//! Every face is cut into n × n rectangles, finer towards the edges. The exchange between rectangles and the mean direct light over
//! each are exact. Only the variation of the exitance within a rectangle is lost, an error that falls as 1/n². Three meshes, each
//! twice as fine as the one before, allow to extrapolate this error away and to estimate what remains.

#[cfg(test)]
mod tests;

use glam::DVec3;

pub use crate::radiosity::faces::RoomFace;
pub use crate::radiosity::sources::RoomSource;

use super::error::{AnalyticError, require, require_length, require_light, require_reflectance};
use crate::radiosity::faces;
use crate::radiosity::mesh::{RoomMesh, extrapolated, graded_edges};

/// A room from the origin to `size_m`; its faces face inwards.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxRoom {
    /// Lengths along x, y and z, m.
    pub size_m: [f64; 3],
    /// Reflectances of the faces, in the order of [`RoomFace::ALL`]: x low, x high, y low, y high, floor, ceiling.
    pub reflectances: [f64; 6],
    /// Light sources of the room.
    pub sources: Vec<RoomSource>,
}

/// The illuminance at a point or over an area of a room.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoomValue {
    /// Direct illuminance from the sources, lx; exact.
    pub direct_lx: f64,
    /// Illuminance after one or more reflections, lx.
    pub indirect_lx: f64,
    /// Estimated error of the indirect part, lx.
    pub estimated_error_lx: f64,
}

impl RoomValue {
    /// Direct and indirect together, lx.
    pub fn total_lx(&self) -> f64 {
        self.direct_lx + self.indirect_lx
    }
}

/// Divisions of a face's edge on the three meshes.
const DIVISIONS: [usize; 3] = [8, 16, 32];

/// A solved room.
#[derive(Clone, Debug)]
pub struct BoxRoomSolution {
    room: BoxRoom,
    meshes: Vec<RoomMesh>,
}

impl BoxRoom {
    /// Solves the room in less than a second, with about 150 MB of memory.
    ///
    /// Accuracy: the indirect part has a relative error of 1e-4. It is larger within a hundredth of the room from an edge or
    /// corner. Every value has its own estimated error. Sources nearer to a face than a tenth of the room lower the accuracy.
    ///
    /// # Errors
    /// Lengths that are not positive, reflectances outside 0 to 1, all reflectances 1 (no face absorbs), sources outside the room
    /// or of negative strength.
    ///
    /// ```
    /// use luxmc::analytic::box_room::{BoxRoom, RoomFace, RoomSource};
    /// use glam::DVec3;
    ///
    /// // CIE 171:2006 case 5.8: 10,000 lm in the middle of a 4 m cube of reflectance 0.5.
    /// let intensity_cd = 10_000.0 / (4.0 * std::f64::consts::PI);
    /// let source = RoomSource::Point { position: DVec3::splat(2.0), intensity_cd };
    /// let room = BoxRoom { size_m: [4.0; 3], reflectances: [0.5; 6], sources: vec![source] };
    /// let solution = room.solve()?;
    /// assert!((solution.face_mean(RoomFace::Floor).indirect_lx - 104.1667).abs() < 1e-4);
    /// assert!((solution.on_face(RoomFace::Floor, 2.0, 2.0)?.indirect_lx - 112.038).abs() < 0.003);
    /// # Ok::<(), luxmc::analytic::AnalyticError>(())
    /// ```
    pub fn solve(&self) -> Result<BoxRoomSolution, AnalyticError> {
        for (axis, length) in ["x", "y", "z"].iter().zip(self.size_m) {
            require_length(&format!("the room's length along {axis}"), length)?;
        }
        for (face, reflectance) in RoomFace::ALL.iter().zip(self.reflectances) {
            require_reflectance(&format!("the reflectance of {face:?}"), reflectance)?;
        }
        let absorbs = self.reflectances.iter().any(|r| *r < 1.0);
        require(
            absorbs,
            "the reflectance of every face",
            1.0,
            "less than 1 on one face at least",
            "let a face absorb",
        )?;
        for source in &self.sources {
            check_source(source, self.size_m)?;
        }
        let mesh = |divisions: &usize| {
            let edges = self.size_m.map(|length| graded_edges(&[0.0, length], *divisions));
            let direct_lx = |face: RoomFace, stretches: [[f64; 2]; 2]| {
                self.sources.iter().map(|s| s.rectangle_mean_lx(self.size_m, face, stretches)).sum()
            };
            RoomMesh::solved(self.size_m, edges, |face, _| self.reflectances[face.index()], direct_lx)
        };
        let meshes = DIVISIONS.iter().map(mesh).collect();
        Ok(BoxRoomSolution { room: self.clone(), meshes })
    }
}

impl BoxRoomSolution {
    /// Mean illuminance over a face.
    ///
    /// The means over all faces balance exactly: Σ (1 − ρ)EA equals the emitted flux.
    pub fn face_mean(&self, face: RoomFace) -> RoomValue {
        let direct_lx = self.meshes[DIVISIONS.len() - 1].face_direct_lx(face);
        self.limit(direct_lx, |mesh| mesh.face_indirect_lx(face))
    }

    /// Illuminance at a point of a face, `u` and `v` metres along the other two axes (in the order of the axes).
    ///
    /// # Errors
    /// A point outside the face.
    pub fn on_face(&self, face: RoomFace, u: f64, v: f64) -> Result<RoomValue, AnalyticError> {
        let [length_u, length_v] = face.other_axes().map(|axis| self.room.size_m[axis]);
        for (what, place, length) in [("the place u", u, length_u), ("the place v", v, length_v)] {
            let on = (0.0..=length).contains(&place);
            require(on, what, place, &format!("0 to {length} m"), "stay on the face")?;
        }
        Ok(self.value_on(face, [u, v]))
    }

    fn limit(&self, direct_lx: f64, indirect_lx: impl Fn(&RoomMesh) -> f64) -> RoomValue {
        let (indirect_lx, estimated_error_lx) = extrapolated([0, 1, 2].map(|level| indirect_lx(&self.meshes[level])));
        RoomValue { direct_lx, indirect_lx, estimated_error_lx }
    }

    fn value_on(&self, face: RoomFace, place: [f64; 2]) -> RoomValue {
        let position = face.position(self.room.size_m, place);
        let normal = face.normal();
        let direct_lx = self.room.sources.iter().map(|s| s.at_point_lx(self.room.size_m, position, normal)).sum();
        self.limit(direct_lx, |mesh| mesh.indirect_at_lx(position, normal))
    }

    /// Mean illuminance over a triangle on a face. Its corners are in the room's coordinates, in either order.
    ///
    /// Accuracy: the direct part is exact for point sources. Integrated parts (the indirect part, panels) have a relative error of
    /// 1e-5 if the triangle is no larger than a quarter of the face.
    ///
    /// # Errors
    /// Corners that do not lie on one face, and triangles with zero area.
    pub fn triangle_mean(&self, corners: [DVec3; 3]) -> Result<RoomValue, AnalyticError> {
        let area_m2 = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        require(area_m2 > 0.0, "the triangle's area", area_m2, "a positive area", "give three corners not in a line")?;
        let face = faces::common_face(self.room.size_m, &corners).ok_or_else(|| AnalyticError {
            what: "the triangle".to_string(),
            got: format!("{corners:?}"),
            expected: "three corners on one face of the room".to_string(),
            remedy: "give the corners in the room's coordinates".to_string(),
        })?;
        let places = faces::triangle_rule();
        let weights: f64 = places.iter().map(|p| p.1).sum();
        let mut mean = RoomValue::default();
        for ([along, across], weight) in places {
            let position = corners[0]
                + (corners[1] - corners[0]) * *along * (1.0 - across)
                + (corners[2] - corners[0]) * *along * *across;
            let value = self.value_on(face, face.place(position));
            mean.indirect_lx += weight / weights * value.indirect_lx;
            mean.estimated_error_lx += weight / weights * value.estimated_error_lx;
        }
        let direct = |source: &RoomSource| source.triangle_mean_lx(self.room.size_m, face, corners, area_m2);
        mean.direct_lx = self.room.sources.iter().map(direct).sum();
        Ok(mean)
    }

    /// Mean illuminance over a rectangle of a face, from `low` to `high` along the other two axes.
    ///
    /// Accuracy and errors: those of [`BoxRoomSolution::triangle_mean`].
    pub fn rectangle_mean(&self, face: RoomFace, low: [f64; 2], high: [f64; 2]) -> Result<RoomValue, AnalyticError> {
        let at = |u: f64, v: f64| face.position(self.room.size_m, [u, v]);
        let [a, b] = [at(low[0], low[1]), at(high[0], high[1])];
        let first = self.triangle_mean([a, at(high[0], low[1]), b])?;
        let second = self.triangle_mean([a, b, at(low[0], high[1])])?;
        Ok(RoomValue {
            direct_lx: 0.5 * (first.direct_lx + second.direct_lx),
            indirect_lx: 0.5 * (first.indirect_lx + second.indirect_lx),
            estimated_error_lx: 0.5 * (first.estimated_error_lx + second.estimated_error_lx),
        })
    }
}

/// Refuses a source outside the room or of negative strength.
fn check_source(source: &RoomSource, size_m: [f64; 3]) -> Result<(), AnalyticError> {
    let remedy = "put the source into the room";
    match *source {
        RoomSource::Point { position, intensity_cd } => {
            require_light("the source's intensity", intensity_cd)?;
            for (axis, length) in size_m.into_iter().enumerate() {
                let within = position[axis] > 0.0 && position[axis] < length;
                require(within, "a coordinate of the source", position[axis], &format!("0 to {length} m"), remedy)?;
            }
        }
        RoomSource::Panel { face, low, high, exitance_lm_m2 } => {
            require_light("the panel's exitance", exitance_lm_m2)?;
            for (i, axis) in face.other_axes().into_iter().enumerate() {
                let length = size_m[axis];
                let expected = format!("0 to {length} m, rising");
                require(low[i] >= 0.0 && low[i] < high[i], "the panel's low edge", low[i], &expected, remedy)?;
                require(high[i] <= length, "the panel's high edge", high[i], &expected, remedy)?;
            }
        }
    }
    Ok(())
}
