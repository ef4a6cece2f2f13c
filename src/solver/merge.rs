//! Merges shares of a run, and parts of its receivers, into one result. Sums are added replica by replica, so that merged results report
//! everything that a single run does.
//! Replica r of the merged map is the mean of replica r of all shares, weighted by samples. The replicas stay independent of each other,
//! and even and odd ones stay separate. Their spread is the random error of the whole: a run with as many samples would have the same
//! error.
//! Parts of the receivers stand side by side. Each entry has the replicas of its part, scaled to the mean number of samples of the parts.
//! The map is judged as a whole.

use std::ops::Range;
use std::time::Instant;

use super::context::Context;
use super::finish::{Ending, finish};
use super::job::{Engine, Job};
use super::pace::{Pace, TimeLeft};
use super::portion::{MapOfShare, MapSums};
use super::share::ShareRecord;
use super::spending::{Activity, Spending};
use super::{ConvergenceRow, DEFAULT_TARGET_ERROR, ErrorParts, Settings, Solution, StopReason};
use crate::control::{EXPONENT_OF_INDEPENDENT_SAMPLES, Forecast, deviation_of_work, needed_work};
use crate::maps::{CellsError, MapKind, MeasuredPart};
use crate::scene::{ReceiversPart, Scene};
use crate::transport::World;

/// The result of a merge.
#[derive(Clone, Debug)]
pub struct Merged {
    /// The result, as of one run.
    pub solution: Solution,
    /// What is missing to the target, if one is set.
    pub more: Option<MoreShares>,
}

/// Shares that must still join.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoreShares {
    /// None: the target is met.
    None,
    /// About this many of the same size.
    About(Forecast),
    /// No number of shares is enough: the error that is not random is above the target, or no light has been found.
    NoNumber,
}

/// Merges shares of one run, in the order of their numbers. The parts of the receivers of each share are also in order. `load` gives the
/// sums of one record.
/// All must have the same maps with as many entries as the scene has, or as their part of it has.
/// # Errors
/// Errors of `load`.
pub fn merge<E>(
    scene: &Scene,
    settings: &Settings,
    shares: &[ShareRecord],
    mut load: impl FnMut(usize) -> Result<Vec<MapSums>, E>,
) -> Result<Merged, E> {
    let started = Instant::now();
    let world = World::new(scene);
    let build_s = started.elapsed().as_secs_f64();
    let context = Context {
        scene,
        world: &world,
        seed: settings.seed,
        method: settings.method,
        target_error: settings.target_error.unwrap_or(DEFAULT_TARGET_ERROR),
        to_target: false,
        adapt_to: None,
        time_left: &|| TimeLeft::Enough,
        pace: Pace::of_chains(),
    };
    let mut maps: Vec<MergedMap> =
        maps_of(shares).into_iter().map(|kind| MergedMap::new(&context, shares, kind)).collect();
    let whole_shares = whole_shares(shares);
    let (mut convergence, mut spending, mut done) = (Vec::new(), Spending::default(), Done::default());
    let mut judging = std::time::Duration::ZERO;
    for parts in &whole_shares {
        maps.iter_mut().for_each(|map| map.begin(&shares[parts.clone()]));
        for index in parts.clone() {
            let (share, sums) = (&shares[index], load(index)?);
            for (about, sums) in share.maps.iter().zip(&sums) {
                let map = maps.iter_mut().find(|map| map.job.kind == about.kind);
                map.into_iter().for_each(|map| map.add(share.part, about, sums));
            }
            done.add(share);
            spending += share.spending;
        }
        maps.iter_mut().for_each(MergedMap::end);
        let judged = Instant::now();
        maps.iter_mut().for_each(|map| map.job.judge_merged(&context, map.chains));
        judging += judged.elapsed();
        convergence.push(row(&maps, settings.target_error, &done));
    }
    spending.add(Activity::Judging, 0, judging);
    maps.iter_mut().for_each(|map| map.job.settle_merged(settings.target_error));
    let needed = settings.target_error.map(|target| needed_of_all(&maps, target, whole_shares.len()));
    let of_maps: Vec<(u64, String)> = maps.iter().map(|map| (map.chains, map.methods())).collect();
    let mut jobs: Vec<Job> = maps.into_iter().map(|map| map.job).collect();
    let stop_reason = if jobs.iter().all(Job::is_exact) { StopReason::Exact } else { StopReason::Shares };
    let compute_s = started.elapsed().as_secs_f64() - build_s;
    let (target_error, begun_wall_s) = (settings.target_error, 0.0);
    let ending = Ending { target_error, convergence, spending, stop_reason, begun_wall_s, build_s, compute_s };
    let mut solution = finish(&context, settings, &mut jobs, ending);
    for (map, (chains, methods)) in solution.maps.iter_mut().zip(of_maps) {
        (map.chains, map.method) = (chains, methods);
        map.method_reason = "the method of the shares".to_owned();
    }
    (solution.chains, solution.rays) = (done.chains, done.rays);
    let is_met = solution.target_met == Some(true);
    if is_met && stop_reason == StopReason::Shares {
        solution.stop_reason = StopReason::TargetMet;
    }
    let more = needed.map(|needed| if is_met { MoreShares::None } else { needed });
    Ok(Merged { solution, more })
}

/// The maps of the shares: elements first, then receivers in file order.
fn maps_of(shares: &[ShareRecord]) -> Vec<MapKind> {
    let mut kinds: Vec<MapKind> = shares.iter().flat_map(|share| &share.maps).map(|map| map.kind).collect();
    kinds.sort_by_key(|kind| match kind {
        MapKind::Elements => 0,
        MapKind::Receivers(set) => 1 + set,
    });
    kinds.dedup();
    kinds
}

/// Ranges of records that make one whole share each: a share's parts of the receivers follow each other.
fn whole_shares(shares: &[ShareRecord]) -> Vec<Range<usize>> {
    let starts: Vec<usize> = (0..shares.len()).filter(|index| shares[*index].part.number == 1).collect();
    let ends = starts.iter().skip(1).copied().chain([shares.len()]);
    starts.iter().copied().zip(ends).map(|(start, end)| start..end).collect()
}

/// Work of the shares so far.
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

/// One map in progress.
struct MergedMap {
    job: Job,
    /// Whether all shares sampled it in the same way. Then samples are their weight, otherwise rays.
    is_alike: bool,
    chains: u64,
    /// Names of the estimators, each once.
    methods: Vec<String>,
    /// Flux of all luminaires, which converts counts of packets to lx.
    luminous_flux_lm: f64,
    cells: CellsOfShares,
    /// Weights of direct and of indirect light of the present share, the same for all its parts.
    weights: [u64; 2],
}

impl MergedMap {
    fn new(context: &Context, shares: &[ShareRecord], kind: MapKind) -> MergedMap {
        let all: Vec<&MapOfShare> = shares.iter().filter_map(|share| share.map(kind)).collect();
        let first = all[0];
        let is_alike = all.iter().all(|map| map.is_like(first));
        let mut methods: Vec<String> = all.iter().map(|map| map.method.clone()).collect();
        methods.sort();
        methods.dedup();
        let engine =
            Engine::named(is_alike.then_some(first.method.as_str()), context.scene, first.kind, context.method);
        let mut job = Job::to_merge(context, first.kind, first.bound, engine, is_alike && first.counts_packets);
        let entries = job.map.len();
        let gathers = all.iter().any(|map| map.cells_error.is_some());
        job.map.cells_error = gathers.then(|| CellsError { by_site: vec![0.0; entries], ..CellsError::default() });
        let cells = CellsOfShares {
            profile: vec![0.0; if gathers { entries } else { 0 }],
            weights: vec![0.0; if gathers { entries } else { 0 }],
            measured: Vec::new(),
        };
        let luminous_flux_lm = context.world.emitters.luminous_flux_lm();
        MergedMap { job, is_alike, chains: 0, methods, luminous_flux_lm, cells, weights: [0; 2] }
    }

    fn methods(&self) -> String {
        self.methods.join(", ")
    }

    /// Begins with a share that has these parts. Its weight is the mean number of their samples.
    fn begin(&mut self, parts: &[ShareRecord]) {
        let maps: Vec<&MapOfShare> = parts.iter().filter_map(|part| part.map(self.job.kind)).collect();
        let mean = |of: fn(&MapOfShare) -> u64| {
            let sum: u64 = maps.iter().map(|map| of(map)).sum();
            sum / (maps.len() as u64).max(1)
        };
        self.weights = match self.is_alike {
            true => [mean(|map| map.direct_samples.complete), mean(|map| map.indirect_samples.complete)],
            false => [mean(|map| map.rays).max(1); 2],
        };
    }

    /// Adds the sums of a share, or of a part of it, as means times its weight: docs/methods.md (46).
    fn add(&mut self, part: ReceiversPart, share: &MapOfShare, sums: &MapSums) {
        let [direct, indirect] = self.weights.map(|weight| weight as f64);
        let places = self.places(part, share.entries);
        let in_unit_of_map = |entry: usize| match share.counts_packets && !self.is_alike {
            true => self.luminous_flux_lm / self.job.weights[places.of(entry)].max(f64::MIN_POSITIVE),
            false => 1.0,
        };
        // A pass that a limit ended midway leaves some entries with one sample more. Their means count like the others.
        let of_direct: Vec<f64> =
            (0..share.entries).map(|entry| direct / share.direct_samples.of(entry).max(1) as f64).collect();
        let of_indirect: Vec<f64> = (0..share.entries)
            .map(|entry| in_unit_of_map(entry) * indirect / share.indirect_samples.of(entry).max(1) as f64)
            .collect();
        let map = &mut self.job.map;
        add_slabs(&mut map.direct, &sums.direct, &of_direct, places);
        add_slabs(&mut map.indirect, &sums.indirect, &of_indirect, places);
        if self.is_alike {
            // Deviations are compared with the samples of the whole.
            let samples = [share.direct_samples, share.indirect_samples].map(|tally| tally.complete.max(1) as f64);
            let factors = [direct / samples[0], indirect / samples[1]];
            for ((all, scores), factor) in map.scores.iter_mut().zip(&share.scores).zip(factors) {
                all.merge(if part == ReceiversPart::WHOLE { scores.clone() } else { scores.clone().scaled(factor) });
            }
        }
        if map.cells_error.is_some() {
            let area =
                |entries: &mut dyn Iterator<Item = usize>| entries.map(|entry| self.job.weights[entry]).sum::<f64>();
            let of_part = area(&mut (0..share.entries).map(|entry| places.of(entry)));
            let of_all = area(&mut (0..self.job.weights.len()));
            let area_share = if of_all > 0.0 { of_part / of_all } else { 1.0 };
            self.cells.add(indirect, area_share, share, sums, places);
        }
        for (all, ends) in self.job.ends.iter_mut().zip(share.ends) {
            *all += ends;
        }
        self.job.work.rays += share.rays;
        self.chains += share.chains;
    }

    /// Ends with a share after all its parts have been added.
    fn end(&mut self) {
        let map = &mut self.job.map;
        map.direct_samples.complete += self.weights[0];
        map.indirect_samples.complete += self.weights[1];
        if let Some(error) = &mut map.cells_error {
            *error = self.cells.error(&self.job.weights);
        }
    }

    /// Positions of the entries of a part.
    fn places(&self, part: ReceiversPart, entries: usize) -> PlacesOfPart {
        let is_whole = entries == self.job.map.len();
        PlacesOfPart(if is_whole { ReceiversPart::WHOLE } else { part })
    }
}

/// Positions of the entries of a part in a map of all of them.
#[derive(Clone, Copy)]
struct PlacesOfPart(ReceiversPart);

impl PlacesOfPart {
    fn of(self, entry: usize) -> usize {
        self.0.nth(entry)
    }
}

fn add_slabs(all: &mut [Vec<f64>], slabs: &[Vec<f64>], factors: &[f64], places: PlacesOfPart) {
    for (all, slab) in all.iter_mut().zip(slabs) {
        for (entry, (value, factor)) in slab.iter().zip(factors).enumerate() {
            all[places.of(entry)] += value * factor;
        }
    }
}

/// Findings of walks in shares on their cells. Each share has cells of its own.
struct CellsOfShares {
    /// Every share, or part of one, and the findings of its walks.
    measured: Vec<MeasuredPart>,
    /// At every element or point, weighted sums of the uncertainty of cells, and of the weights.
    profile: Vec<f64>,
    weights: Vec<f64>,
}

impl CellsOfShares {
    fn add(&mut self, weight: f64, area_share: f64, share: &MapOfShare, sums: &MapSums, places: PlacesOfPart) {
        self.measured.push(MeasuredPart { weight, area_share, measured: share.cells_error });
        for (entry, unsure) in sums.cells_profile.iter().enumerate() {
            self.profile[places.of(entry)] += weight * unsure;
            self.weights[places.of(entry)] += weight;
        }
    }

    /// The remaining error of the cells. `areas` are the weights of the entries in the map.
    fn error(&self, areas: &[f64]) -> CellsError {
        let all: f64 = areas.iter().sum();
        let of_gathering: f64 =
            areas.iter().zip(&self.weights).filter(|(_, weight)| **weight > 0.0).map(|(area, _)| area).sum();
        // If some parts gather and others do not, those that do have all the error.
        let spread = if of_gathering > 0.0 { (all / of_gathering).sqrt() } else { 1.0 };
        let unsure = |(sum, weight): (&f64, &f64)| spread * sum / weight.max(f64::MIN_POSITIVE);
        let profile: Vec<f64> = self.profile.iter().zip(&self.weights).map(unsure).collect();
        CellsError::of_mean(&self.measured, &profile)
    }
}

/// The state of the merged maps after some of the shares. Seconds are those of all of them, one after another.
fn row(maps: &[MergedMap], target_error: Option<f64>, done: &Done) -> ConvergenceRow {
    let bound = || maps.iter().filter(|map| map.job.bound);
    let errors = bound().map(|map| ErrorParts::of(&map.job.judgement));
    let worst = errors.max_by(|one, other| one.estimated.total_cmp(&other.estimated)).unwrap_or_default();
    let times = target_error.map_or(1.0, |target| times_of_all(maps, target).0.max(1.0));
    // If no amount of work is enough, the forecast repeats the present state.
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

/// Ratio of the work to the target to the work of all shares so far, and the standard deviation of its logarithm.
fn times_of_all(maps: &[MergedMap], target: f64) -> (f64, f64) {
    let open =
        maps.iter().filter(|map| map.job.bound && !map.job.is_exact() && map.job.weights.iter().any(|w| *w > 0.0));
    let times = open.map(|map| {
        let judgement = &map.job.judgement;
        let times = needed_work(target, judgement, EXPONENT_OF_INDEPENDENT_SAMPLES);
        (
            times,
            deviation_of_work(
                judgement.degrees_of_freedom,
                f64::INFINITY,
                1.0 / times.max(1.0),
                EXPONENT_OF_INDEPENDENT_SAMPLES,
            ),
        )
    });
    times.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((0.0, 0.0))
}

/// Shares that must still join `shares` shares. Random error falls as the root of their number; the error that halves share does not.
fn needed_of_all(maps: &[MergedMap], target: f64, shares: usize) -> MoreShares {
    let (times, deviation_ln) = times_of_all(maps, target);
    if !times.is_finite() {
        return MoreShares::NoNumber;
    }
    // If only a check or luck delays acceptance, one more share is requested.
    let count = shares as f64;
    let all = Forecast::spread(times.max(f64::MIN_POSITIVE) * count, deviation_ln);
    let more = |all: f64| (all.ceil() - count).max(1.0);
    MoreShares::About(Forecast { expected: more(all.expected), low: more(all.low), high: more(all.high) })
}
