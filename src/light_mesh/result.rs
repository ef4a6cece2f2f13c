//! Converts computed points to a map with its stated error.

use super::classes::{CLASSES, Classes, kind, squares_of};
use super::complete::Rounds;
use super::entries::Entries;
use super::judge::{
    Checked, INDIRECT_PLACES, LAST_INDIRECT_PLACES, MeanSquare, MeasuredDifference, ONE_IN_SIXTY, choose,
    measure_direct, samples_until,
};
use super::options::DIRECT_PLACES;
use super::plan::{DirectPlan, IndirectPlan, MapPlan, Planner};
use super::samples::Samples;
use super::tracing::{DirectBy, Effort, EntryLight, IndirectBy, light_of, mean_value, random_error};
use crate::control::ONE_IN_TWENTY;
use crate::maps::{
    MapError, MapKind, MapResult, MapValues, StatedValues, TableKind, TableRow, grid_places, grid_slopes, stated_row,
};
use crate::scene::{ElementSizes, Elements, EvaluationGrid, Quantity, ReceiverLayout, Scene, Side, evaluation_grid};

/// Entries computed between two checks of the clock.
const ENTRIES_OF_PART: usize = 1024;
/// Standard error of the measured squared error, relative to its mean, above which it is stated too.
const MOST_UNSURE: f64 = 0.5;

/// A computed map, with the work for it.
pub struct TracedMap {
    /// The map.
    pub map: MapResult,
    /// Measured error of the map.
    pub measured: MeasuredDifference,
    /// Upper bound of the stated error with 95% probability.
    pub upper_error: f64,
    /// Work for computing the map, including planning.
    pub effort: Effort,
    /// Rays for checking the map.
    pub check_rays: u64,
    /// Facts of the mesh for direct light, if one was used.
    pub mesh: Option<MeshFacts>,
    /// Settings, with step and walks, of the mesh that gathered indirect light.
    pub gathering: Option<super::indirect::Gathering>,
    /// Rounds of shadow rays and walks from every receiver point, if these completed the map.
    pub rounds: Rounds,
}

/// Facts to report of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshFacts {
    /// Step in m.
    pub step_m: f64,
    /// Radius in m.
    pub radius_m: f64,
    /// Memory in bytes.
    pub bytes: u64,
    /// Memory in bytes with every point stored.
    pub dense_bytes: f64,
}

impl Planner<'_> {
    /// Computes a map by its plan and measures its error at separate points.
    pub fn trace(&self, entries: &Entries, map: u32, plan: &MapPlan) -> TracedMap {
        let seed = self.wishes.seed;
        let (mut effort, mut check_rays) = (plan.effort, plan.check_rays);
        effort.sight_rays += entries.lines_of_sight.as_ref().map_or(0, |lines| lines.rays);
        let mut compute = |direct: &DirectBy, indirect: &IndirectBy| {
            let (lights, more) = self.light_of_all(entries, direct, indirect, map);
            effort += more;
            lights
        };
        let mut lights = match &plan.direct {
            DirectPlan::Mesh(mesh) => compute(&DirectBy::Mesh(mesh), &plan.indirect.by()),
            DirectPlan::Rays(_) => compute(&DirectBy::Rays { first: 0, passes: 0 }, &plan.indirect.by()),
        };
        let rounds = self.complete(entries, map, plan, &mut lights, &mut effort);

        // The stated error is checked at points and with random numbers that were not used for any choice.
        let mut measured = MeasuredDifference::default();
        let chosen = |most: usize| -> Vec<(usize, EntryLight)> {
            choose(entries, most, seed, map).into_iter().map(|entry| (entry, lights[entry])).collect()
        };
        let classes = Classes::of(&lights);
        let (mut direct_of_class, mut indirect_of_kind) = ([0.0; CLASSES], [0.0; CLASSES]);
        if matches!(plan.direct, DirectPlan::Mesh(_)) || entries.have_chance() && !entries.draw_lines_of_sight() {
            let mut checked = chosen(DIRECT_PLACES);
            let (of_all, mut products) =
                measure_direct(&self.around, entries, &checked, samples_until(entries, self.stop), seed, map);
            measured = of_all;
            // Rare kinds of points contribute only to the errors of points of the same kind.
            let known: Vec<usize> = checked.iter().map(|(entry, _)| *entry).collect();
            let missing = classes.missing(&lights, &entries.weights, &known);
            let more: Vec<(usize, EntryLight)> = missing.into_iter().map(|entry| (entry, lights[entry])).collect();
            let (of_more, products_of_more) =
                measure_direct(&self.around, entries, &more, samples_until(entries, self.stop), seed, map);
            measured.rays += of_more.rays;
            checked.extend(more);
            products.extend(products_of_more);
            let class_of = checked.iter().map(|(_, light)| classes.class(light));
            direct_of_class =
                squares_of(&class_of.zip(products).collect::<Vec<(usize, f64)>>(), &measured.direct, true);
        }
        if let IndirectPlan::Mesh(_) = plan.indirect {
            let chosen = choose(entries, LAST_INDIRECT_PLACES, seed, map);
            // The total number of walks equals the plan's number for its points.
            let walks = (plan.check_walks * INDIRECT_PLACES as u64).div_ceil(chosen.len().max(1) as u64);
            let mut checked = Checked::of(chosen, seed, map);
            checked.add(&self.around, entries, walks, self.stop);
            let products = checked.products(checked.chosen.iter().map(|entry| lights[*entry]));
            let indirect = MeanSquare::of(&products);
            let kinds = checked.chosen.iter().map(|entry| kind(lights[*entry].indirect_set));
            indirect_of_kind = squares_of(&kinds.zip(products).collect::<Vec<(usize, f64)>>(), &indirect, false);
            let rays = checked.rays;
            measured.indirect = indirect;
            measured.rays += rays;
        }
        check_rays += measured.rays;
        let mesh = match &plan.direct {
            DirectPlan::Mesh(mesh) => Some(MeshFacts {
                step_m: mesh.options.step_m,
                radius_m: mesh.options.radius_m,
                bytes: mesh.bytes(),
                dense_bytes: mesh.dense_bytes(),
            }),
            DirectPlan::Rays(_) => None,
        };
        let squares =
            |light: &EntryLight| direct_of_class[classes.class(light)] + indirect_of_kind[kind(light.indirect_set)];
        let (map, upper_error) = self.map_of(entries, &lights, &measured, squares, mesh.is_some());
        let gathering = match &plan.indirect {
            IndirectPlan::Mesh(mesh) => Some(mesh.gathering),
            _ => None,
        };
        TracedMap { map, measured, upper_error, effort, check_rays, mesh, gathering, rounds }
    }

    /// Computes all entries of a map, part by part. Entries that are left when the run is abandoned stay dark.
    pub(super) fn light_of_all(
        &self,
        entries: &Entries,
        direct: &DirectBy,
        indirect: &IndirectBy,
        map: u32,
    ) -> (Vec<EntryLight>, Effort) {
        let all: Vec<usize> = (0..entries.weights.len()).collect();
        let (mut lights, mut effort) = (Vec::with_capacity(all.len()), Effort::default());
        for part in all.chunks(ENTRIES_OF_PART) {
            if (self.around.give_up)() {
                break;
            }
            let (more, took) = light_of(&self.around, entries, part, direct, indirect, self.wishes.seed, map);
            lights.extend(more);
            effort += took;
        }
        lights.resize(all.len(), EntryLight::default());
        (lights, effort)
    }

    /// Computes direct light with a shadow ray to every sample point, each as a point source, and measures its error.
    pub fn trace_points(&self, entries: &Entries, map: u32, points: &Samples) -> TracedMap {
        let seed = self.wishes.seed;
        let all: Vec<usize> = (0..entries.weights.len()).collect();
        let (direct, indirect) = (DirectBy::Points(points), IndirectBy::Nothing);
        let (lights, effort) = light_of(&self.around, entries, &all, &direct, &indirect, seed, map);
        let chosen = choose(entries, DIRECT_PLACES, seed, map).into_iter().map(|entry| (entry, lights[entry]));
        let chosen: Vec<(usize, EntryLight)> = chosen.collect();
        let (measured, _) =
            measure_direct(&self.around, entries, &chosen, samples_until(entries, self.stop), seed, map);
        let of_all = |_: &EntryLight| measured.direct.mean.max(measured.direct.standard_error);
        let (map, upper_error) = self.map_of(entries, &lights, &measured, of_all, true);
        let map = MapResult { method: "points".to_owned(), ..map };
        let check_rays = measured.rays;
        TracedMap {
            map,
            measured,
            upper_error,
            effort,
            check_rays,
            mesh: None,
            gathering: None,
            rounds: Rounds::default(),
        }
    }

    /// Builds the map and its upper error. `squares` returns the mean square error of a point's kind, in the squared unit of the map's values.
    fn map_of(
        &self,
        entries: &Entries,
        lights: &[EntryLight],
        measured: &MeasuredDifference,
        squares: impl Fn(&EntryLight) -> f64,
        by_mesh: bool,
    ) -> (MapResult, f64) {
        let mean_value = mean_value(entries, lights);
        let halves = random_error(entries, lights, EntryLight::halves);
        // The measured error includes the noise of a mesh's walks, but not the noise of rays and walks from the receiver points. With k
        // points, each with an independent difference, the estimate of that noise is too small by this factor in one case in twenty.
        let places = entries.weights.iter().filter(|weight| **weight > 0.0).count().max(1) as f64;
        let short = 1.0 + ONE_IN_TWENTY / (2.0 * places).sqrt();
        let of_places = if measured.indirect == MeanSquare::default() {
            short * halves
        } else {
            short * random_error(entries, lights, |light| light.direct)
        };
        let random_error = halves.max(of_places);
        let total = measured.total();
        // An interrupted check may be too small by chance. If it is uncertain, its standard error is added to the stated error.
        let unsure = if total.standard_error > MOST_UNSURE * total.mean { total.standard_error } else { 0.0 };
        let whole = total.mean.max(0.0) + unsure + of_places.powi(2);
        let estimated = whole.max(random_error.powi(2)).sqrt();
        let bias = (estimated.powi(2) - random_error.powi(2)).max(0.0).sqrt();
        let upper = total.upper_root(ONE_IN_SIXTY).hypot(of_places).max(estimated);
        let relative = |error: f64| if mean_value > 0.0 { error / mean_value } else { 0.0 };
        let error_of = |light: &EntryLight| {
            if light.is_known {
                return 0.0;
            }
            (squares(light) + of_places.powi(2)).sqrt()
        };
        let is_counted = |entry: usize| entries.weights[entry] > 0.0;
        let entry_values = || lights.iter().enumerate();
        let values = MapValues {
            value: lights.iter().map(|light| light.direct_mean() + light.indirect_mean()).collect(),
            standard_error: entry_values()
                .map(|(entry, light)| if is_counted(entry) { error_of(light) } else { 0.0 })
                .collect(),
            direct: lights.iter().map(EntryLight::direct_mean).collect(),
            indirect: lights.iter().map(EntryLight::indirect_mean).collect(),
            ..MapValues::default()
        };
        let error = MapError {
            random: relative(random_error),
            bias: relative(bias),
            estimated: relative(estimated),
            degrees_of_freedom: 0.0,
            dark_upper_bound: None,
            ..MapError::default()
        };
        let scene = self.around.scene;
        let tables = match entries.kind {
            MapKind::Elements => element_tables(scene, &self.around.world.elements, &values, &entries.weights),
            MapKind::Receivers(set) => {
                let set = &scene.receivers[set];
                let (kind, area_m2) = match set.layout {
                    _ if set.quantity == Quantity::Luminance => (TableKind::Luminance, 0.0),
                    ReceiverLayout::Grid { area_m2, .. } => (TableKind::Grid, area_m2),
                    _ => (TableKind::Points, 0.0),
                };
                let all = StatedValues::of(&values, &entries.weights, 0..lights.len());
                vec![stated_row(&set.name, kind, Side::Front.name(), area_m2, &all, &all.places())]
            }
        };
        let method = if by_mesh || measured.indirect != MeanSquare::default() { "light-mesh" } else { "shadow-rays" };
        let map = MapResult {
            name: entries.kind.name(scene).to_owned(),
            kind: entries.kind,
            quantity: entries.kind.quantity(scene),
            method: method.to_owned(),
            method_reason: "requested".to_owned(),
            chains: 0,
            values,
            error,
            bound: false,
            target_met: None,
            refusals: 0,
            checks: Vec::new(),
            tables,
        };
        (map, relative(upper))
    }
}

fn element_tables(scene: &Scene, elements: &Elements, values: &MapValues, weights: &[f64]) -> Vec<TableRow> {
    let mut rows = Vec::new();
    for (id, surface) in scene.surfaces.iter().enumerate() {
        let range = elements.of_surface(scene, id as u32);
        for side in [Side::Front, Side::Back] {
            let of_side: Vec<usize> = range
                .clone()
                .filter(|index| elements.element(*index).side == side)
                .map(|index| index as usize)
                .collect();
            if of_side.is_empty() {
                continue;
            }
            let pick = |all: &[f64]| -> Vec<f64> { of_side.iter().map(|entry| all[*entry]).collect() };
            let part = MapValues {
                value: pick(&values.value),
                standard_error: pick(&values.standard_error),
                ..MapValues::default()
            };
            let weights = pick(weights);
            let stated = StatedValues::of(&part, &weights, 0..of_side.len());
            let grid = evaluation_grid(scene, elements, id as u32, side, |_| (1.0, 1.0), ElementSizes::Fine);
            let halves = |entry: usize| [values.value[entry]; 2];
            let slopes = |grid: &EvaluationGrid| grid_slopes(scene, elements, &of_side, grid, |_| true, halves);
            let (area_m2, places) = (weights.iter().sum(), grid_places(values, grid.as_ref(), slopes));
            rows.push(stated_row(&surface.name, TableKind::Surface, side.name(), area_m2, &stated, &places));
        }
    }
    rows
}
