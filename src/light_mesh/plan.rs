//! How a map is computed: the step and the walks that the target needs, and shadow rays where they are cheaper.

use std::f64::consts::PI;

use super::entries::Entries;
use super::indirect::IndirectMesh;
use super::judge::{ONE_IN_SIXTY, choose, looks_until, measure_direct};
use super::mesh::{LightMesh, Surroundings};
use super::options::{
    Accelerations, DIRECT_PLACES, FIRST_CHECK_WALKS, IndirectForm, Options, RADIUS_PER_STEP, SHARE_OF_ALL,
    SHARE_OF_DIRECT, Stop,
};
use super::tracing::{DirectBy, Effort, EntryLight, IndirectBy, light_of};

/// Steps along the side of a map's area on the first mesh tried.
pub(super) const FIRST_STEPS: f64 = 16.0;
/// Refinements at most: steps from the first to a 4,000th of it.
pub(super) const MOST_REFINEMENTS: u32 = 12;
/// The maps' numbers of the streams that check while a plan is made; what is stated at the end is checked anew.
pub(super) const PLANNING: u32 = 1 << 16;

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

/// Why shadow rays, or walks, from every place complete a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Why {
    /// Every place by itself takes fewer rays than a mesh of this step in m and what it takes to find one.
    Cheaper(f64),
    /// A mesh of half the step, down to this one in m, is not nearer to the light: nothing near by is smooth enough.
    NotSmooth(f64),
    /// Plans with a mesh missed the target.
    Missed,
    /// Samples with lines of sight of their own take fewer rays than rays along gloss for a mesh do.
    Gloss,
    /// The step that the user gave does not meet the target: this error in it.
    StepMisses(f64),
    /// A luminaire stands close to a surface, and the points of this map's mesh could not look back from the spot that it lights.
    NearLights,
    /// The step in m that the user gave makes a mesh of more points than can be numbered.
    TooFine(f64),
    /// A limit or the user ended the search before a mesh was found that is better than few walks.
    Cut,
    /// There is no light to trace.
    Dark,
}

/// How indirect light of a map is computed.
pub enum IndirectPlan<'a> {
    /// Nothing reflects.
    Nothing,
    /// Gathered at the points of a mesh.
    Mesh(Box<IndirectMesh<'a>>),
    /// By walks from every place, and why.
    Walks(Why),
}

impl<'a> IndirectPlan<'a> {
    /// The same for computing.
    pub fn by(&self) -> IndirectBy<'_, 'a> {
        match self {
            IndirectPlan::Nothing => IndirectBy::Nothing,
            IndirectPlan::Mesh(mesh) => IndirectBy::Mesh(mesh),
            // What completes the map comes round by round.
            IndirectPlan::Walks(_) => IndirectBy::Nothing,
        }
    }
}

/// A plan for one map.
pub struct MapPlan<'a> {
    /// Direct light.
    pub direct: DirectPlan<'a>,
    /// Indirect light.
    pub indirect: IndirectPlan<'a>,
    /// Walks of each half that the last check of indirect light needs.
    pub check_walks: u64,
    /// What the mesh's error in direct light stays below with 95% probability, in lx; 0 by shadow rays.
    pub direct_upper_lx: f64,
    /// Work so far.
    pub effort: Effort,
    /// Rays of checks so far.
    pub check_rays: u64,
}

impl MapPlan<'_> {
    /// Whether the points of a mesh for indirect light can look back from what luminaires light that stand close to surfaces:
    /// those that keep the light of planes can, those that keep light from all sides or leave mirrors to the places cannot.
    pub fn looks_back(&self, around: &Surroundings, entries: &Entries) -> bool {
        let is_directional = match &self.indirect {
            IndirectPlan::Mesh(mesh) => mesh.gathering.form == IndirectForm::Directional,
            _ => true,
        };
        is_directional && entries.normals.is_some() && around.has_no_images()
    }
}

/// Makes plans for maps of one scene.
pub struct Planner<'a> {
    /// The scene.
    pub around: Surroundings<'a>,
    /// What is asked for.
    pub wishes: Wishes,
    /// Part of the target that plans aim at, 1 or less: a map whose last check missed it is planned again with less.
    pub caution: f64,
    /// Whether every place is to be computed by itself: a map whose meshes have missed the target is.
    pub by_places: bool,
    /// Rays that a map which the target does not bind may take, about.
    pub most_rays: f64,
    /// Whether a limit or the user has ended the run.
    pub stop: Stop<'a>,
}

impl<'a> Planner<'a> {
    /// Plans a map. One that the target does not bind is not refined.
    pub fn plan(&self, entries: &Entries, map: u32, refines: bool) -> MapPlan<'a> {
        let mut plan = MapPlan {
            direct: DirectPlan::Rays(Why::Dark),
            indirect: IndirectPlan::Nothing,
            check_walks: FIRST_CHECK_WALKS,
            direct_upper_lx: 0.0,
            effort: Effort::default(),
            check_rays: 0,
        };
        if entries.places() == 0 && !entries.draw_sights() || self.around.samples.is_empty() {
            return plan;
        }
        let reflects = self.around.stage.reflects();
        if refines && self.by_places || entries.draw_sights() {
            let why = if entries.draw_sights() { Why::Gloss } else { Why::Missed };
            plan.direct = DirectPlan::Rays(why);
            plan.indirect = if reflects { IndirectPlan::Walks(why) } else { IndirectPlan::Nothing };
            return plan;
        }
        let target_error = self.wishes.target_error.filter(|_| refines).map(|target| self.caution * target);
        match target_error {
            Some(target_error) if reflects => {
                let checked = self.pilot(entries, map, &mut plan);
                self.plan_direct(entries, map, Some(target_error), checked.mean_lx(), &mut plan);
                self.plan_indirect(entries, map, target_error, checked, &mut plan);
            }
            Some(_) => self.plan_direct(entries, map, target_error, 0.0, &mut plan),
            None => {
                self.plan_direct(entries, map, None, 0.0, &mut plan);
                if reflects {
                    self.plan_quietly(entries, map, &mut plan);
                }
            }
        }
        plan
    }

    pub(super) fn radius_per_step(&self) -> f64 {
        match (self.wishes.radius_m, self.wishes.step_m) {
            (Some(radius_m), Some(step_m)) => radius_m / step_m,
            _ => RADIUS_PER_STEP,
        }
    }

    fn plan_direct(
        &self,
        entries: &Entries,
        map: u32,
        target_error: Option<f64>,
        indirect_lx: f64,
        plan: &mut MapPlan<'a>,
    ) {
        let share = if self.around.stage.reflects() { SHARE_OF_DIRECT } else { SHARE_OF_ALL };
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
                if asked_m.is_some() {
                    plan.direct = DirectPlan::Rays(Why::TooFine(step_m));
                    return;
                }
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
            let looks = looks_until(entries, self.stop);
            let (measured, _) = measure_direct(&self.around, entries, &pairs, looks, self.wishes.seed, PLANNING + map);
            plan.check_rays += measured.rays;
            plan.direct_upper_lx = measured.direct.upper_root_lx(ONE_IN_SIXTY);
            let error = plan.direct_upper_lx / mean_lx.max(f64::MIN_POSITIVE);
            // A given step is refused for its error alone: a target was given too.
            if error <= share * target_error || (self.stop)() {
                plan.direct = DirectPlan::Mesh(Box::new(mesh));
                return;
            }
            plan.direct_upper_lx = 0.0;
            if asked_m.is_some() {
                plan.direct = DirectPlan::Rays(Why::StepMisses(error));
                return;
            }
            step_m *= 0.5;
        }
        plan.direct = DirectPlan::Rays(Why::Cheaper(step_m));
    }
}

/// Side of the square that a map stands for: of its area, or of the largest face of the box around it.
pub(super) fn side_m(entries: &Entries) -> f64 {
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
pub(super) fn points_needed(entries: &Entries, step_m: f64, radius_m: f64) -> f64 {
    let layer = area_m2(entries) / (step_m * step_m) * (radius_m / step_m + 1.0);
    layer.min(half_ball(radius_m / step_m) * entries.places() as f64)
}

/// Points of half a ball, by its volume.
pub(super) fn half_ball(radius_per_step: f64) -> f64 {
    2.0 / 3.0 * PI * radius_per_step.powi(3)
}

pub(super) fn mean(numbers: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = numbers.len().max(1) as f64;
    numbers.sum::<f64>() / count
}
