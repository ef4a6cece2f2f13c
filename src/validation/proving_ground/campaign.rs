//! Runs `auto` in every room, to every target and with many seeds.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::judgement::{JudgedEntry, RoomJudgement, judge};
use super::patient::solve_watched;
use super::reference::{Cost, Reference, ReferenceSettings};
use super::rival::{Rival, RivalRun, run_rival};
use super::rooms::{Kind, Room};
use super::scene_of;
use crate::maps::{MapKind, MapResult};
use crate::scene::Scene;
use crate::solver::{MapSelection, Method, Settings, Solution};
use crate::validation::error::CaseError;
use crate::validation::forecasts::{JudgedForecast, judged_forecasts};

/// Settings of a proof.
#[derive(Clone)]
pub struct ProofSettings {
    /// Kinds of rooms.
    pub kinds: Vec<&'static Kind>,
    /// Seeds of the rooms of each kind.
    pub rooms: Range<u64>,
    /// Number of runs of each room and target, with seeds from 0.
    pub seeds: u64,
    /// Targets, as fractions.
    pub targets: Vec<f64>,
    /// Accuracy of the references.
    pub reference: ReferenceSettings,
    /// Folder in which references are stored.
    pub references: PathBuf,
    /// The rival, if there is one.
    pub rival: Option<Rival>,
    /// Processor seconds after which a run is stopped.
    pub patience_s: f64,
    /// Number of rooms computed at the same time, each on one thread.
    pub threads: usize,
}

/// All results of a proof.
#[derive(Clone, Debug, Default)]
pub struct Proof {
    /// Rooms by kind, then by seed.
    pub rooms: Vec<RoomProof>,
}

/// Results of a room.
#[derive(Clone, Debug)]
pub struct RoomProof {
    /// Name of the kind.
    pub kind: &'static str,
    /// Seed of the room.
    pub seed: u64,
    /// Number of triangles of the scene.
    pub triangles: usize,
    /// Number of its luminaires.
    pub luminaires: usize,
    /// Cost of the reference.
    pub reference: Cost,
    /// Cost of walks to each target.
    pub walks: Vec<Cost>,
    /// Cost of the rival to each target, or the reason why it does not run here.
    pub rival: Result<Vec<Cost>, String>,
    /// Runs, target by target.
    pub runs: Vec<RunProof>,
}

/// A run of `auto`.
#[derive(Clone, Debug)]
pub struct RunProof {
    /// Target as a fraction.
    pub target_error: f64,
    /// Seed of the run.
    pub seed: u64,
    /// Cost of the run.
    pub cost: Cost,
    /// Reason of the end.
    pub stop_reason: &'static str,
    /// One entry per receiver set with light.
    pub maps: Vec<MapProof>,
    /// Forecasts of its end, in order.
    pub forecasts: Vec<JudgedForecast>,
}

/// A map of a run compared with the reference.
#[derive(Clone, Debug)]
pub struct MapProof {
    /// Name of the receiver set.
    pub name: String,
    /// Estimator of the map.
    pub estimator: String,
    /// Whether it reported "target met".
    pub said_met: bool,
    /// Stated error.
    pub stated_error: f64,
    /// Comparison with the reference.
    pub judgement: RoomJudgement,
}

impl RoomProof {
    /// Name of the room.
    pub fn name(&self) -> String {
        format!("{}-{}", self.kind, self.seed)
    }

    /// Returns whether methods may be tuned on the room: rooms with even seeds. Rooms with odd seeds serve only for judging.
    pub fn is_for_tuning(&self) -> bool {
        self.seed.is_multiple_of(2)
    }
}

/// Runs the whole proof. `tell` receives a message for every room and run that begins.
///
/// # Errors
///
/// A room that cannot be read, or a reference that cannot be stored.
pub fn prove(settings: &ProofSettings, tell: &(dyn Fn(&str) + Sync)) -> Result<Proof, CaseError> {
    let wanted: Vec<(&'static Kind, u64)> =
        settings.kinds.iter().flat_map(|kind| settings.rooms.clone().map(|seed| (*kind, seed))).collect();
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, Result<RoomProof, CaseError>)>> = Mutex::new(Vec::new());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some((kind, seed)) = wanted.get(index) else { return };
            let room = kind.room(*seed);
            let tell_of = |what: &str| tell(&format!("{}/{} {}: {what}", index + 1, wanted.len(), room.name()));
            let proof = prove_room(&room, settings, &tell_of);
            done.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push((index, proof));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..settings.threads.max(1) {
            scope.spawn(work);
        }
    });
    let mut done = done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    done.sort_by_key(|(index, _)| *index);
    let rooms = done.into_iter().map(|(_, proof)| proof).collect::<Result<_, _>>()?;
    Ok(Proof { rooms })
}

fn prove_room(room: &Room, settings: &ProofSettings, tell: &dyn Fn(&str)) -> Result<RoomProof, CaseError> {
    let scene = scene_of(room)?;
    let reference = Reference::of(room, &scene, &settings.references, &settings.reference, tell)?;
    let own_errors: Vec<f64> = (0..scene.receivers.len()).map(|set| own_error(&scene, &reference, set)).collect();
    let walks = settings.targets.iter().map(|target| reference.cost_to(*target, &own_errors)).collect();
    let rival = match &settings.rival {
        None => Err("no rival was named".to_owned()),
        Some(rival) => {
            tell("rival");
            let run = run_rival(rival, &scene, &reference);
            run.map(|run: RivalRun| settings.targets.iter().map(|target| run.cost_to(*target)).collect())
        }
    };
    let mut runs = Vec::new();
    for target_error in &settings.targets {
        tell(&format!("auto to {}", crate::validation::words::percent(*target_error)));
        for seed in 0..settings.seeds {
            runs.push(run_once(&scene, &reference, *target_error, seed, settings.patience_s));
        }
    }
    Ok(RoomProof {
        kind: room.kind,
        seed: room.seed,
        triangles: scene.triangles.len(),
        luminaires: scene.luminaires.len(),
        reference: Cost { rays: reference.rays as f64, cpu_s: reference.cpu_s },
        walks,
        rival,
        runs,
    })
}

fn run_once(scene: &Scene, reference: &Reference, target_error: f64, seed: u64, patience_s: f64) -> RunProof {
    let run = Settings {
        method: Method::Auto,
        seed,
        target_error: Some(target_error),
        maps: MapSelection::Receivers,
        ..Settings::default()
    };
    let (solution, cpu_s) = solve_watched(scene, &run, patience_s);
    let maps = solution.maps.iter().filter_map(|map| {
        let judgement = judge_map(scene, reference, map, &solution)?;
        Some(MapProof {
            name: map.name.clone(),
            estimator: map.method.clone(),
            said_met: map.target_met == Some(true),
            stated_error: map.error.estimated,
            judgement,
        })
    });
    RunProof {
        target_error,
        seed,
        maps: maps.collect(),
        cost: Cost { rays: solution.rays as f64, cpu_s },
        stop_reason: solution.stop_reason.name(),
        forecasts: judged_forecasts(&solution.convergence),
    }
}

fn judge_map(scene: &Scene, reference: &Reference, map: &MapResult, solution: &Solution) -> Option<RoomJudgement> {
    let MapKind::Receivers(set) = map.kind else { return None };
    let truth = &reference.maps[set];
    let points = &scene.receivers[set].points;
    let entry = |index: usize| JudgedEntry {
        value_lx: map.values.value[index],
        standard_error_lx: map.values.standard_error[index],
        reference_lx: truth.illuminance_lx[index],
        reference_error_lx: truth.standard_error_lx[index],
        weight: if points[index].inside { 0.0 } else { points[index].weight },
    };
    let entries: Vec<JudgedEntry> = (0..points.len()).map(entry).collect();
    judge(&entries, solution.replicas.saturating_sub(1) as f64)
}

/// The reference's own error of a set; 0 if it found no light.
fn own_error(scene: &Scene, reference: &Reference, set: usize) -> f64 {
    let truth = &reference.maps[set];
    let points = &scene.receivers[set].points;
    let entry = |index: usize| JudgedEntry {
        value_lx: truth.illuminance_lx[index],
        reference_lx: truth.illuminance_lx[index],
        reference_error_lx: truth.standard_error_lx[index],
        weight: if points[index].inside { 0.0 } else { points[index].weight },
        ..JudgedEntry::default()
    };
    let entries: Vec<JudgedEntry> = (0..points.len()).map(entry).collect();
    judge(&entries, 1.0).map_or(0.0, |judgement| judgement.reference_error)
}
