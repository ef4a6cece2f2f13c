//! Runs a rival program in the same room, on the same receivers, and compares it with the same reference.

use std::path::PathBuf;
use std::process::Command;

use super::judgement::{JudgedEntry, judge};
use super::reference::{Cost, Reference};
use super::rival_scene::rival_scene;
use crate::scene::Scene;

/// Seed of the rival's random numbers.
const SEED: u32 = 1;

/// The rival program and its settings.
#[derive(Clone, Debug)]
pub struct Rival {
    /// Path of the program.
    pub program: PathBuf,
    /// Number of paths that it traces from each receiver.
    pub paths: u32,
}

/// Result of a run of the rival.
#[derive(Clone, Debug)]
pub struct RivalRun {
    /// Rays and processor seconds.
    pub cost: Cost,
    /// Number of points and true error of every receiver set with light.
    pub sets: Vec<(usize, f64)>,
}

impl RivalRun {
    /// Cost to a target: the sum over the sets of their shares of the work, with cost ∝ 1/error². It uses the true error, which a
    /// user does not know.
    pub fn cost_to(&self, target_error: f64) -> Cost {
        let points: usize = self.sets.iter().map(|(points, _)| points).sum();
        let times = |(set, error): &(usize, f64)| *set as f64 / points.max(1) as f64 * (error / target_error).powi(2);
        let factor: f64 = self.sets.iter().map(times).sum();
        Cost { rays: factor * self.cost.rays, cpu_s: factor * self.cost.cpu_s }
    }
}

/// Runs the rival in a room.
///
/// # Errors
///
/// A room that the rival cannot represent, or a program that does not run; described in words.
pub fn run_rival(rival: &Rival, scene: &Scene, reference: &Reference) -> Result<RivalRun, String> {
    let program = &rival.program;
    let bytes = rival_scene(scene)?;
    let words = |error: std::io::Error| format!("{}: {error}", program.display());
    let folder = tempfile::tempdir().map_err(words)?;
    let [input, output] = ["scene.bin", "out.bin"].map(|name| folder.path().join(name));
    std::fs::write(&input, bytes).map_err(words)?;
    // One thread, all paths in one batch, and fast instead of watertight rays, as in the rival's own script.
    let numbers = [1, rival.paths, 1, SEED, 0].map(|number| number.to_string());
    let ran = Command::new(program).arg("pt").args([&input, &output]).args(numbers).output().map_err(words)?;
    let printed = String::from_utf8_lossy(&ran.stdout);
    if !ran.status.success() {
        return Err(format!("{}: {}", program.display(), String::from_utf8_lossy(&ran.stderr).trim()));
    }
    let printed: Vec<&str> = printed.split_whitespace().collect();
    let number = |name: &str| {
        let at = printed.iter().position(|word| *word == name);
        let number = at.and_then(|at| printed.get(at + 1)).and_then(|word| word.parse::<f64>().ok());
        number.ok_or_else(|| format!("{}: its output has no {name}", program.display()))
    };
    let cost = Cost { rays: number("rays")?, cpu_s: number("cpu_s")? };
    let values = std::fs::read(&output).map_err(words)?;
    let values_lx: Vec<f64> =
        values.chunks_exact(16).map(|pair| f64::from_le_bytes(std::array::from_fn(|byte| pair[byte]))).collect();
    Ok(RivalRun { cost, sets: sets(scene, reference, &values_lx) })
}

fn sets(scene: &Scene, reference: &Reference, values_lx: &[f64]) -> Vec<(usize, f64)> {
    let mut first = 0;
    let mut sets = Vec::new();
    for (set, map) in scene.receivers.iter().zip(&reference.maps) {
        let entry = |(index, point): (usize, &crate::scene::ReceiverPoint)| JudgedEntry {
            value_lx: values_lx.get(first + index).copied().unwrap_or(0.0),
            reference_lx: map.illuminance_lx[index],
            reference_error_lx: map.standard_error_lx[index],
            weight: if point.inside { 0.0 } else { point.weight },
            ..JudgedEntry::default()
        };
        let entries: Vec<JudgedEntry> = set.points.iter().enumerate().map(entry).collect();
        sets.extend(judge(&entries, 1.0).map(|judgement| (entries.len(), judgement.true_error)));
        first += entries.len();
    }
    sets
}
