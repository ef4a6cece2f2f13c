//! Rectangular rooms as truth: radiosity with exact form factors, extrapolated over three meshes.

use std::sync::{Arc, Mutex};

use glam::DVec3;
use serde::Deserialize;

use super::exact::{Exact, LightPart, TruthSite};
use crate::analytic::box_room::{BoxRoom, BoxRoomSolution, RoomFace, RoomSource, RoomValue};

/// A point within this distance of a face, in m, lies on it.
const ON_FACE_M: f64 = 1e-9;
/// Names of the faces in scenes, in the order of [`RoomFace::ALL`].
const FACE_NAMES: [&str; 6] = ["x_min", "x_max", "y_min", "y_max", "floor", "ceiling"];

/// An empty diffuse room with a corner at the origin, lit by an isotropic point source.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoomTruth {
    /// Lengths along x, y and z in m.
    pub size_m: [f64; 3],
    /// Reflectances of `x_min`, `x_max`, `y_min`, `y_max`, `floor` and `ceiling`.
    pub reflectances: [f64; 6],
    /// Position of the source in m.
    pub source_m: [f64; 3],
    /// Luminous flux of the source in lm.
    pub luminous_flux_lm: f64,
}

/// Cache of the room solved last, since several comparisons use the same room.
#[derive(Debug, Default)]
pub struct RoomCache(Mutex<Option<(BoxRoom, Arc<BoxRoomSolution>)>>);

impl RoomCache {
    fn solved(&self, room: &BoxRoom) -> Result<Arc<BoxRoomSolution>, String> {
        let mut latest = self.0.lock().map_err(|_| "another room failed".to_owned())?;
        if let Some((known, solution)) = latest.as_ref()
            && known == room
        {
            return Ok(Arc::clone(solution));
        }
        let solution = Arc::new(room.solve().map_err(|error| error.to_string())?);
        *latest = Some((room.clone(), Arc::clone(&solution)));
        Ok(solution)
    }
}

pub(super) fn room_truth(
    truth: &RoomTruth,
    cache: &RoomCache,
    site: &TruthSite,
    light: LightPart,
) -> Result<Exact, String> {
    let intensity_cd = truth.luminous_flux_lm / (4.0 * std::f64::consts::PI);
    let source = RoomSource::Point { position: DVec3::from(truth.source_m), intensity_cd };
    let room = BoxRoom { size_m: truth.size_m, reflectances: truth.reflectances, sources: vec![source] };
    let solution = cache.solved(&room)?;
    let part = |value: &RoomValue| match light {
        LightPart::Direct => value.direct_lx,
        LightPart::Indirect => value.indirect_lx,
        LightPart::Total => value.total_lx(),
    };
    let (value, discretisation_lx) = match site {
        TruthSite::Average { surface } => (solution.face_mean(face_named(surface.unwrap_or(""))?), 0.0),
        TruthSite::Point { position_m, normal, .. } => (on_face(truth, &solution, *position_m, *normal)?, 0.0),
        TruthSite::Element { corners_m, .. } => {
            let [a, b, c] = *corners_m;
            let mean = solution.triangle_mean(*corners_m).map_err(|error| error.to_string())?;
            let normal = (b - a).cross(c - a).normalize();
            let centre = on_face(truth, &solution, (a + b + c) / 3.0, normal)?;
            let difference_lx = (part(&mean) - part(&centre)).abs();
            (mean, difference_lx)
        }
    };
    let uncertainty_lx = if light == LightPart::Direct { 0.0 } else { value.estimated_error_lx };
    Ok(Exact {
        value: part(&value),
        uncertainty: uncertainty_lx,
        discretisation: discretisation_lx,
        ..Exact::default()
    })
}

fn face_named(surface: &str) -> Result<RoomFace, String> {
    let part = surface.rsplit('/').next().unwrap_or("");
    let index = FACE_NAMES.iter().position(|name| *name == part);
    index.map(|index| RoomFace::ALL[index]).ok_or_else(|| format!("\"{surface}\" is not a face of a room"))
}

fn on_face(
    truth: &RoomTruth,
    solution: &BoxRoomSolution,
    position_m: DVec3,
    normal: DVec3,
) -> Result<RoomValue, String> {
    let lies_on = |face: &&RoomFace| {
        let axis = face.axis();
        let at_m = if face.is_high() { truth.size_m[axis] } else { 0.0 };
        (position_m[axis] - at_m).abs() <= ON_FACE_M && face.normal().dot(normal) > 0.5
    };
    let face = RoomFace::ALL.iter().find(lies_on).ok_or("a point does not lie on a face of the room")?;
    let [u, v] = face.other_axes();
    solution.on_face(*face, position_m[u], position_m[v]).map_err(|error| error.to_string())
}
