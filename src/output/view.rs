//! The view of the scene in space, for `report.html`: false colours that can be turned, and numbers at the picked point.
//!
//! The page contains the numbers as columns of two-byte values, and a script that draws them with WebGL. It loads no other files.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde_json::json;

use super::color::perceptual;
use super::numbers::{grouped, percent};
use super::picture::escaped;
use super::plan::{SMOOTH_COSINE, edges_with_triangles};
use super::scale::end_of_scale_lx;
use super::texts::{decimal, said, say, words};
use super::view_columns::{Columns, LuxCode, PlaceCode, SPAN};
use crate::maps::{MapKind, MapResult};
use crate::scene::{Elements, ReceiverLayout, ReceiverSet, Scene, Side};
use crate::solver::Solution;

const MARKUP: &str = include_str!("view.html");
const STYLE: &str = include_str!("view.css");
const SCRIPT: &str = include_str!("view.js");

/// Largest number of triangles of surfaces in a page. If there are more, the parts of the scene's largest triangles are shown.
const MOST_FACETS: usize = 300_000;
/// Largest number of receiver points in a page; further sets are left out.
const MOST_POINTS: usize = 40_000;
/// Largest number of lines of outlines; if there are more, the longest are shown.
const MOST_LINES: usize = 20_000;
/// Largest number of luminaires that are marked.
const MOST_LUMINAIRES: usize = 2_000;
/// Name of a surface that the report does not list.
const UNNAMED: &str = words!("not in the tables");
/// Texts for a picked point, with placeholders for names and numbers: no object; no number; a value below its error; an element or
/// receiver; and a point on an element.
const READINGS: [&str; 5] = [
    words!("Nothing there. Pick a point to read it."),
    words!("{}: no number here. At {} m."),
    words!("{}: < {} lx. At {} m."),
    words!("{}: {} ± {} lx; direct {} lx, indirect {} lx. At {} m."),
    words!("{}: {} ± {} lx on this element, {} lx at the point; direct {} lx, indirect {} lx. At {} m."),
];
/// Largest number of names that a column can number.
const MOST_PARTS: usize = 65_535;
/// Size of a luminaire's mark, and of a receiver point without a cell, as shares of the scene's size.
const MARK: f64 = 0.012;
const POINT: f64 = 0.006;
/// Number of intervals of the colour scale in the page.
const STOPS: u32 = 32;

/// The section of the page. It stays hidden if the browser has no WebGL or runs no scripts.
pub fn view_section(scene: &Scene, solution: &Solution) -> String {
    let view = ViewPage::of(scene, solution);
    let (about, data) = view.packed();
    // Names may contain anything; only the character that could end the script is replaced.
    let about = about.to_string().replace('<', "\\u003c");
    let left_out: String = view.left_out.iter().map(|words| format!(" {}", escaped(words))).collect();
    format!(
        "<style>\n{STYLE}</style>\n{}\
         <script type=\"application/json\" id=\"view-about\">{about}</script>\n\
         <script type=\"text/plain\" id=\"view-data\">{data}</script>\n<script>\n{SCRIPT}</script>\n",
        markup().replace("LEFT_OUT", &left_out)
    )
}

/// The markup, with its words (in double brackets) translated to the current language.
fn markup() -> String {
    let mut pieces = MARKUP.split("[[");
    let before = pieces.next().unwrap_or_default().to_owned();
    pieces.fold(before, |markup, piece| {
        let (words, behind) = piece.split_once("]]").unwrap_or(("", piece));
        markup + said(words) + behind
    })
}

/// The values of a triangle of the view.
#[derive(Clone, Copy)]
struct TriangleReading {
    /// Illuminance, its direct part, its indirect part, and its standard error, in lx.
    mean_lx: [f64; 4],
    /// Illuminance at the corners in lx.
    at_corners_lx: [f64; 3],
}

/// A triangle of the view, seen from the side on which its corners run counter-clockwise.
struct ViewTriangle {
    corners_m: [DVec3; 3],
    part: usize,
    /// `None` if nothing was computed, under contact with an object, and inside solids.
    reading: Option<TriangleReading>,
}

impl ViewTriangle {
    fn area_m2(&self) -> f64 {
        let [a, b, c] = self.corners_m;
        0.5 * (b - a).cross(c - a).length()
    }
}

/// All data of a scene for the page.
struct ViewPage {
    /// Triangles of surface sides, and after them two triangles for every receiver point.
    facets: Vec<ViewTriangle>,
    surface_facets: usize,
    /// Names of receiver sets, and after them of surface sides.
    parts: Vec<String>,
    /// Outlines, and after them the marks of luminaires.
    lines_m: Vec<[DVec3; 2]>,
    outlines: usize,
    is_sloped: bool,
    /// What the view does not show, in words.
    left_out: Vec<String>,
}

impl ViewPage {
    fn of(scene: &Scene, solution: &Solution) -> ViewPage {
        let mut view = ViewPage {
            facets: Vec::new(),
            surface_facets: 0,
            parts: part_names(scene),
            lines_m: Vec::new(),
            outlines: 0,
            is_sloped: false,
            left_out: Vec::new(),
        };
        view.add_surfaces(scene, solution);
        view.surface_facets = view.facets.len();
        view.add_receivers(scene, solution);
        view.add_outlines(scene);
        view.outlines = view.lines_m.len();
        view.add_luminaires(scene);
        view
    }

    /// Adds the elements if they were computed, else the scene's triangles without numbers.
    fn add_surfaces(&mut self, scene: &Scene, solution: &Solution) {
        let map = solution.maps.iter().find(|map| map.kind == MapKind::Elements);
        let of_scene = Elements::of(scene);
        let elements = if map.is_some() { &solution.elements } else { &of_scene };
        self.is_sloped = map.is_some_and(|map| !map.values.slopes_lx.is_empty());
        let shown = self.largest(scene, elements);
        self.facets.reserve(shown.len());
        for index in shown {
            let element = elements.element(index);
            let is_front = element.side == Side::Front;
            let turned = if is_front { [0, 1, 2] } else { [0, 2, 1] };
            let corners_m = elements.corners_m(scene, element);
            self.facets.push(ViewTriangle {
                corners_m: turned.map(|corner| corners_m[corner]),
                part: scene.receivers.len()
                    + 2 * scene.surface_id_of(element.triangle) as usize
                    + usize::from(!is_front),
                reading: map.and_then(|map| element_reading(map, index as usize, turned)),
            });
        }
    }

    /// The elements that are shown, in their order. Omitted elements are reported in `left_out`.
    fn largest(&mut self, scene: &Scene, elements: &Elements) -> Vec<u32> {
        let count = elements.len();
        let mut shown: Vec<u32> = (0..count as u32).collect();
        if count <= MOST_FACETS {
            return shown;
        }
        // The elements of a large wall are all shown, however finely it is divided.
        let whole_m2 = |index: &u32| scene.triangle_area_m2(elements.element(*index).triangle);
        shown.sort_by_cached_key(|index| std::cmp::Reverse(whole_m2(index).to_bits()));
        let own_m2 = |index: &u32| elements.area_m2(scene, elements.element(*index));
        let all_m2: f64 = shown.iter().map(own_m2).sum();
        shown.truncate(MOST_FACETS);
        shown.sort_unstable();
        let shown_m2: f64 = shown.iter().map(own_m2).sum();
        self.left_out.push(say!(
            "Of {} triangles, {} are shown: the largest ones, with {} of the scene's area.",
            grouped(count as u64),
            grouped(MOST_FACETS as u64),
            percent(shown_m2 / all_m2)
        ));
        shown
    }

    fn add_receivers(&mut self, scene: &Scene, solution: &Solution) {
        let mut room = MOST_POINTS;
        let point_m = POINT * size_m(scene);
        for map in &solution.maps {
            let MapKind::Receivers(number) = map.kind else { continue };
            let set = &scene.receivers[number];
            if !set.quantity.is_illuminance() {
                continue;
            }
            if set.points.len() > room {
                let count = grouped(set.points.len() as u64);
                self.left_out.push(say!("Receiver set “{}” is not shown: {} points are too many.", set.name, count));
                continue;
            }
            room -= set.points.len();
            for index in 0..set.points.len() {
                let [a, b, c, d] = cell_m(set, index, point_m);
                let reading = (!set.points[index].inside).then(|| point_reading(map, index));
                for corners_m in [[a, b, c], [a, c, d]] {
                    self.facets.push(ViewTriangle { corners_m, part: number, reading });
                }
            }
        }
    }

    /// Adds the creases and rims of the scene; if there are very many, the longest.
    fn add_outlines(&mut self, scene: &Scene) {
        let sides = edges_with_triangles(scene);
        let is_drawn = |sides: &&[[u32; 3]]| match sides {
            [[.., one], [.., other]] => scene.triangle_normal(*one).dot(scene.triangle_normal(*other)) < SMOOTH_COSINE,
            _ => true,
        };
        let edges = sides.chunk_by(|one, other| one[..2] == other[..2]).filter(is_drawn);
        let ends = |sides: &[[u32; 3]]| [sides[0][0], sides[0][1]].map(|vertex| scene.vertices_m[vertex as usize]);
        self.lines_m = edges.map(ends).collect();
        if self.lines_m.len() > MOST_LINES {
            let length_m = |line: &[DVec3; 2]| line[0].distance(line[1]);
            self.lines_m.sort_by(|one, other| length_m(other).total_cmp(&length_m(one)));
            self.lines_m.truncate(MOST_LINES);
        }
    }

    /// Adds a cross of three lines at every luminaire that is not a surface.
    fn add_luminaires(&mut self, scene: &Scene) {
        let arm_m = MARK * size_m(scene);
        let places_m = scene.luminaires.iter().filter_map(|luminaire| luminaire.emission.place_m());
        for place_m in places_m.take(MOST_LUMINAIRES) {
            self.lines_m.extend(DVec3::AXES.map(|axis| [place_m - arm_m * axis, place_m + arm_m * axis]));
        }
    }

    /// A description of the data, and the data: columns, compressed, in base 64.
    fn packed(&self) -> (serde_json::Value, String) {
        let corners = self.facets.iter().flat_map(|facet| facet.corners_m);
        let places_m: Vec<DVec3> = corners.chain(self.lines_m.iter().flatten().copied()).collect();
        let place = PlaceCode::of(&places_m);
        let readings = || self.facets.iter().filter_map(|facet| facet.reading);
        let numbers = readings().flat_map(|reading| reading.mean_lx.into_iter().chain(reading.at_corners_lx));
        let lux = LuxCode { most_lx: numbers.fold(0.0, f64::max) };

        let mut columns = Columns::default();
        for corner in 0..3 {
            for axis in 0..3 {
                columns.add(self.facets.iter().map(|facet| place.code(facet.corners_m[corner], axis)));
            }
        }
        columns.add(self.facets.iter().map(|facet| facet.part.min(self.parts.len() - 1) as u16));
        for quantity in 0..4 {
            let of = |facet: &ViewTriangle| lux.code(facet.reading.map(|reading| reading.mean_lx[quantity]));
            columns.add(self.facets.iter().map(of));
        }
        for corner in (0..3).filter(|_| self.is_sloped) {
            let of = |facet: &ViewTriangle| lux.code(facet.reading.map(|reading| reading.at_corners_lx[corner]));
            columns.add(self.facets.iter().map(of));
        }
        for end in 0..2 {
            for axis in 0..3 {
                columns.add(self.lines_m.iter().map(|line| place.code(line[end], axis)));
            }
        }

        let ends_lx = [0, 1, 2, 3].map(|quantity| self.end_lx(quantity));
        let about = json!({
            "facets": self.facets.len(),
            "surface_facets": self.surface_facets,
            "lines": self.lines_m.len(),
            "outlines": self.outlines,
            "is_sloped": self.is_sloped,
            "low_m": place.low_m.to_array(),
            "step_m": place.step_m,
            "most_lx": lux.most_lx,
            "span": SPAN,
            "ends_lx": ends_lx,
            "colors": (0..=STOPS).map(|stop| perceptual(f64::from(stop) / f64::from(STOPS))).collect::<Vec<_>>(),
            "parts": self.parts,
            "readings": READINGS.map(said),
            "decimal_sign": decimal(".".to_owned()),
        });
        (about, STANDARD.encode(columns.compressed()))
    }

    /// The upper end of a quantity's colours. Receivers and surfaces share the higher of their two ends.
    fn end_lx(&self, quantity: usize) -> f64 {
        let (surfaces, receivers) = self.facets.split_at(self.surface_facets);
        let end_lx = |facets: &[ViewTriangle]| {
            let lit = facets.iter().filter_map(|facet| Some((facet.reading?.mean_lx[quantity], facet.area_m2())));
            end_of_scale_lx(lit.collect())
        };
        let most_lx = || {
            let lit = self.facets.iter().filter_map(|facet| Some(facet.reading?.mean_lx[quantity]));
            lit.reduce(f64::max).filter(|most_lx| *most_lx > 0.0)
        };
        // If next to nothing is lit, the brightest value ends the scale. If everything is dark, any scale will do.
        let ends_lx = [end_lx(surfaces), end_lx(receivers)];
        ends_lx.into_iter().flatten().reduce(f64::max).or_else(most_lx).unwrap_or(1.0)
    }
}

/// Names of receiver sets, then of both sides of every surface. Names beyond the capacity of a column are replaced by one common
/// name. Surfaces that the report does not list are visible but unnamed.
fn part_names(scene: &Scene) -> Vec<String> {
    let name = |name: &str| if scene.is_reported(name) { name.to_owned() } else { said(UNNAMED).to_owned() };
    let sides = scene
        .surfaces
        .iter()
        .map(|surface| name(&surface.name))
        .flat_map(|name| [name.clone(), say!("{}, back", name)]);
    let sets = scene.receivers.iter().map(|set| set.name.clone());
    let mut names: Vec<String> = sets.chain(sides).take(MOST_PARTS).collect();
    if names.len() == MOST_PARTS {
        names.push(say!("one of very many surfaces").to_owned());
    }
    names
}

fn element_reading(map: &MapResult, index: usize, turned: [usize; 3]) -> Option<TriangleReading> {
    if map.values.in_contact.get(index).is_some_and(|in_contact| *in_contact) {
        return None;
    }
    let at_corners_lx = map.values.at_corners_lx(index);
    Some(TriangleReading { at_corners_lx: turned.map(|corner| at_corners_lx[corner]), ..point_reading(map, index) })
}

fn point_reading(map: &MapResult, index: usize) -> TriangleReading {
    let values = &map.values;
    let mean_lx = [&values.value, &values.direct, &values.indirect, &values.standard_error];
    let mean_lx = mean_lx.map(|numbers| numbers[index]);
    TriangleReading { mean_lx, at_corners_lx: [mean_lx[0]; 3] }
}

/// The square that represents a receiver point: its cell for a grid, else one of a visible size.
fn cell_m(set: &ReceiverSet, index: usize, point_m: f64) -> [DVec3; 4] {
    let point = &set.points[index];
    let half = |span_m: DVec3, count: u32| 0.5 * span_m / f64::from(count.max(2) - 1);
    let [u_m, v_m] = match set.layout {
        ReceiverLayout::Grid { columns, rows, u_m, v_m, .. } => [half(u_m, columns), half(v_m, rows)],
        _ => {
            let (u, v) = point.normal.any_orthonormal_pair();
            [point_m * u, point_m * v]
        }
    };
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(i, j)| point.position_m + i * u_m + j * v_m)
}

/// The longest edge of the box about the scene's surfaces.
fn size_m(scene: &Scene) -> f64 {
    let bound = |pick: fn(DVec3, DVec3) -> DVec3| scene.vertices_m.iter().copied().reduce(pick).unwrap_or_default();
    (bound(DVec3::max) - bound(DVec3::min)).max_element()
}
