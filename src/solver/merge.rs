//! Shares of a run made one: sums are added replica by replica, so that everything that is told of a run is told of them alike.
//!
//! Replica r of the merged map is the mean of replica r of all shares, weighed by samples. The replicas stay independent of each other,
//! even and odd stay apart, and their spread is the chance of the whole: a run of as many samples would have come to the same.

use std::time::Instant;

use super::finish::finish;
use super::job::{Context, Engine, Job};
use super::pace::{Pace, TimeLeft};
use super::run::DEFAULT_TARGET_ERROR;
use super::share::{MapOfShare, MapSums, ShareRecord};
use super::spending::{Activity, Spending};
use super::{ConvergenceRow, ErrorParts, Settings, Solution, StopReason};
use crate::chain::Stage;
use crate::control::{Forecast, USUAL_EXPONENT, deviation_of_work, needed_work};
use crate::maps::{CellsError, Measured};
use crate::scene::Scene;

/// What came of a merge.
#[derive(Clone, Debug)]
pub struct Merged {
    /// The result, as of one run.
    pub solution: Solution,
    /// What is missing to the target, if one is set.
    pub more: Option<MoreShares>,
}

/// Shares that are still to join.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoreShares {
    /// None: the target is met.
    None,
    /// About so many of the same size.
    About(Forecast),
    /// No number of them: what is not chance is above the target, or no light has been found.
    NoNumber,
}

/// Merges shares of one run, in the order of their numbers; `load` gives the sums of one of them.
///
/// All must have the same maps with as many entries as the scene has.
///
/// # Errors
///
/// What `load` says.
pub fn merge<E>(
    scene: &Scene,
    settings: &Settings,
    shares: &[ShareRecord],
    mut load: impl FnMut(usize) -> Result<Vec<MapSums>, E>,
) -> Result<Merged, E> {
    let started = Instant::now();
    let stage = Stage::new(scene);
    let build_s = started.elapsed().as_secs_f64();
    let context = Context {
        scene,
        stage: &stage,
        seed: settings.seed,
        method: settings.method,
        target_error: settings.target_error.unwrap_or(DEFAULT_TARGET_ERROR),
        adapt_to: None,
        time_left: &|| TimeLeft::Enough,
        pace: Pace::of_chains(),
    };
    let mut maps: Vec<MergedMap> = first_maps(shares).map(|number| MergedMap::new(&context, shares, number)).collect();
    let (mut convergence, mut spending, mut done) = (Vec::new(), Spending::default(), Done::default());
    let mut judging = std::time::Duration::ZERO;
    for (index, share) in shares.iter().enumerate() {
        let sums = load(index)?;
        for (map, (about, sums)) in maps.iter_mut().zip(share.maps.iter().zip(&sums)) {
            map.add(about, sums);
        }
        let judged = Instant::now();
        maps.iter_mut().for_each(|map| map.job.judge_merged(&context, map.chains));
        judging += judged.elapsed();
        done.add(share);
        spending += share.spending;
        convergence.push(row(&maps, settings.target_error, &done));
    }
    spending.add(Activity::Judging, 0, judging);
    maps.iter_mut().for_each(|map| map.job.settle_merged(settings.target_error));
    let looks = (settings.target_error, shares.len());
    let needed = |target: f64| needed_of_all(&maps, target, looks.1);
    let needed = looks.0.map(needed);
    let told: Vec<(u64, String)> = maps.iter().map(|map| (map.chains, map.methods())).collect();
    let jobs: Vec<Job> = maps.into_iter().map(|map| map.job).collect();
    let stop_reason = if jobs.iter().all(Job::is_exact) { StopReason::Exact } else { StopReason::Shares };
    let compute_s = started.elapsed().as_secs_f64() - build_s;
    let target_error = settings.target_error;
    let mut solution =
        finish(&context, settings, target_error, jobs, convergence, spending, stop_reason, 0.0, build_s, compute_s);
    for (map, (chains, methods)) in solution.maps.iter_mut().zip(told) {
        (map.chains, map.method) = (chains, methods);
        map.method_reason = "that of the shares".to_owned();
    }
    (solution.chains, solution.rays) = (done.chains, done.rays);
    let is_met = solution.target_met == Some(true);
    if is_met && stop_reason == StopReason::Shares {
        solution.stop_reason = StopReason::TargetMet;
    }
    let more = needed.map(|needed| if is_met { MoreShares::None } else { needed });
    Ok(Merged { solution, more })
}

/// Numbers of the maps that shares have.
fn first_maps(shares: &[ShareRecord]) -> std::ops::Range<usize> {
    0..shares.first().map_or(0, |share| share.maps.len())
}

/// What the shares so far have taken.
#[derive(Default)]
struct Done {
    chains: u64,
    rays: u64,
    compute_s: f64,
}

impl Done {
    fn add(&mut self, share: &ShareRecord) {
        self.chains += share.chains;
        self.rays += share.rays;
        self.compute_s += share.compute_s;
    }
}

/// One map in the making.
struct MergedMap {
    job: Job,
    /// Whether all shares sampled it in one way, so that samples are their weight; else rays are.
    is_alike: bool,
    chains: u64,
    /// Names of the estimators, each once.
    methods: Vec<String>,
    /// Flux of all luminaires, by which counts of packets are told in lx.
    luminous_flux_lm: f64,
    cells: CellsOfShares,
}

impl MergedMap {
    fn new(context: &Context, shares: &[ShareRecord], number: usize) -> MergedMap {
        let first = &shares[0].maps[number];
        let is_alike = shares.iter().all(|share| share.maps[number].is_like(first));
        let mut methods: Vec<String> = shares.iter().map(|share| share.maps[number].method.clone()).collect();
        methods.sort();
        methods.dedup();
        let engine =
            Engine::named(is_alike.then_some(first.method.as_str()), context.scene, first.kind, context.method);
        let mut job = Job::to_merge(context, first.kind, first.bound, engine, is_alike && first.counts_packets);
        job.map.cells_error = shares
            .iter()
            .any(|share| share.maps[number].cells_error.is_some())
            .then(|| CellsError { by_site_lx: vec![0.0; first.entries], ..CellsError::default() });
        let cells = CellsOfShares { profile: vec![0.0; first.entries], ..CellsOfShares::default() };
        let luminous_flux_lm = context.stage.emitters.luminous_flux_lm();
        MergedMap { job, is_alike, chains: 0, methods, luminous_flux_lm, cells }
    }

    fn methods(&self) -> String {
        self.methods.join(", ")
    }

    /// Adds the sums of a share, as means times its weight.
    fn add(&mut self, share: &MapOfShare, sums: &MapSums) {
        let weights = match self.is_alike {
            true => [share.direct_samples.complete, share.indirect_samples.complete],
            false => [share.rays.max(1); 2],
        };
        let [direct, indirect] = weights.map(|weight| weight as f64);
        let in_lx = |entry: usize| match share.counts_packets && !self.is_alike {
            true => self.luminous_flux_lm / self.job.weights[entry].max(f64::MIN_POSITIVE),
            false => 1.0,
        };
        // A sweep that a limit ended in its middle leaves some entries one sample more: their means count like the others.
        let of_direct: Vec<f64> =
            (0..share.entries).map(|entry| direct / share.direct_samples.of(entry).max(1) as f64).collect();
        let of_indirect: Vec<f64> = (0..share.entries)
            .map(|entry| in_lx(entry) * indirect / share.indirect_samples.of(entry).max(1) as f64)
            .collect();
        let map = &mut self.job.map;
        add_slabs(&mut map.direct, &sums.direct, &of_direct);
        add_slabs(&mut map.indirect, &sums.indirect, &of_indirect);
        map.direct_samples.complete += weights[0];
        map.indirect_samples.complete += weights[1];
        if self.is_alike {
            for (part, scores) in map.scores.iter_mut().zip(&share.scores) {
                part.merge(scores.clone());
            }
        }
        if let Some(error) = &mut map.cells_error {
            self.cells.add(indirect, share, sums);
            *error = self.cells.error();
        }
        for (all, ends) in self.job.ends.iter_mut().zip(share.ends) {
            *all += ends;
        }
        self.job.rays += share.rays;
        self.chains += share.chains;
    }
}

fn add_slabs(all: &mut [Vec<f64>], slabs: &[Vec<f64>], factors: &[f64]) {
    for (all, slab) in all.iter_mut().zip(slabs) {
        for ((sum, value), factor) in all.iter_mut().zip(slab).zip(factors) {
            *sum += value * factor;
        }
    }
}

/// What walks in shares say of their cells, each of which has cells of its own.
#[derive(Default)]
struct CellsOfShares {
    /// Weight of every share, and what its walks say.
    measured: Vec<(f64, Option<Measured>)>,
    /// Weighted sums of how unsure cells are at every element or point, and of the weights.
    profile: Vec<f64>,
    weight: f64,
}

impl CellsOfShares {
    fn add(&mut self, weight: f64, share: &MapOfShare, sums: &MapSums) {
        self.measured.push((weight, share.cells_error));
        for (all, unsure) in self.profile.iter_mut().zip(&sums.cells_profile) {
            *all += weight * unsure;
        }
        self.weight += if share.cells_error.is_some() { weight } else { 0.0 };
    }

    fn error(&self) -> CellsError {
        let weight = self.weight.max(f64::MIN_POSITIVE);
        let profile: Vec<f64> = self.profile.iter().map(|sum| sum / weight).collect();
        CellsError::of_mean(&self.measured, &profile)
    }
}

/// How the merged maps stand after some of the shares; seconds are those of all of them, one after another.
fn row(maps: &[MergedMap], target_error: Option<f64>, done: &Done) -> ConvergenceRow {
    let bound = || maps.iter().filter(|map| map.job.bound);
    let errors = bound().map(|map| ErrorParts::of(&map.job.judgement));
    let worst = errors.max_by(|one, other| one.estimated.total_cmp(&other.estimated)).unwrap_or_default();
    let times = target_error.map_or(1.0, |target| times_of_all(maps, target).0.max(1.0));
    // Where no amount of work is enough, the present is repeated.
    let times = if times.is_finite() { times } else { 1.0 };
    ConvergenceRow {
        wall_s: done.compute_s,
        rays: done.rays,
        chains: done.chains,
        error: worst,
        judged: true,
        forecast_rays: Forecast::known(times * done.rays as f64),
        forecast_wall_s: Forecast::known(times * done.compute_s),
    }
}

/// How many times the work of all shares so far the target takes, and the standard deviation of that number's logarithm.
fn times_of_all(maps: &[MergedMap], target: f64) -> (f64, f64) {
    let open =
        maps.iter().filter(|map| map.job.bound && !map.job.is_exact() && map.job.weights.iter().any(|w| *w > 0.0));
    let times = open.map(|map| {
        let judgement = &map.job.judgement;
        let times = needed_work(target, judgement, USUAL_EXPONENT);
        (times, deviation_of_work(judgement.degrees_of_freedom, f64::INFINITY, 1.0 / times.max(1.0), USUAL_EXPONENT))
    });
    times.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((0.0, 0.0))
}

/// Shares that are still to join so many: chance falls as the root of their number, what halves have in common does not.
fn needed_of_all(maps: &[MergedMap], target: f64, shares: usize) -> MoreShares {
    let (times, deviation_ln) = times_of_all(maps, target);
    if !times.is_finite() {
        return MoreShares::NoNumber;
    }
    // Where a check or luck alone holds the target up, one more shows what it is worth.
    let count = shares as f64;
    let all = Forecast::spread(times.max(f64::MIN_POSITIVE) * count, deviation_ln);
    let more = |all: f64| (all.ceil() - count).max(1.0);
    MoreShares::About(Forecast { expected: more(all.expected), low: more(all.low), high: more(all.high) })
}
