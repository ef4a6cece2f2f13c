//! The parts of a run and its steps: slices of work, looks at maps, and what every map still gets at the end.

use std::time::Instant;

use super::clock::Clock;
use super::long_over::{LONG_OVER, PATIENCE_S, is_long_over, patience_s};
use super::map_states::MapStates;
use super::observer::Observer;
use super::requests::choose_jobs;
use crate::control::{accepts, after_refusal, needed_work, next_judgement};
use crate::maps::MapKind;
use crate::solver::choice;
use crate::solver::context::Context;
use crate::solver::gathering::CellSets;
use crate::solver::job::{Engine, Job, Refinement};
use crate::solver::pace::{TimeLeft, slice_s};
use crate::solver::sparse::fill_sparse_elements;
use crate::solver::spending::{Activity, Spending};
use crate::solver::{ConvergenceRow, DEFAULT_TARGET_ERROR, Method, Settings, StopReason};

/// Unbound maps get at most this share of the rays that the bound ones take.
pub const UNBOUND_SHARE: f64 = 0.25;
/// Rays that an unbound map may take for its first look in any case.
pub const FIRST_LOOK_RAYS: f64 = 4e6;
/// Rays of a first look if a limit or the user ended the run.
const RAYS_IN_HASTE: f64 = 4e5;
/// Time for counting all elements in that case, in slices; and the fewest rays of a first look, however little time is left.
const SLICES_IN_HASTE: f64 = 4.0;
const FEWEST_RAYS_IN_HASTE: f64 = 1000.0;
/// Ratio of the rays that a map takes at least after it starts anew on finer elements to those that it took before.
const WORK_ANEW: f64 = 4.0;
/// Smallest target error that is considered for a run that only a limit ends, and factor between the errors that are tried.
const LEAST_AIM: f64 = 1e-4;
const AIM_STEP: f64 = 1.2;
/// Cells, and what maps have gathered, may take one part in this many of the memory. Solving for their light takes as much again.
pub const SHARE_OF_MEMORY: u64 = 8;

/// A run between its beginning and its end.
pub struct Run<'a> {
    pub context: &'a Context<'a>,
    pub settings: &'a Settings,
    pub target_error: Option<f64>,
    pub observer: &'a dyn Observer,
    pub jobs: Vec<Job>,
    /// The cells that gathering rays look up, if any do.
    pub sets: Option<CellSets>,
    /// Bytes that the cells, and what maps have gathered, may take.
    pub most_bytes_of_cells: u64,
    pub convergence: Vec<ConvergenceRow>,
    /// Seconds of pilots and of judging.
    pub spending: Spending,
    /// How fast its rays are.
    pub clock: Clock,
    /// The progress of its maps.
    pub map_states: MapStates,
    /// Rays at the latest progress report to the observer.
    pub last_row_rays: Option<u64>,
    /// Rays at the latest row of its history.
    pub recorded_at: Option<u64>,
}

impl<'a> Run<'a> {
    /// Creates a run before any work; its cells, and what maps gather, may take `most_bytes_of_cells` bytes.
    pub fn new(
        context: &'a Context<'a>,
        settings: &'a Settings,
        target_error: Option<f64>,
        observer: &'a dyn Observer,
        most_bytes_of_cells: u64,
    ) -> Run<'a> {
        Run {
            context,
            settings,
            target_error,
            observer,
            jobs: Vec::new(),
            sets: None,
            most_bytes_of_cells,
            convergence: Vec::new(),
            spending: Spending::default(),
            clock: Clock::begun(observer.wall_s()),
            map_states: MapStates::default(),
            last_row_rays: None,
            recorded_at: None,
        }
    }
}

impl Run<'_> {
    /// Begins with pilots. Returns whether they ended without an interruption by the user.
    pub fn begin(&mut self) -> bool {
        let piloted = Instant::now();
        self.jobs = choose_jobs(self.context, &self.settings.maps);
        self.cut_elements();
        // Pilots of gathering and of local estimation come after this, and may take longer.
        self.record(false);
        self.tell();
        self.context.pace.begin(self.all_rays(), piloted.elapsed());
        self.prepare();
        self.spending.add(Activity::Pilots, self.context.world.selection_rays(), piloted.elapsed());
        self.clock.pilots_end(self.all_rays(), self.observer.wall_s());
        self.record(false);
        if let Some(error) = self.affordable_error() {
            self.observer.expects(error, self.settings.target_error);
        }
        !self.observer.is_interrupted()
    }

    /// Runs the pilots of gathering and plans what follows from them.
    pub fn prepare(&mut self) {
        self.start_gathering();
        let affordable_rays = self.affordable_rays();
        self.context.world.learn_selection_by_cell(self.planned_rays().min(affordable_rays));
        for job in &mut self.jobs {
            job.next_judgement = job.first_samples();
        }
    }

    /// Works until the run ends.
    pub fn work(&mut self) -> StopReason {
        loop {
            if self.observer.is_interrupted() {
                return StopReason::Interrupted;
            }
            if self.settings.time_limit_s.is_some_and(|limit_s| self.observer.wall_s() >= limit_s) {
                return StopReason::TimeLimit;
            }
            let Some(index) = self.next_job() else {
                return self.why_all_is_done();
            };
            if !self.fits(&self.jobs[index], self.all_rays()) || !self.slice_fits(&self.jobs[index]) {
                return StopReason::TimeLimit;
            }
            self.slice(index);
            self.record(false);
            self.tell();
            self.keep_if_due();
        }
    }

    /// Whether there is light to gather, and the method allows gathering.
    pub fn may_gather(&self) -> bool {
        matches!(self.settings.method, Method::Auto | Method::Gather) && self.context.world.reflects()
    }

    /// Lets maps gather that can, if gathering is requested or pays.
    pub fn start_gathering(&mut self) {
        if !self.may_gather() {
            return;
        }
        let error = self.error_to_plan_for();
        let target = self.settings.target_error;
        for job in &mut self.jobs {
            let has_light = job.has_light_to_gather(self.context);
            if has_light {
                job.prepare_gathering(self.context, error);
            }
            let by_gathering = match job.can_gather(self.context) {
                true if has_light => Ok(job.work_by_gathering(self.context, error)),
                true => Err("its pilot found no light"),
                false => Err("it computes no luminances, and no light that only chains find"),
            };
            if choice::settle(self.context, job, by_gathering, target) {
                job.start_gathering(self.context, error, self.settings.chains);
            } else {
                job.adapting.coarse = None;
            }
        }
        let gathering = self.jobs.iter().filter(|job| job.engine == Engine::Gather);
        let longest = gathering.map(Job::rays_of_a_walk).reduce(f64::max);
        // Samples of cells end by reflectance alone, so their walks are not longer.
        let longer = self.context.world.roulette.longer;
        self.sets = longest.map(|rays_of_a_walk| CellSets::new(self.context, error, rays_of_a_walk / longer));
    }

    /// The target, or approximately the error that a time limit affords.
    pub fn error_to_plan_for(&self) -> f64 {
        if let Some(target) = self.settings.target_error.or(self.target_error) {
            return target;
        }
        if self.settings.time_limit_s.is_none() {
            return DEFAULT_TARGET_ERROR;
        }
        let work = |error: f64| -> f64 {
            let cells = self.jobs.iter().filter(|job| job.bound && job.can_gather(self.context));
            cells.map(|job| job.work_by_gathering(self.context, error)).sum()
        };
        least_affordable(DEFAULT_TARGET_ERROR, self.affordable_rays(), work).min(DEFAULT_TARGET_ERROR)
    }

    /// Rays that fit into half of the time that a limit leaves, at the rate of the run so far; infinite without a limit.
    pub fn affordable_rays(&self) -> f64 {
        let Some(limit_s) = self.settings.time_limit_s else {
            return f64::INFINITY;
        };
        let wall_s = self.observer.wall_s();
        let rays = self.all_rays() as f64;
        0.5 * (limit_s - wall_s).max(0.0) * rays / wall_s.max(f64::MIN_POSITIVE)
    }

    /// Whether the smallest next step of a map ends soon after the time limit, at the rate so far; if the limit has passed, soon after now.
    /// In a nearly white room that is not refused, a single packet of every replica may take seconds.
    fn fits(&self, job: &Job, all_rays: u64) -> bool {
        let Some(limit_s) = self.settings.time_limit_s else {
            return true;
        };
        let wall_s = self.observer.wall_s();
        let took_s = (wall_s - self.clock.begun_wall_s()) * job.rays_at_least() / (all_rays as f64).max(1.0);
        took_s <= (LONG_OVER * limit_s - wall_s).max(0.0) + PATIENCE_S
    }

    /// Rays that end within a time limit and the patience beyond it. Their rate is that of the map's next kind of work, else that of the
    /// run so far.
    pub fn rays_in_patience(&self, job: &Job) -> f64 {
        if self.settings.time_limit_s.is_none() {
            return f64::INFINITY;
        }
        let (rays, wall_s) = (self.all_rays(), self.observer.wall_s());
        let of_map = job.rays_per_s_of_next(self.goal(job));
        let rays_per_s = of_map.unwrap_or_else(|| self.clock.rays_per_s(rays, wall_s));
        patience_s(self.settings.time_limit_s, wall_s) * rays_per_s
    }

    /// Whether the map's next slice ends in time. This matters if the clock does not control its size: with slow rays, a slice of a fixed
    /// number of chains may take many times the limit.
    fn slice_fits(&self, job: &Job) -> bool {
        let rays = || job.rays_of_next_slice(self.context, self.goal(job));
        self.settings.chains.is_none() || rays() <= self.rays_in_patience(job)
    }

    /// Rays, approximately, for which walks and gathering take light samples until the run's end, from the measurements of the pilots;
    /// infinite if only a limit or the user ends it.
    fn planned_rays(&self) -> f64 {
        let takes_light_samples = |job: &&Job| job.bound && !job.is_black() && job.engine != Engine::Collision;
        let jobs = self.jobs.iter().filter(takes_light_samples);
        match (self.settings.chains, self.target_error) {
            (Some(chains), _) => jobs.map(|job| job.rays_to(job.samples_for(chains))).sum(),
            (None, None) => f64::INFINITY,
            (None, Some(target)) => {
                let walked = jobs.filter(|job| job.engine == Engine::Walk);
                let rays = |job: &Job| job.rays_without_gathering(self.context, target * job.mean_without_gathering());
                walked.map(rays).sum::<f64>()
            }
        }
    }

    /// Refines the elements if they cannot show what the target requires. Then the map starts anew, or only its direct light. Returns
    /// whether it did.
    /// A limit must leave time for the extra work: a map that starts anew and does not finish is worth less than before.
    fn refine_elements(&mut self, index: usize) -> bool {
        let affordable_rays = self.affordable_rays();
        let job = &mut self.jobs[index];
        let is_affordable = WORK_ANEW * job.kept_rays() as f64 <= affordable_rays;
        if self.settings.chains.is_some() || job.met || !is_affordable {
            return false;
        }
        let refinement = job.refine_elements(self.context);
        if refinement == Refinement::None {
            job.adapting.finest = job.is_finest();
            return false;
        }
        job.next_judgement = job.samples.max(job.first_samples());
        true
    }

    /// Plans the next work of a map that gathers.
    fn plan_gathering(&mut self, index: usize) {
        let job = &mut self.jobs[index];
        if job.engine == Engine::Gather && !job.met && self.settings.chains.is_none() {
            job.plan_gathering(self.target_error);
        }
    }

    /// Samples at which a job stops to be judged.
    pub fn goal(&self, job: &Job) -> u64 {
        job.next_judgement.min(self.settings.chains.map_or(u64::MAX, |chains| job.samples_for(chains)))
    }

    pub fn slice(&mut self, index: usize) {
        let goal = self.goal(&self.jobs[index]);
        let job = &mut self.jobs[index];
        let arrived = job.advance(self.context, self.sets.as_mut(), goal);
        self.note(index);
        if !self.keeps_to_its_memory() {
            // A map has changed to walks or counts, which store only sums. The states of all maps are evaluated anew.
            self.map_states.forget();
            return;
        }
        if !arrived || goal < self.jobs[index].next_judgement {
            return;
        }
        self.look(index);
    }

    /// Whether a map may change from gathering or local estimation to another method. An unbound map keeps its method if its share of the
    /// rays is too small to finish with the other one.
    fn may_begin_anew(&self, job: &Job, target: f64) -> bool {
        let work = || job.work_without_gathering(self.context, target * job.judgement.mean);
        job.bound || work() <= self.rays_for_unbound(0.0)
    }

    /// Judges a map, and plans what it needs next.
    pub fn look(&mut self, index: usize) {
        let started = Instant::now();
        let needed = self.accept_or_go_on(index);
        let bound = self.jobs[index].bound;
        let is_refined = self.refine_elements(index);
        if !is_refined {
            self.plan_gathering(index);
        }
        self.spending.add(Activity::Judging, 0, started.elapsed());
        if !is_refined {
            self.reconsider_method(index, needed);
        }
        self.note(index);
        if bound {
            self.record(true);
        }
    }

    /// Judges a map by the stop rule and the statistical checks, and sets the samples of its next look. Returns the ratio of the work that
    /// the target takes to the work so far.
    fn accept_or_go_on(&mut self, index: usize) -> f64 {
        let (context, target_error) = (self.context, self.target_error);
        let job = &mut self.jobs[index];
        job.settle_gathering(self.sets.as_mut());
        job.judge(context);
        let needed =
            target_error.map_or(f64::INFINITY, |target| needed_work(target, &job.judgement, job.error_exponent()));
        let accepted = target_error.is_some_and(|target| accepts(target, &job.judgement));
        job.met = accepted && job.run_checks(target_error);
        let without_mean = job.judgement.mean <= 0.0 && !job.judgement.dark;
        job.looks.refused = without_mean || (accepted && !job.met);
        job.looks.refusals += u64::from(job.looks.refused);
        job.next_judgement =
            if job.looks.refused { after_refusal(job.samples) } else { next_judgement(job.samples, needed) };
        needed
    }

    /// Lets the method `auto` change the method of a map, or share its walks out anew. A limit must leave time for the extra work.
    fn reconsider_method(&mut self, index: usize, needed: f64) {
        let (Some(target), None, Method::Auto) = (self.target_error, self.settings.chains, self.settings.method) else {
            return;
        };
        let piloted = Instant::now();
        let affordable_rays = self.affordable_rays();
        let may_begin_anew = self.may_begin_anew(&self.jobs[index], target);
        let job = &mut self.jobs[index];
        let samples = job.samples;
        if may_begin_anew {
            choice::reconsider(self.context, job, target);
        }
        if job.samples == samples && WORK_ANEW * job.kept_rays() as f64 <= affordable_rays {
            job.share_out_walks(self.context, needed);
        }
        self.spending.add(Activity::Pilots, 0, piloted.elapsed());
    }

    /// Whether cells, and what maps have gathered, take no more than their share of the memory. If they take more, the map that takes most
    /// and has not met the target changes to walks or counts. The cells are dropped with the last map that gathers.
    fn keeps_to_its_memory(&mut self) -> bool {
        let Some(sets) = &self.sets else {
            return true;
        };
        let of_maps = || self.jobs.iter().map(Job::bytes_of_gathering).sum::<usize>();
        let all = sets.bytes() + self.map_states.bytes().unwrap_or_else(of_maps);
        if all as u64 <= self.most_bytes_of_cells {
            return true;
        }
        let gathering = self.jobs.iter_mut().filter(|job| job.engine == Engine::Gather && !job.met);
        let Some(job) = gathering.max_by_key(|job| job.bytes_of_gathering()) else {
            return true;
        };
        job.stop_gathering(self.context);
        job.method_reason = format!(
            "cells, and the results gathered through them, used up their {} MB of memory",
            self.most_bytes_of_cells >> 20
        );
        job.next_judgement = job.first_samples();
        if !self.jobs.iter().any(|job| job.engine == Engine::Gather) {
            self.sets = None;
        }
        false
    }

    /// Makes every requested map show something, however the run ended.
    pub fn give_every_map_a_start(&mut self, in_haste: bool) {
        let all_rays = self.all_rays();
        let is_unstarted = |job: &Job| !job.map.is_empty() && (!job.has_started() || in_haste && !job.knows_its_bias());
        let most_rays = |job: &Job| match in_haste {
            true => RAYS_IN_HASTE.min(self.rays_in_patience(job).max(FEWEST_RAYS_IN_HASTE)),
            false => FIRST_LOOK_RAYS,
        };
        let starts = |job: &Job| (self.fits(job, all_rays) && is_unstarted(job)).then(|| most_rays(job));
        let to_start: Vec<Option<f64>> = self.jobs.iter().map(starts).collect();
        for (index, most_rays) in to_start.into_iter().enumerate() {
            if let Some(most_rays) = most_rays {
                self.start(index, most_rays, in_haste);
            }
        }
    }

    /// Takes the first sample of a map; of elements for which it would take longer than `most_rays`, as many chains as these rays allow.
    fn start(&mut self, index: usize, most_rays: f64, in_haste: bool) {
        let job = &mut self.jobs[index];
        if in_haste && !job.knows_its_bias() {
            job.stop_gathering(self.context);
            job.method_reason = "the run ended before walks could measure the error of the cells".to_owned();
        }
        let is_too_long = || in_haste || job.engine == Engine::Collision || job.rays_to(1) > most_rays;
        if job.kind != MapKind::Elements || job.is_black() || !is_too_long() {
            while !job.advance(self.context, self.sets.as_mut(), 1) && !is_long_over(self.settings, self.observer) {}
            return;
        }
        if job.engine == Engine::Gather {
            job.stop_gathering(self.context);
            job.method_reason = "a first sample of every element by gathering would take too long".to_owned();
        }
        let limit_s = self.settings.time_limit_s.filter(|_| in_haste);
        let most_s = limit_s.map_or(f64::INFINITY, |limit_s| SLICES_IN_HASTE * slice_s(limit_s));
        let chains = (most_rays / job.rays_per_sample()) as u64;
        job.count_all_by_chains(self.context, chains, most_s);
    }

    /// Removes and returns the maps that show nothing when a time limit passed long ago: a walk from each of their points would take far
    /// longer.
    pub fn leave_out(&mut self) -> Vec<(String, bool)> {
        let all_rays = self.all_rays();
        if (self.context.time_left)() > TimeLeft::None && self.jobs.iter().all(|job| self.fits(job, all_rays)) {
            return Vec::new();
        }
        let shows = |job: &Job| job.has_started() || job.map.is_empty();
        let left_out = self.jobs.iter().filter(|job| !shows(job));
        let left_out = left_out.map(|job| (job.kind.name(self.context.scene).to_owned(), job.bound)).collect();
        self.jobs.retain(shows);
        left_out
    }

    pub fn judge_all(&mut self, in_haste: bool) {
        for job in &mut self.jobs {
            if !in_haste {
                fill_sparse_elements(self.context, job);
                job.balance_flux(self.context);
            }
            let started = Instant::now();
            job.settle_gathering(self.sets.as_mut());
            job.judge(self.context);
            if !job.met {
                job.run_checks(self.target_error);
            }
            self.spending.add(Activity::Judging, 0, started.elapsed());
        }
        self.record_end();
    }
}

/// The smallest error up to about `most` that takes no more than the affordable rays, for a run that only a limit ends.
fn least_affordable(most: f64, affordable_rays: f64, rays_to: impl Fn(f64) -> f64) -> f64 {
    let mut error = LEAST_AIM;
    while error < most && rays_to(error) > affordable_rays {
        error *= AIM_STEP;
    }
    error
}
