//! Table rows of finished maps: sides of surfaces, and receiver sets.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::contact::{CONTACT_POINTS, KnownContact, contact_free_shares};
use super::context::Context;
use super::job::Job;
use crate::maps::{
    CellSlopes, HALF, Places, RemainingInAverage, TableKind, TableRow, TableSubject, grid_slopes, remaining_by_average,
    table_row,
};
use crate::scene::{ElementSizes, EvaluationGrid, Quantity, ReceiverLayout, Scene, Side, SurfaceId, evaluation_grid};

/// Weights of the second and third corner of an element at its centroid, where its slope functions are 0.
const CENTROID: [f64; 2] = [1.0 / 3.0; 2];

/// Largest share of a map's rays that tests for contact occlusion may take.
const SHARE_OF_CONTACT: f64 = 0.1;

/// A side of a surface that the element map reports.
struct SurfaceSide {
    surface: SurfaceId,
    side: Side,
    entries: Vec<usize>,
    grid: Option<EvaluationGrid>,
}

/// One table row for every side of every surface.
pub(super) fn surface_tables(context: &Context, job: &Job) -> Vec<TableRow> {
    let sides = surface_sides(context, job);
    let discretisation_lx: Vec<f64> = match &job.adapting.adaptive {
        Some(_) => job.discretisation_lx(),
        None => Vec::new(),
    };
    let rare_scores = job.map.rare_scores();
    // Adaptive elements are reported without their hidden part. Given elements are means over the hidden part too.
    let contact_free =
        if job.adapting.adaptive.is_some() { Vec::new() } else { contact_free_of_given(context, job, &sides) };
    let contact_free_of = |entry: usize| contact_free.get(entry).copied().unwrap_or(1.0);
    let remaining = remaining_in_averages(job, sides.iter().map(|of| &of.entries[..]), contact_free_of);
    let row = |(of, average_left): (SurfaceSide, Option<f64>)| {
        let weights: Vec<f64> = of.entries.iter().map(|entry| job.weights[*entry]).collect();
        let mut of = of;
        let mut slopes = Vec::new();
        if let Some(grid) = &mut of.grid {
            fit_to_elements(grid, job, &contact_free);
            slopes = slopes_of_given(context.scene, job, &of.entries, &contact_free, grid);
        }
        let in_contact = |(entry, weight): (&usize, &f64)| weight * (1.0 - contact_free_of(*entry));
        let subject = TableSubject {
            name: &context.scene.surfaces[of.surface as usize].name,
            kind: TableKind::Surface,
            side: of.side.name(),
            entries: &of.entries,
            weights: &weights,
            area_m2: weights.iter().sum(),
            covered_area_m2: of.entries.iter().zip(&weights).map(in_contact).sum(),
            places: Places::Grid {
                grid: of.grid.as_ref().filter(|grid| !grid.cells.is_empty()),
                discretisation_lx: &discretisation_lx,
                slopes: &slopes,
            },
            rare_scores,
            average_left,
        };
        let mut row = table_row(&job.map, &subject);
        if job.adapting.adaptive.is_some() {
            row.estimated_error = job.error_of_elements(&of.entries);
            let (scene, elements) = (context.scene, &job.elements);
            let whole_m2 =
                of.entries.iter().map(|entry| elements.area_m2(scene, elements.element(*entry as u32))).sum::<f64>();
            row.covered_area_m2 = (whole_m2 - row.area_m2).max(0.0);
        }
        row
    };
    sides.into_par_iter().with_max_len(1).zip(remaining).map(row).collect()
}

/// The remaining error of cells in the average of each of several rows, in the unit of the map's values, as measured by walks. It is taken
/// from the elements that gathered for the row, or from its own entries.
fn remaining_in_averages<'a>(
    job: &Job,
    rows: impl ExactSizeIterator<Item = &'a [usize]>,
    contact_free: impl Fn(usize) -> f64,
) -> Vec<Option<f64>> {
    let gathered = job.gathered();
    let known = gathered.residuals.as_ref().filter(|residuals| residuals.walks > 0).zip(gathered.cells_error.as_ref());
    let Some((residuals, error)) = known else { return vec![None; rows.len()] };
    let of_row = |entries: &[usize]| match &job.adapting.coarse {
        Some(coarse) => {
            let sites: BTreeSet<usize> = entries.iter().map(|entry| coarse.children[*entry].parent as usize).collect();
            RemainingInAverage::of(residuals, error, sites.into_iter().map(|site| (site, coarse.weights_m2[site])))
        }
        None => {
            let weight = |entry: &usize| (*entry, job.weights[*entry] * contact_free(*entry));
            RemainingInAverage::of(residuals, error, entries.iter().map(weight))
        }
    };
    let averages: Vec<RemainingInAverage> = rows.map(of_row).collect();
    remaining_by_average(&averages).into_iter().map(Some).collect()
}

/// All sides with their elements, and with the grid of their uniformities if elements are fine enough for it.
fn surface_sides(context: &Context, job: &Job) -> Vec<SurfaceSide> {
    let (scene, elements) = (context.scene, &job.elements);
    let mut sides = Vec::new();
    for surface in 0..scene.surfaces.len() as SurfaceId {
        for side in [Side::Front, Side::Back] {
            let range = elements.of_surface(scene, surface);
            let entries: Vec<usize> =
                range.filter(|index| elements.element(*index).side == side).map(|index| index as usize).collect();
            if entries.is_empty() {
                continue;
            }
            let share = |element: u32| match &job.adapting.adaptive {
                Some(adaptive) => (adaptive.contact_free[element as usize], 1.0),
                None => (1.0, 1.0),
            };
            let sizes = if job.adapting.adaptive.is_some() { ElementSizes::Any } else { ElementSizes::Fine };
            let grid = evaluation_grid(scene, elements, surface, side, share, sizes);
            sides.push(SurfaceSide { surface, side, entries, grid });
        }
    }
    sides
}

/// Contact-free share of every given element. It is tested closely, unless the elements are so many that this would take long relative to the
/// map's own rays. In that case it is tested closely only for grids, and elsewhere elements that are wholly hidden are left out of the
/// average. If the run has ended, for example by a limit, one point of an element decides, and only for grids. Otherwise whatever stands on
/// a floor would make its least value 0.
fn contact_free_of_given(context: &Context, job: &Job, sides: &[SurfaceSide]) -> Vec<f64> {
    if !job.adapting.contact_free.is_empty() {
        return job.adapting.contact_free.clone();
    }
    let mut is_requested = vec![false; job.elements.len()];
    for of in sides.iter().filter(|of| of.grid.is_some()) {
        of.entries.iter().for_each(|entry| is_requested[*entry] = true);
    }
    let has_ended = context.is_over();
    let is_cheap = (CONTACT_POINTS * job.elements.len() as u64) as f64 <= SHARE_OF_CONTACT * job.all_rays() as f64;
    let known = |index: u32| match is_requested[index as usize] {
        true if has_ended => KnownContact::AtAPlace,
        false if has_ended || !is_cheap => KnownContact::AsAWhole,
        _ => KnownContact::Unknown,
    };
    contact_free_shares(context, &job.elements, 0..job.elements.len(), known).0
}

/// Removes the hidden part of given elements from a grid's cells, and slopes from elements that show none.
fn fit_to_elements(grid: &mut EvaluationGrid, job: &Job, contact_free: &[f64]) {
    for part in grid.cells.iter_mut().flatten() {
        let element = part.element as usize;
        if let Some(share) = contact_free.get(element) {
            part.area_m2 *= share;
            part.scale = if *share > 0.0 { 1.0 / share } else { 0.0 };
        }
        if job.adapting.adaptive.as_ref().is_some_and(|adaptive| !adaptive.sloped[element]) {
            part.at = CENTROID;
        }
    }
    grid.leave_out_contact();
}

/// Changes by the slopes of light across given elements in the cells that cut them. Adaptive elements have slopes of their own.
fn slopes_of_given(
    scene: &Scene,
    job: &Job,
    entries: &[usize],
    contact_free: &[f64],
    grid: &EvaluationGrid,
) -> Vec<CellSlopes> {
    if job.adapting.adaptive.is_some() {
        return Vec::new();
    }
    let half_lx = |entry: usize, first: usize| {
        (0..HALF).map(|pair| job.map.value(2 * pair + first, entry)).sum::<f64>() / HALF as f64
    };
    let halves_lx = |entry: usize| [0, 1].map(|first| half_lx(entry, first));
    grid_slopes(scene, &job.elements, entries, grid, |entry| contact_free[entry] == 1.0, halves_lx)
}

/// The table row of a receiver set.
pub(super) fn receiver_table(scene: &Scene, set: usize, job: &Job) -> TableRow {
    let receivers = &scene.receivers[set];
    let entries: Vec<usize> = (0..receivers.points.len()).collect();
    let (kind, area_m2) = match receivers.layout {
        ReceiverLayout::Grid { area_m2, .. } => (TableKind::Grid, area_m2),
        _ => (TableKind::Points, 0.0),
    };
    let kind = match receivers.quantity {
        Quantity::Luminance => TableKind::Luminance,
        Quantity::Glare(_) => TableKind::Glare,
        Quantity::Intensity { .. } => TableKind::Intensity,
        _ => kind,
    };
    let subject = TableSubject {
        name: &receivers.name,
        kind,
        side: "front",
        entries: &entries,
        weights: &job.weights,
        area_m2,
        covered_area_m2: 0.0,
        places: Places::Entries,
        rare_scores: job.map.rare_scores(),
        average_left: remaining_in_averages(job, std::iter::once(&entries[..]), |_| 1.0)[0],
    };
    table_row(&job.map, &subject)
}
