//! A finished map: values, standard errors, tables and the stated error.

use crate::estimators::basis::Linear;
use crate::scene::{Quantity, ReceiverPoint, Scene};

/// A number with its standard error. An error of 0 means exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// One standard error.
    pub standard_error: f64,
}

impl Estimate {
    /// Whether the value is distinct from 0: it is not where it is smaller than its own error.
    pub fn is_known(&self) -> bool {
        self.value >= self.standard_error
    }

    /// Returns an upper bound of the true value with at least 95% probability: two standard errors above the estimate, or above 0 for a
    /// negative estimate.
    pub fn upper_bound(&self) -> f64 {
        self.value.max(0.0) + 2.0 * self.standard_error
    }
}

/// Subject of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum MapKind {
    /// Area means of the elements, in the order of [`crate::scene::Elements`].
    Elements,
    /// Points of a receiver set, given by its index in [`crate::scene::Scene::receivers`].
    Receivers(usize),
}

impl MapKind {
    /// Returns the number among the maps of a scene, for random streams: 0 for the elements, `i + 1` for receiver set `i`.
    pub fn number(self) -> u32 {
        match self {
            MapKind::Elements => 0,
            MapKind::Receivers(set) => set as u32 + 1,
        }
    }

    /// Returns `elements`, or the name of the receiver set.
    pub fn name(self, scene: &Scene) -> &str {
        match self {
            MapKind::Elements => "elements",
            MapKind::Receivers(set) => &scene.receivers[set].name,
        }
    }

    /// Returns the quantity of the map's values: elements have illuminances of their own planes.
    pub fn quantity(self, scene: &Scene) -> Quantity {
        match self {
            MapKind::Elements => Quantity::Perpendicular,
            MapKind::Receivers(set) => scene.receivers[set].quantity,
        }
    }
}

/// Values of one map as a structure of arrays: entry `i` is element side or point `i`. They are in the unit of the map's `quantity`
/// ([`MapResult::quantity`]). For a luminance, *direct* is what the eye sees of luminaires and of light reflected once.
#[derive(Clone, Debug, Default)]
pub struct MapValues {
    /// The value, in the unit of `quantity`.
    pub value: Vec<f64>,
    /// Standard error of the value, in the unit of `quantity`.
    pub standard_error: Vec<f64>,
    /// Value from the even and from the odd half alone, in the unit of `quantity`. The halves are independent. Empty for a method without
    /// halves.
    pub halves: Vec<[f64; 2]>,
    /// Direct part, in the unit of `quantity`: light that has met nothing on its way.
    pub direct: Vec<f64>,
    /// Indirect part, in the unit of `quantity`: the rest.
    pub indirect: Vec<f64>,
    /// Standard error of the direct part, in the unit of `quantity`; empty for a method that does not give it.
    pub direct_standard_error: Vec<f64>,
    /// Adaptive elements: coefficients in lx of the two linear polynomials of [`crate::estimators::basis`]. Empty otherwise.
    pub slopes_lx: Vec<[f64; 2]>,
    /// Adaptive elements: estimated root mean square in lx of the variation that the element cannot show. Empty otherwise.
    pub discretisation_lx: Vec<f64>,
    /// For planes with light from the sky only: light directly from the sky, by way of something outside, and by way of something inside,
    /// in lx. Their sum is the illuminance. Empty otherwise.
    pub sky_components_lx: Vec<[Estimate; 3]>,
    /// Adaptive elements: whether the element is completely hidden by contact with something on it. Empty otherwise.
    pub in_contact: Vec<bool>,
}

impl MapValues {
    /// Returns values without entries, with capacity for `entries` entries in the arrays that every map has.
    pub fn with_capacity(entries: usize) -> MapValues {
        let room = || Vec::with_capacity(entries);
        MapValues {
            value: room(),
            standard_error: room(),
            halves: Vec::with_capacity(entries),
            direct: room(),
            indirect: room(),
            direct_standard_error: room(),
            ..MapValues::default()
        }
    }

    /// Returns the illuminance in lx that an element shows at its three corners, at least 0. It is the mean, plus the slopes where there
    /// are any.
    pub fn at_corners_lx(&self, site: usize) -> [f64; 3] {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|corner| self.at_lx(site, corner).max(0.0))
    }

    /// Returns the illuminance in lx that an element shows at a point, given by the weights of its second and third corner.
    pub fn at_lx(&self, site: usize, at: [f64; 2]) -> f64 {
        let [first_lx, second_lx] = self.slopes_lx.get(site).copied().unwrap_or_default();
        Linear([self.value[site], first_lx, second_lx]).at(at)
    }
}

/// A finished map.
#[derive(Clone, Debug)]
pub struct MapResult {
    /// `elements`, or the receiver set's name.
    pub name: String,
    /// Elements or a receiver set.
    pub kind: MapKind,
    /// The quantity of its values and tables. [`Quantity::unit`] is their unit.
    pub quantity: Quantity,
    /// Name of the estimator that computed it.
    pub method: String,
    /// Reason for this estimator, in words.
    pub method_reason: String,
    /// Number of chains spent on it.
    pub chains: u64,
    /// Its values.
    pub values: MapValues,
    /// The error that the map states.
    pub error: MapError,
    /// Whether the target applies to it.
    pub bound: bool,
    /// Whether the stop rule accepted it; `None` without a target.
    pub target_met: Option<bool>,
    /// Number of looks (error checks) at which the stop rule accepted the map and a statistical check refused it.
    pub refusals: u64,
    /// Statistical checks of its samples; empty if there are none to check.
    pub checks: Vec<StatisticalCheck>,
    /// One row per surface side, or one row for the set.
    pub tables: Vec<TableRow>,
}

impl MapResult {
    /// Returns in words the upper bound of the mean of a map without light, with its unit and two digits.
    pub fn dark_bound_words(&self) -> Option<String> {
        let unit = self.quantity.unit();
        self.error.dark_upper_bound.map(|bound| match bound {
            0.1.. => format!("{bound:.2} {unit}"),
            _ => format!("{bound:.1e} {unit}"),
        })
    }

    /// Returns the values of the points of the map's set that count, with their weights.
    pub fn counted<'a>(&'a self, points: &'a [ReceiverPoint]) -> impl Iterator<Item = (Estimate, f64)> + 'a {
        let counted = points.iter().enumerate().filter(|(_, point)| !point.inside && point.weight > 0.0);
        counted.map(|(index, point)| {
            let estimate =
                Estimate { value: self.values.value[index], standard_error: self.values.standard_error[index] };
            (estimate, point.weight)
        })
    }
}

/// A statistical check of a map: whether its error is credible.
#[derive(Clone, Debug, PartialEq)]
pub struct StatisticalCheck {
    /// `mean`, `error`, `figure of merit`, `tail` or `scores`.
    pub name: &'static str,
    /// Whether the check found no fault.
    pub passed: bool,
    /// Measured value; `None` if the run is too short, or if the map has no random error.
    pub value: Option<f64>,
    /// Limit that the value must not exceed (`scores`: must not fall below).
    pub limit: f64,
    /// Meaning of a failed check.
    pub explanation: String,
}

/// The stated error of a map and its parts, as fractions of the map's mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapError {
    /// Random part, from the even and the odd half.
    pub random: f64,
    /// Estimated bias (cache look-up, mesh); 0 for an unbiased method.
    pub bias: f64,
    /// Estimated discretisation error of adaptive elements; 0 where values stand only for means and points.
    pub discretisation: f64,
    /// The stated error: all parts in quadrature.
    pub estimated: f64,
    /// Effective degrees of freedom k = (tr C)²/tr C² of the random part.
    pub degrees_of_freedom: f64,
    /// Upper bound of the mean, for a map that no light has reached yet; in the unit of its values.
    pub dark_upper_bound: Option<f64>,
}

/// Subject of a table row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableKind {
    /// One side of a surface.
    Surface,
    /// A grid of receivers.
    Grid,
    /// Receivers without an order.
    Points,
    /// Directions of view: the numbers are luminances in cd/m².
    Luminance,
    /// An intensity distribution: the numbers are intensities in cd, and the average is over all directions.
    Intensity,
    /// A glare rating: the numbers are the indirect illuminance at the eye.
    Glare,
}

impl TableKind {
    /// Whether the row's numbers are illuminances that a result table lists.
    pub fn is_illuminance(self) -> bool {
        matches!(self, TableKind::Surface | TableKind::Grid | TableKind::Points)
    }
}

impl TableKind {
    /// Returns the name written in the table.
    pub fn name(self) -> &'static str {
        match self {
            TableKind::Surface => "surface",
            TableKind::Grid => "grid",
            TableKind::Points => "points",
            TableKind::Luminance => "luminance",
            TableKind::Glare => "ugr",
            TableKind::Intensity => "intensity",
        }
    }
}

/// A row of the result table, in the form that lighting engineers use.
#[derive(Clone, Debug)]
pub struct TableRow {
    /// Name of the surface or receiver set.
    pub name: String,
    /// Subject of the row.
    pub kind: TableKind,
    /// `front` or `back`.
    pub side: &'static str,
    /// Weighted mean, in the unit of the map's `quantity`: Ē of an illuminance.
    pub average: Estimate,
    /// Minimum over the evaluation points, in the unit of `quantity`: Emin.
    pub minimum: Estimate,
    /// Maximum over the evaluation points, in the unit of `quantity`: Emax.
    pub maximum: Estimate,
    /// U0 = Emin/Ē.
    pub uniformity_u0: Estimate,
    /// Ud = Emin/Emax.
    pub uniformity_ud: Estimate,
    /// Distance by which chance may have pulled minimum and maximum, in the unit of `quantity`. Their errors and those of the uniformities
    /// include it in quadrature.
    pub pulled: [f64; 2],
    /// Number of evaluation points for Emin and Emax: the points of a receiver set, or the cells of a grid on a surface. With 0 there is no
    /// grid, and minimum, maximum and uniformities are 0.
    pub places: usize,
    /// Area in m² (0 for loose points without areas). For a surface it is the visible area only.
    pub area_m2: f64,
    /// Area in m² of a surface side that is hidden by contact, as far as it is known.
    pub covered_area_m2: f64,
    /// Relative RMS error of the row's own values.
    pub estimated_error: f64,
    /// Mean of each replica, in the unit of `quantity`. With it, the error of a mean over several rows accounts for the correlation between
    /// rows. Empty where there are no replicas.
    pub replica_averages: Vec<f64>,
}

impl TableRow {
    /// Whether any part of it is visible. A face that is completely hidden by contact has no light to report.
    pub fn shows(&self) -> bool {
        self.area_m2 > 0.0 || self.covered_area_m2 <= 0.0
    }

    /// Whether minimum and maximum exist and light was found.
    pub fn knows_extremes(&self) -> bool {
        self.places > 0 && self.average.is_known()
    }

    /// Returns Emin, if it is known. A value below its own error shows that the point may be dark.
    pub fn least(&self) -> Option<Estimate> {
        self.knows_extremes().then_some(self.minimum)
    }

    /// Returns Emax, if it is known. A value below its own error gives no information, because the known average is below it.
    pub fn greatest(&self) -> Option<Estimate> {
        (self.knows_extremes() && self.maximum.is_known()).then_some(self.maximum)
    }

    /// Returns U0, if it gives information: average and minimum must be distinct from 0.
    pub fn u0(&self) -> Option<Estimate> {
        let is_known = self.knows_extremes() && self.average.value > 0.0 && self.minimum.is_known();
        is_known.then_some(self.uniformity_u0)
    }

    /// Returns Ud, if U0 and Emax give information.
    pub fn ud(&self) -> Option<Estimate> {
        self.u0().and(self.greatest()).map(|_| self.uniformity_ud)
    }
}
