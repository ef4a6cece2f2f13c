//! Plans the computation of a map: the mesh step and the number of walks that the target requires, or shadow rays where they are cheaper.

use std::f64::consts::PI;

use super::entries::Entries;
use super::indirect::IndirectMesh;
use super::judge::{ONE_IN_SIXTY, choose, measure_direct, samples_until};
use super::mesh::{LightMesh, Surroundings};
use super::options::{
    Accelerations, DIRECT_PLACES, FIRST_CHECK_WALKS, IndirectForm, Options, RADIUS_PER_STEP, SHARE_OF_ALL,
    SHARE_OF_DIRECT, Stop,
};
use super::tracing::{DirectBy, Effort, EntryLight, IndirectBy, light_of};

/// Steps along the side of a map's area for the first mesh.
pub(super) const FIRST_STEPS: f64 = 16.0;
/// Largest number of refinements: the last step is a 4,000th of the first.
pub(super) const MOST_REFINEMENTS: u32 = 12;
/// Offset of the maps' numbers for streams of checks during planning. The stated error is checked with other streams at the end.
pub(super) const PLANNING: u32 = 1 << 16;

/// The user's settings for light meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wishes {
    /// Step in m; `None`: found by refinement.
    pub step_m: Option<f64>,
    /// Radius in m; `None`: 1.25 steps.
    pub radius_m: Option<f64>,
    /// Form in which mesh points store indirect light.
    pub form: IndirectForm,
    /// Accelerations to use.
    pub accelerations: Accelerations,
    /// Target error as a fraction; `None`: use the mesh as set.
    pub target_error: Option<f64>,
    /// Seed of all streams.
    pub seed: u64,
}

/// Method for the direct light of a map.
pub enum DirectPlan<'a> {
    /// By a mesh.
    Mesh(Box<LightMesh<'a>>),
    /// By shadow rays, with the reason.
    Rays(Why),
}

/// Reason why shadow rays or walks from every receiver point complete a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Why {
    /// Every receiver point alone takes fewer rays than a mesh of this step in m and the search for it.
    Cheaper(f64),
    /// A mesh with half the step, down to this one in m, is not more accurate: the light nearby is not smooth enough.
    NotSmooth(f64),
    /// Plans with a mesh missed the target.
    Missed,
    /// Samples with their own lines of sight take fewer rays than rays along gloss for a mesh.
    Gloss,
    /// The user's step does not meet the target: the mesh has this error.
    StepMisses(f64),
    /// A luminaire stands close to a surface. Points of this map's mesh cannot use light-path connections from the spot that it lights.
    NearLuminaires,
    /// The user's step in m gives a mesh with more points than can be numbered.
    TooFine(f64),
    /// A limit or the user ended the search before a mesh was found that is better than few walks.
    Cut,
    /// There is no light to trace.
    Dark,
}

/// Method for the indirect light of a map.
pub enum IndirectPlan<'a> {
    /// No surface reflects.
    Nothing,
    /// Light is gathered at the points of a mesh.
    Mesh(Box<IndirectMesh<'a>>),
    /// By walks from every receiver point, with the reason.
    Walks(Why),
}

impl<'a> IndirectPlan<'a> {
    /// Returns the method in the form used for computing.
    pub fn by(&self) -> IndirectBy<'_, 'a> {
        match self {
            IndirectPlan::Nothing => IndirectBy::Nothing,
            IndirectPlan::Mesh(mesh) => IndirectBy::Mesh(mesh),
            // Rounds of walks complete the map later.
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
    /// Walks in each half for the last check of indirect light.
    pub check_walks: u64,
    /// Upper bound of the mesh's error in direct light with 95% probability, in the unit of the map's values; 0 for shadow rays.
    pub direct_upper: f64,
    /// Work so far.
    pub effort: Effort,
    /// Rays of checks so far.
    pub check_rays: u64,
}

impl MapPlan<'_> {
    /// Whether the mesh points for indirect light can use light-path connections to luminaires that stand close to surfaces. Points that
    /// store the light of planes can. Points that store light from all sides, or that leave mirrors to the receiver points, cannot.
    pub fn connects_to_packets(&self, around: &Surroundings, entries: &Entries) -> bool {
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
    /// The user's settings.
    pub wishes: Wishes,
    /// Part of the target at which plans aim, 1 or less. A map whose last check missed the target is planned again with a smaller part.
    pub caution: f64,
    /// Whether every receiver point is computed by itself. This applies to a map whose meshes have missed the target.
    pub by_places: bool,
    /// Approximate limit of rays for a map without a target.
    pub most_rays: f64,
    /// Whether a limit or the user has ended the run.
    pub stop: Stop<'a>,
}

impl<'a> Planner<'a> {
    /// Plans a map. Only a map with a target (`refines`) is refined.
    pub fn plan(&self, entries: &Entries, map: u32, refines: bool) -> MapPlan<'a> {
        let mut plan = MapPlan {
            direct: DirectPlan::Rays(Why::Dark),
            indirect: IndirectPlan::Nothing,
            check_walks: FIRST_CHECK_WALKS,
            direct_upper: 0.0,
            effort: Effort::default(),
            check_rays: 0,
        };
        if entries.places() == 0 && !entries.draw_lines_of_sight() || self.around.samples.is_empty() {
            return plan;
        }
        let reflects = self.around.world.reflects();
        if refines && self.by_places || entries.draw_lines_of_sight() {
            let why = if entries.draw_lines_of_sight() { Why::Gloss } else { Why::Missed };
            plan.direct = DirectPlan::Rays(why);
            plan.indirect = if reflects { IndirectPlan::Walks(why) } else { IndirectPlan::Nothing };
            return plan;
        }
        let target_error = self.wishes.target_error.filter(|_| refines).map(|target| self.caution * target);
        match target_error {
            Some(target_error) if reflects => {
                let checked = self.pilot(entries, map, &mut plan);
                self.plan_direct(entries, map, Some(target_error), checked.mean(), &mut plan);
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
        indirect: f64,
        plan: &mut MapPlan<'a>,
    ) {
        let share = if self.around.world.reflects() { SHARE_OF_DIRECT } else { SHARE_OF_ALL };
        let of_radius = self.wishes.radius_m.map(|radius_m| radius_m / RADIUS_PER_STEP);
        let given_m = self.wishes.step_m.or(of_radius);
        let mut step_m = given_m.unwrap_or_else(|| side_m(entries) / FIRST_STEPS);
        for _ in 0..MOST_REFINEMENTS {
            let radius_m = self.radius_per_step() * step_m;
            if given_m.is_none() && points_needed(entries, step_m, radius_m) >= entries.places() as f64 {
                break;
            }
            let options = Options { step_m, radius_m, accelerations: self.wishes.accelerations };
            let Some(mesh) = LightMesh::new(self.around, entries.bounds_m, options) else {
                if given_m.is_some() {
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
            let mean = indirect + mean(lights.iter().map(EntryLight::direct_mean));
            let pairs: Vec<(usize, EntryLight)> = chosen.into_iter().zip(lights).collect();
            let samples = samples_until(entries, self.stop);
            let (measured, _) =
                measure_direct(&self.around, entries, &pairs, samples, self.wishes.seed, PLANNING + map);
            plan.check_rays += measured.rays;
            plan.direct_upper = measured.direct.upper_root(ONE_IN_SIXTY);
            let error = plan.direct_upper / mean.max(f64::MIN_POSITIVE);
            // A target was given, so the user's step is refused if its error is too large.
            if error <= share * target_error || (self.stop)() {
                plan.direct = DirectPlan::Mesh(Box::new(mesh));
                return;
            }
            plan.direct_upper = 0.0;
            if given_m.is_some() {
                plan.direct = DirectPlan::Rays(Why::StepMisses(error));
                return;
            }
            step_m *= 0.5;
        }
        plan.direct = DirectPlan::Rays(Why::Cheaper(step_m));
    }
}

/// Returns the side of the square that a map stands for, in m: of its area, or of the largest face of its bounding box.
pub(super) fn side_m(entries: &Entries) -> f64 {
    area_m2(entries).sqrt()
}

fn area_m2(entries: &Entries) -> f64 {
    let size = entries.bounds_m[1] - entries.bounds_m[0];
    let face_m2 = (size.x * size.y).max(size.y * size.z).max(size.z * size.x);
    // A row of points has no area: use a square as long as the row.
    let box_m2 = if face_m2 > 0.0 { face_m2 } else { size.max_element().powi(2) };
    let area_m2 = entries.area_m2.filter(|area_m2| *area_m2 > 0.0).unwrap_or(box_m2);
    if area_m2 > 0.0 { area_m2 } else { 1.0 }
}

/// Estimates how many mesh points a map uses: a layer over its area as thick as the radius, or a half ball for each receiver point.
pub(super) fn points_needed(entries: &Entries, step_m: f64, radius_m: f64) -> f64 {
    let layer = area_m2(entries) / (step_m * step_m) * (radius_m / step_m + 1.0);
    layer.min(half_ball(radius_m / step_m) * entries.places() as f64)
}

/// Returns the number of mesh points in a half ball, from its volume.
pub(super) fn half_ball(radius_per_step: f64) -> f64 {
    2.0 / 3.0 * PI * radius_per_step.powi(3)
}

pub(super) fn mean(numbers: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = numbers.len().max(1) as f64;
    numbers.sum::<f64>() / count
}
