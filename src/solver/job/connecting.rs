//! Local estimation that a run chooses by itself: its expected cost, the switch to it and the switch back to walks.

use serde::{Deserialize, Serialize};

use super::engine::first_rounds;
use super::{Engine, Job};
use crate::maps::REPLICAS;
use crate::solver::context::Context;
use crate::solver::local::{Kernel, LocalPlan};
use crate::solver::pilot::DirectShare;

/// First looks that a run needs at least. The statistical checks seldom accept the first look, because it has few scores.
const LEAST_LOOKS: f64 = 2.0;

/// Local estimation as an option for a map.
#[derive(Serialize, Deserialize)]
pub struct Offer {
    pub plan: LocalPlan,
    /// Work to the target. It includes no work for light sampling: chains begin at luminaires and choose none.
    pub work: f64,
}

/// Local estimation, or the reason why it was not considered.
pub type Offered = Result<Offer, &'static str>;

impl Job {
    /// Does rounds until `until` are complete. A round that a limit ends counts nothing.
    pub(super) fn connect_until(&mut self, context: &Context, set: usize, until: u64) {
        let done = self.map.indirect_samples.complete;
        if let Some(plan) = &self.connecting.plan
            && let Some(rays) = plan.rounds(context, set, &mut self.map, done..until)
        {
            self.work.rays += rays;
            self.map.indirect_samples.complete = until;
        }
    }

    /// Rays that local estimation takes to `absolute_error`, from the measurements of its pilot; at least the rays to its first looks.
    /// All points share the random error of its chains. With so few degrees of freedom the stop rule requires a wide margin.
    pub fn rays_by_connecting(&self, plan: &LocalPlan, absolute_error: f64) -> f64 {
        let cost = plan.cost(&self.weights);
        let safe_error = absolute_error / plan.margin;
        let variance = cost.variance / plan.quasi_gain;
        let alone = variance * plan.rays_per_round / (safe_error * safe_error);
        let first = LEAST_LOOKS * first_rounds(plan.chains_per_round, plan.rays_per_round) as f64;
        let first_rays = first * plan.rays_per_round * REPLICAS as f64;
        self.rays_with_direct(alone, absolute_error).max(self.rays_of_a_pass() + first_rays)
    }

    /// Uses local estimation instead of walks. No work on the map has been done yet.
    pub fn start_connecting(&mut self, plan: LocalPlan) {
        self.share = DirectShare::of(self.costs.direct, plan.cost(&self.weights), [self.map.len(); 2]);
        self.engine = Engine::Local(Kernel::Bounded);
        self.connecting.plan = Some(plan);
    }

    /// Goes back to walks. Direct light keeps its samples.
    pub fn stop_connecting(&mut self) {
        self.begin_walks_anew();
        self.connecting.plan = None;
        self.engine = Engine::Walk;
        self.share = DirectShare::of(self.costs.direct, self.costs.indirect, [self.map.len(); 2]);
    }

    /// Whether the map uses local estimation.
    pub fn connects(&self) -> bool {
        self.connecting.plan.is_some()
    }
}
