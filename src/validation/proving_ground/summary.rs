//! Statistics over many runs: shares, means, and worst values.

use super::campaign::{MapProof, Proof, RoomProof, RunProof};
use super::reference::Cost;
use crate::solver::StopReason;
use crate::validation::forecasts::JudgedForecast;

/// A map is judged by its target if the reference's own error is at most this share of the target.
const EXACT_ENOUGH: f64 = 0.6;

/// Forecasts of runs that take fewer seconds are not judged, since they would be of no use.
const LEAST_SECONDS_FORECAST: f64 = 1.0;

/// Sums over the runs of some rooms to one target, or to all targets.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    /// Number of maps that reported "target met" and for which the reference is accurate enough to judge.
    pub said_met: usize,
    /// Number of these whose true error is at most the target.
    pub truly_met: usize,
    /// Number of maps that did not reach their target.
    pub missed: usize,
    /// Number of maps that reported "target met" but for which the reference is not accurate enough to judge.
    pub unjudged: usize,
    /// Largest true error over the target among the judged maps that reported "target met".
    pub worst: f64,
    /// Name of that map.
    pub worst_name: String,
    /// Number of error bars of maps for which the reference is accurate enough.
    pub bars: usize,
    /// Number of error bars that hold.
    pub held: usize,
    /// Share of error bars that hold, for each run.
    pub shares: Vec<f64>,
    true_squares: f64,
    stated_squares: f64,
    maps: usize,
}

impl Sums {
    /// Adds the maps of a run for which `wanted` is true.
    pub fn add(&mut self, room: &RoomProof, run: &RunProof, wanted: impl Fn(&MapProof) -> bool) {
        let (mut bars, mut held) = (0, 0);
        for map in run.maps.iter().filter(|map| wanted(map)) {
            let judgement = &map.judgement;
            let is_exact_enough = judgement.reference_error <= EXACT_ENOUGH * run.target_error;
            if is_exact_enough {
                bars += judgement.bars;
                held += judgement.held;
            }
            self.maps += 1;
            self.true_squares += (judgement.true_error / run.target_error).powi(2);
            self.stated_squares += (map.stated_error / run.target_error).powi(2);
            let ratio = judgement.true_error / run.target_error;
            match (map.said_met, is_exact_enough) {
                (false, _) => self.missed += 1,
                (true, false) => self.unjudged += 1,
                (true, true) => {
                    self.said_met += 1;
                    self.truly_met += usize::from(ratio <= 1.0);
                    if ratio > self.worst {
                        self.worst = ratio;
                        self.worst_name = format!("{}, {}, seed {}", room.name(), map.name, run.seed);
                    }
                }
            }
        }
        self.bars += bars;
        self.held += held;
        if bars > 0 {
            self.shares.push(held as f64 / bars as f64);
        }
    }

    /// Share of the error bars that hold.
    pub fn coverage(&self) -> f64 {
        self.held as f64 / self.bars.max(1) as f64
    }

    /// Ratio of the root mean squares of true error and stated error, each over the target.
    pub fn true_over_stated(&self) -> f64 {
        (self.true_squares / self.stated_squares.max(f64::MIN_POSITIVE)).sqrt()
    }

    /// Root mean square of the true error over the target.
    pub fn true_over_target(&self) -> f64 {
        (self.true_squares / self.maps.max(1) as f64).sqrt()
    }

    /// Root mean square of the stated error over the target.
    pub fn stated_over_target(&self) -> f64 {
        (self.stated_squares / self.maps.max(1) as f64).sqrt()
    }
}

/// Group of rooms that a row describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// All rooms.
    All,
    /// Rooms on which methods may be tuned.
    Tuned,
    /// Rooms that serve only for judging.
    Untuned,
}

impl Group {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Group::All => "all",
            Group::Tuned => "tuned on",
            Group::Untuned => "not tuned on",
        }
    }

    fn holds(self, room: &RoomProof) -> bool {
        match self {
            Group::All => true,
            Group::Tuned => room.is_for_tuning(),
            Group::Untuned => !room.is_for_tuning(),
        }
    }
}

impl Proof {
    /// The rooms of a group.
    pub fn rooms_of(&self, group: Group) -> impl Iterator<Item = &RoomProof> {
        self.rooms.iter().filter(move |room| group.holds(room))
    }

    /// Sums over a group of rooms, to one target or to all targets.
    pub fn sums(&self, group: Group, target_error: Option<f64>) -> Sums {
        let mut sums = Sums::default();
        for room in self.rooms_of(group) {
            room.runs_to(target_error).for_each(|run| sums.add(room, run, |_| true));
        }
        sums
    }

    /// The forecasts of those runs of a group that met their target and took long enough, in order for each run.
    pub fn forecasts(&self, group: Group) -> impl Iterator<Item = &[JudgedForecast]> {
        let is_judged = |run: &&RunProof| {
            run.stop_reason == StopReason::TargetMet.name() && run.cost.cpu_s >= LEAST_SECONDS_FORECAST
        };
        self.rooms_of(group).flat_map(|room| &room.runs).filter(is_judged).map(|run| run.forecasts.as_slice())
    }

    /// Sums over all maps with this name.
    pub fn sums_of_region(&self, region: &str, target_error: Option<f64>) -> Sums {
        let mut sums = Sums::default();
        for room in &self.rooms {
            room.runs_to(target_error).for_each(|run| sums.add(room, run, |map| map.name == region));
        }
        sums
    }

    /// Names of receiver sets, in order of first appearance.
    pub fn regions(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for map in self.rooms.iter().flat_map(|room| &room.runs).flat_map(|run| &run.maps) {
            if !names.contains(&map.name.as_str()) {
                names.push(&map.name);
            }
        }
        names
    }
}

impl RoomProof {
    /// Runs to one target, or all runs.
    pub fn runs_to(&self, target_error: Option<f64>) -> impl Iterator<Item = &RunProof> {
        self.runs.iter().filter(move |run| target_error.is_none_or(|target| run.target_error == target))
    }

    /// Sums over its runs, to one target or to all targets.
    pub fn sums(&self, target_error: Option<f64>) -> Sums {
        let mut sums = Sums::default();
        self.runs_to(target_error).for_each(|run| sums.add(self, run, |_| true));
        sums
    }

    /// Mean cost of its runs to a target.
    pub fn cost(&self, target_error: f64) -> Cost {
        let count = self.runs_to(Some(target_error)).count().max(1) as f64;
        let mean =
            |of: fn(&Cost) -> f64| self.runs_to(Some(target_error)).map(|run| of(&run.cost)).sum::<f64>() / count;
        Cost { rays: mean(|cost| cost.rays), cpu_s: mean(|cost| cost.cpu_s) }
    }

    /// Seconds of walks and of the rival to a target, over those of `auto`. The target is given by its index and as an error.
    /// `None` unless every run met it.
    pub fn ratios(&self, target: usize, target_error: f64) -> [Option<f64>; 2] {
        let auto_s = self.cost(target_error).cpu_s;
        let counts = self.always_met(target_error) && auto_s > 0.0;
        let ratio = |cpu_s: f64| (counts && cpu_s > 0.0).then_some(cpu_s / auto_s);
        let rival = self.rival.as_ref().ok().and_then(|costs| ratio(costs[target].cpu_s));
        [ratio(self.walks[target].cpu_s), rival]
    }

    /// Returns whether every map of every run to a target met it. Otherwise the cost is not comparable.
    pub fn always_met(&self, target_error: f64) -> bool {
        self.runs_to(Some(target_error)).all(|run| run.maps.iter().all(|map| map.said_met))
    }
}

/// Geometric mean and smallest of the ratios; `None` if there are none.
pub fn mean_and_worst(ratios: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let ratios: Vec<f64> = ratios.filter(|ratio| ratio.is_finite() && *ratio > 0.0).collect();
    if ratios.is_empty() {
        return None;
    }
    let mean = (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp();
    Some((mean, ratios.into_iter().fold(f64::INFINITY, f64::min)))
}
