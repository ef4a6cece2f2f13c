//! Plans the indirect light of a map: a fine enough mesh step and enough walks for a small random error, or walks from every receiver point
//! where these take fewer rays.

use super::entries::Entries;
use super::indirect::{Gathering, HURRIED_WALKS, IndirectMesh};
use super::judge::{Checked, INDIRECT_PLACES, choose};
use super::options::{FIRST_CHECK_WALKS, HURRIED_PLACE_WALKS, IndirectForm, SHARE_OF_ALL, SHARE_OF_DIRECT};
use super::plan::{
    DirectPlan, FIRST_STEPS, IndirectPlan, MOST_REFINEMENTS, MapPlan, PLANNING, Planner, Why, half_ball, mean,
    points_needed, side_m,
};
use super::tracing::{DirectBy, EntryLight, IndirectBy, light_of};
use crate::control::ONE_IN_TWENTY;

/// Ratio of the step for indirect light to the user's step. Indirect light varies more smoothly.
const INDIRECT_COARSER: f64 = 3.0;
/// Ratio of radius to step for the sets over which directional indirect light is fitted.
const DIRECTIONAL_RADIUS_PER_STEP: f64 = 2.1;
/// Walks from a mesh point in the first trial.
const FIRST_WALKS: u32 = 512;
/// Least and largest number of walks from a mesh point.
const WALKS: [u32; 2] = [64, 1 << 15];
/// Largest factor by which the next trial has more walks.
const MOST_MORE_WALKS: f64 = 16.0;
/// Random error of indirect light, relative to its mean, without a target.
const QUIET: f64 = 0.007;
/// Largest number of walks from a mesh point without a target.
const MOST_QUIET_WALKS: u32 = 8192;
/// Walks in each half from a checked point for estimating the mean and the noise of indirect light.
const PILOT_WALKS: u64 = 64;
/// Largest number of walks in each half from a checked point.
const MOST_CHECK_WALKS: u64 = 16_384;
/// Part of the squared error allowed for indirect light that the mesh's step may take.
const SHARE_OF_STEP: f64 = 0.55;
/// Part of that squared error that random error may take. The rest is left to the random error of the last check.
const SHARE_OF_CHANCE: f64 = 0.3;
/// Least part of the target for indirect light, whatever direct light has used.
pub(super) const LEAST_INDIRECT: f64 = 0.3;
/// Half the step must leave less than this part of the squared error.
const HELPED: f64 = 0.8;
/// Part of the rays for walks from every receiver point that the search for a mesh may take.
const SHARE_OF_SEARCH: f64 = 0.25;
/// Random error below this part of the value to be measured is acceptable.
const LITTLE: f64 = 0.3;

/// A mesh with its error at the checked points.
struct Trial<'a> {
    /// The mesh.
    mesh: IndirectMesh<'a>,
    /// Light of the checked points from the mesh.
    lights: Vec<EntryLight>,
    /// Squared random error from its walks, in the squared unit of the map's values.
    of_chance: f64,
    /// Number of mesh points at which light was gathered.
    points: f64,
    /// Rays of one walk from one mesh point.
    rays_per_walk: f64,
    /// All rays of the trial.
    rays: f64,
}

impl Trial<'_> {
    /// Returns the squared error from the step, in the squared unit of the map's values, and its standard error.
    fn of_step(&self, checked: &Checked) -> (f64, f64) {
        let measured = checked.compare(self.lights.iter().copied());
        ((measured.mean - self.of_chance).max(0.0), measured.standard_error)
    }

    /// Returns the walks from each mesh point that keep the random error within its part of the allowed squared error.
    fn walks_needed(&self, allowed: f64) -> u32 {
        let needed = f64::from(self.mesh.gathering.walks) * self.of_chance / (SHARE_OF_CHANCE * allowed);
        (needed.clamp(f64::from(WALKS[0]), f64::from(WALKS[1])) as u32).next_multiple_of(2)
    }
}

impl Planner<'_> {
    /// Returns the squared error from the step of a trial, in the squared unit of the map's values, for comparison with its limit `most`. If
    /// the check has the larger random error, it gets more walks. `None` if the result stays uncertain because the mesh has the larger
    /// random error.
    fn measured_step(&self, entries: &Entries, trial: &Trial, checked: &mut Checked, most: f64) -> Option<f64> {
        loop {
            let (of_step, standard_error) = trial.of_step(checked);
            let is_clear = (of_step - most).abs() > ONE_IN_TWENTY * standard_error;
            let of_check = checked.variance_of_walk() / checked.walks as f64;
            let asks_more = !is_clear && of_check > trial.of_chance.max(LITTLE * most);
            if !asks_more || checked.walks >= MOST_CHECK_WALKS || (self.stop)() {
                let walks = trial.mesh.gathering.walks;
                let is_reported = is_clear || walks >= WALKS[1] || trial.of_chance < LITTLE * most;
                return is_reported.then_some(of_step);
            }
            checked.add(&self.around, entries, checked.walks, self.stop);
        }
    }

    /// Sets have two layers, so that the slope across them can be fitted. Sets of the paper's form are means and as close as possible.
    fn indirect_radius_per_step(&self) -> f64 {
        match (self.wishes.radius_m, self.wishes.form) {
            (None, IndirectForm::Directional) => DIRECTIONAL_RADIUS_PER_STEP,
            _ => self.radius_per_step(),
        }
    }

    fn indirect_step_m(&self, entries: &Entries) -> f64 {
        let given_m = self.wishes.step_m.map(|step_m| INDIRECT_COARSER * step_m);
        given_m.unwrap_or_else(|| side_m(entries) / FIRST_STEPS)
    }

    /// Traces a few walks from some points to estimate the mean of indirect light and the random error of a walk.
    pub(super) fn pilot(&self, entries: &Entries, map: u32, plan: &mut MapPlan) -> Checked {
        let chosen = choose(entries, INDIRECT_PLACES, self.wishes.seed, PLANNING + map);
        let mut checked = Checked::of(chosen, self.wishes.seed, PLANNING + map);
        checked.add(&self.around, entries, PILOT_WALKS, self.stop);
        plan.check_rays += checked.rays;
        checked
    }

    /// Adds enough walks to measure the error of a first mesh.
    fn add_to_pilot(&self, entries: &Entries, checked: &mut Checked, plan: &mut MapPlan) {
        let before = checked.rays;
        checked.add(&self.around, entries, FIRST_CHECK_WALKS.saturating_sub(checked.walks), self.stop);
        plan.check_rays += checked.rays - before;
    }
}

impl<'a> Planner<'a> {
    /// Plans indirect light within the part of the target that direct light leaves.
    pub(super) fn plan_indirect(
        &self,
        entries: &Entries,
        map: u32,
        target_error: f64,
        mut checked: Checked,
        plan: &mut MapPlan<'a>,
    ) {
        let allowed = self.allowed_indirect(entries, map, target_error, &checked, plan).powi(2);
        let counted = entries.weights.iter().filter(|weight| **weight > 0.0).count();
        let walks_of_places = (checked.variance_of_walk() / allowed.max(f64::MIN_POSITIVE)).max(16.0);
        let rays_by_places = walks_of_places * counted as f64 * checked.rays_per_walk();

        if self.around.world.near_luminaires.is_some()
            && (self.wishes.form == IndirectForm::Scalar || !plan.connects_to_packets(&self.around, entries))
        {
            plan.indirect = IndirectPlan::Walks(Why::NearLuminaires);
            return;
        }
        let is_requested = self.wishes.step_m.is_some();
        let ratio = self.indirect_radius_per_step();
        let mut step_m = self.indirect_step_m(entries);
        let mut walks = FIRST_WALKS;
        let mut rays_per_walk = checked.rays_per_walk();
        let (mut spent, mut coarser) = (0.0, None);
        let mut last: Option<Trial> = None;
        for _ in 0..2 * MOST_REFINEMENTS {
            let points = points_needed(entries, step_m, ratio * step_m);
            let points_of_trial = points.min(half_ball(ratio) * checked.chosen.len() as f64);
            let search = spent + points_of_trial * f64::from(walks) * rays_per_walk;
            if !is_requested && search > SHARE_OF_SEARCH * rays_by_places {
                break;
            }
            self.add_to_pilot(entries, &mut checked, plan);
            let gathering = Gathering { step_m, radius_m: ratio * step_m, walks, form: self.wishes.form };
            let Some(trial) = self.try_mesh(entries, map, gathering, &checked, plan) else { break };
            if (self.stop)() {
                // This trial may be incomplete, with fewer walks, as the remaining points would have. The previous trial is complete.
                plan.indirect = match last {
                    Some(last) => {
                        let walks = last.mesh.gathering.walks;
                        best_when_cut(last, walks, &checked, points)
                    }
                    None => best_when_cut(trial, HURRIED_WALKS, &checked, points),
                };
                return;
            }
            spent += trial.rays;
            rays_per_walk = trial.rays_per_walk;
            let most = SHARE_OF_STEP * allowed;
            let (rays_before, walks_before) = (checked.rays, checked.walks);
            let of_step = self.measured_step(entries, &trial, &mut checked, most);
            spent += (checked.rays - rays_before) as f64;
            plan.check_rays += checked.rays - rays_before;
            if (checked.rays, checked.walks) != (rays_before, walks_before) {
                plan.check_walks = checked.walks;
            }
            if (self.stop)() {
                plan.indirect = best_when_cut(trial, walks, &checked, points);
                return;
            }
            let Some(of_step) = of_step else {
                walks = more_walks(walks, 4.0);
                last = Some(trial);
                continue;
            };
            if of_step <= most {
                let walks = trial.walks_needed(allowed);
                let is_dearer = points * f64::from(walks) * rays_per_walk >= rays_by_places;
                let gathering = Gathering { walks, ..gathering };
                let seed = self.wishes.seed;
                if (is_requested || !is_dearer)
                    && let Some(mesh) = IndirectMesh::new(self.around, entries, gathering, seed, self.stop)
                {
                    plan.indirect = IndirectPlan::Mesh(Box::new(mesh));
                    return;
                }
                break;
            }
            if is_requested {
                let error = of_step.sqrt() / self.whole_light(entries, map, &checked, plan).max(f64::MIN_POSITIVE);
                plan.indirect = IndirectPlan::Walks(Why::StepMisses(error));
                return;
            }
            let spread = ONE_IN_TWENTY * trial.of_step(&checked).1;
            if coarser.is_some_and(|coarser: f64| of_step - spread > HELPED * coarser) {
                plan.indirect = IndirectPlan::Walks(Why::NotSmooth(step_m));
                return;
            }
            coarser = Some(of_step + spread);
            step_m *= 0.5;
            // The error from the step is much smaller now. Measuring this does not require the walks of the previous step.
            walks = FIRST_WALKS;
            last = Some(trial);
        }
        plan.indirect = IndirectPlan::Walks(Why::Cheaper(step_m));
    }

    /// Returns the allowed error of indirect light in the unit of the map's values: the part that direct light leaves.
    fn allowed_indirect(
        &self,
        entries: &Entries,
        map: u32,
        target_error: f64,
        checked: &Checked,
        plan: &mut MapPlan,
    ) -> f64 {
        let target = target_error * self.whole_light(entries, map, checked, plan);
        let of_direct = match plan.direct {
            DirectPlan::Mesh(_) => plan.direct_upper,
            DirectPlan::Rays(Why::Dark) => 0.0,
            DirectPlan::Rays(_) if self.rays_are_exact(entries) => 0.0,
            DirectPlan::Rays(_) => SHARE_OF_DIRECT * target,
        };
        let square = (SHARE_OF_ALL * target).powi(2) - of_direct.powi(2);
        square.max((LEAST_INDIRECT * target).powi(2)).sqrt()
    }

    /// Returns the mean of all light in the unit of the map's values, from few shadow rays and from walks of the checked points.
    fn whole_light(&self, entries: &Entries, map: u32, checked: &Checked, plan: &mut MapPlan) -> f64 {
        let by_rays = DirectBy::Rays { first: 0, passes: 1 };
        let (seed, map) = (self.wishes.seed, PLANNING + map);
        let (lights, effort) =
            light_of(&self.around, entries, &checked.chosen, &by_rays, &IndirectBy::Nothing, seed, map);
        plan.effort += effort;
        checked.mean() + mean(lights.iter().map(EntryLight::direct_mean))
    }

    /// Gathers light for the checked points and compares.
    fn try_mesh(
        &self,
        entries: &Entries,
        map: u32,
        gathering: Gathering,
        checked: &Checked,
        plan: &mut MapPlan,
    ) -> Option<Trial<'a>> {
        let (seed, map) = (self.wishes.seed, PLANNING + map);
        let mesh = IndirectMesh::new(self.around, entries, gathering, seed, self.stop)?;
        let none = DirectBy::Rays { first: 0, passes: 0 };
        let (lights, effort) =
            light_of(&self.around, entries, &checked.chosen, &none, &IndirectBy::Mesh(&mesh), seed, map);
        plan.effort += effort;
        let of_chance = mean(lights.iter().map(|light| 0.25 * (light.indirect[0] - light.indirect[1]).powi(2)));
        let walks = effort.gather.points as f64 * f64::from(gathering.walks);
        let rays_per_walk = effort.gather.walk_rays as f64 / walks.max(1.0);
        Some(Trial {
            mesh,
            lights,
            of_chance,
            rays_per_walk,
            points: effort.gather.points as f64,
            rays: effort.rays() as f64,
        })
    }

    /// Plans indirect light without a target: the mesh as set, with enough walks to make random error invisible, if the map's limit of rays
    /// allows them.
    pub(super) fn plan_quietly(&self, entries: &Entries, map: u32, plan: &mut MapPlan<'a>) {
        let (step_m, ratio) = (self.indirect_step_m(entries), self.indirect_radius_per_step());
        let mut checked = self.pilot(entries, map, plan);
        self.add_to_pilot(entries, &mut checked, plan);
        let quiet = (QUIET * checked.mean()).powi(2);
        let mut gathering = Gathering { step_m, radius_m: ratio * step_m, walks: FIRST_WALKS, form: self.wishes.form };
        let rays_of_one = points_needed(entries, step_m, ratio * step_m) * checked.rays_per_walk();
        let affordable =
            (self.most_rays / rays_of_one.max(1.0)).clamp(f64::from(WALKS[0]), f64::from(MOST_QUIET_WALKS));
        let most = (affordable as u32).next_power_of_two();
        gathering.walks = FIRST_WALKS.min(most);
        while gathering.walks < most && !(self.stop)() {
            let Some(trial) = self.try_mesh(entries, map, gathering, &checked, plan) else { break };
            if trial.of_chance <= quiet {
                break;
            }
            gathering.walks = more_walks(gathering.walks, trial.of_chance / quiet).min(most);
        }
        plan.check_walks = FIRST_CHECK_WALKS.max(u64::from(gathering.walks / 4)).min(MOST_CHECK_WALKS);
        let mesh = IndirectMesh::new(self.around, entries, gathering, self.wishes.seed, self.stop);
        plan.indirect = match mesh {
            Some(mesh) => IndirectPlan::Mesh(Box::new(mesh)),
            None => IndirectPlan::Walks(Why::Cheaper(step_m)),
        };
    }
}

/// Returns the best plan after an interrupted search: the mesh of a trial, whose other points get few walks, or few walks from every
/// receiver point.
fn best_when_cut<'a>(trial: Trial<'a>, walks: u32, checked: &Checked, points: f64) -> IndirectPlan<'a> {
    let known = (trial.points / points.max(1.0)).min(1.0);
    let times = f64::from(walks) / f64::from(HURRIED_WALKS);
    let of_mesh = trial.of_step(checked).0 + trial.of_chance * (known + (1.0 - known) * times.max(1.0));
    if of_mesh < checked.variance_of_walk() / f64::from(HURRIED_PLACE_WALKS) {
        IndirectPlan::Mesh(Box::new(trial.mesh))
    } else {
        IndirectPlan::Walks(Why::Cut)
    }
}

/// Returns the walks for the next trial. The squared random error falls at least as 1/n, and too many walks are the more expensive mistake.
fn more_walks(walks: u32, excess: f64) -> u32 {
    let times = excess.clamp(2.0, MOST_MORE_WALKS).log2().ceil().exp2();
    ((f64::from(walks) * times) as u32).min(WALKS[1])
}
