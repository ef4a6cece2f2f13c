//! Reads `spherical_harmonics`: a smooth closed body by the coefficients of its radius, in the scene or in a file.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::bodies::{Body, corner_directions, leaves};
use super::error::SceneError;
use super::keys::{ANY_LENGTH, Key, NUMBER, TEXT, VECTOR, ValueShape, optional};
use super::placing::Placing;
use super::plain_file::read_plain_file;
use super::reader::{Fields, Node, Source};
use super::shapes::{GeometryShape, ShapePart};
use super::units::LengthUnit;
use crate::base::harmonics::{HarmonicSeries, LARGEST_DEGREE, place_of};

/// Keys of this geometry alone.
#[rustfmt::skip]
pub(super) const OWN_KEYS: &[Key] = &[
    optional("center", VECTOR, "Point from which the radius is measured (the origin by default)."),
    optional("coefficients", ValueShape::List(&ValueShape::Tuple(&[ValueShape::Index, ValueShape::Whole, NUMBER]), ANY_LENGTH),
        "Terms [l, m, coefficient] of r = Σ c_lm Y_lm, l up to 31; instead of a file."),
    optional("file", TEXT, "The file of coefficients (CSV, `l,m,coefficient`)."),
];
/// First line of a file of coefficients.
pub const HEADER: &str = "l,m,coefficient";
/// Largest file of coefficients in bytes.
const MOST_BYTES: u64 = 1 << 20;

/// A body in the file's unit.
pub(super) struct WrittenBody {
    series: HarmonicSeries,
    center: DVec3,
    inward: bool,
}

impl WrittenBody {
    /// Places the body. Its leaves are a scene's triangles from `first_triangle` on.
    pub fn placed(&self, placing: &Placing, unit: LengthUnit, first_triangle: u32) -> Arc<Body> {
        let longer = unit.length_m(placing.scale);
        let series = HarmonicSeries::new(self.series.coefficients().iter().map(|c| c * longer).collect());
        let center_m = unit.point_m(placing.apply(self.center));
        let end = first_triangle + leaves(self.inward).len() as u32;
        Arc::new(Body::new(series, center_m, placing.turn(), self.inward, first_triangle..end))
    }
}

/// Reads a body and its leaves.
pub(super) fn read(fields: &Fields, base_dir: &Path, inward: bool) -> Result<(GeometryShape, WrittenBody), SceneError> {
    let center = fields.get("center").map_or(Ok(DVec3::ZERO), |node| node.vector())?;
    let (which, node) = fields.one_of(["coefficients", "file"])?;
    let series = if which == 0 { of_list(&node)? } else { of_file(&node, base_dir)? };
    let bounds = series.bounds();
    if !(bounds.low > 0.0 && bounds.high.is_finite()) {
        return Err(node.refuse_as(
            "the radius is not above 0 in all directions",
            format!("between {:.3} and {:.3}", bounds.low, bounds.high),
            "a series above 0 everywhere, with a margin of 9% of its range",
            "enlarge the coefficient of l = 0, m = 0, or make the others smaller",
        ));
    }
    let corner = |direction: DVec3| center + series.value_and_slope(direction).0 * direction;
    let vertices = corner_directions().into_iter().map(corner).collect();
    let shape = GeometryShape { vertices, parts: vec![ShapePart { name: None, triangles: leaves(inward) }] };
    Ok((shape, WrittenBody { series, center, inward }))
}

/// Returns degree, order and value of a term, if the numbers are valid.
fn term(numbers: &[f64]) -> Option<(usize, i64, f64)> {
    let [l, m, value] = *numbers else { return None };
    let fits = l.fract() == 0.0 && m.fract() == 0.0 && (0.0..=LARGEST_DEGREE as f64).contains(&l) && m.abs() <= l;
    (fits && value.is_finite()).then_some((l as usize, m as i64, value))
}

/// Describes a valid term.
fn expected() -> String {
    format!("a degree l of 0 to {LARGEST_DEGREE}, an order m of −l to l, and a length, each pair once")
}

/// Makes the series of some terms. The error is the index of the first repeated term.
fn series_of(terms: &[(usize, i64, f64)]) -> Result<HarmonicSeries, usize> {
    let degree = terms.iter().map(|(l, ..)| *l).max().unwrap_or(0);
    let mut coefficients = vec![None; (degree + 1) * (degree + 1)];
    for (number, (l, m, value)) in terms.iter().enumerate() {
        if coefficients[place_of(*l, *m)].replace(*value).is_some() {
            return Err(number);
        }
    }
    Ok(HarmonicSeries::new(coefficients.into_iter().map(Option::unwrap_or_default).collect()))
}

fn of_list(node: &Node) -> Result<HarmonicSeries, SceneError> {
    let items = node.items("coefficients")?;
    let refuse = |item: &Node| item.refuse("this is not a term of a series", expected(), "write [l, m, coefficient]");
    let mut terms = Vec::with_capacity(items.len());
    for item in &items {
        let numbers = item.items("a term")?.iter().map(|number| number.number()).collect::<Result<Vec<f64>, _>>()?;
        terms.push(term(&numbers).ok_or_else(|| refuse(item))?);
    }
    series_of(&terms).map_err(|number| refuse(&items[number]))
}

fn of_file(node: &Node, base_dir: &Path) -> Result<HarmonicSeries, SceneError> {
    let path = base_dir.join(node.name()?);
    let read = || -> Result<HarmonicSeries, SceneError> {
        let bytes = read_plain_file(&path, MOST_BYTES).map_err(|error| {
            let what = format!("cannot read {}", path.display());
            SceneError::of_file(&path, what, error.to_string(), "a file of coefficients", "check the name")
        })?;
        let text = String::from_utf8_lossy(&bytes);
        let source = Source { text: &text, path: &path };
        let mut start = 0;
        let mut terms = Vec::new();
        let mut places = Vec::new();
        for (number, line) in text.split_inclusive('\n').enumerate() {
            let place = start..start + line.trim_end().len();
            start += line.len();
            let line = line.trim().trim_start_matches('\u{feff}');
            let refuse = |expected: String| {
                source.refuse(
                    place.clone(),
                    "",
                    "this is not a term of a series",
                    format!("{line:?}"),
                    expected,
                    "correct the line",
                )
            };
            if number == 0 {
                if line != HEADER {
                    return Err(refuse(format!("the header {HEADER}")));
                }
                continue;
            }
            if line.is_empty() {
                continue;
            }
            let numbers: Option<Vec<f64>> = line.split(',').map(|field| field.trim().parse().ok()).collect();
            let read = numbers.and_then(|numbers| term(&numbers)).ok_or_else(|| refuse(expected()))?;
            terms.push(read);
            places.push(place);
        }
        series_of(&terms).map_err(|number| {
            let what = "a term is given twice";
            source.refuse(places[number].clone(), "", what, "the same l and m again", expected(), "leave out one")
        })
    };
    read().map_err(|error| error.named_by(node.as_namer()))
}

/// Writes a series as a file of coefficients: one line per term, in the order of l and m.
pub fn series_file(series: &HarmonicSeries) -> String {
    let mut text = format!("{HEADER}\n");
    for l in 0..=series.degree() {
        for m in -(l as i64)..=l as i64 {
            text.push_str(&format!("{l},{m},{}\n", series.coefficients()[place_of(l, m)]));
        }
    }
    text
}
