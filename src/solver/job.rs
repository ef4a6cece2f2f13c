//! The work on one map: what a sample is, and how its sixteen replicas go forward together.

mod connecting;
mod counting;
mod elements;
mod engine;
mod expected;
mod forecast;
mod gathering;
mod judged;
mod leaving;
mod merged;
mod parts;
mod sharing_out;
mod walking;

use std::ops::Range;
use std::time::Instant;

use serde::{Deserialize, Serialize};

pub use self::connecting::{Offer, Offered};
pub use self::elements::Refinement;
pub use self::engine::Engine;
pub use self::forecast::Hindrance;
pub use self::gathering::SHARE_OF_A_LOOK;
use self::parts::{AdaptingState, ConnectingState, Costs, GatheringState, Looks, WalkingState, WorkDone};
use super::Method;
use super::adapt::{Adaptive, Cutting};
use super::context::Context;
use super::empty_maps::{element_map, numbers_per_site, receiver_map};
use super::ends::Ends;
use super::gathering::CellSets;
use super::local::LocalPlan;
pub use super::pace::RAYS_PER_SLICE;
use super::passes;
use super::pilot::{DirectShare, IndirectCost, direct_cost, indirect_cost};
use super::spending::Activity;
use crate::estimators::control_variate::ControlVariates;
use crate::maps::{Judgement, MapKind, PACKETS_OF_A_BOUND, REPLICAS, ROUNDING_OF_SUMS, ReplicaMap, Tally, judge};
use crate::scene::Elements;

/// A map that is still dark after this many chains, or gathering rays, divided by the target error is left dark.
const CHAINS_FOR_DARKNESS: f64 = 100.0 * PACKETS_OF_A_BOUND;

/// Chains per replica that show where the flux goes, for elements that count no chains.
const CHAINS_OF_BALANCE: u64 = 256;

/// One map in progress.
#[derive(Serialize, Deserialize)]
pub struct Job {
    /// `elements` or the receiver set's name.
    pub name: String,
    /// The element map, or the number of the receiver set.
    pub kind: MapKind,
    /// The elements of an element map; none for receivers.
    pub elements: Elements,
    /// State of elements that adapt, and of other elements from which walks or rays start.
    pub adapting: AdaptingState,
    /// Sums of direct and indirect scores, for every entry and replica.
    pub map: ReplicaMap,
    /// Area or weight of every entry of the map. A weight of 0 excludes the entry from errors.
    pub weights: Vec<f64>,
    /// Whether the map must meet the target.
    pub bound: bool,
    /// Whether the stop rule accepted it.
    pub met: bool,
    /// Samples done in every replica: chains for elements, passes of walks for receivers, passes over direct light in a black scene.
    pub samples: u64,
    /// Number of samples at which the map is judged next.
    pub next_judgement: u64,
    /// Rays and seconds so far.
    pub work: WorkDone,
    /// Ends of its packets for each replica (elements only).
    pub ends: [Ends; REPLICAS],
    /// Latest judgement.
    pub judgement: Judgement,
    /// Findings of the looks (error checks) at its present samples.
    pub looks: Looks,
    /// Estimator of its indirect light.
    pub engine: Engine,
    /// Reason for this engine, in words for the summary.
    pub method_reason: String,
    /// Variance of its direct light in one replica, in the square of the map's unit, from the latest look.
    pub direct_variance: f64,
    /// Cost of a sample as measured by the pilots, and how direct and indirect light share the work.
    costs: Costs,
    share: DirectShare,
    /// Control variates of direct light at the map's points.
    control_variates: ControlVariates,
    /// State that each estimator of indirect light needs.
    walking: WalkingState,
    gathering: GatheringState,
    pub connecting: ConnectingState,
    black: bool,
}

impl Job {
    /// Creates a job for the element map. If its elements adapt, it starts with the given elements until they are cut ([`Job::cut_on`]).
    pub fn elements(context: &Context, bound: bool) -> Job {
        let given = context.world.elements.clone();
        let adapt_to = context.adapt_to.filter(|_| bound && !given.is_empty());
        let (map, weights) = element_map(context, &given, None);
        let mut job = Job::new(context, MapKind::Elements, given, None, map, weights, bound);
        job.adapting.cutting = adapt_to.map(|target_error| {
            let means_lx = [job.costs.direct.mean, job.costs.indirect.mean];
            Box::new(Cutting::begin(&job.elements, target_error, means_lx, job.costs.direct.rays))
        });
        job
    }

    /// Creates a job for a receiver set.
    pub fn receivers(context: &Context, set: usize, bound: bool) -> Job {
        let (map, weights) = receiver_map(context, set);
        Job::new(context, MapKind::Receivers(set), Elements::default(), None, map, weights, bound)
    }

    fn new(
        context: &Context,
        kind: MapKind,
        elements: Elements,
        adaptive: Option<Adaptive>,
        map: ReplicaMap,
        weights: Vec<f64>,
        bound: bool,
    ) -> Job {
        // Where elements show slopes, the slopes have a random error of their own.
        let numbers = numbers_per_site(&weights, map.len());
        let (direct, control_variates) = direct_cost(context, kind, &elements, adaptive.as_ref());
        let engine = Engine::unbiased(context.scene, kind, context.method);
        let local = match (kind, engine) {
            (MapKind::Receivers(set), Engine::Local(kernel)) if context.world.reflects() => {
                Some(LocalPlan::of(context, set, kernel, 0.0))
            }
            _ => None,
        };
        let indirect = match &local {
            Some(plan) => IndirectCost::alone(plan.cost(&weights)),
            None => indirect_cost(context, kind, &elements, (bound && context.to_target).then_some(direct.mean)),
        };
        // Only `auto` shares walks out.
        let gain_to_come = if context.method == Method::Auto { indirect.gain_to_come } else { 1.0 };
        let walking =
            WalkingState { sharing: indirect.sharing, to_come: gain_to_come.recip(), ..WalkingState::default() };
        let [direct, walked, indirect] = [direct, indirect.alone, indirect.shared].map(|cost| cost.times(numbers));
        let entries = map.len();
        let cutting_rays = adaptive.as_ref().map_or(0, |adaptive| adaptive.pilot_rays);
        let pilot_rays = direct.pilot_rays + indirect.pilot_rays + cutting_rays;
        let mut job = Job {
            adapting: AdaptingState { adaptive, ..AdaptingState::default() },
            work: WorkDone { pilot_rays, ..WorkDone::default() },
            method_reason: if context.method == Method::Auto { "no other method applies" } else { "requested" }
                .to_owned(),
            costs: Costs { direct, indirect, walked },
            walking,
            share: DirectShare::of(direct, indirect, [entries; 2]),
            control_variates,
            connecting: ConnectingState { plan: local, offered: None },
            ..Job::bare(context, kind, elements, (map, weights), bound, engine)
        };
        if bound && context.to_target {
            job.walking.first_walks = job.first_walks(context.target_error);
        }
        job
    }

    /// Creates a job for a map without samples, pilot or plan.
    fn bare(
        context: &Context,
        kind: MapKind,
        elements: Elements,
        (map, weights): (ReplicaMap, Vec<f64>),
        bound: bool,
        engine: Engine,
    ) -> Job {
        Job {
            name: kind.name(context.scene).to_owned(),
            kind,
            elements,
            adapting: AdaptingState::default(),
            map,
            weights,
            bound,
            met: false,
            samples: 0,
            next_judgement: 0,
            work: WorkDone::default(),
            ends: [Ends::default(); REPLICAS],
            judgement: Judgement::default(),
            looks: Looks::default(),
            engine,
            method_reason: String::new(),
            direct_variance: 0.0,
            costs: Costs::default(),
            share: DirectShare::default(),
            control_variates: ControlVariates::default(),
            walking: WalkingState::default(),
            gathering: GatheringState::default(),
            connecting: ConnectingState::default(),
            black: !context.world.reflects(),
        }
    }

    /// All rays so far, including those of pilots.
    pub fn all_rays(&self) -> u64 {
        self.work.rays + self.work.pilot_rays
    }

    /// Chains in one round of local estimation.
    fn chains_per_round(&self) -> u64 {
        self.connecting.plan.as_ref().map_or(1, |plan| plan.chains_per_round)
    }

    /// Rays for one sample in all replicas, as counted by the pilot.
    pub fn rays_per_sample(&self) -> f64 {
        let direct = self.share.rays_per_pass * if self.black { 1.0 } else { self.share.passes_per_sample };
        (direct + self.share.rays_per_indirect).max(1.0) * REPLICAS as f64
    }

    /// Rays of the chains for `samples` samples of a counted map.
    pub fn rays_of_chains(&self, samples: u64) -> f64 {
        samples as f64 * self.share.rays_per_indirect * REPLICAS as f64
    }

    /// Rays still needed to reach a number of samples, as counted by the pilot.
    pub fn rays_to(&self, samples: u64) -> f64 {
        if let Some(rays) = self.rays_left_to_gather() {
            return rays;
        }
        let samples_to_come = samples.saturating_sub(self.samples);
        self.direct_rays_to(samples) + samples_to_come as f64 * self.share.rays_per_indirect * REPLICAS as f64
    }

    /// Rays of direct light still needed to reach a number of samples, as counted by the pilot.
    fn direct_rays_to(&self, samples: u64) -> f64 {
        let passes = self.passes_at(samples).saturating_sub(self.map.direct_samples.complete);
        passes as f64 * self.share.rays_per_pass * REPLICAS as f64
    }

    /// Whether every entry has direct samples and, if light is reflected, indirect samples.
    pub fn has_started(&self) -> bool {
        self.map.direct_samples.complete > 0 && (self.black || self.gathered().indirect_samples.complete > 0)
    }

    /// Whether the error is 0 and stays 0.
    pub fn is_exact(&self) -> bool {
        self.black && self.map.direct_samples.complete > 0 && self.judgement.expected_error < ROUNDING_OF_SUMS
    }

    /// Whether nothing reflects light: the scene is black.
    pub fn is_black(&self) -> bool {
        self.black
    }

    fn passes_at(&self, samples: u64) -> u64 {
        if self.engine == Engine::Gather {
            return self.gathering.goal.direct;
        }
        if self.black {
            return samples;
        }
        ((samples as f64 * self.share.passes_per_sample).ceil() as u64).max(1)
    }

    /// Goes forward by one slice of work towards a number of samples in every replica. Returns whether that number is reached.
    /// Direct light goes first. Passes over very many entries take several slices, so that a limit or the user can end the run during
    /// a pass.
    /// `sets` are the cells that gathering rays look up. It is `None` if no map gathers.
    pub fn advance(&mut self, context: &Context, sets: Option<&mut CellSets>, goal: u64) -> bool {
        let (activity, rays, started) = (self.next_activity(goal), self.work.rays, Instant::now());
        context.pace.turn_to(&self.work.slices, activity);
        let arrived = self.do_a_slice(context, sets, goal);
        let took = started.elapsed();
        self.work.spending.add(activity, self.work.rays - rays, took);
        context.pace.note(&mut self.work.slices, activity, took);
        arrived
    }

    /// Rays of the next slice of work towards a goal, approximately.
    pub fn rays_of_next_slice(&self, context: &Context, goal: u64) -> f64 {
        context.pace.rays_of_next(&self.work.slices, self.next_activity(goal))
    }

    /// Rays per second for the kind of work that is next towards a goal, if any of it has been done.
    pub fn rays_per_s_of_next(&self, goal: u64) -> Option<f64> {
        self.work.spending.seconds_per_ray(&[self.next_activity(goal)], 1).map(f64::recip)
    }

    /// Kind of work in the next slice.
    fn next_activity(&self, goal: u64) -> Activity {
        if self.map.direct_samples.complete < self.passes_at(goal) {
            return Activity::Direct;
        }
        self.engine.activity().unwrap_or_else(|| self.next_of_gathering())
    }

    /// Does one slice of work. Returns whether the map has reached the goal with it.
    fn do_a_slice(&mut self, context: &Context, sets: Option<&mut CellSets>, goal: u64) -> bool {
        let passes = self.passes_at(goal);
        if self.map.direct_samples.complete < passes {
            self.advance_direct(context, passes);
        } else if self.engine == Engine::Gather {
            return sets.is_none_or(|sets| self.gather_a_slice(context, sets));
        } else if !self.black {
            self.advance_indirect(context, goal);
        }
        if self.engine == Engine::Gather {
            return false;
        }
        let indirect = self.map.indirect_samples;
        self.samples = if self.black { self.map.direct_samples.complete } else { indirect.complete };
        self.samples >= goal && self.map.direct_samples.complete >= passes
    }

    /// Does a part of a pass over direct light, or several passes, towards `passes`.
    fn advance_direct(&mut self, context: &Context, passes: u64) {
        // The first pass also makes the control variates that the pilot has not made.
        let rays_ahead = if self.map.direct_samples.complete == 0 { self.control_variates.rays_to_make } else { 0.0 };
        let rays = self.share.rays_per_pass + rays_ahead / REPLICAS as f64;
        let passes = if self.may_share_out_direct(context) { 1 } else { passes };
        let (entries, times) = slice_of_passes(context, self.map.direct_samples, passes, self.map.len(), rays);
        let (elements, map, part) = (&self.elements, &mut self.map, (entries.clone(), times.clone()));
        let rays = match (self.kind, &mut self.adapting.adaptive) {
            (MapKind::Elements, Some(adaptive)) => {
                passes::direct_in_elements(context, elements, map, adaptive, part.0, part.1)
            }
            (MapKind::Elements, None) => {
                let of_elements = (elements, &self.adapting.direct_samples);
                passes::direct_over_elements(context, of_elements, map, part.0, part.1)
            }
            (MapKind::Receivers(set), _) => {
                passes::direct_at_points(context, set, map, &mut self.control_variates, part.0, part.1)
            }
        };
        self.work.rays += rays;
        self.work.direct_rays += rays;
        self.map.direct_samples = after_passes(entries, times, self.map.len());
        self.share_out_direct(context);
    }

    /// Judges the present error.
    pub fn judge(&mut self, context: &Context) {
        self.looks.judged_samples = self.samples;
        self.direct_variance = self.map.direct_variance(&self.weights);
        self.judgement = judge(&self.map, self.weights.iter().copied().enumerate());
        if let Some(adaptive) = &self.adapting.adaptive {
            let coarse = self.adapting.coarse.as_ref();
            self.adapting.loss = adaptive.loss(context, &self.elements, self.site_weights(), &self.map, coarse);
            self.judgement.discretisation =
                self.adapting.loss.stated_lx2().sqrt() / self.judgement.mean.max(f64::MIN_POSITIVE);
        }
        self.bound_unseen(context, self.chains());
        if self.engine == Engine::Gather {
            // Cells improve from look to look, so the samples of this look are not those of the look before plus some more.
            self.looks.history.clear();
        }
        self.forecast_from(self.judgement);
        self.note_judgement();
    }

    /// Ratio of the flux of all luminaires to the flux that the map shows: 1 / (Σ E A / Φ) for elements, 1 for receivers.
    fn flux_over_map(&self, context: &Context) -> f64 {
        if self.kind != MapKind::Elements && self.engine != Engine::Collision {
            return 1.0;
        }
        let area_m2: f64 = self.site_weights().iter().sum();
        context.world.emitters.luminous_flux_lm() / (area_m2 * self.judgement.mean)
    }

    /// Whether the map is dark after enough chains that it no longer delays the end of the run.
    pub fn stays_dark(&self, target_error: f64) -> bool {
        let looked = match self.engine {
            Engine::Gather => self.samples * self.gathered().len() as u64 * REPLICAS as u64,
            _ => self.chains(),
        };
        self.looks.judged_samples > 0
            && self.judgement.dark
            && (self.black || looked as f64 * target_error > CHAINS_FOR_DARKNESS)
    }
}

impl Job {
    /// Starts a new history, because the map starts anew.
    fn forget_looks(&mut self) {
        self.looks.history.clear();
        self.looks.held_since = None;
        self.looks.latest = None;
    }
}

/// The part of the passes that one slice does: a range of entries, and a range of passes over them.
fn slice_of_passes(
    context: &Context,
    tally: Tally,
    goal: u64,
    len: usize,
    rays_per_pass: f64,
) -> (Range<usize>, Range<u64>) {
    let most_rays = context.pace.rays_per_slice();
    let rays = rays_per_pass.max(1.0) * REPLICAS as f64;
    if tally.partial == 0 && rays <= most_rays {
        let times = ((most_rays / rays) as u64).min(goal - tally.complete).max(1);
        return (0..len, tally.complete..tally.complete + times);
    }
    let entries = ((len as f64 * most_rays / rays) as usize).max(1);
    (tally.partial..(tally.partial + entries).min(len), tally.complete..tally.complete + 1)
}

fn after_passes(entries: Range<usize>, times: Range<u64>, len: usize) -> Tally {
    if entries.end == len {
        Tally { complete: times.end, partial: 0 }
    } else {
        Tally { complete: times.start, partial: entries.end }
    }
}
