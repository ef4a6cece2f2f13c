//! The plan of a scene: objects, luminaires and receivers, seen from above and to scale.

use std::collections::HashSet;

use glam::DVec3;
use rayon::prelude::*;

use super::axes::{ChartFrame, Scale, TYPE};
use super::color::{AMBER, BLACK, BLUE, GREY, Ink, WHITE, mixed};
use super::font::text_width;
use super::picture::{PagePoint, Pen, Picture, TextAnchor, Words};
use super::schedule::Schedule;
use super::texts::say;
use crate::scene::{Emission, ReceiverLayout, ReceiverSet, Scene};

/// Largest width and height of the drawing itself.
const LARGEST: [f64; 2] = [760.0, 620.0];
/// Largest width and height of the drawing of a small plan.
const SMALL: [f64; 2] = [370.0, 290.0];
const LEFT: f64 = 58.0;
const TOP: f64 = 16.0;
/// Largest number of drawn edges. Beyond it a plan shows only where objects stand.
const MOST_EDGES: usize = 4000;
/// An edge is not drawn if the cosine between its triangles exceeds this: it lies within a smooth or flat face.
pub(super) const SMOOTH_COSINE: f64 = 0.94;
/// Side of the squares that show objects if there are too many edges.
const SQUARE: f64 = 2.0;
/// Beyond this many luminaires, only one is drawn in each square of the page of the size of a symbol.
const MOST_SYMBOLS: usize = 2_000;
const SYMBOL: f64 = 10.0;
/// Beyond this many luminaires, symbols have no letters.
const MOST_LETTERS: usize = 200;
/// Largest number of receiver sets that are named. Each name is moved below the names in its way.
const MOST_NAMES: usize = 200;
/// Free space beside a name.
const FREE: f64 = 4.0;
/// Ink of edges.
const EDGES: Ink = [120, 120, 120];

/// Draws the scene from above: x to the right, y up, in metres.
pub fn plan_picture(scene: &Scene, schedule: &Schedule) -> Picture {
    let (plan, mut picture) = Plan::begin(scene, say!("Plan of the scene from above"));
    let mut labels = Labels::default();
    plan.draw_luminaires(&mut picture, &mut labels, schedule);
    plan.draw_receivers(&mut picture, &mut labels);
    picture
}

/// The same, so small that two pictures fit side by side.
pub fn small_plan(scene: &Scene, schedule: &Schedule) -> Picture {
    let (plan, mut picture) = Plan::within(scene, say!("Plan of the scene from above"), SMALL);
    let mut labels = Labels::default();
    plan.draw_luminaires(&mut picture, &mut labels, schedule);
    plan.draw_receivers(&mut picture, &mut labels);
    picture
}

fn bounds_m(scene: &Scene) -> [DVec3; 2] {
    let corners = scene.vertices_m.iter().copied();
    let places = scene.luminaires.iter().filter_map(|luminaire| luminaire.emission.place_m());
    let receivers = scene.receivers.iter().flat_map(|set| set.points.iter().map(|point| point.position_m));
    corners
        .chain(places)
        .chain(receivers)
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], point| [low.min(point), high.max(point)])
}

/// Edges, each with its triangle, in sorted order, so that those of one edge are adjacent. Millions of them take little memory.
pub(super) fn edges_with_triangles(scene: &Scene) -> Vec<[u32; 3]> {
    let mut sides: Vec<[u32; 3]> = Vec::with_capacity(3 * scene.triangles.len());
    for (index, [a, b, c]) in scene.triangles.iter().enumerate() {
        sides.extend([[*a, *b], [*b, *c], [*c, *a]].map(|[from, to]| [from.min(to), from.max(to), index as u32]));
    }
    sides.par_sort_unstable();
    sides
}

/// The middle of a luminaire.
pub(super) fn middle_m(scene: &Scene, emission: &Emission) -> DVec3 {
    if let Emission::Area { surfaces, .. } = emission {
        let triangles = surfaces.iter().flat_map(|id| scene.surfaces[*id as usize].triangles.clone());
        let corners: Vec<DVec3> = triangles.flat_map(|triangle| scene.corners_m(triangle)).collect();
        return corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
    }
    emission.place_m().unwrap_or(DVec3::ZERO)
}

/// Occupied places of words: left end, baseline and width of each, and how many of them are names of receiver sets.
#[derive(Default)]
pub(super) struct Labels {
    taken: Vec<[f64; 3]>,
    names: usize,
}

/// A plan under construction: its frame, and its scene.
pub(super) struct Plan<'a> {
    scene: &'a Scene,
    frame: ChartFrame,
}

impl<'a> Plan<'a> {
    /// Draws the frame and the scene's objects.
    pub fn begin(scene: &'a Scene, title: impl Into<String>) -> (Plan<'a>, Picture) {
        Plan::within(scene, title, LARGEST)
    }

    /// The same, no larger than this.
    fn within(scene: &'a Scene, title: impl Into<String>, largest: [f64; 2]) -> (Plan<'a>, Picture) {
        let [low_m, high_m] = bounds_m(scene);
        let size_m = (high_m - low_m).max(DVec3::splat(1e-9));
        let scale = (largest[0] / size_m.x).min(largest[1] / size_m.y);
        let (width, height) = (size_m.x * scale, size_m.y * scale);
        let frame = ChartFrame {
            left: LEFT,
            top: TOP,
            width,
            height,
            x: Scale::linear(low_m.x, high_m.x),
            y: Scale::linear(low_m.y, high_m.y),
        };
        let mut picture = Picture::new(LEFT + width + 18.0, TOP + height + 50.0, title);
        frame.draw_plain(&mut picture, ["x / m", "y / m"]);
        let ring = vec![[LEFT, TOP], [LEFT + width, TOP], [LEFT + width, TOP + height], [LEFT, TOP + height]];
        picture.area(ring, WHITE, 0.75);
        let plan = Plan { scene, frame };
        plan.draw_geometry(&mut picture);
        (plan, picture)
    }

    /// The point of the page for a point of the scene.
    pub fn spot(&self, point_m: DVec3) -> PagePoint {
        self.frame.spot(point_m.x, point_m.y)
    }

    fn draw_geometry(&self, picture: &mut Picture) {
        let edges = self.edges();
        let outline = |long: f64| {
            edges.iter().filter(move |[a, b]| super::contour::distance(*a, *b) > long).map(|edge| edge.to_vec())
        };
        if edges.len() <= MOST_EDGES {
            for line in outline(0.0) {
                picture.line(line, Pen::new(EDGES, 0.9));
            }
            return;
        }
        let squares = self.covered_squares();
        if !squares.is_empty() {
            picture.cells(squares, mixed(GREY, WHITE, 0.1));
        }
        for line in outline(0.2 * self.frame.width.min(self.frame.height)) {
            picture.line(line, Pen::new(EDGES, 0.9));
        }
    }

    /// Creases, rims and silhouettes as seen from above, each once.
    fn edges(&self) -> Vec<[PagePoint; 2]> {
        let scene = self.scene;
        let sides = edges_with_triangles(scene);
        let is_drawn = |sides: &&[[u32; 3]]| match sides {
            [[.., one], [.., other]] => {
                let [one, other] = [one, other].map(|triangle| scene.triangle_normal(*triangle));
                one.dot(other) < SMOOTH_COSINE || (one.z > 0.0) != (other.z > 0.0)
            }
            _ => true,
        };
        let mut seen = HashSet::new();
        let mut edges: Vec<[PagePoint; 2]> = Vec::new();
        for drawn in sides.chunk_by(|one, other| one[..2] == other[..2]).filter(is_drawn) {
            let [from, to, _] = drawn[0];
            let edge = [from, to].map(|vertex| self.spot(scene.vertices_m[vertex as usize]));
            let mut key = edge.map(|spot| spot.map(|x| (2.0 * x).round() as i64));
            key.sort_unstable();
            if key[0] != key[1] && seen.insert(key) {
                edges.push(edge);
            }
        }
        edges
    }

    /// Squares that contain upward-facing surfaces above the floor, joined along rows.
    fn covered_squares(&self) -> Vec<Vec<PagePoint>> {
        let scene = self.scene;
        let floor_m = scene.vertices_m.iter().map(|vertex| vertex.z).fold(f64::INFINITY, f64::min);
        let columns = (self.frame.width / SQUARE).ceil() as usize;
        let rows = (self.frame.height / SQUARE).ceil() as usize;
        let mut covered = vec![false; columns * rows];
        for triangle in 0..scene.triangles.len() as u32 {
            let corners_m = scene.corners_m(triangle);
            if scene.triangle_normal(triangle).z < 0.3 || corners_m.iter().all(|corner| corner.z < floor_m + 0.05) {
                continue;
            }
            let ring = corners_m.map(|corner| self.spot(corner));
            let range = |axis: usize, first: f64, count: usize| {
                let places = ring.map(|spot| (spot[axis] - first) / SQUARE);
                let low = places.iter().fold(f64::INFINITY, |low, x| low.min(*x)).floor().max(0.0) as usize;
                let high = places.iter().fold(0.0f64, |high, x| high.max(*x)).ceil() as usize;
                low..high.min(count)
            };
            for row in range(1, self.frame.top, rows) {
                for column in range(0, self.frame.left, columns) {
                    let middle = [
                        self.frame.left + (column as f64 + 0.5) * SQUARE,
                        self.frame.top + (row as f64 + 0.5) * SQUARE,
                    ];
                    covered[row * columns + column] |= holds(&ring, middle);
                }
            }
        }
        let mut squares = Vec::new();
        for (row, line) in covered.chunks(columns.max(1)).enumerate() {
            let mut column = 0;
            while column < columns {
                let length = line[column..].iter().take_while(|covered| **covered).count();
                if length > 0 {
                    let (left, top) = (self.frame.left + column as f64 * SQUARE, self.frame.top + row as f64 * SQUARE);
                    let (right, bottom) = (left + length as f64 * SQUARE, top + SQUARE);
                    squares.push(vec![[left, top], [right, top], [right, bottom], [left, bottom]]);
                }
                column += length.max(1);
            }
        }
        squares
    }

    fn draw_receivers(&self, picture: &mut Picture, labels: &mut Labels) {
        for set in &self.scene.receivers {
            match set.layout {
                ReceiverLayout::Grid { origin_m, u_m, v_m, columns, rows, .. } => {
                    let ring = [DVec3::ZERO, u_m, u_m + v_m, v_m].map(|corner| self.spot(origin_m + corner));
                    picture.ring(ring.to_vec(), Pen::new(BLUE, 1.4).dashed(6.0, 3.0));
                    let what = format!("{}, {columns} × {rows}", set.name);
                    self.label(picture, labels, &ring, what);
                }
                ReceiverLayout::Points | ReceiverLayout::Part(_) if set.quantity.is_illuminance() => {
                    self.draw_points(picture, labels, set)
                }
                ReceiverLayout::Towards { eye_m } => {
                    self.draw_lines_of_sight(picture, eye_m, &[]);
                    self.label(picture, labels, &[self.spot(eye_m)], set.name.clone());
                }
                // Light that leaves the scene is not received at a place in it.
                ReceiverLayout::Intensity(_) => {}
                _ => self.draw_observer(picture, labels, set),
            }
        }
    }

    /// Draws an eye with the first, the middle and the last of its directions. For glare observers it draws all eyes, and the line
    /// of sight if there is only one.
    fn draw_observer(&self, picture: &mut Picture, labels: &mut Labels, set: &ReceiverSet) {
        let Some(first) = set.points.first() else { return };
        let last = set.points.len() - 1;
        let eyes_m = match &set.observers[..] {
            [] => {
                let views = [0, last / 2, last].map(|index| set.points[index].normal);
                self.draw_lines_of_sight(picture, first.position_m, &views);
                vec![first.position_m]
            }
            [observer] => {
                self.draw_lines_of_sight(picture, observer.eye_m, &[observer.view]);
                vec![observer.eye_m]
            }
            observers => {
                let mut eyes_m: Vec<DVec3> = observers.iter().map(|observer| observer.eye_m).collect();
                eyes_m.dedup();
                eyes_m.iter().for_each(|eye_m| picture.circle(self.spot(*eye_m), 2.0, Pen::new(BLUE, 1.2)));
                eyes_m
            }
        };
        let spots: Vec<PagePoint> = eyes_m.into_iter().map(|eye_m| self.spot(eye_m)).collect();
        self.label(picture, labels, &spots, set.name.clone());
    }

    /// Draws an eye with lines of sight.
    pub fn draw_lines_of_sight(&self, picture: &mut Picture, eye_m: DVec3, views: &[DVec3]) {
        const SIGHT: f64 = 26.0;
        let eye = self.spot(eye_m);
        for direction in views {
            let end = [eye[0] + SIGHT * direction.x, eye[1] - SIGHT * direction.y];
            picture.line(vec![eye, end], Pen::new(BLUE, 1.2));
        }
        picture.circle(eye, 4.0, Pen::new(BLUE, 1.4));
    }

    fn draw_points(&self, picture: &mut Picture, labels: &mut Labels, set: &ReceiverSet) {
        let spots: Vec<PagePoint> = set.points.iter().map(|point| self.spot(point.position_m)).collect();
        for [x, y] in &spots {
            for (i, j) in [(3.0, 3.0), (3.0, -3.0)] {
                picture.line(vec![[x - i, y - j], [x + i, y + j]], Pen::new(BLUE, 1.2));
            }
        }
        self.label(picture, labels, &spots, set.name.clone());
    }

    /// Names a set at its upper left corner, below words that are there already, and within the page. Of very many sets only the
    /// first are named.
    pub fn label(&self, picture: &mut Picture, labels: &mut Labels, ring: &[PagePoint], text: String) {
        if labels.names >= MOST_NAMES {
            return;
        }
        let least = |axis: usize| ring.iter().map(|spot| spot[axis]).fold(f64::INFINITY, f64::min);
        let width = text_width(&text, TYPE, false);
        let left = (least(0) + 5.0).min(picture.width - width - FREE).max(FREE);
        let mut spot = [left, least(1) + 14.0];
        let is_taken = |[_, y]: PagePoint, [other, base, other_width]: &[f64; 3]| {
            left < other + other_width + FREE && *other < left + width + FREE && (base - y).abs() < 14.0
        };
        while labels.taken.iter().any(|other| is_taken(spot, other)) {
            spot[1] += 15.0;
        }
        labels.taken.push([left, spot[1], width]);
        labels.names += 1;
        picture.words(Words::new(text, spot, TYPE).ink(BLUE).rimmed(2.0));
    }

    fn draw_luminaires(&self, picture: &mut Picture, labels: &mut Labels, schedule: &Schedule) {
        let has_letters = self.scene.luminaires.len() <= MOST_LETTERS;
        // If there are very many, symbols that hide each other are drawn once.
        let is_crowded = self.scene.luminaires.len() > MOST_SYMBOLS;
        let mut drawn: HashSet<[i64; 2]> = HashSet::new();
        let mut named = HashSet::new();
        for (index, luminaire) in self.scene.luminaires.iter().enumerate() {
            let emission = &luminaire.emission;
            if emission.is_daylight() {
                // Daylight has no position.
                continue;
            }
            let middle = match emission.place_m() {
                None => self.draw_emitting_surfaces(picture, emission.surfaces()),
                Some(place_m) => {
                    let spot = self.spot(place_m);
                    let at = spot.map(|coordinate| (coordinate / SYMBOL).round() as i64);
                    if is_crowded && !drawn.insert(at) {
                        continue;
                    }
                    for outline_m in emission.outlines_m() {
                        let line = outline_m.iter().chain(outline_m.first()).map(|point_m| self.spot(*point_m));
                        picture.line(line.collect(), Pen::new(BLACK, 1.0));
                    }
                    if let (true, Some(c0)) = (has_letters, emission.c0()) {
                        let is_first = named.insert(schedule.letter_of(index));
                        draw_c0(picture, spot, c0, is_first);
                    }
                    if let Some(axis) = emission.aim() {
                        let reach = [22.0 * axis.x, -22.0 * axis.y];
                        picture.line(vec![spot, [spot[0] + reach[0], spot[1] + reach[1]]], Pen::new(BLACK, 1.2));
                    }
                    picture.disk(spot, 5.0, AMBER);
                    picture.circle(spot, 5.0, Pen::new(BLACK, 1.0));
                    spot
                }
            };
            if has_letters {
                let letter = schedule.letter_of(index);
                let spot = [middle[0] + 8.0, middle[1] - 6.0];
                labels.taken.push([spot[0], spot[1], text_width(letter, TYPE, true)]);
                picture.words(Words::new(letter, spot, TYPE).bold().rimmed(2.0).anchored(TextAnchor::Start));
            }
        }
    }

    fn draw_emitting_surfaces(&self, picture: &mut Picture, surfaces: &[u32]) -> PagePoint {
        let mut sum = [0.0; 2];
        let mut count = 0.0;
        let mut rings = Vec::new();
        for triangle in surfaces.iter().flat_map(|id| self.scene.surfaces[*id as usize].triangles.clone()) {
            let ring = self.scene.corners_m(triangle).map(|corner| self.spot(corner));
            sum = [0, 1].map(|axis| sum[axis] + ring.iter().map(|spot| spot[axis]).sum::<f64>());
            count += 3.0;
            rings.push(ring.to_vec());
        }
        let middle = sum.map(|sum| sum / f64::max(count, 1.0));
        picture.cells(rings, AMBER);
        picture.circle(middle, 2.0, Pen::new(BLACK, 1.0));
        middle
    }
}

/// Draws an arrow from a luminaire along C0, with the name of C0 if `is_named`. There is none if C0 points up or down.
fn draw_c0(picture: &mut Picture, [x, y]: PagePoint, c0: DVec3, is_named: bool) {
    const REACH: f64 = 20.0;
    const BARB: f64 = 4.0;
    // A shorter arrow would be hidden by the symbol.
    const LEAST: f64 = 0.4;
    let (right, down) = (c0.x, -c0.y);
    if right.hypot(down) < LEAST {
        return;
    }
    let tip = [x + REACH * right, y + REACH * down];
    let barb = |side: f64| [tip[0] - BARB * (right - side * down), tip[1] - BARB * (down + side * right)];
    picture.line(vec![[x, y], tip], Pen::new(EDGES, 1.0));
    picture.line(vec![barb(0.6), tip, barb(-0.6)], Pen::new(EDGES, 1.0));
    if is_named {
        let anchor = if right < 0.0 { TextAnchor::End } else { TextAnchor::Start };
        let spot = [tip[0] + 3.0 * right.signum(), tip[1] + 4.0];
        picture.words(Words::new("C0", spot, TYPE).ink(EDGES).rimmed(2.0).anchored(anchor));
    }
}

fn holds([a, b, c]: &[PagePoint; 3], spot: PagePoint) -> bool {
    let side = |from: &PagePoint, to: &PagePoint| {
        (to[0] - from[0]) * (spot[1] - from[1]) - (to[1] - from[1]) * (spot[0] - from[0])
    };
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::scene_from_json;

    /// A thousand sets at one position: two hundred names stand below each other, and the other sets are skipped.
    #[test]
    fn of_very_many_sets_the_first_bear_their_names() {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" } ],
            "luminaires": [ { "name": "l", "type": "point", "position": [1,1,1], "luminous_flux_lm": 1 } ] }"#;
        let scene = scene_from_json(text, None, std::path::Path::new(".")).expect("a valid scene");
        let (plan, mut picture) = Plan::begin(&scene, "plan");
        let mut labels = Labels::default();
        for number in 0..1000 {
            plan.label(&mut picture, &mut labels, &[[100.0, 100.0]], format!("p{number}"));
        }
        assert_eq!(labels.taken.len(), MOST_NAMES);
        assert!(labels.taken.windows(2).all(|pair| pair[1][1] - pair[0][1] >= 14.0));
        // At the right edge a name is moved inward, and away from other words.
        let right = picture.width;
        let mut labels = Labels { taken: vec![[right - 60.0, 114.0, 40.0]], names: 0 };
        plan.label(&mut picture, &mut labels, &[[right - 10.0, 100.0]], "view to the board".to_owned());
        let [left, base, width] = labels.taken[1];
        assert!(left + width < right && base >= 128.0, "{left} {base} {width}");
    }
}
