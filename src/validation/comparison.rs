//! One comparison of a case: what is compared with which truth, and when it passes.

use serde::Deserialize;

use super::exact::LightPart;
use super::fields::Fraction;
use super::truth_spec::TruthSpec;

/// What is compared with which truth, and when it passes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Name in the report.
    pub name: String,
    /// Kind of the numbers: averages, points, elements or a UGR rating.
    pub what: What,
    /// Name of the map; default `elements`.
    #[serde(default = "element_map")]
    pub map: String,
    /// A surface (or all of a geometry) to which an element comparison or an average is restricted.
    pub surface: Option<String>,
    /// Part of the light that is compared.
    #[serde(default)]
    pub light: LightPart,
    /// Source of the exact numbers.
    pub truth: TruthSpec,
    /// Published numbers to show beside the exact ones.
    pub beside: Option<PublishedNumbers>,
    /// Condition to pass.
    pub criterion: Criterion,
    /// Names of the points, if they have names.
    pub labels: Option<Vec<String>>,
    /// Horizontal axis of the plot; without it the entries appear in order.
    pub axis: Option<Axis>,
    /// Names of the runs that the comparison belongs to; without them all runs.
    pub runs: Option<Vec<String>>,
}

/// Name of the element map.
pub const ELEMENT_MAP: &str = "elements";

fn element_map() -> String {
    ELEMENT_MAP.to_owned()
}

/// Kind of the compared numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum What {
    /// A mean over a surface, a receiver set or the whole enclosure.
    Average,
    /// Every point of a receiver set.
    Points,
    /// Every element of the map.
    Elements,
    /// The UGR rating of an observer. Fields called illuminance in lx then contain UGR values.
    Ugr,
}

impl What {
    /// Returns whether each run gives one number, so that one table shows the numbers of several runs.
    pub fn is_one_number(self) -> bool {
        matches!(self, What::Average | What::Ugr)
    }
}

impl Comparison {
    /// Returns whether a surface belongs to the comparison, by its name or by its geometry's name.
    pub fn takes_in(&self, surface: &str, geometry: &str) -> bool {
        self.surface.as_ref().is_none_or(|wanted| wanted == surface || wanted == geometry)
    }
}

/// Published numbers: a column of the truth's reference file, or one number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedNumbers {
    /// Source of the numbers.
    pub name: String,
    /// The column; empty cells are skipped.
    pub column: Option<String>,
    /// The number in lx; `null` if there is none.
    pub value_lx: Option<f64>,
}

/// Conditions for a comparison to pass. Every condition that is given must hold. Deviations must always be consistent with their
/// error bars.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Criterion {
    /// Maximum deviation of every value, relative to the exact value.
    pub worst: Option<Fraction>,
    /// Maximum deviation of every value, in the unit of the compared values.
    pub worst_difference: Option<f64>,
    /// Maximum of the map's true relative RMS error.
    pub true_error: Option<Fraction>,
    /// Level of significance at which the error bars must cover the truth as often as they claim.
    pub coverage_alpha: Option<f64>,
}

/// Horizontal axis of a plot of points.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// `x`, `y`, `z`: a coordinate in m.
    pub along: Along,
    /// Label of the axis.
    pub label: String,
}

/// A coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Along {
    /// First coordinate.
    X,
    /// Second coordinate.
    Y,
    /// Third coordinate.
    Z,
}

impl Along {
    /// Its letter.
    pub fn name(self) -> &'static str {
        match self {
            Along::X => "x",
            Along::Y => "y",
            Along::Z => "z",
        }
    }
}
