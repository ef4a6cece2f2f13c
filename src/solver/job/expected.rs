//! Rays and work that each method would take to reach an error, from the measurements of pilots.

use super::{Engine, Job};
use crate::maps::REPLICAS;
use crate::solver::context::Context;
use crate::solver::regions::POINTS_OF_A_BLOCK;

/// Chains per replica at which counts are judged for the first time, and walks from each point at the first look. If the pilot finds that
/// the target takes few walks, the first look comes at this share of them. Early looks make early forecasts.
const FIRST_COUNTED_CHAINS: u64 = 256;
pub(super) const FIRST_WALKS: u64 = 2;
const FEWEST_FIRST_WALKS: u64 = 1;
const SHARE_OF_FIRST_LOOK: f64 = 0.7;

/// Ratio of the walks needed from quasi-random first directions to the independent walks that a pilot predicts. In 62 receiver sets of 15
/// made-up rooms to 1 % it was between 0.3 and 1.9; this is the median.
const WALKS_OVER_PILOT: f64 = 0.7;

impl Job {
    /// Samples at which counts, or walks, are judged for the first time.
    pub(super) fn first_look(&self, engine: Engine) -> u64 {
        if engine == Engine::Collision { FIRST_COUNTED_CHAINS } else { self.walking.first_walks }
    }

    /// Walks per replica from each point before the first look, for a given target error, from the measurements of the pilot.
    pub(super) fn first_walks(&self, error: f64) -> u64 {
        let absolute_error = error * self.mean_without_gathering();
        let wanted =
            WALKS_OVER_PILOT * self.costs.indirect.variance / (absolute_error * absolute_error * REPLICAS as f64);
        ((SHARE_OF_FIRST_LOOK * wanted).ceil() as u64).clamp(FEWEST_FIRST_WALKS, FIRST_WALKS)
    }

    /// Fewest rays of one slice of its indirect light, as counted by the pilot.
    pub fn rays_at_least(&self) -> f64 {
        let entries = match self.engine {
            Engine::Walk if self.walking.sharing.neighbours > 1 => self.map.len().div_ceil(POINTS_OF_A_BLOCK),
            Engine::Walk | Engine::Gather => self.map.len(),
            _ => 1,
        };
        self.share.rays_per_indirect * REPLICAS as f64 / entries.max(1) as f64
    }

    /// Rays that counting or walking takes to `absolute_error`, from the measurements of the pilot; at least the rays to its first look.
    pub fn rays_without_gathering(&self, context: &Context, absolute_error: f64) -> f64 {
        self.without_gathering(context, absolute_error, self.costs.indirect.rays)
    }

    /// The same as work: rays, plus the cost of choosing among luminaires.
    pub fn work_without_gathering(&self, context: &Context, absolute_error: f64) -> f64 {
        let rays = self.rays_without_gathering(context, absolute_error);
        let choosing =
            if context.world.would_learn_selection_by_cell(rays) { 0.0 } else { self.costs.indirect.choosing };
        self.without_gathering(context, absolute_error, self.costs.indirect.work() + choosing)
    }

    fn without_gathering(&self, context: &Context, absolute_error: f64, rays_per_sample: f64) -> f64 {
        let to_first_look = self.first_look(Engine::unbiased(context.scene, self.kind, context.method)) as f64;
        let first_rays = to_first_look * rays_per_sample * self.map.len() as f64 * REPLICAS as f64;
        let walks = Engine::unbiased(context.scene, self.kind, context.method) == Engine::Walk;
        let over_pilot = if walks { WALKS_OVER_PILOT } else { 1.0 };
        let alone = over_pilot * self.costs.indirect.variance * rays_per_sample * self.map.len() as f64
            / (absolute_error * absolute_error);
        self.rays_with_direct(alone, absolute_error).max(self.rays_of_a_pass() + first_rays)
    }

    /// Rays of direct and indirect light together to `absolute_error`, from the rays that indirect light alone would take.
    /// The best split of rays is proportional to the square roots of what each part would take alone. But direct light has at least one
    /// pass.
    pub(super) fn rays_with_direct(&self, indirect: f64, absolute_error: f64) -> f64 {
        let direct = self.costs.direct.variance * self.costs.direct.rays * self.map.len() as f64
            / (absolute_error * absolute_error);
        let both = direct.sqrt() + indirect.sqrt();
        let pass = self.rays_of_a_pass();
        if direct.sqrt() * both >= pass {
            return both * both;
        }
        // The variance of direct light is then direct/pass of the squared error. The rest is left for indirect light.
        pass + indirect / (1.0 - direct / pass)
    }

    /// Rays of one pass over direct light in all replicas, from the measurements of the pilot.
    pub(super) fn rays_of_a_pass(&self) -> f64 {
        self.costs.direct.rays * self.map.len() as f64 * REPLICAS as f64
    }

    /// Mean of all its light in the unit of the map's values, from the measurements of the pilot.
    pub fn mean_without_gathering(&self) -> f64 {
        self.costs.direct.mean + self.costs.indirect.mean
    }
}
