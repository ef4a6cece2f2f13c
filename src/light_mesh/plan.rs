//! How a map is computed: the step and the walks that the target needs, and shadow rays where they are cheaper.

use std::f64::consts::PI;

use super::entries::Entries;
use super::indirect::{Gathering, IndirectMesh};
use super::judge::{DIRECT_PLACES, INDIRECT_PLACES, MeanSquare, choose, measure_direct, measure_indirect};
use super::mesh::{LightMesh, Surroundings};
use super::options::{Accelerations, IndirectForm, Options, RADIUS_PER_STEP};
use super::tracing::{DirectBy, Effort, EntryLight, IndirectBy, light_of};

/// Steps along the side of a map's area on the first mesh tried.
const FIRST_STEPS: f64 = 16.0;
/// Indirect light varies more smoothly: its mesh is this much coarser than a step that the user gives.
const INDIRECT_COARSER: f64 = 3.0;
/// Radius over step of the sets that indirect light with directions is fitted over.
const DIRECTIONAL_RADIUS_PER_STEP: f64 = 2.1;
/// Walks from a mesh point on the first try.
const FIRST_WALKS: u32 = 512;
/// The next try has this many times the walks at most.
const MOST_MORE_WALKS: f64 = 16.0;
/// Part of the squared error allowed to indirect light that its chance may take.
const SHARE_OF_CHANCE: f64 = 0.5;
/// A step half as long should leave less than this part of the squared error.
const HELPED: f64 = 0.8;
/// Chance in indirect light over its mean, where no target is set.
const QUIET: f64 = 0.007;
/// Walks from a mesh point at most where no target is set.
const MOST_QUIET_WALKS: u32 = 8192;
/// Walks from a mesh point at most.
const MOST_WALKS: u32 = 1 << 15;
/// Walks from a checked place in each half, first and at most.
const CHECK_WALKS: [u64; 2] = [256, 16_384];
/// Refinements at most: steps from the first to a 4,000th of it.
const MOST_REFINEMENTS: u32 = 12;
/// Part of the target that direct and indirect light may each use where there are both; squares add up.
const SHARE_OF_BOTH: f64 = 0.7;
/// Part of the target that direct light alone may use: the last check has its own chance.
const SHARE_ALONE: f64 = 0.9;
/// The maps' numbers of the streams that check while a plan is made; what is stated at the end is checked anew.
const PLANNING: u32 = 1 << 16;

/// What the user asks of light meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wishes {
    /// Step in m; `None`: found by refining.
    pub step_m: Option<f64>,
    /// Radius in m; `None`: 1.25 steps.
    pub radius_m: Option<f64>,
    /// What mesh points keep of indirect light.
    pub form: IndirectForm,
    /// What saves time.
    pub accelerations: Accelerations,
    /// Error to reach, as a fraction; `None`: the mesh as asked for.
    pub target_error: Option<f64>,
    /// Seed of all streams.
    pub seed: u64,
}

/// How direct light of a map is computed.
pub enum DirectPlan<'a> {
    /// By a mesh.
    Mesh(Box<LightMesh<'a>>),
    /// By shadow rays, and why.
    Rays(Why),
}

/// Why shadow rays complete a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Why {
    /// A mesh of this step in m would have more points than the map has places.
    Cheaper(f64),
    /// The step that the user gave does not meet the target: this error in it.
    StepMisses(f64),
    /// There is no light to trace.
    Dark,
}

/// How indirect light of a map is computed.
pub enum IndirectPlan<'a> {
    /// Nothing reflects.
    Nothing,
    /// Gathered at the points of a mesh.
    Mesh(Box<IndirectMesh<'a>>),
    /// By walks from every place, this many at first: a finer mesh would have more points than there are places.
    Walks(u32),
}

impl<'a> IndirectPlan<'a> {
    /// The same for computing.
    pub fn by(&self) -> IndirectBy<'_, 'a> {
        match self {
            IndirectPlan::Nothing => IndirectBy::Nothing,
            IndirectPlan::Mesh(mesh) => IndirectBy::Mesh(mesh),
            IndirectPlan::Walks(walks) => IndirectBy::Walks(*walks),
        }
    }
}

/// A plan for one map.
pub struct Plan<'a> {
    /// Direct light.
    pub direct: DirectPlan<'a>,
    /// Indirect light.
    pub indirect: IndirectPlan<'a>,
    /// Walks of each half that the last check of indirect light needs.
    pub check_walks: u64,
    /// Work so far.
    pub effort: Effort,
    /// Rays of checks so far.
    pub check_rays: u64,
}

/// Makes plans for maps of one scene.
pub struct Planner<'s, 'a> {
    /// The scene.
    pub around: Surroundings<'a>,
    /// What is asked for.
    pub wishes: Wishes,
    /// Part of the target that plans aim at, 1 or less: a map whose last check missed it is planned again with less.
    pub caution: f64,
    /// Whether a limit or the user has ended the run.
    pub stop: &'s dyn Fn() -> bool,
}

impl<'a> Planner<'_, 'a> {
    /// Plans a map. One that the target does not bind is not refined.
    pub fn plan(&self, entries: &Entries, map: u32, refines: bool) -> Plan<'a> {
        let mut plan = Plan {
            direct: DirectPlan::Rays(Why::Dark),
            indirect: IndirectPlan::Nothing,
            check_walks: CHECK_WALKS[0],
            effort: Effort::default(),
            check_rays: 0,
        };
        if entries.places() == 0 || self.around.samples.is_empty() {
            return plan;
        }
        let target_error = self.wishes.target_error.filter(|_| refines).map(|target| self.caution * target);
        let mut indirect_lx = 0.0;
        if self.around.stage.reflects() {
            indirect_lx = self.plan_indirect(entries, map, target_error, &mut plan);
        }
        self.plan_direct(entries, map, target_error, indirect_lx, &mut plan);
        plan
    }

    fn radius_per_step(&self) -> f64 {
        match (self.wishes.radius_m, self.wishes.step_m) {
            (Some(radius_m), Some(step_m)) => radius_m / step_m,
            _ => RADIUS_PER_STEP,
        }
    }

    /// Sets of two layers, so that a slope across them is known; those of the paper's form are means, as close as can be.
    fn indirect_radius_per_step(&self) -> f64 {
        match (self.wishes.radius_m, self.wishes.form) {
            (None, IndirectForm::Directional) => DIRECTIONAL_RADIUS_PER_STEP,
            _ => self.radius_per_step(),
        }
    }

    fn plan_direct(
        &self,
        entries: &Entries,
        map: u32,
        target_error: Option<f64>,
        indirect_lx: f64,
        plan: &mut Plan<'a>,
    ) {
        let alone = matches!(plan.indirect, IndirectPlan::Nothing);
        let share = if alone { SHARE_ALONE } else { SHARE_OF_BOTH };
        let of_radius = self.wishes.radius_m.map(|radius_m| radius_m / RADIUS_PER_STEP);
        let asked_m = self.wishes.step_m.or(of_radius);
        let mut step_m = asked_m.unwrap_or_else(|| side_m(entries) / FIRST_STEPS);
        for _ in 0..MOST_REFINEMENTS {
            let radius_m = self.radius_per_step() * step_m;
            if asked_m.is_none() && points_needed(entries, step_m, radius_m) >= entries.places() as f64 {
                break;
            }
            let options = Options { step_m, radius_m, accelerations: self.wishes.accelerations };
            let Some(mesh) = LightMesh::new(self.around, entries.bounds_m, options) else {
                break;
            };
            let Some(target_error) = target_error else {
                plan.direct = DirectPlan::Mesh(Box::new(mesh));
                return;
            };
            let chosen = choose(entries, DIRECT_PLACES, self.wishes.seed, PLANNING + map);
            let by_mesh = DirectBy::Mesh(&mesh);
            let (lights, effort) = light_of(
                &self.around,
                entries,
                &chosen,
                &by_mesh,
                &IndirectBy::Nothing,
                self.wishes.seed,
                PLANNING + map,
            );
            plan.effort += effort;
            let mean_lx = indirect_lx + mean(lights.iter().map(EntryLight::direct_mean_lx));
            let pairs: Vec<(usize, EntryLight)> = chosen.into_iter().zip(lights).collect();
            let measured = measure_direct(&self.around, entries, &pairs, self.wishes.seed, PLANNING + map);
            plan.check_rays += measured.rays;
            let error = measured.direct.upper_root_lx() / mean_lx.max(f64::MIN_POSITIVE);
            if error <= share * target_error || (self.stop)() {
                plan.direct = DirectPlan::Mesh(Box::new(mesh));
                return;
            }
            if asked_m.is_some() {
                plan.direct = DirectPlan::Rays(Why::StepMisses(error));
                return;
            }
            step_m *= 0.5;
        }
        plan.direct = DirectPlan::Rays(Why::Cheaper(step_m));
    }

    /// Plans indirect light; returns its mean.
    fn plan_indirect(&self, entries: &Entries, map: u32, target_error: Option<f64>, plan: &mut Plan<'a>) -> f64 {
        let asked_m = self.wishes.step_m.map(|step_m| INDIRECT_COARSER * step_m);
        let mut step_m = asked_m.unwrap_or_else(|| side_m(entries) / FIRST_STEPS);
        let mut walks = FIRST_WALKS;
        let ratio = self.indirect_radius_per_step();
        let mut indirect_lx = 0.0;
        let mut last_mean = None;
        let chosen = choose(entries, INDIRECT_PLACES, self.wishes.seed, PLANNING + map);
        // Errors are relative to all the light; a few shadow rays tell how much of it is direct.
        let by_rays = DirectBy::Rays { passes: 1 };
        for refinement in 0..=MOST_REFINEMENTS {
            let gathering = Gathering { step_m, radius_m: ratio * step_m, walks, form: self.wishes.form };
            let Some(mesh) = IndirectMesh::new(self.around, entries.bounds_m, gathering, self.wishes.seed) else {
                break;
            };
            let by_mesh = IndirectBy::Mesh(&mesh);
            let (lights, effort) =
                light_of(&self.around, entries, &chosen, &by_rays, &by_mesh, self.wishes.seed, PLANNING + map);
            plan.effort += effort;
            plan.indirect = IndirectPlan::Mesh(Box::new(mesh));
            indirect_lx = mean(lights.iter().map(EntryLight::indirect_mean_lx));
            let random = mean(lights.iter().map(|light| 0.25 * (light.indirect_lx[0] - light.indirect_lx[1]).powi(2)));
            let Some(target_error) = target_error else {
                // Without a target the mesh is as it was asked for, and chance is not to be seen.
                let quiet = (QUIET * indirect_lx).powi(2);
                if random <= quiet || walks >= MOST_QUIET_WALKS || (self.stop)() {
                    break;
                }
                walks = more_walks(walks, random / quiet).min(MOST_QUIET_WALKS);
                continue;
            };
            let whole_lx = indirect_lx + mean(lights.iter().map(EntryLight::direct_mean_lx));
            let allowed = (SHARE_OF_BOTH * target_error * whole_lx).powi(2);
            let pairs: Vec<(usize, EntryLight)> = chosen.iter().copied().zip(lights).collect();
            let measured = self.checked(entries, &pairs, map, allowed, plan);
            let refines_to_no_end = refinement == MOST_REFINEMENTS || (walks >= MOST_WALKS && asked_m.is_some());
            if measured.upper_root_lx().powi(2) <= allowed || refines_to_no_end || (self.stop)() {
                break;
            }
            // Walks from the places themselves would need this many for the same chance: a set shares those of its points.
            let set = half_ball(ratio);
            let place_walks = random * f64::from(walks) * set / (0.5 * allowed).max(f64::MIN_POSITIVE);
            let next = points_needed(entries, 0.5 * step_m, ratio * 0.5 * step_m);
            // Chance must shrink in any case, and a coarse mesh is where that is cheap. What is left is the mesh's doing,
            // unless finer ones do not help: then nothing near by is smooth enough for one (light that mirrors gather).
            let helped = last_mean.is_none_or(|last_mean: f64| measured.mean < HELPED * last_mean);
            if walks < MOST_WALKS && (random > SHARE_OF_CHANCE * allowed || asked_m.is_some()) {
                walks = more_walks(walks, random / (SHARE_OF_CHANCE * allowed));
            } else if !helped || next * f64::from(walks) > place_walks * entries.places() as f64 {
                plan.indirect = IndirectPlan::Walks(walks);
                break;
            } else {
                last_mean = Some(measured.mean);
                step_m *= 0.5;
            }
        }
        indirect_lx
    }

    /// Measures indirect light with walks enough to tell whether it is within what is allowed.
    fn checked(
        &self,
        entries: &Entries,
        pairs: &[(usize, EntryLight)],
        map: u32,
        allowed: f64,
        plan: &mut Plan,
    ) -> MeanSquare {
        loop {
            let (measured, rays) =
                measure_indirect(&self.around, entries, pairs, plan.check_walks, self.wishes.seed, PLANNING + map);
            plan.check_rays += rays;
            let is_clear = measured.upper_root_lx().powi(2) <= allowed
                || measured.mean - measured.standard_error > allowed
                || measured.standard_error < 0.2 * allowed;
            if is_clear || plan.check_walks >= CHECK_WALKS[1] || (self.stop)() {
                return measured;
            }
            plan.check_walks *= 2;
        }
    }
}

/// Walks for the next try: chance's square falls at least as 1/n, and a try that goes too far is the dearer mistake.
fn more_walks(walks: u32, excess: f64) -> u32 {
    let times = excess.clamp(2.0, MOST_MORE_WALKS).log2().ceil().exp2();
    ((f64::from(walks) * times) as u32).min(MOST_WALKS)
}

/// Side of the square that a map stands for: of its area, or of the largest face of the box around it.
fn side_m(entries: &Entries) -> f64 {
    area_m2(entries).sqrt()
}

fn area_m2(entries: &Entries) -> f64 {
    let size = entries.bounds_m[1] - entries.bounds_m[0];
    let face_m2 = (size.x * size.y).max(size.y * size.z).max(size.z * size.x);
    // A row of points has no area: it stands for a square as long as itself.
    let box_m2 = if face_m2 > 0.0 { face_m2 } else { size.max_element().powi(2) };
    let area_m2 = entries.area_m2.filter(|area_m2| *area_m2 > 0.0).unwrap_or(box_m2);
    if area_m2 > 0.0 { area_m2 } else { 1.0 }
}

/// About how many mesh points a map uses: a layer as thick as the radius over its area, or a half ball for each place.
fn points_needed(entries: &Entries, step_m: f64, radius_m: f64) -> f64 {
    let layer = area_m2(entries) / (step_m * step_m) * (radius_m / step_m + 1.0);
    layer.min(half_ball(radius_m / step_m) * entries.places() as f64)
}

/// Points of half a ball, by its volume.
fn half_ball(radius_per_step: f64) -> f64 {
    2.0 / 3.0 * PI * radius_per_step.powi(3)
}

fn mean(numbers: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = numbers.len().max(1) as f64;
    numbers.sum::<f64>() / count
}
