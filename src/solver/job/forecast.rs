//! What is known about the error of a map, and a forecast of the work that it still takes.

use serde::{Deserialize, Serialize};

use super::{CHAINS_OF_BALANCE, Engine, Job};
use crate::control::{
    Forecast, GROWTH_AFTER_REFUSAL, ONE_IN_TWENTY, deviation_of_work, effective_scores, needed_work, spare_for_tail,
    work_for_tail, work_to_pass,
};
use crate::maps::{Judgement, MapKind, REPLICAS, judge};
use crate::solver::ErrorParts;
use crate::solver::context::Context;
use crate::solver::spending::Activity;

/// Judging one entry takes about the time of this many rays. Judging for forecasts may take this share of a run.
const RAYS_OF_AN_ENTRY: f64 = 1.0;
const SHARE_OF_JUDGING: f64 = 0.01;
/// Share of the squared target that is left for random error, where elements must be cut before they can meet the target.
const SHARE_OF_CHANCE: f64 = 0.75;
// Standard deviations of the logarithm of the work, by the source of the forecast. These constants and those that follow were measured in
// the rooms of even seeds of the proving ground to 3 and 1 %.
/// Deviation of a forecast by a pilot of walks or chains.
const DEVIATION_BY_PILOT: f64 = 0.3;
/// Deviation of a forecast by a pilot of walks, for a map that will gather: in some rooms cells are far better than walks can predict.
const DEVIATION_BY_PILOT_OF_CELLS: f64 = 0.5;
/// Deviation of a forecast by a look at walks or chains, in addition to the random error of the look itself.
const DEVIATION_OF_LOOK: f64 = 0.11;
/// Deviation of a forecast by a look at counts, in addition to the random error of the look itself.
const DEVIATION_OF_COUNTS: f64 = 0.05;
/// Deviation of a forecast of the remaining work by the plan of a map that gathers.
const DEVIATION_OF_PLAN: f64 = 0.4;
/// Deviation of a forecast of all work, where a check has refused the map.
const DEVIATION_BY_REFUSAL: f64 = 0.6;
/// Deviation of a forecast where elements must be cut.
const DEVIATION_BY_CUTTING: f64 = 0.7;
/// Standard deviation, among maps, of the power with which errors fall with the work.
const DEVIATION_OF_EXPONENT: f64 = 0.035;
/// Standard deviation of the logarithm of an error of connections from quasi-random points, around their power law.
const SCATTER_OF_CONNECTIONS: f64 = 0.06;
/// Ratio of the rays that walks take to what their pilot predicts: a target is met with a margin (measured in eleven made-up rooms).
const WALKS_BEYOND_PILOT: f64 = 1.25;
/// Passes of walks that a map takes beyond those forecast, as passes are whole. (Measured in 27 maps of up to 12 passes: 0.3 to 0.6.)
const PASSES_BEYOND_FORECAST: f64 = 0.5;
/// Ratio of the work at which a map of walks or connections ends to that at which its error is forecast to meet the target: a target is met
/// at a look, and errors scatter. (Measured in 558 runs of 29 rooms: 1.03 leaves the least median error at a fifth and at half of the run.)
const WORK_BEYOND_TARGET: f64 = 1.03;
/// Ratio of the rays that local estimation takes to what its pilot predicts (measured in six made-up rooms and the office).
const LOCAL_OVER_PILOT: f64 = 1.4;
/// Rays of one kind after which their speed is known.
const TIMED_RAYS: u64 = 20_000;
/// Half of the maps that a check refuses are refused again. Median ratio of the work that a refused map takes to the work to its next look.
const WORK_OF_REFUSED: f64 = 1.22;

/// What keeps a map from its target, apart from random error, which falls with the work.
#[derive(Clone, Debug, PartialEq)]
pub enum Hindrance {
    /// The bias of cells, as a fraction of the mean. It is above the target, and no plan that was tried takes it below.
    Cells(f64),
    /// What the map's elements cannot show, as a fraction of the mean. It is above the target, so the elements must be cut.
    Elements(f64),
    /// A statistical check refused the map this many times when it met the target.
    Check(u64),
}

impl Hindrance {
    /// Whether more of the same work is not expected to remove it.
    pub fn is_out_of_reach(&self) -> bool {
        matches!(self, Hindrance::Cells(_))
    }
}

/// What was known of a map before it started anew on finer elements.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct BeforeCut {
    error: ErrorParts,
    /// Rays that it still had to take, and rays that it had taken.
    left: Forecast,
    rays: u64,
}

impl Job {
    /// Seconds per ray of the map's work to come, from the time that rays of the same kinds have taken. Rays of direct light build control
    /// variates and take longer than those of walks. `None` before rays are timed.
    pub fn seconds_per_ray(&self) -> Option<f64> {
        let timed = |kinds: &[Activity]| self.work.spending.seconds_per_ray(kinds, TIMED_RAYS);
        let of_direct = timed(&[Activity::Direct]);
        if self.black {
            return of_direct;
        }
        let Some(indirect) = self.engine.activity() else {
            return timed(&[Activity::Direct, Activity::Gathering, Activity::Cells, Activity::ResidualWalks]);
        };
        let indirect_s = timed(&[indirect])?;
        let direct_rays = self.share.rays_per_pass * self.share.passes_per_sample;
        let direct_share = direct_rays / (direct_rays + self.share.rays_per_indirect).max(f64::MIN_POSITIVE);
        Some(direct_share * of_direct.unwrap_or(indirect_s) + (1.0 - direct_share) * indirect_s)
    }

    /// What is known of the map now, to be stored while its elements are cut.
    pub(super) fn before_cut(&self, context: &Context) -> Option<BeforeCut> {
        let left = self.rays_left(context, context.target_error)?;
        Some(BeforeCut { error: self.error_so_far(context)?, left, rays: self.work.rays })
    }

    /// What keeps the map from a target apart from random error, by its latest look.
    pub fn hindrance(&self, target: f64) -> Option<Hindrance> {
        let (judgement, _) = self.looks.latest.as_ref()?;
        if self.looks.refused {
            return Some(Hindrance::Check(self.looks.refusals));
        }
        if judgement.discretisation >= target {
            return Some(Hindrance::Elements(judgement.discretisation));
        }
        let is_planned = self.gathering.growth.as_ref().is_none_or(|(growth, _)| growth.reaches);
        (judgement.bias >= target && !is_planned).then_some(Hindrance::Cells(judgement.bias))
    }

    /// The error that the map states by its latest look.
    pub fn stated_error(&self) -> Option<f64> {
        self.looks.latest.as_ref().map(|(judgement, _)| judgement.stated_error())
    }

    /// Whether more is known of its error than its pilot predicts, possibly on coarser elements.
    pub fn has_been_judged(&self) -> bool {
        self.is_judged() || self.adapting.before_cut.is_some()
    }

    /// Whether more is known of the error of its present samples than its pilot predicts.
    pub fn is_judged(&self) -> bool {
        self.looks.latest.is_some()
    }

    /// The error so far: from the latest look, possibly on coarser elements, or else the error that the pilot predicts for as many rays of
    /// walks or counts. `None` if the pilot found no light.
    pub fn error_so_far(&self, context: &Context) -> Option<ErrorParts> {
        match &self.looks.latest {
            Some((judgement, _)) if judgement.mean > 0.0 => Some(ErrorParts::of(judgement)),
            _ => self.adapting.before_cut.map(|before| before.error).or_else(|| self.error_by_pilot(context)),
        }
    }

    fn error_by_pilot(&self, context: &Context) -> Option<ErrorParts> {
        let mean = self.mean_without_gathering();
        let indirect = self.costs.indirect.variance * self.costs.indirect.rays * self.map.len() as f64;
        let direct = self.costs.direct.variance * self.costs.direct.rays * self.map.len() as f64;
        let rays = self.all_rays() + context.world.selection_rays();
        let error = (direct.sqrt() + indirect.sqrt()) / (rays as f64).sqrt() / mean;
        (mean > 0.0 && rays > 0).then_some(ErrorParts::random(error))
    }

    /// Judges the error to report it, not to decide by it, if judging is cheap relative to `rays`.
    pub fn judge_for_forecast(&mut self, rays: f64) {
        let is_cheap = RAYS_OF_AN_ENTRY * self.map.entries() as f64 <= SHARE_OF_JUDGING * rays;
        let is_whole = self.map.direct_samples.partial == 0 && self.map.indirect_samples.partial == 0;
        // Before a first look there are too few samples to show more than the pilot.
        let is_new = self.looks.latest.as_ref().is_some_and(|(_, samples)| self.samples > *samples);
        let counts = !self.black && self.engine != Engine::Gather && self.samples > 0 && !self.met;
        if !(is_cheap && is_whole && is_new && counts && self.has_started()) {
            return;
        }
        let mut judgement = judge(&self.map, self.weights.iter().copied().enumerate());
        if judgement.mean > 0.0 && !judgement.unseen {
            // What elements cannot show stays as it was.
            judgement.discretisation = self.looks.latest.map_or(0.0, |(seen, _)| seen.discretisation);
            self.forecast_from(judgement);
        }
    }

    /// Stores a judgement as the latest of its present samples, from which forecasts start.
    pub(super) fn forecast_from(&mut self, judgement: Judgement) {
        self.looks.latest = Some((judgement, self.samples));
        let parts = self.score_parts();
        self.looks.latest_scores = effective_scores(parts).unwrap_or(f64::INFINITY);
        self.looks.latest_tail_spare = spare_for_tail(parts);
    }

    /// Rays still needed to reach a target: by its plan, else by its latest look, else by its pilot. `None` if the pilot found no light.
    pub fn rays_left(&self, context: &Context, target: f64) -> Option<Forecast> {
        match (&self.looks.latest, self.rays_left_to_gather()) {
            (_, Some(rays)) => Some(self.left_by_plan(rays)),
            (Some((judgement, samples)), None) if judgement.mean > 0.0 && *samples > 0 => {
                Some(self.left_by_look(context, target))
            }
            _ => self.left_by_pilot(context, target).map(|left| self.at_least_as_before(left)),
        }
    }

    /// The forecast of the pilot, or that of the look before the elements were cut, whichever is more. A pilot contains no information
    /// about elements that must still be cut.
    fn at_least_as_before(&self, left: Forecast) -> Forecast {
        let before =
            self.adapting.before_cut.map(|before| before.left.less(self.work.rays.saturating_sub(before.rays) as f64));
        before.filter(|before| before.expected > left.expected).unwrap_or(left)
    }

    /// Forecast from its plan, which has `rays` left.
    fn left_by_plan(&self, rays: f64) -> Forecast {
        let done = self.work.rays as f64;
        let all = done + rays;
        if self.looks.refused {
            return Forecast { low: all, ..Forecast::spread(WORK_OF_REFUSED * all, DEVIATION_BY_REFUSAL) }.less(done);
        }
        let [low, high] = match (&self.gathering.bounds, &self.gathering.growth) {
            (Some(bounds), Some((_, planned_at))) => bounds.map(|more| *planned_at as f64 + more),
            _ => [all; 2],
        };
        let model = Forecast::spread(rays, DEVIATION_OF_PLAN);
        let of_look = Forecast { expected: all, low: low.min(all), high: high.max(all) };
        of_look.less(done).plus(Forecast { expected: 0.0, low: model.low - rays, high: model.high - rays }).less(0.0)
    }

    /// Rays to its first look, for a map that has had none.
    pub fn rays_to_look(&self, context: &Context) -> f64 {
        if self.engine != Engine::Gather {
            return self.rays_to(self.first_samples());
        }
        (self.rays_of_first_look(context) - self.kept_rays() as f64).max(0.0)
    }

    /// Rays of the first look at a map that gathers.
    fn rays_of_first_look(&self, context: &Context) -> f64 {
        self.gathering.goal.direct as f64 * self.rays_of_a_pass() + self.rays_to_first_look(context.target_error)
    }

    /// Rays of the chains that show where the flux goes, for elements that count no chains.
    pub fn rays_of_balance(&self) -> f64 {
        let gathers = self.kind == MapKind::Elements && self.engine == Engine::Gather;
        let rays_of_a_chain = self.costs.indirect.rays * self.elements.len() as f64;
        if gathers { (CHAINS_OF_BALANCE * REPLICAS as u64) as f64 * rays_of_a_chain } else { 0.0 }
    }

    fn left_by_pilot(&self, context: &Context, target: f64) -> Option<Forecast> {
        let (rays, deviation_ln) = self.rays_by_pilot(context, target)?;
        let left = Forecast::spread(rays, deviation_ln).less(self.kept_rays() as f64);
        Some(left.plus(Forecast::known(self.rays_to_cut(context))))
    }

    /// Rays to a target by the pilot, and the standard deviation of their logarithm.
    fn rays_by_pilot(&self, context: &Context, target: f64) -> Option<(f64, f64)> {
        let absolute_error = target * self.mean_without_gathering();
        let (rays, deviation_ln) = match (&self.connecting.plan, self.engine) {
            _ if absolute_error <= 0.0 => return None,
            _ if self.is_to_be_cut() => {
                let without = self.rays_without_gathering(context, absolute_error);
                // Coarse elements exist if the map may gather.
                let by_gathering =
                    self.adapting.coarse.as_ref().map_or(f64::INFINITY, |_| self.work_by_gathering(context, target));
                (without.min(by_gathering), DEVIATION_BY_PILOT.hypot(DEVIATION_BY_CUTTING))
            }
            (_, Engine::Gather) => (self.rays_by_pilot_of_cells(context, target), DEVIATION_BY_PILOT_OF_CELLS),
            (Some(plan), Engine::Local(_)) => {
                (LOCAL_OVER_PILOT * self.rays_by_connecting(plan, absolute_error), DEVIATION_BY_PILOT)
            }
            (_, Engine::Walk) => {
                let even = WALKS_BEYOND_PILOT * self.rays_without_gathering(context, absolute_error);
                let last_rays = PASSES_BEYOND_FORECAST * self.share.rays_per_indirect * REPLICAS as f64;
                let walked = self.walking.brought * self.walking.to_come * even;
                (walked + self.control_variates.rays_to_make + last_rays, DEVIATION_BY_PILOT)
            }
            _ => (self.rays_without_gathering(context, absolute_error), DEVIATION_BY_PILOT),
        };
        (rays.is_finite() && rays > 0.0).then_some((rays, deviation_ln))
    }

    /// Rays to a target by the pilot of walks, for a map that gathers or is about to.
    fn rays_by_pilot_of_cells(&self, context: &Context, target: f64) -> f64 {
        let absolute_error = target * self.mean_without_gathering();
        // After a first look the map changes to local estimation if that takes less.
        let by_gathering = self.rays_by_gathering(target);
        let by_chains = self.connecting.offered.as_ref().and_then(|offered| offered.as_ref().ok());
        let by_chains = by_chains.map(|offer| LOCAL_OVER_PILOT * self.rays_by_connecting(&offer.plan, absolute_error));
        let hoped = by_chains.map_or(by_gathering, |rays| rays.min(by_gathering));
        let without = self.rays_without_gathering(context, absolute_error);
        let first = self.rays_of_first_look(context);
        match self.kind {
            MapKind::Elements => hoped.min(without).max(first),
            // Half of the receiver sets walk in the end. So the forecast is the geometric mean of the hoped-for work and that of walks.
            MapKind::Receivers(_) => first + (hoped * without).sqrt(),
        }
    }

    /// Forecast of the rays to a target for a map that is about to gather.
    pub fn rays_left_by_cells(&self, context: &Context, target: f64) -> Forecast {
        Forecast::spread(self.rays_by_pilot_of_cells(context, target), DEVIATION_BY_PILOT_OF_CELLS)
    }

    /// Forecast from the samples so far and the error that remained.
    fn left_by_look(&self, context: &Context, target: f64) -> Forecast {
        let Some((judgement, seen_at)) = &self.looks.latest else {
            return Forecast::default();
        };
        let done = self.kept_rays() as f64;
        let rays_per_sample = done / self.samples.max(1) as f64;
        let exponent = self.error_exponent();
        let needed = needed_work(target, judgement, exponent);
        if !needed.is_finite() {
            let chance = SHARE_OF_CHANCE * target * target;
            let anew = judgement.expected_error.powi(2) / chance * *seen_at as f64 * rays_per_sample;
            return Forecast::spread(anew, DEVIATION_BY_CUTTING);
        }
        let passing = work_to_pass(needed, self.looks.latest_scores, self.looks.latest_tail_spare);
        let beyond = if self.engine == Engine::Walk { PASSES_BEYOND_FORECAST } else { 0.0 };
        let late = if self.engine == Engine::Collision { 1.0 } else { WORK_BEYOND_TARGET };
        let even = self.rays_of(late * passing * *seen_at as f64 + beyond);
        let all = if even > done { done + self.walking.to_come * (even - done) } else { even };
        if self.looks.refused {
            let next = self.rays_of(self.next_judgement as f64);
            let expected = all.max(WORK_OF_REFUSED * next);
            return Forecast { low: next, ..Forecast::spread(expected, DEVIATION_BY_REFUSAL) }.less(done);
        }
        let left = (1.0 - 1.0 / needed).max(0.0);
        let of_chance =
            deviation_of_work(judgement.degrees_of_freedom, self.looks.latest_scores, 1.0 / needed, exponent);
        let is_of_law = self.engine != Engine::Collision;
        let of_law = if is_of_law { DEVIATION_OF_EXPONENT * needed.ln().max(0.0) / exponent } else { 0.0 };
        let scatter = if self.connects() { SCATTER_OF_CONNECTIONS } else { 0.0 };
        let of_errors = scatter * left.sqrt() / exponent;
        let of_kind = if self.engine == Engine::Collision { DEVIATION_OF_COUNTS } else { DEVIATION_OF_LOOK };
        // A tail may not delay the map at all, or it may delay it twice as often as expected.
        let of_tail = work_for_tail(self.looks.latest_tail_spare).ln() / ONE_IN_TWENTY;
        let of_look = of_chance.hypot(of_law).hypot(of_errors).hypot(of_kind * left.sqrt()).hypot(of_tail);
        // The pilot's forecast weighs more if the look is uncertain, and less if it is far from the look's forecast. The pilot may have
        // missed what few walks or chains bring.
        match self.rays_by_pilot(context, target) {
            Some((rays, of_pilot)) => {
                let rays = rays * passing / needed;
                let of_pilot = of_pilot.hypot(of_chance).hypot((all / rays).ln());
                Forecast::pooled([(all, of_look), (rays, of_pilot)]).less(done)
            }
            None => Forecast::spread(all, of_look).less(done),
        }
    }

    /// Rays that `samples` samples take in all, estimated from those so far. Passes over direct light do not grow evenly with samples, and
    /// the first pass also makes the control variates.
    fn rays_of(&self, samples: f64) -> f64 {
        let direct = self.work.direct_rays as f64 + self.direct_rays_to(samples.ceil() as u64);
        let indirect = self.kept_rays().saturating_sub(self.work.direct_rays) as f64 / self.samples.max(1) as f64;
        direct + indirect * samples
    }

    /// Rays that a map must take once more if a statistical check refuses it when it meets the target. For gathering, direct light or rays
    /// double; the larger of the two is assumed.
    pub fn rays_if_refused(&self, left: f64) -> f64 {
        let all = self.kept_rays() as f64 + left;
        match &self.gathering.progress {
            Some(gathered) if self.engine == Engine::Gather => {
                let parts = [self.work.direct_rays, gathered.rays[0]];
                let share = parts.into_iter().max().unwrap_or(0) as f64 / (self.kept_rays().max(1)) as f64;
                share.min(1.0) * all
            }
            _ => (GROWTH_AFTER_REFUSAL - 1.0) * all,
        }
    }
}
