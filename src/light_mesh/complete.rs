//! Maps whose points are computed one by one, where this is cheaper than a mesh. Shadow rays and walks from every point are added in rounds
//! until random error takes at most its part of the target.

use super::entries::Entries;
use super::exact::light_samples_are_exact;
use super::options::{HURRIED_PLACE_WALKS, SHARE_OF_ALL, SHARE_OF_DIRECT};
use super::plan::{DirectPlan, IndirectPlan, MapPlan, Planner};
use super::plan_indirect::LEAST_INDIRECT;
use super::tracing::{DirectBy, Effort, EntryLight, IndirectBy, mean_value, random_error};
use super::walks::HALVES;
use crate::control::ONE_IN_TWENTY;

/// Largest number of passes of shadow rays in each half, where these have random error.
const MOST_PASSES: u64 = 1 << 20;
/// Largest number of walks from a receiver point.
const MOST_WALKS: u32 = 1 << 20;
/// Walks from a receiver point in the first round.
const FIRST_ROUND_WALKS: u32 = 16;
/// Approximate number of rays in a round. The clock and the error are checked after each round.
const RAYS_OF_ROUND: f64 = 1e6;

/// Rounds that have been run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rounds {
    /// Passes of shadow rays over all luminaires in each half.
    pub passes: u64,
    /// Walks from every receiver point.
    pub walks: u32,
}

impl Planner<'_> {
    /// Whether shadow rays from every receiver point have no random error.
    pub(super) fn rays_are_exact(&self, entries: &Entries) -> bool {
        light_samples_are_exact(self.around.world) && !entries.are_means() && !entries.show_gloss()
    }

    /// Completes the part of the map that the plan leaves to the receiver points.
    pub(super) fn complete(
        &self,
        entries: &Entries,
        map: u32,
        plan: &MapPlan,
        lights: &mut [EntryLight],
        effort: &mut Effort,
    ) -> Rounds {
        let mut rounds = Rounds::default();
        if matches!(plan.direct, DirectPlan::Rays(_)) {
            self.complete_direct(entries, map, plan, lights, effort, &mut rounds);
        }
        if matches!(plan.indirect, IndirectPlan::Walks(_)) {
            self.complete_indirect(entries, map, plan, lights, effort, &mut rounds);
        }
        rounds
    }

    /// Returns the target in the unit of the map's values for a map of this brightness, reduced for the random error of the last check.
    fn target(&self, entries: &Entries, lights: &[EntryLight]) -> Option<f64> {
        // With k points, each with an independent difference, the estimate of the error is too small by this factor in one case in twenty.
        let places = entries.weights.iter().filter(|weight| **weight > 0.0).count().max(1) as f64;
        let short = 1.0 + ONE_IN_TWENTY / (2.0 * places).sqrt();
        self.wishes.target_error.map(|target| self.caution * target * mean_value(entries, lights) / short)
    }

    fn complete_direct(
        &self,
        entries: &Entries,
        map: u32,
        plan: &MapPlan,
        lights: &mut [EntryLight],
        effort: &mut Effort,
        rounds: &mut Rounds,
    ) {
        let mut more = 1;
        loop {
            let by_rays = DirectBy::Rays { first: rounds.passes, passes: more };
            let (found, took) = self.light_of_all(entries, &by_rays, &IndirectBy::Nothing, map);
            *effort += took;
            let (before, now) = (rounds.passes as f64, more as f64);
            for (light, found) in lights.iter_mut().zip(found) {
                light.direct = joined([before, now], [light.direct, found.direct]);
                light.is_known = found.is_known;
            }
            rounds.passes += more;
            let random_error = random_error(entries, lights, |light| light.direct);
            // If indirect light is still missing, its part of the brightness is unknown. The target is computed as if it were 0.
            let share = if matches!(plan.indirect, IndirectPlan::Nothing) { SHARE_OF_ALL } else { SHARE_OF_DIRECT };
            let goes_on = self.target(entries, lights).is_some_and(|target| random_error > share * target);
            if !goes_on || rounds.passes >= MOST_PASSES || (self.stop)() {
                return;
            }
            let rays_of_pass = (took.exact_rays as f64 / now).max(1.0);
            let excess = self.target(entries, lights).map_or(1.0, |target| random_error / (share * target));
            let missing = missing(rounds.passes as f64, excess);
            more = rounds.passes.min((RAYS_OF_ROUND / rays_of_pass) as u64).min(missing as u64).max(1);
        }
    }

    fn complete_indirect(
        &self,
        entries: &Entries,
        map: u32,
        plan: &MapPlan,
        lights: &mut [EntryLight],
        effort: &mut Effort,
        rounds: &mut Rounds,
    ) {
        let none = DirectBy::Rays { first: 0, passes: 0 };
        let direct = plan.direct_upper.hypot(random_error(entries, lights, |light| light.direct));
        // Gloss shows many surface points, each of which is a small part of a direction.
        let mut more = match (self.stop)() {
            _ if entries.show_gloss() && !entries.draw_lines_of_sight() => HALVES as u32,
            true => HURRIED_PLACE_WALKS,
            false => FIRST_ROUND_WALKS,
        };
        loop {
            let by_walks = IndirectBy::Walks([rounds.walks, more]);
            let (found, took) = self.light_of_all(entries, &none, &by_walks, map);
            *effort += took;
            let (before, now) = (f64::from(rounds.walks), f64::from(more));
            for (light, found) in lights.iter_mut().zip(found) {
                light.indirect = joined([before, now], [light.indirect, found.indirect]);
            }
            rounds.walks += more;
            let random_error = random_error(entries, lights, |light| light.indirect);
            let target = self.target(entries, lights).unwrap_or(f64::INFINITY);
            let square = ((SHARE_OF_ALL * target).powi(2) - direct.powi(2)).max((LEAST_INDIRECT * target).powi(2));
            if random_error.powi(2) <= square || rounds.walks >= MOST_WALKS || (self.stop)() {
                return;
            }
            let rays_of_walk = (took.gather.walk_rays as f64 / now).max(1.0);
            let of_round = (RAYS_OF_ROUND / rays_of_walk) as u32;
            let missing = missing(f64::from(rounds.walks), random_error / square.sqrt());
            more = rounds.walks.min(of_round).min(missing as u32).max(2).next_multiple_of(2);
        }
    }
}

/// Returns the number of missing samples. The random error of `samples` samples is `excess` times the allowed one, and falls at least with
/// the square root of their number.
fn missing(samples: f64, excess: f64) -> f64 {
    (samples * (excess * excess - 1.0)).ceil()
}

/// Returns the means of two halves over the earlier and the new samples.
fn joined([before, now]: [f64; 2], [known, found]: [[f64; 2]; 2]) -> [f64; 2] {
    [0, 1].map(|half| (before * known[half] + now * found[half]) / (before + now))
}
