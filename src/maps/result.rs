//! A finished map: values, standard errors, tables and the error it states.

use super::basis::Linear;
use crate::scene::{ReceiverPoint, Scene};

/// A number and the standard error of it; an error of 0 means exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// One standard error.
    pub standard_error: f64,
}

impl Estimate {
    /// Whether it is told from 0: not where it lies under its own error.
    pub fn is_known(&self) -> bool {
        self.value >= self.standard_error
    }

    /// What the truth is below in 95% of the cases or more: two standard errors above the estimate, or above 0.
    pub fn upper_bound(&self) -> f64 {
        self.value.max(0.0) + 2.0 * self.standard_error
    }
}

/// What a map is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum MapKind {
    /// Area means of the elements, in the order of [`crate::scene::Elements`].
    Elements,
    /// The points of a receiver set: its place in [`crate::scene::Scene::receivers`].
    Receivers(usize),
}

impl MapKind {
    /// Number among the maps of a scene, for random streams: 0 for the elements, `i + 1` for receiver set `i`.
    pub fn number(self) -> u32 {
        match self {
            MapKind::Elements => 0,
            MapKind::Receivers(set) => set as u32 + 1,
        }
    }

    /// `elements`, or the name of the receiver set.
    pub fn name(self, scene: &Scene) -> &str {
        match self {
            MapKind::Elements => "elements",
            MapKind::Receivers(set) => &scene.receivers[set].name,
        }
    }
}

/// Illuminances of one map, arrays by structure: entry `i` is element side or point `i`. For a set that asks for
/// luminance all four are cd/m² instead, and *direct* is what the eye sees of luminaires and of light reflected once.
#[derive(Clone, Debug, Default)]
pub struct MapValues {
    /// Illuminance in lx.
    pub illuminance_lx: Vec<f64>,
    /// Its standard error in lx.
    pub standard_error_lx: Vec<f64>,
    /// The same illuminance in lx by the even and by the odd half alone, which know nothing of each other; empty where a method has no
    /// halves.
    pub halves_lx: Vec<[f64; 2]>,
    /// Part that has met nothing on its way, in lx.
    pub direct_lx: Vec<f64>,
    /// The rest, in lx.
    pub indirect_lx: Vec<f64>,
    /// Standard error of the direct part in lx; empty where a method does not tell it.
    pub direct_standard_error_lx: Vec<f64>,
    /// Adaptive elements: coefficients in lx of the two linear polynomials of [`super::basis`]. Else empty.
    pub slopes_lx: Vec<[f64; 2]>,
    /// Adaptive elements: estimated root mean square in lx of what the element cannot show. Else empty.
    pub discretisation_lx: Vec<f64>,
    /// Of planes where all light is the sky's what comes straight from the sky, by way of something outside, and by way of something inside, in lx;
    /// together the illuminance. Else empty.
    pub sky_components_lx: Vec<[Estimate; 3]>,
    /// Whether something that stands on it covers all of an element that adapts; none where they do not.
    pub covered: Vec<bool>,
}

impl MapValues {
    /// No entry yet, and room for so many of what every map tells.
    pub fn with_capacity(entries: usize) -> MapValues {
        let room = || Vec::with_capacity(entries);
        MapValues {
            illuminance_lx: room(),
            standard_error_lx: room(),
            halves_lx: Vec::with_capacity(entries),
            direct_lx: room(),
            indirect_lx: room(),
            direct_standard_error_lx: room(),
            ..MapValues::default()
        }
    }

    /// What an element shows at its three corners in lx: its mean, or what its slopes make of it, 0 at least.
    pub fn at_corners_lx(&self, site: usize) -> [f64; 3] {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|corner| self.at_lx(site, corner).max(0.0))
    }

    /// What an element shows at a point of it in lx, by the weights of its second and third corner.
    pub fn at_lx(&self, site: usize, at: [f64; 2]) -> f64 {
        let [first_lx, second_lx] = self.slopes_lx.get(site).copied().unwrap_or_default();
        Linear([self.illuminance_lx[site], first_lx, second_lx]).at(at)
    }
}

/// A finished map.
#[derive(Clone, Debug)]
pub struct MapResult {
    /// `elements`, or the receiver set's name.
    pub name: String,
    /// Elements or a receiver set.
    pub kind: MapKind,
    /// Name of the estimator that gave it.
    pub method: String,
    /// Why that one, in words.
    pub method_reason: String,
    /// Chains spent on it.
    pub chains: u64,
    /// Illuminances.
    pub values: MapValues,
    /// The error it states.
    pub error: MapError,
    /// Whether the target binds it.
    pub bound: bool,
    /// Whether the stop rule accepted it; `None` without a target.
    pub target_met: Option<bool>,
    /// Looks at which the stop rule accepted it and a statistical check refused.
    pub refusals: u64,
    /// Statistical checks of its samples; empty where there are none to check.
    pub checks: Vec<StatisticalCheck>,
    /// One row a surface side, or one row for the set.
    pub tables: Vec<TableRow>,
}

impl MapResult {
    /// The values of those points of the map's set that count, with their weights.
    pub fn counted<'a>(&'a self, points: &'a [ReceiverPoint]) -> impl Iterator<Item = (Estimate, f64)> + 'a {
        let counted = points.iter().enumerate().filter(|(_, point)| !point.inside && point.weight > 0.0);
        counted.map(|(index, point)| {
            let estimate = Estimate {
                value: self.values.illuminance_lx[index],
                standard_error: self.values.standard_error_lx[index],
            };
            (estimate, point.weight)
        })
    }
}

/// A statistical check of a map: whether its error can be believed.
#[derive(Clone, Debug, PartialEq)]
pub struct StatisticalCheck {
    /// `mean`, `error`, `figure of merit`, `tail` or `scores`.
    pub name: &'static str,
    /// Whether nothing was found.
    pub passed: bool,
    /// What was measured; `None` where the run is too short to tell, or chance has no part.
    pub value: Option<f64>,
    /// What it must not exceed (`scores`: not fall below).
    pub limit: f64,
    /// What it means where it fails.
    pub says: String,
}

/// The stated error of a map and its parts, as fractions of the map's mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapError {
    /// Random part: from the even and the odd half.
    pub random: f64,
    /// Estimated bias (look-up, mesh); 0 for an unbiased method.
    pub bias: f64,
    /// Estimated discretisation error of adaptive elements; 0 where values stand for means and points alone.
    pub discretisation: f64,
    /// All of them in quadrature: the stated error.
    pub estimated: f64,
    /// Effective degrees of freedom k = (tr C)²/tr C² of the random part.
    pub degrees_of_freedom: f64,
    /// For a map that nothing has reached yet: upper bound of its mean in lx.
    pub dark_upper_bound_lx: Option<f64>,
}

impl MapError {
    /// What the mean of a map is below in which no light was found, in words: two digits of lx.
    pub fn dark_bound_words(&self) -> Option<String> {
        self.dark_upper_bound_lx.map(|bound_lx| match bound_lx {
            0.1.. => format!("{bound_lx:.2} lx"),
            _ => format!("{bound_lx:.1e} lx"),
        })
    }
}

/// What a table row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableKind {
    /// One side of a surface.
    Surface,
    /// A grid of receivers.
    Grid,
    /// Receivers in no order.
    Points,
    /// Directions of view: the numbers are luminances in cd/m².
    Luminance,
    /// An intensity distribution: the numbers are intensities in cd, the average that over all directions.
    Intensity,
    /// A glare rating: the numbers are the indirect illuminance of the eye.
    Glare,
}

impl TableKind {
    /// Whether the row's numbers are illuminances that a result table lists.
    pub fn is_illuminance(self) -> bool {
        matches!(self, TableKind::Surface | TableKind::Grid | TableKind::Points)
    }
}

impl TableKind {
    /// Name as the table writes it.
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

/// A row of the result table, as lighting engineers expect it.
#[derive(Clone, Debug)]
pub struct TableRow {
    /// Surface or receiver set.
    pub name: String,
    /// What it is.
    pub kind: TableKind,
    /// `front` or `back`.
    pub side: &'static str,
    /// Ē: weighted mean in lx.
    pub average_lx: Estimate,
    /// Emin in lx, the least illuminance of the places.
    pub minimum_lx: Estimate,
    /// Emax in lx, the greatest.
    pub maximum_lx: Estimate,
    /// U0 = Emin/Ē.
    pub uniformity_u0: Estimate,
    /// Ud = Emin/Emax.
    pub uniformity_ud: Estimate,
    /// How far in lx chance may have pulled Emin and Emax: in their errors and in those of the uniformities, in squares.
    pub pulled_lx: [f64; 2],
    /// Places of which Emin and Emax are told: the points of a receiver set, or the cells of a grid on a surface. 0: there is no such
    /// grid, and minimum, maximum and uniformities are 0.
    pub places: usize,
    /// Area in m² (0 for loose points without areas), of a surface that of what shows.
    pub area_m2: f64,
    /// Area in m² of a surface side that something covers, as far as that is known.
    pub covered_area_m2: f64,
    /// Relative RMS error of the row's own values.
    pub estimated_error: f64,
    /// Ē of each replica in lx, so that means over several rows get an error that knows how the rows hang together.
    /// Empty where there are no replicas.
    pub replica_averages_lx: Vec<f64>,
}

impl TableRow {
    /// Whether anything of it shows: a face that stands on another as a whole has no light to tell of.
    pub fn shows(&self) -> bool {
        self.area_m2 > 0.0 || self.covered_area_m2 <= 0.0
    }

    /// Whether least and greatest are told and light was found.
    pub fn knows_extremes(&self) -> bool {
        self.places > 0 && self.average_lx.is_known()
    }

    /// Emin, where it is told. One that lies under its own error says that the place may be dark.
    pub fn least(&self) -> Option<Estimate> {
        self.knows_extremes().then_some(self.minimum_lx)
    }

    /// Emax, where it is told: one that lies under its own error says nothing, as the average that is known lies below it.
    pub fn greatest(&self) -> Option<Estimate> {
        (self.knows_extremes() && self.maximum_lx.is_known()).then_some(self.maximum_lx)
    }

    /// U0, where it says anything: all that it is made of is told from 0.
    pub fn u0(&self) -> Option<Estimate> {
        let is_known = self.knows_extremes() && self.average_lx.value > 0.0 && self.minimum_lx.is_known();
        is_known.then_some(self.uniformity_u0)
    }

    /// Ud, likewise.
    pub fn ud(&self) -> Option<Estimate> {
        self.u0().and(self.greatest()).map(|_| self.uniformity_ud)
    }
}
