//! One comparison of a case: what is compared with which truth, and when it passes.

use serde::Deserialize;

use super::exact::LightPart;
use super::fields::Fraction;
use super::truth_spec::TruthSpec;

/// What is compared with what, and when it passes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Name in the report.
    pub name: String,
    /// Averages, points or elements.
    pub what: What,
    /// Name of the map; without it `elements`.
    #[serde(default = "element_map")]
    pub map: String,
    /// A surface (or all of a geometry) to which an element comparison or an average is restricted.
    pub surface: Option<String>,
    /// Which part of the light.
    #[serde(default)]
    pub light: LightPart,
    /// The exact numbers.
    pub truth: TruthSpec,
    /// Published numbers to show beside the exact ones.
    pub beside: Option<PublishedNumbers>,
    /// When it passes.
    pub criterion: Criterion,
    /// Names of the points, where they have some.
    pub labels: Option<Vec<String>>,
    /// Horizontal axis of the plot; without it the entries in order.
    pub axis: Option<Axis>,
    /// Names of the runs that it belongs to; without it all.
    pub runs: Option<Vec<String>>,
}

/// Name of the element map.
pub const ELEMENT_MAP: &str = "elements";

fn element_map() -> String {
    ELEMENT_MAP.to_owned()
}

/// What kind of numbers are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum What {
    /// A mean over a surface, a receiver set or the whole enclosure.
    Average,
    /// Every point of a receiver set.
    Points,
    /// Every element of the map.
    Elements,
    /// The rating of an observer; what is called illuminance in lx is then UGR.
    Ugr,
}

impl What {
    /// Whether it is a number a run, put into one table with those of other runs.
    pub fn is_one_number(self) -> bool {
        matches!(self, What::Average | What::Ugr)
    }
}

impl Comparison {
    /// Whether a surface, or the geometry that it is a part of, is compared.
    pub fn takes_in(&self, surface: &str, geometry: &str) -> bool {
        self.surface.as_ref().is_none_or(|wanted| wanted == surface || wanted == geometry)
    }
}

/// Published numbers: a column of the truth's reference file, or one number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedNumbers {
    /// Whose numbers they are.
    pub name: String,
    /// The column; empty cells are skipped.
    pub column: Option<String>,
    /// The number in lx; `null` where there is none.
    pub value_lx: Option<f64>,
}

/// When a comparison passes. Whatever is named must hold; that deviations fit their error bars must hold always.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Criterion {
    /// No value deviates by more than this part of the exact one.
    pub worst: Option<Fraction>,
    /// No value deviates by more than this, in the unit of what is compared.
    pub worst_difference: Option<f64>,
    /// The true relative RMS error of the map is at most this.
    pub true_error: Option<Fraction>,
    /// The error bars cover the truth as often as they claim, at this level of significance.
    pub coverage_alpha: Option<f64>,
}

/// Horizontal axis of a plot of points.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// `x`, `y`, `z`: a coordinate in m.
    pub along: Along,
    /// What the axis says.
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
