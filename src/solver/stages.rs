//! What gathering adds to a run: the choice of the maps that gather, and the chains of the forward stage.

use super::choice::{self, USUAL_ERROR};
use super::forward::Forward;
use super::job::{Context, Engine, Job, Refinement, USUAL_DEGREES};
use super::plan::{
    CHAINS_SHARE, ChainCosts, GatherCosts, GatherPlan, RAYS_OF_FORWARD, gather_costs, patch_edge_m, patches_for,
    pilot_chains,
};
use super::survey::Demand;
use super::{Method, Settings};
use crate::chain::median_distance_m;
use crate::control::{GatherState, gather_need, margin};
use crate::maps::REPLICAS;

/// Where only a limit ends the run, every stage does so many times the work of the one before.
const GROWTH: f64 = 4.0;
/// The last of them may take so much more than half of the time left, and does at least so many times the work.
const LAST_SHARE: f64 = 1.6;
const LEAST_GROWTH: f64 = 2.0;
/// Errors between which such a run looks for one that it can reach.
const LEAST_AIM: f64 = 1e-4;
const MOST_AIM: f64 = 0.1;
const AIM_STEP: f64 = 1.2;
/// Share of the target, for the bias of look-ups, surely above which patches are made smaller, by how much, and how often at most.
const MOST_BIAS: f64 = 0.5;
const MORE_PATCHES: f64 = 4.0;
const MOST_REFINEMENTS: u32 = 5;
/// Chains over those from which on patches gather themselves, since the pilot counts their rays but roughly.
const REFINING_MARGIN: f64 = 1.25;
/// Deposits of a replica on a patch from which on what patches gather from each other gains little by more.
const DEPOSITS_PER_PATCH: f64 = 1.0;
/// Share of a run's rays that the forward stage may take for that.
const MOST_FOR_REFINING: f64 = 0.25;
/// A map leaves gathering for what is so many times cheaper by all that a look tells: early looks are unsure.
const LEAVING: f64 = 2.0;
/// Edges of elements that gather for those that adapt, over those of patches, before a look has told what they lose.
const BROAD_EDGES: f64 = 0.5;
/// Patches of the pilot that share its light evenly, about, below which the program does not choose gathering by itself.
const FEWEST_LIT_PATCHES: f64 = 16.0;
/// Rays of all maps together, as the first pilot expects them without gathering, below which a pilot of gathering would not pay.
const RAYS_OF_A_PILOT: f64 = 4e4;

/// The forward stage of a run, and what its pilot said.
pub struct Stages {
    /// What gathering rays look up.
    pub forward: Forward,
    chain: ChainCosts,
    /// Median way of light between surfaces, in m.
    free_path_m: f64,
    /// Error that the run is planned for.
    aim: f64,
    /// Patches that it asks for.
    patches: f64,
    /// How often patches were made smaller.
    refinements: u32,
    /// For every job what gathering costs it, if it gathers.
    costs: Vec<Option<GatherCosts>>,
    /// What rays ask of patches.
    demand: Demand,
    /// Chains of each replica at the end of the present stage.
    pub goal_chains: u64,
}

impl Stages {
    /// Pilots a run, and lets maps go over to local estimation where that is the cheapest; `None` where nothing gathers.
    pub fn pilot(context: &Context, jobs: &mut [Job], settings: &Settings) -> Option<Stages> {
        let gathers = matches!(settings.method, Method::Auto | Method::Gather);
        // All others ask cells.
        let adapts = |job: &Job| job.adaptive.is_some();
        if !gathers || !context.stage.reflects() || !jobs.iter().any(adapts) {
            return None;
        }
        let error = settings.target_error.unwrap_or(USUAL_ERROR);
        let auto = settings.method == Method::Auto;
        if auto && settings.target_error.is_some() {
            let bound = jobs.iter().filter(|job| job.bound && adapts(job));
            let rays_of = |job: &Job| job.rays_without_gathering(context, error * job.mean_without_gathering_lx());
            let without: f64 = bound.map(rays_of).sum();
            if without < RAYS_OF_A_PILOT {
                let why = "all maps together take less work than it takes to weigh it";
                choice::without_gathering(context, jobs, settings.target_error, why);
                return None;
            }
        }
        let mut forward = pilot_chains(context);
        if let Some(job) = jobs.first_mut() {
            // It serves all maps; a run that does not gather has no other place for it.
            job.pilot_rays += std::mem::take(&mut forward.rays);
        }
        let chain = ChainCosts { rays: forward.rays_per_chain(), deposits: forward.deposits_per_chain() };
        // Where the light lies in a few patches of very many, looking it up there says nothing of how it is spread in them.
        let lies_in_few = chain.deposits == 0.0 || forward.lit_patches() < FEWEST_LIT_PATCHES;
        if auto && lies_in_few {
            let why = "the light lies in few patches, where looking it up would not be exact";
            choice::without_gathering(context, jobs, settings.target_error, why);
            return None;
        }
        if chain.deposits == 0.0 {
            return None;
        }
        let edge_m = BROAD_EDGES * patch_edge_m(context, patches_for(error), f64::INFINITY);
        let measured = |job: &mut Job| {
            let counts = job.weights.iter().any(|weight| *weight > 0.0) && adapts(job);
            if counts {
                job.prepare_gathering(context, edge_m);
            }
            let costs = counts.then(|| gather_costs(context, &forward, job))?;
            job.pilot_rays += costs.pilot_rays;
            // What its pilot finds no light for is left to walks: nothing tells how many rays it takes.
            (costs.mean_lx > 0.0).then_some(costs)
        };
        let mut costs: Vec<Option<GatherCosts>> = jobs.iter_mut().map(measured).collect();
        let mut shared_chains = 0.0f64;
        for (job, costs) in jobs.iter_mut().zip(&mut costs).filter(|(job, _)| adapts(job)) {
            let by_gathering = costs.as_ref().map(|costs| {
                let error_lx = error * (costs.mean_lx + job.direct_mean_lx());
                job.work_by_gathering(context, costs, chain, error_lx, shared_chains)
            });
            let gathering =
                by_gathering.map(|(work, _)| work).ok_or("it knows no luminances, or its pilot found no light");
            if !choice::settle(context, job, choice::POINTS_ONLY, gathering, settings.target_error) {
                *costs = None;
                job.broad = None;
            } else if let Some((_, chains)) = by_gathering {
                shared_chains = shared_chains.max(chains);
            }
        }
        if costs.iter().all(Option::is_none) {
            return None;
        }
        let (free_path_m, path_rays) = median_distance_m(context.stage);
        jobs[0].pilot_rays += path_rays;
        Some(Stages {
            forward,
            chain,
            free_path_m,
            aim: error,
            patches: patches_for(error),
            refinements: 0,
            costs,
            demand: Demand::default(),
            goal_chains: 0,
        })
    }

    /// What a map needs for a target, by the pilot.
    fn needed(&self, job: &Job, costs: &GatherCosts, target: f64) -> GatherPlan {
        let degrees = USUAL_DEGREES.min(costs.entries);
        let error_lx = target * (costs.mean_lx + job.direct_mean_lx()) / margin(degrees);
        let at_once = costs.plan(self.chain, error_lx);
        costs.plan(self.chain, error_lx * job.gathered_share(at_once.rays, error_lx))
    }

    /// What every map that gathers and that the target binds needs.
    fn needs<'a>(&'a self, jobs: &'a [Job], target: f64) -> impl Iterator<Item = GatherPlan> + 'a {
        let bound = jobs.iter().zip(&self.costs).filter(|(job, _)| job.bound);
        bound.filter_map(move |(job, costs)| Some(self.needed(job, costs.as_ref()?, target)))
    }

    /// Rays, about, that these take.
    pub fn rays_to(&self, jobs: &[Job], target: f64) -> f64 {
        self.needs(jobs, target).map(|plan| plan.rays).sum()
    }

    /// Plans the first stage: with a target or a number of chains the only one, if the pilot was right.
    pub fn plan_first(&mut self, context: &Context, jobs: &mut [Job], settings: &Settings, target: f64) {
        let chains = match settings.chains {
            Some(chains) => chains as f64 / REPLICAS as f64,
            None => self.needs(jobs, target).map(|plan| plan.chains).fold(0.0, f64::max),
        };
        self.start(context, jobs, chains);
    }

    /// The least error, about, that is affordable, for a run that only a limit ends; patches become as fine as it asks for.
    pub fn aim_within(&mut self, jobs: &[Job], affordable_rays: f64) -> f64 {
        let error = least_affordable(MOST_AIM, affordable_rays, |error| self.rays_to(jobs, error));
        self.aim = error;
        self.patches = patches_for(error);
        error
    }

    /// Plans a stage of several times the work, for a run that only a limit ends; whether it is affordable.
    pub fn plan_next(&mut self, context: &Context, jobs: &mut [Job], affordable_rays: f64) -> bool {
        let rays = self.forward.rays + jobs.iter().map(Job::kept_rays).sum::<u64>();
        // These were half of what time is left for.
        let growth = (LAST_SHARE * affordable_rays / rays as f64).min(GROWTH);
        if growth >= LEAST_GROWTH {
            let chains = self.forward.chains as f64 * growth;
            self.start(context, jobs, chains);
        }
        growth >= LEAST_GROWTH
    }

    /// Patches for so many chains, and gathering rays in proportion.
    fn start(&mut self, context: &Context, jobs: &mut [Job], chains: f64) {
        let earlier_rays = self.forward.all_rays();
        let edge_m = patch_edge_m(context, self.patches, self.free_path_m);
        self.forward = Forward::new(context, edge_m);
        self.forward.earlier_rays = earlier_rays;
        let open = |job: &Job, costs: &Option<GatherCosts>| costs.filter(|_| !job.met);
        let plan = |costs: GatherCosts| costs.plan_for_chains(self.chain, chains);
        let plans: Vec<Option<GatherPlan>> =
            jobs.iter().zip(&self.costs).map(|(job, costs)| open(job, costs).map(plan)).collect();
        let planned_rays: f64 = plans.iter().flatten().map(|plan| plan.rays).sum();
        let samples: Vec<f64> = plans.iter().map(|plan| plan.map_or(0.0, |plan| plan.samples)).collect();
        self.demand = Demand::of(context, &mut self.forward, jobs, &samples, self.demand.times);
        self.share(context, &samples);
        for (index, plan) in plans.into_iter().enumerate() {
            if let (Some(plan), Some(costs)) = (plan, self.costs_of(index)) {
                jobs[index].start_gathering(context, &costs, plan.samples, plan.checked_share);
            }
        }
        // Patches that do not gather themselves show corners too flat: what is still missing to that is worth it.
        let to_refine = REFINING_MARGIN * self.forward.chains_to_refine(self.chain.rays);
        let rays_to_refine = to_refine * self.chain.rays * RAYS_OF_FORWARD * REPLICAS as f64;
        // Where they gather for all that ask them, what they find must not hang on whether a packet came by.
        let dense = DEPOSITS_PER_PATCH * self.forward.patch_count() as f64 / self.chain.deposits;
        let affordable = MOST_FOR_REFINING * planned_rays / (self.chain.rays * REPLICAS as f64);
        let goal_chains = if self.forward.rays_to_share().is_some() {
            chains.max(dense.min(affordable))
        } else if rays_to_refine <= MOST_FOR_REFINING * planned_rays {
            chains.max(to_refine)
        } else {
            // Deposits alone take more chains.
            chains.max((chains / CHAINS_SHARE).min(to_refine))
        };
        self.goal_chains = (goal_chains.ceil() as u64).max(1);
    }

    /// Lets patches take samples for all rays where that pays, if maps take so many of every entry.
    fn share(&mut self, context: &Context, samples: &[f64]) {
        // Spots of luminaires that are close to surfaces are looked back from, which patches know nothing of; where nothing is
        // checked nothing would take off what they have wrong.
        let may_tell = context.stage.near_lights.is_none() && context.stage.paths_not_found.is_empty();
        let sharing = self.demand.sharing(samples);
        self.forward.share(sharing.map(|sharing| (sharing, may_tell.then_some(self.aim))));
    }

    /// Goes on with a map whose elements were cut; its share of the plan stays what the chains are right for.
    pub fn refined(&mut self, context: &Context, jobs: &mut [Job], index: usize, refinement: Refinement) {
        let job = &mut jobs[index];
        if let Some(costs) = &mut self.costs[index] {
            costs.entries = job.gathered().len() as f64;
        }
        let Some(costs) = self.costs_of(index) else {
            return;
        };
        if refinement == Refinement::Anew {
            let samples = job.planned_samples as f64;
            job.start_gathering(context, &costs, samples, job.checked_share());
        } else {
            job.share_out(&costs);
        }
    }

    /// What gathering costs a map with patches as they are.
    fn costs_of(&self, index: usize) -> Option<GatherCosts> {
        let costs = self.costs[index]?;
        Some(costs.knowing_direct(self.forward.told_share()))
    }

    /// Decides after a look how a map that gathers goes on to its target: with more rays, or with more chains and its
    /// rays anew.
    ///
    /// Where `may_leave` and walks or counting would be done with fewer rays than it still takes, the map goes over to them.
    /// What would take more than the affordable rays is not begun anew: a limit would come before its end.
    pub fn replan(
        &mut self,
        context: &Context,
        jobs: &mut [Job],
        index: usize,
        target: f64,
        may_leave: bool,
        affordable_rays: f64,
    ) {
        // The bias falls about as the edge of patches.
        let excess = jobs[index].judgement.least_bias / (MOST_BIAS * target);
        let steps = (excess.powi(2).log(MORE_PATCHES).ceil().max(0.0) as u32).min(MOST_REFINEMENTS - self.refinements);
        if steps > 0 && MORE_PATCHES * jobs[index].kept_rays() as f64 <= affordable_rays {
            self.refinements += steps;
            self.patches *= MORE_PATCHES.powi(steps as i32);
            let chains = self.goal_chains as f64;
            self.start(context, jobs, chains);
            return;
        }
        let job = &mut jobs[index];
        if job.judgement.mean_lx <= 0.0 {
            // Nothing was found yet, of which nothing follows.
            job.planned_samples = 2 * job.samples;
            return;
        }
        let mean_squared = job.judgement.mean_lx.powi(2) * REPLICAS as f64;
        let crossed = job.variances;
        let [rows, columns, cells, direct] =
            [crossed.rows, crossed.columns, crossed.cells, job.direct_variance].map(|variance| variance / mean_squared);
        job.share_anew(direct, rows);
        let [direct_rays, gather_rays] = job.rays_by_plan(job.samples);
        let state = GatherState {
            rows,
            columns,
            cells,
            direct,
            degrees_of_columns: job.variances.degrees_of_columns,
            ray_exponent: job.rows.exponent(),
            gather_rays,
            unplanned_rays: gather_rays * (1.0 - job.first_plan() as f64 / job.samples as f64).max(0.0),
            direct_rays,
            direct_done: job.direct_rays_done(),
            direct_ahead: job.direct_rays_done() / direct_rays.max(f64::MIN_POSITIVE),
            chain_rays: self.forward.chain_rays() as f64,
            patch_rays: self.forward.patch_rays() as f64,
        };
        let need = gather_need(target, &job.judgement, &state);
        let error_lx = target * job.judgement.mean_lx / margin(job.judgement.degrees_of_freedom);
        let without = job.rays_without_gathering(context, error_lx);
        if may_leave && need.rays > LEAVING * without && without <= affordable_rays {
            job.method_reason = compared("a look in the run", target, need.rays, without);
            job.stop_gathering();
            self.costs[index] = None;
            return;
        }
        let planned_before = job.planned_samples;
        job.planned_samples = ((job.samples as f64 * need.samples).ceil() as u64).max(job.samples + 1);
        if need.chains == 1.0 {
            return;
        }
        if need.rays > affordable_rays {
            job.planned_samples = 2 * job.samples;
            return;
        }
        self.goal_chains = (self.forward.chains as f64 * need.chains).ceil() as u64;
        // Patches take as many times more, whatever is planned now.
        self.demand.times *= need.chains * planned_before as f64 / jobs[index].planned_samples as f64;
        let gathers = |job: &Job, costs: &Option<GatherCosts>| costs.is_some() && !job.met;
        let samples_of = |(job, costs): (&Job, &Option<GatherCosts>)| {
            if gathers(job, costs) { job.planned_samples as f64 } else { 0.0 }
        };
        let samples: Vec<f64> = jobs.iter().zip(&self.costs).map(samples_of).collect();
        self.share(context, &samples);
        for (index, job) in jobs.iter_mut().enumerate() {
            if let Some(costs) = self.costs_of(index)
                && !job.met
            {
                let samples = job.planned_samples as f64;
                let error_lx = target * (costs.mean_lx + job.direct_mean_lx());
                let checked_share = costs.checked_share(samples, error_lx);
                job.start_gathering(context, &costs, samples, checked_share);
            }
        }
    }

    /// Chains of all replicas that the forward stage is still to trace, and the rays that this takes.
    pub fn left(&self) -> (f64, f64) {
        let chains = (self.goal_chains.saturating_sub(self.forward.chains) * REPLICAS as u64) as f64;
        let rays = match self.forward.rays_to_share() {
            _ if chains == 0.0 => 0.0,
            Some(rays) => chains * self.chain.rays + rays,
            None => chains * self.chain.rays * RAYS_OF_FORWARD,
        };
        (chains, rays)
    }

    /// Chains up to which the next slice traces, about so many rays long.
    pub fn slice(&self, rays: f64) -> u64 {
        let chains = (rays / (self.chain.rays.max(1.0) * REPLICAS as f64)).ceil() as u64;
        (self.forward.chains + chains.max(1)).min(self.goal_chains)
    }

    /// Whether a job has had the samples that its plan gave it and half as many again.
    pub fn is_overdrawn(&self, job: &Job) -> bool {
        job.engine == Engine::Gathering && 2 * job.samples >= 3 * job.planned_samples
    }
}

/// The least error up to about `most` that takes no more than the affordable rays, for a run that only a limit ends.
pub fn least_affordable(most: f64, affordable_rays: f64, rays_to: impl Fn(f64) -> f64) -> f64 {
    let mut error = LEAST_AIM;
    while error < most && rays_to(error) > affordable_rays {
        error *= AIM_STEP;
    }
    error
}

/// Why one of two ways was taken: rays that each would take.
fn compared(by: &str, error: f64, gathering_rays: f64, rays_without: f64) -> String {
    format!(
        "by {by}, {gathering_rays:.1e} rays to {} % by gathering and {rays_without:.1e} without",
        (error * 1e4).round() / 100.0
    )
}
