//! Errors and table rows of maps whose errors are not random: those of a sum add up, in the worst case.

use std::ops::Range;

use super::{Estimate, MapError, MapValues, TableKind, TableRow};

/// Values, errors and weights of a part of a map.
pub struct StatedValues<'a> {
    illuminance_lx: &'a [f64],
    error_lx: &'a [f64],
    weights: &'a [f64],
}

impl<'a> StatedValues<'a> {
    /// A range of a map's entries; `weights` are those of the whole map.
    pub fn of(values: &'a MapValues, weights: &'a [f64], range: Range<usize>) -> StatedValues<'a> {
        StatedValues {
            illuminance_lx: &values.illuminance_lx[range.clone()],
            error_lx: &values.standard_error_lx[range.clone()],
            weights: &weights[range],
        }
    }

    fn mean(&self, of: impl Fn(usize) -> f64) -> f64 {
        let weight: f64 = self.weights.iter().sum();
        let sum: f64 = self.weights.iter().enumerate().map(|(i, w)| w * of(i)).sum();
        if weight > 0.0 { sum / weight } else { 0.0 }
    }

    fn relative_error(&self) -> f64 {
        let mean_lx = self.mean(|i| self.illuminance_lx[i]);
        if mean_lx > 0.0 { self.mean(|i| self.error_lx[i].powi(2)).sqrt() / mean_lx } else { 0.0 }
    }
}

/// The stated error of a map: all of it a bias.
pub fn stated_error(values: &StatedValues) -> MapError {
    let bias = values.relative_error();
    MapError {
        random: 0.0,
        bias,
        discretisation: 0.0,
        estimated: bias,
        degrees_of_freedom: 0.0,
        dark_upper_bound_lx: None,
    }
}

/// A table row of one side.
pub fn stated_row(name: &str, kind: TableKind, side: &'static str, area_m2: f64, values: &StatedValues) -> TableRow {
    let average_lx = Estimate {
        value: values.mean(|i| values.illuminance_lx[i]),
        standard_error: values.mean(|i| values.error_lx[i]),
    };
    let counted = || (0..values.weights.len()).filter(|i| values.weights[*i] > 0.0);
    let least = counted().min_by(|a, b| values.illuminance_lx[*a].total_cmp(&values.illuminance_lx[*b]));
    let minimum_lx = least.map_or(Estimate::default(), |i| Estimate {
        value: values.illuminance_lx[i],
        standard_error: values.error_lx[i],
    });
    let maximum_lx = counted().map(|i| values.illuminance_lx[i]).fold(0.0, f64::max);
    let ratio = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    let u0 = ratio(minimum_lx.value, average_lx.value);
    let u0_error = ratio(minimum_lx.standard_error + u0 * average_lx.standard_error, average_lx.value);
    TableRow {
        name: name.to_owned(),
        kind,
        side,
        average_lx,
        minimum_lx,
        maximum_lx,
        uniformity_u0: Estimate { value: u0, standard_error: u0_error },
        uniformity_ud: ratio(minimum_lx.value, maximum_lx),
        area_m2,
        estimated_error: values.relative_error(),
        replica_averages_lx: Vec::new(),
    }
}
