//! Long runs of walks that stand for the truth of a room, kept in files so that they are made once.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error_of;
use super::patient::solve_watched;
use super::rooms::Room;
use crate::scene::Scene;
use crate::solver::{MapSelection, Method, Settings};
use crate::validation::error::CaseError;

/// Seed of references: far from those of the runs that they judge.
const SEED: u64 = 1_000_000_007;

/// A long run of walks in one room.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Reference {
    /// Fingerprint of the room's files.
    pub fingerprint: String,
    /// Error that was asked for, as a fraction.
    pub target_error: f64,
    /// Processor seconds after which it was to end in any case.
    pub limit_s: f64,
    /// Rays that it took.
    pub rays: u64,
    /// Processor seconds that it took.
    pub cpu_s: f64,
    /// One entry a receiver set, in the order of the scene.
    pub maps: Vec<ReferenceMap>,
}

/// What it says of one receiver set.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReferenceMap {
    /// Name of the set.
    pub name: String,
    /// Walks spent on it.
    pub walks: u64,
    /// Illuminance of every point in lx.
    pub illuminance_lx: Vec<f64>,
    /// Its standard error in lx.
    pub standard_error_lx: Vec<f64>,
}

/// Rays and processor seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Rays.
    pub rays: f64,
    /// Processor seconds.
    pub cpu_s: f64,
}

/// How exact references are to be.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceSettings {
    /// Their error, as a fraction.
    pub target_error: f64,
    /// Processor seconds that one may take.
    pub limit_s: f64,
}

impl Reference {
    /// The reference of a room: read from `folder` where one stands there that is as exact as asked, else computed and kept there.
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
            illuminance_lx: map.values.illuminance_lx,
            standard_error_lx: map.values.standard_error_lx,
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

    /// What walks take to a target: of every set its share of the work, by rays ∝ 1/error². `errors` are the sets' own.
    pub fn cost_to(&self, target_error: f64, errors: &[f64]) -> Cost {
        let walks: u64 = self.maps.iter().map(|map| map.walks).sum();
        let share = |map: &ReferenceMap| map.walks as f64 / walks.max(1) as f64;
        let times = |(map, error): (&ReferenceMap, &f64)| share(map) * (error / target_error).powi(2);
        let factor: f64 = self.maps.iter().zip(errors).map(times).sum();
        Cost { rays: factor * self.rays as f64, cpu_s: factor * self.cpu_s }
    }
}

/// Hash of everything that a room's files say (FNV-1a, 64 bits).
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
    // Whole or not at all: another run may look for it.
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
        // Three quarters of the work at the target, one quarter at half of it.
        let cost = reference.cost_to(0.01, &[0.01, 0.005]);
        assert!((cost.rays - (750.0 + 250.0 / 4.0)).abs() < 1e-9);
        assert!((cost.cpu_s - (7.5 + 2.5 / 4.0)).abs() < 1e-9);
    }
}
