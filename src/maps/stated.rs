//! Errors and table rows of maps whose errors are not random. Such errors add up linearly in a sum: this is the worst case.

use std::ops::Range;

use super::{CellSlopes, Estimate, MapError, MapValues, TableKind, TableRow};
use crate::scene::EvaluationGrid;

/// Values, errors and weights of a part of a map.
pub struct StatedValues<'a> {
    value: &'a [f64],
    error: &'a [f64],
    weights: &'a [f64],
}

impl<'a> StatedValues<'a> {
    /// Returns a range of a map's entries. `weights` are the weights of the whole map.
    pub fn of(values: &'a MapValues, weights: &'a [f64], range: Range<usize>) -> StatedValues<'a> {
        StatedValues {
            value: &values.value[range.clone()],
            error: &values.standard_error[range.clone()],
            weights: &weights[range],
        }
    }

    /// Returns all values of positive weight, each as an evaluation point of its own.
    pub fn places(&self) -> Vec<Estimate> {
        let counted = (0..self.weights.len()).filter(|i| self.weights[*i] > 0.0);
        counted.map(|i| Estimate { value: self.value[i], standard_error: self.error[i] }).collect()
    }

    fn mean(&self, of: impl Fn(usize) -> f64) -> f64 {
        let weight: f64 = self.weights.iter().sum();
        let sum: f64 = self.weights.iter().enumerate().map(|(i, w)| w * of(i)).sum();
        if weight > 0.0 { sum / weight } else { 0.0 }
    }

    fn relative_error(&self) -> f64 {
        let mean = self.mean(|i| self.value[i]);
        if mean > 0.0 { self.mean(|i| self.error[i].powi(2)).sqrt() / mean } else { 0.0 }
    }
}

/// Returns the error of a map whose values have an error each, for example by light meshes. All of it is bias.
pub fn worst_case_error(values: &StatedValues) -> MapError {
    let bias = values.relative_error();
    MapError {
        random: 0.0,
        bias,
        discretisation: 0.0,
        estimated: bias,
        degrees_of_freedom: 0.0,
        dark_upper_bound: None,
    }
}

/// Returns a grid's cells on a surface, with what the map holds there and its errors. The result is empty where elements are coarser than
/// the grid.
pub fn grid_places(
    values: &MapValues,
    grid: Option<&EvaluationGrid>,
    slopes: impl Fn(&EvaluationGrid) -> Vec<CellSlopes>,
) -> Vec<Estimate> {
    let Some(grid) = grid.filter(|grid| !grid.is_finer_than_elements) else { return Vec::new() };
    let mean = |cell: &[crate::scene::GridPart], of: &[f64]| {
        let area_m2: f64 = cell.iter().map(|part| part.area_m2).sum();
        cell.iter().map(|part| part.area_m2 * part.scale * of[part.element as usize]).sum::<f64>() / area_m2
    };
    let slopes = slopes(grid);
    let place = |(number, cell): (usize, &Vec<crate::scene::GridPart>)| {
        let mut place =
            Estimate { value: mean(cell, &values.value), standard_error: mean(cell, &values.standard_error) };
        if let Some(CellSlopes { weights, lost_lx2 }) = slopes.get(number) {
            for (element, weight) in weights {
                place.value += weight * values.value[*element as usize];
                place.standard_error += weight.abs() * values.standard_error[*element as usize];
            }
            place.standard_error += lost_lx2.sqrt();
        }
        place
    };
    grid.cells.iter().enumerate().map(place).collect()
}

/// Builds the table row of one side. `places` holds the values for minimum and maximum: all values of the side, or the cells of a grid.
pub fn stated_row(
    name: &str,
    kind: TableKind,
    side: &'static str,
    area_m2: f64,
    values: &StatedValues,
    places: &[Estimate],
) -> TableRow {
    let average =
        Estimate { value: values.mean(|i| values.value[i]), standard_error: values.mean(|i| values.error[i]) };
    let by_value = |a: &&Estimate, b: &&Estimate| a.value.total_cmp(&b.value);
    let minimum = places.iter().min_by(by_value).copied().unwrap_or_default();
    let maximum = places.iter().max_by(by_value).copied().unwrap_or_default();
    TableRow {
        name: name.to_owned(),
        kind,
        side,
        average,
        minimum,
        maximum,
        uniformity_u0: ratio(minimum, average),
        uniformity_ud: ratio(minimum, maximum),
        pulled: [0.0; 2],
        places: places.len(),
        area_m2,
        covered_area_m2: 0.0,
        estimated_error: values.relative_error(),
        replica_averages: Vec::new(),
    }
}

/// Returns a ratio with its error in the worst case: the relative effects of both numbers' errors add up.
fn ratio(part: Estimate, whole: Estimate) -> Estimate {
    if whole.value <= 0.0 {
        return Estimate::default();
    }
    let value = part.value / whole.value;
    Estimate { value, standard_error: (part.standard_error + value * whole.standard_error) / whole.value }
}
