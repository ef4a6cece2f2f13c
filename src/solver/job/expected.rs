//! What a pilot lets a map expect of its methods.

use super::{Context, Engine, Job};
use crate::control::margin;
use crate::maps::REPLICAS;
use crate::solver::plan::{ChainCosts, GatherCosts};

/// Chains of a replica at which counts are judged for the first time, and walks from each point.
const FIRST_COUNTED_CHAINS: u64 = 256;
const FIRST_WALKS: u64 = 4;

/// Degrees of freedom of the error of a large map that is gathered, about: neighbours share the chains' chance. Of a small
/// one they are a third of its entries.
pub const USUAL_DEGREES: f64 = 100.0;
const DEGREES_OF_AN_ENTRY: f64 = 1.0 / 3.0;
/// Chains that the looks of a run ask for, over those of its first plan. Measured: 23 to 28 on nine and on 48 points, 6 on
/// 768, where chains are a small share of all rays.
const CHAINS_OF_LOOKS: f64 = 20.0;

/// Samples at which counts, or walks, are judged for the first time.
pub fn first_look(engine: Engine) -> u64 {
    if engine == Engine::Counting { FIRST_COUNTED_CHAINS } else { FIRST_WALKS }
}

impl Job {
    /// Rays that counting or walking takes to an error in lx, by what the pilot measured: at least those to its first look.
    pub fn rays_without_gathering(&self, context: &Context, error_lx: f64) -> f64 {
        self.without_gathering(context, error_lx, self.indirect.rays)
    }

    /// The same in work: rays, and what choosing among luminaires takes beside them.
    pub fn work_without_gathering(&self, context: &Context, error_lx: f64) -> f64 {
        let rays = self.rays_without_gathering(context, error_lx);
        let choosing =
            if context.stage.would_look_out(context.scene.area_m2(), rays) { 0.0 } else { self.indirect.choosing };
        self.without_gathering(context, error_lx, self.indirect.rays + choosing)
    }

    fn without_gathering(&self, context: &Context, error_lx: f64, rays_per_sample: f64) -> f64 {
        let to_first_look = first_look(Engine::unbiased(self.kind, context.method)) as f64;
        let first_rays = to_first_look * rays_per_sample * self.map.len() as f64 * REPLICAS as f64;
        let alone = self.indirect.variance * rays_per_sample * self.map.len() as f64 / (error_lx * error_lx);
        self.rays_with_direct(alone, error_lx).max(self.rays_of_a_pass() + first_rays)
    }

    /// Rays of direct light and of indirect light that go with so many samples, by what the pilot counted.
    pub fn rays_by_plan(&self, samples: u64) -> [f64; 2] {
        let indirect = samples as f64 * self.share.rays_per_indirect * REPLICAS as f64;
        let passes = samples as f64 * self.share.passes_per_sample;
        [passes * self.share.rays_per_pass * REPLICAS as f64, indirect]
    }

    /// Rays of the direct light that is done, by the same.
    pub fn direct_rays_done(&self) -> f64 {
        self.map.direct_samples.complete as f64 * self.share.rays_per_pass * REPLICAS as f64
    }

    /// Work of gathering to an error in lx, by what the pilots measured, in rays, and the chains of a replica for it.
    ///
    /// `shared` chains are traced for other maps anyway. The first plan is a guess that looks mend, which costs few points
    /// most: chains are most of their rays, and of the few degrees of freedom that they have the stop rule asks more margin.
    pub fn work_by_gathering(
        &self,
        context: &Context,
        costs: &GatherCosts,
        chain: ChainCosts,
        error_lx: f64,
        shared: f64,
    ) -> (f64, f64) {
        let degrees = (DEGREES_OF_AN_ENTRY * costs.entries).min(USUAL_DEGREES);
        let safe_error_lx = error_lx * margin(USUAL_DEGREES) / margin(degrees);
        let in_rays = costs.plan(chain, safe_error_lx);
        let looks_out = context.stage.would_look_out(context.scene.area_m2(), in_rays.rays);
        let plan = if looks_out { in_rays } else { costs.with_choosing().plan(chain, safe_error_lx) };
        let chains = CHAINS_OF_LOOKS * plan.chains;
        let more = (chains - shared).max(0.0) - plan.chains;
        (self.rays_with_direct(plan.rays + REPLICAS as f64 * more * chain.rays, error_lx), chains)
    }

    /// Rays of direct and indirect light together to an error in lx, from those that indirect light would take alone.
    ///
    /// Rays are best shared out like the roots of what either would take alone; but direct light has one pass at least.
    pub(super) fn rays_with_direct(&self, indirect: f64, error_lx: f64) -> f64 {
        let direct = self.direct.variance * self.direct.rays * self.map.len() as f64 / (error_lx * error_lx);
        let both = direct.sqrt() + indirect.sqrt();
        let pass = self.rays_of_a_pass();
        if direct.sqrt() * both >= pass {
            return both * both;
        }
        // Its chance is then direct/pass of the squared error, and the rest is for the indirect light.
        pass + indirect / (1.0 - direct / pass)
    }

    /// Rays of one pass over direct light in all replicas, by what the pilot measured.
    pub(super) fn rays_of_a_pass(&self) -> f64 {
        self.direct.rays * self.map.len() as f64 * REPLICAS as f64
    }

    /// Mean of all its light in lx, by what the pilot measured.
    pub fn mean_without_gathering_lx(&self) -> f64 {
        self.direct.mean_lx + self.indirect.mean_lx
    }

    /// Mean of its direct light in lx, by what the pilot measured.
    pub fn direct_mean_lx(&self) -> f64 {
        self.direct.mean_lx
    }

    /// Share of an error that chains and gathering rays may have, the rest being that of direct light: variances are best
    /// shared out like the roots of variance times cost, which for the gathered part follow from its rays to the error.
    pub fn gathered_share(&self, rays: f64, error_lx: f64) -> f64 {
        let direct = (self.direct.variance * self.direct.rays * self.map.len() as f64).sqrt();
        let gathered = rays.sqrt() * error_lx;
        (gathered / (gathered + direct)).sqrt()
    }
}
