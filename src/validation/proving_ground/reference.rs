//! Long runs of walks as the truth of a room. They are stored in files, so that each is computed once.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error_of;
use super::patient::solve_watched;
use super::rooms::Room;
use crate::scene::Scene;
use crate::solver::{MapSelection, Method, Settings};
use crate::validation::error::CaseError;

/// Seed of references, far from the seeds of the runs that they judge.
const SEED: u64 = 1_000_000_007;

/// A long run of walks in one room.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Reference {
    /// Fingerprint of the room's files.
    pub fingerprint: String,
    /// Target error, as a fraction.
    pub target_error: f64,
    /// Limit of processor seconds for the run.
    pub limit_s: f64,
    /// Number of rays traced.
    pub rays: u64,
    /// Processor seconds used.
    pub cpu_s: f64,
    /// One entry per receiver set, in the order of the scene.
    pub maps: Vec<ReferenceMap>,
}

/// Results of the reference for one receiver set.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReferenceMap {
    /// Name of the set.
    pub name: String,
    /// Number of walks for the set.
    pub walks: u64,
    /// Illuminance of every point in lx.
    pub illuminance_lx: Vec<f64>,
    /// Standard error at every point in lx.
    pub standard_error_lx: Vec<f64>,
}

/// A cost in rays and processor seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Number of rays.
    pub rays: f64,
    /// Processor seconds.
    pub cpu_s: f64,
}

/// Required accuracy of references.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceSettings {
    /// Target error, as a fraction.
    pub target_error: f64,
    /// Limit of processor seconds for one reference.
    pub limit_s: f64,
}

impl Reference {
    /// The reference of a room. It is read from `folder` if a sufficiently accurate one is stored there. Otherwise it is computed
    /// and stored.
    ///
    /// # Errors
    ///
    /// A folder or file that cannot be written.
    pub fn of(
        room: &Room,
        scene: &Scene,
        folder: &Path,
        settings: &ReferenceSettings,
        tell: &dyn Fn(&str),
    ) -> Result<Reference, CaseError> {
        let path = folder.join(format!("{}.json", room.name()));
        let fingerprint = fingerprint(room);
        let serves = |kept: &Reference| {
            let is_exact = kept.target_error <= settings.target_error || kept.limit_s >= settings.limit_s;
            kept.fingerprint == fingerprint && is_exact
        };
        if let Some(kept) = read(&path).filter(serves) {
            return Ok(kept);
        }
        tell("reference");
        let reference = Reference::compute(scene, fingerprint, settings);
        write(&path, &reference)?;
        Ok(reference)
    }

    fn compute(scene: &Scene, fingerprint: String, settings: &ReferenceSettings) -> Reference {
        let run = Settings {
            method: Method::Collision,
            seed: SEED,
            target_error: Some(settings.target_error),
            maps: MapSelection::Receivers,
            ..Settings::default()
        };
        let (solution, cpu_s) = solve_watched(scene, &run, settings.limit_s);
        let maps = solution.maps.into_iter().map(|map| ReferenceMap {
            name: map.name,
            walks: map.chains,
            illuminance_lx: map.values.value,
            standard_error_lx: map.values.standard_error,
        });
        Reference {
            fingerprint,
            target_error: settings.target_error,
            limit_s: settings.limit_s,
            rays: solution.rays,
            cpu_s,
            maps: maps.collect(),
        }
    }

    /// Cost of walks to a target: the sum over the sets of their shares of the work, with rays ∝ 1/error². `errors` are the sets'
    /// own errors.
    pub fn cost_to(&self, target_error: f64, errors: &[f64]) -> Cost {
        let walks: u64 = self.maps.iter().map(|map| map.walks).sum();
        let share = |map: &ReferenceMap| map.walks as f64 / walks.max(1) as f64;
        let times = |(map, error): (&ReferenceMap, &f64)| share(map) * (error / target_error).powi(2);
        let factor: f64 = self.maps.iter().zip(errors).map(times).sum();
        Cost { rays: factor * self.rays as f64, cpu_s: factor * self.cpu_s }
    }
}

/// Hash of the contents of a room's files (FNV-1a, 64 bits).
fn fingerprint(room: &Room) -> String {
    let texts = room.files.iter().flat_map(|file| [file.name.as_bytes(), file.text.as_bytes()]);
    let bytes = std::iter::once(room.scene.as_bytes()).chain(texts).flatten();
    let hash =
        bytes.fold(0xCBF2_9CE4_8422_2325u64, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3));
    format!("{hash:016x}")
}

fn read(path: &Path) -> Option<Reference> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

fn write(path: &Path, reference: &Reference) -> Result<(), CaseError> {
    let refuse = |error: std::io::Error| error_of(path, "the reference cannot be kept", &error.to_string());
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    std::fs::create_dir_all(&folder).map_err(refuse)?;
    let text = serde_json::to_string(reference).map_err(|error| refuse(error.into()))?;
    // The file is written completely or not at all, because another run may read it.
    let mut file = tempfile::NamedTempFile::new_in(&folder).map_err(refuse)?;
    std::io::Write::write_all(&mut file, text.as_bytes()).map_err(refuse)?;
    file.persist(path).map_err(|error| refuse(error.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_follow_the_squared_error_of_each_set() {
        let map = |walks| ReferenceMap {
            name: String::new(),
            walks,
            illuminance_lx: Vec::new(),
            standard_error_lx: Vec::new(),
        };
        let reference = Reference {
            fingerprint: String::new(),
            target_error: 0.01,
            limit_s: 1.0,
            rays: 1000,
            cpu_s: 10.0,
            maps: vec![map(300), map(100)],
        };
        // Three quarters of the work have the target error, one quarter has half of it.
        let cost = reference.cost_to(0.01, &[0.01, 0.005]);
        assert!((cost.rays - (750.0 + 250.0 / 4.0)).abs() < 1e-9);
        assert!((cost.cpu_s - (7.5 + 2.5 / 4.0)).abs() < 1e-9);
    }
}
