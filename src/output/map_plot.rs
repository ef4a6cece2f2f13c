//! The false-colour and isolux plot of a map, and its value chart.

use std::collections::{BTreeMap, HashMap};

use super::axes::{Scale, TYPE};
use super::color::{BLACK, GREY, Ink, SHADES, SOFT, WHITE, mixed, perceptual};
use super::contour::{Isoline, distance, isolux_levels};
use super::flat::{FlatMap, FlatPoint, quantity_words, unit_words};
use super::font::text_width;
use super::map_words::{LineSpace, ROOM, SMALL, foot, head, numbers_of};
use super::numbers::{lux_alone, round_step, round_ticks, tick};
use super::picture::{PagePoint, Pen, Picture, TextAnchor, Words};
use super::texts::{said, say};

/// Largest width and height of the drawing itself.
const LARGEST: [f64; 2] = [700.0, 560.0];
/// Largest width and height of the drawing of a small map.
const SMALLEST: [f64; 2] = [330.0, 260.0];
/// Space around a small map, which has no titles.
const SMALL_ROOM: LineSpace = LineSpace { top: 28.0, bottom: 46.0, left: 50.0, right: 80.0 };
/// Smallest width of a page with titles.
const LEAST_WIDTH: f64 = 620.0;
/// If the greatest value exceeds the median by this factor, the field is shown on a logarithmic scale.
const LOGARITHMIC_FROM: f64 = 8.0;
/// Values beyond this quantile times [`BEYOND`] do not stretch the scale.
const QUANTILE: f64 = 0.99;
const BEYOND: f64 = 1.4;
/// Smallest number of nodes for useful isolux lines.
const FEWEST_NODES: usize = 12;
/// A range of values narrower than this share of the greatest is not spread over all colours. The same holds for a range that may
/// be chance. n normally distributed values lie within `RANGE_OF_CHANCE` times √(2 ln n) stated errors (for 36 values, all but one
/// range in a hundred).
const NARROW: f64 = 0.05;
const RANGE_OF_CHANCE: f64 = 2.3;
/// The scale begins at 0 unless all values exceed this share of the greatest.
const FROM_ZERO: f64 = 0.7;
/// Largest stated error for isolux lines, which would otherwise follow noise.
const NOISIEST: f64 = 0.12;
/// Largest stated error for short isolux lines.
const NOISY: f64 = 0.02;
/// Smallest height of a legend beside a flat drawing, and how far it may extend below the drawing's axis.
pub(super) const LEAST_LEGEND: f64 = 90.0;
const LEGEND_BELOW: f64 = 34.0;

/// Position and scale of the drawing on its page.
pub(super) struct MapLayout {
    low_m: PagePoint,
    scale: f64,
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl MapLayout {
    pub fn of(map: &FlatMap) -> (MapLayout, Picture) {
        MapLayout::within(map, LARGEST, &ROOM, LEAST_WIDTH)
    }

    /// A layout no larger than this, with space around it, on a page of at least this width.
    fn within(map: &FlatMap, largest: [f64; 2], room: &LineSpace, least_width: f64) -> (MapLayout, Picture) {
        let [low_m, high_m] = map.bounds_m();
        let size_m = [0, 1].map(|axis| (high_m[axis] - low_m[axis]).max(f64::MIN_POSITIVE));
        let scale = (largest[0] / size_m[0]).min(largest[1] / size_m[1]);
        let (width, height) = (size_m[0] * scale, size_m[1] * scale);
        let page_width = (room.left + width + room.right).max(least_width);
        let left = room.left + 0.5 * (page_width - room.left - width - room.right);
        let layout = MapLayout { low_m, scale, left, top: room.top, width, height };
        let description = say!("Illuminance map of {}", map.row.name);
        let page_height = room.top + room.bottom + height.max(LEAST_LEGEND - LEGEND_BELOW);
        (layout, Picture::new(page_width, page_height, description))
    }

    fn spot(&self, [x, y]: PagePoint) -> PagePoint {
        [self.left + (x - self.low_m[0]) * self.scale, self.top + self.height - (y - self.low_m[1]) * self.scale]
    }

    fn ring(&self, ring: &[PagePoint]) -> Vec<PagePoint> {
        ring.iter().map(|spot| self.spot(*spot)).collect()
    }

    fn frame(&self) -> Vec<PagePoint> {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        vec![[self.left, self.top], [right, self.top], [right, bottom], [self.left, bottom]]
    }

    /// The nearest point to this one that keeps the given distances from the edges of the drawing, if the drawing is large enough.
    fn inward(&self, [x, y]: PagePoint, [across, up]: [f64; 2]) -> PagePoint {
        let within = |at: f64, from: f64, length: f64, room: f64| match 2.0 * room < length {
            true => at.clamp(from + room, from + length - room),
            false => at,
        };
        [within(x, self.left, self.width, across), within(y, self.top, self.height, up)]
    }

    /// Whether a box around a point lies within the drawing.
    fn holds(&self, [x, y]: PagePoint, room: f64) -> bool {
        (self.left + room..=self.left + self.width - room).contains(&x)
            && (self.top + room..=self.top + self.height - room).contains(&y)
    }
}

/// Draws false colours with isolux lines, axes in metres, legend, averages and errors.
///
/// Every cell has the colour of its own value, so that nothing is smoothed. The isolux lines run between the points of a grid
/// (bilinear), or between the corners of a surface's elements.
pub fn map_picture(map: &FlatMap, note: &str) -> Picture {
    let (layout, mut picture) = MapLayout::of(map);
    let rest = head(&mut picture, map, said(quantity_words(map.quantity)), "");
    numbers_of(&mut picture, map.row);
    let remark = draw_map(&mut picture, map, &layout, (isolux_of(map), say!("isolux lines")), unit_words(map.quantity));
    foot(&mut picture, map, &format!("{rest}{remark}{note}"));
    picture
}

/// Draws colours, isolux lines, axes and legend only, so small that two pictures fit side by side.
pub fn small_map(map: &FlatMap) -> Picture {
    let (layout, mut picture) = MapLayout::within(map, SMALLEST, &SMALL_ROOM, 0.0);
    draw_map(&mut picture, map, &layout, (isolux_of(map), say!("isolux lines")), unit_words(map.quantity));
    picture
}

/// Levels of the isolux lines of a map.
fn isolux_of(map: &FlatMap) -> Vec<f64> {
    map.field.range().map(isolux_levels).unwrap_or_default()
}

/// Draws the cells, lines at the given levels under their name, axes, and a legend with its unit. Returns the reason if there are
/// no lines.
pub(super) fn draw_map(
    picture: &mut Picture,
    map: &FlatMap,
    layout: &MapLayout,
    (levels, lines): (Vec<f64>, &str),
    unit: &str,
) -> String {
    let colors = ColorScale::of(map);
    draw_cells(picture, map, layout, mean, &|value| colors.ink(value));
    let is_too_noisy = map.estimated_error > NOISIEST && !levels.is_empty();
    let is_even = !levels.is_empty() && map.field.range().is_some_and(|range| is_even(map, range));
    let is_without = map.field.nodes.len() < FEWEST_NODES || is_too_noisy || is_even;
    let drawn = if is_without { Vec::new() } else { levels };
    draw_isolines(picture, map, layout, &drawn);
    draw_axes(picture, map, layout);
    colors.draw_legend(picture, layout, &drawn, unit);
    match (is_too_noisy, is_even) {
        (true, _) => say!("No {}: with this error they would show noise. ", lines),
        (false, true) => say!("No {}: the values differ by little more than their error. ", lines),
        (false, false) => String::new(),
    }
}

/// Whether values between these two differ so little that the difference may be chance.
fn is_even(map: &FlatMap, [low, high]: [f64; 2]) -> bool {
    let errors = RANGE_OF_CHANCE * (2.0 * (map.cells.len().max(2) as f64).ln()).sqrt();
    high - low < errors * map.estimated_error * high
}

/// Draws the values of a grid's points as numbers, thinned where they would overlap.
pub fn value_chart(map: &FlatMap, note: &str) -> Picture {
    let (layout, mut picture) = MapLayout::of(map);
    let colors = ColorScale::of(map);
    draw_cells(&mut picture, map, &layout, mean, &|value| mixed(colors.ink(value), WHITE, 0.72));
    draw_axes(&mut picture, map, &layout);
    colors.draw_legend(&mut picture, &layout, &[], "lx");
    let thinning = match draw_values(&mut picture, map, &layout) {
        [1, 1] => String::new(),
        [across, 1] => say!("; every {} column shown", ordinal(across)),
        [1, up] => say!("; every {} row shown", ordinal(up)),
        [across, up] => say!("; every {} column and {} row shown", ordinal(across), ordinal(up)),
    };
    let title = say!("{}, values in lx", said(quantity_words(map.quantity)));
    let rest = head(&mut picture, map, &title, &say!("{}; minimum and maximum framed", thinning));
    numbers_of(&mut picture, map.row);
    foot(&mut picture, map, &format!("{rest}{note}"));
    picture
}

fn ordinal(count: u32) -> String {
    match count {
        2 => say!("2nd").to_owned(),
        3 => say!("3rd").to_owned(),
        n => say!("{}th", n),
    }
}

/// A map with more cells is drawn by pooled spots of the page.
const MOST_CELLS: usize = 160_000;
/// Width of a spot in units of the page; a map is about 600 units wide.
const SPOT: f64 = 2.0;

/// The mean of `count` values from their sum.
pub(super) fn mean(sum: f64, count: f64) -> f64 {
    sum / count
}

pub(super) fn draw_cells(
    picture: &mut Picture,
    map: &FlatMap,
    layout: &MapLayout,
    pool: fn(f64, f64) -> f64,
    ink: &dyn Fn(f64) -> Ink,
) {
    // Cells of one ink make one path.
    let mut by_ink: BTreeMap<Ink, Vec<Vec<PagePoint>>> = BTreeMap::new();
    let mut solid = Vec::new();
    let spots = map.cells.iter().map(|cell| (layout.ring(&cell.ring), cell.value));
    for (ring, illuminance_lx) in if map.cells.len() > MOST_CELLS { coarse(spots, pool) } else { spots.collect() } {
        match illuminance_lx {
            Some(value) => by_ink.entry(ink(value)).or_default().push(ring),
            None => solid.push(ring),
        }
    }
    for (ink, rings) in by_ink {
        picture.cells(rings, ink);
    }
    for ring in &solid {
        hatch(picture, ring);
    }
}

/// Pools cells that the eye cannot distinguish: one rectangle for the cells of each spot of the page, with the pooled value of
/// their sum and count.
fn coarse(
    cells: impl Iterator<Item = (Vec<PagePoint>, Option<f64>)>,
    pool: fn(f64, f64) -> f64,
) -> Vec<(Vec<PagePoint>, Option<f64>)> {
    /// Corners, sum and count of the cells of a spot.
    type CellSpot = ([PagePoint; 2], f64, u32);
    let mut spots: BTreeMap<([i64; 2], bool), CellSpot> = BTreeMap::new();
    for (ring, value) in cells {
        let corner = |pick: fn(f64, f64) -> f64, from: f64| {
            ring.iter().fold([from; 2], |corner, spot| [0, 1].map(|axis| pick(corner[axis], spot[axis])))
        };
        let (low, high) = (corner(f64::min, f64::INFINITY), corner(f64::max, f64::NEG_INFINITY));
        let place = [0, 1].map(|axis| (0.5 * (low[axis] + high[axis]) / SPOT).floor() as i64);
        let spot = spots.entry((place, value.is_some())).or_insert(([low, high], 0.0, 0));
        spot.0 =
            [[0, 1].map(|axis| spot.0[0][axis].min(low[axis])), [0, 1].map(|axis| spot.0[1][axis].max(high[axis]))];
        (spot.1, spot.2) = (spot.1 + value.unwrap_or(0.0), spot.2 + 1);
    }
    let ring = |[low, high]: [PagePoint; 2]| vec![low, [high[0], low[1]], high, [low[0], high[1]]];
    let drawn = |(_, is_lit): ([i64; 2], bool), (corners, sum, count): CellSpot| {
        (ring(corners), is_lit.then(|| pool(sum, f64::from(count))))
    };
    spots.into_iter().map(|(place, spot)| drawn(place, spot)).collect()
}

/// Draws grey with diagonal strokes: there are no values inside a solid.
fn hatch(picture: &mut Picture, ring: &[PagePoint]) {
    const DISTANCE: f64 = 6.0;
    picture.cells(vec![ring.to_vec()], mixed(GREY, WHITE, 0.4));
    let along = |[x, y]: PagePoint| x + y;
    let (low, high) =
        ring.iter().fold((f64::MAX, f64::MIN), |(low, high), spot| (low.min(along(*spot)), high.max(along(*spot))));
    let mut stroke = (low / DISTANCE).ceil();
    while stroke * DISTANCE < high {
        let sum = stroke * DISTANCE;
        let crossings: Vec<PagePoint> = (0..ring.len())
            .filter_map(|i| {
                let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
                let share = (sum - along(a)) / (along(b) - along(a));
                (0.0..1.0).contains(&share).then(|| [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])])
            })
            .collect();
        if let [a, b] = crossings[..] {
            picture.line(vec![a, b], Pen::new([140, 140, 140], 0.8));
        }
        stroke += 1.0;
    }
}

pub(super) fn draw_axes(picture: &mut Picture, map: &FlatMap, layout: &MapLayout) {
    let (bottom, right) = (layout.top + layout.height, layout.left + layout.width);
    let [low, high] = map.bounds_m();
    for (axis, of) in map.plane.axes.iter().enumerate() {
        let numbers = [of.number_m(low[axis]), of.number_m(high[axis])];
        let length = if axis == 0 { layout.width } else { layout.height };
        let most = ((length / 60.0) as usize).clamp(2, 12);
        let mut last = f64::NEG_INFINITY;
        let mut is_free = |at: f64, room: f64| {
            let is_free = (at - last).abs() >= room;
            last = if is_free { at } else { last };
            is_free
        };
        for number in round_ticks(numbers[0].min(numbers[1]), numbers[0].max(numbers[1]), most) {
            let at = of.coordinate_m(number);
            if axis == 0 {
                let [x, _] = layout.spot([at, low[1]]);
                if !is_free(x, text_width(&tick(rounded(number)), TYPE, false) + 6.0) {
                    continue;
                }
                picture.line(vec![[x, bottom], [x, bottom + 4.0]], Pen::new(BLACK, 0.8));
                let words = Words::new(tick(rounded(number)), [x, bottom + 17.0], TYPE);
                picture.words(words.anchored(TextAnchor::Middle));
            } else {
                let [_, y] = layout.spot([low[0], at]);
                if !is_free(y, TYPE + 2.0) {
                    continue;
                }
                picture.line(vec![[layout.left - 4.0, y], [layout.left, y]], Pen::new(BLACK, 0.8));
                let words = Words::new(tick(rounded(number)), [layout.left - 7.0, y + 4.0], TYPE);
                picture.words(words.anchored(TextAnchor::End));
            }
        }
    }
    picture.ring(layout.frame(), Pen::new(BLACK, 1.0));
    let below = Words::new(map.plane.axes[0].label.clone(), [0.5 * (layout.left + right), bottom + 35.0], TYPE);
    picture.words(below.anchored(TextAnchor::Middle).ink(SOFT));
    let beside = [layout.left - 42.0, layout.top + 0.5 * layout.height];
    let beside = Words::new(map.plane.axes[1].label.clone(), beside, TYPE);
    picture.words(beside.anchored(TextAnchor::Middle).ink(SOFT).turned(-90.0));
}

/// Rounds a tick such as 0.30000000000000004.
fn rounded(number: f64) -> f64 {
    (number * 1e9).round() / 1e9
}

fn draw_isolines(picture: &mut Picture, map: &FlatMap, layout: &MapLayout, levels: &[f64]) {
    // A closed line that spans only a few cells is noise, or too small for its label.
    let cell = (layout.width * layout.height / map.cells.len().max(1) as f64).sqrt();
    let shortest = if map.estimated_error > NOISY { 8.0 } else { 4.0 } * cell.clamp(4.0, 30.0);
    let lines: Vec<Isoline> = levels
        .iter()
        .flat_map(|level| map.field.isolines(*level))
        .map(|line| Isoline { level: line.level, spots: layout.ring(&line.spots) })
        .filter(|line| line.length() > shortest)
        .map(|line| line.smoothed())
        .collect();
    for pen in [Pen::new(WHITE, 2.6).faint(0.55), Pen::new(BLACK, 1.1)] {
        for line in &lines {
            picture.line(line.spots.clone(), pen);
        }
    }
    let mut labels: Vec<(PagePoint, f64)> = Vec::new();
    for line in &lines {
        label_line(picture, line, layout, &mut labels);
    }
}

/// Puts the level's label on the straightest free stretch of a line, twice on long lines.
fn label_line(picture: &mut Picture, line: &Isoline, layout: &MapLayout, labels: &mut Vec<(PagePoint, f64)>) {
    const STEP: f64 = 9.0;
    const LONG: f64 = 900.0;
    const STRAIGHT: f64 = 0.9;
    let text = tick(rounded(line.level));
    let width = text_width(&text, SMALL, false) + 8.0;
    let length = line.length();
    if length < 2.2 * width {
        return;
    }
    let wanted = if length > LONG { 2 } else { 1 };
    for _ in 0..wanted {
        let places = ((length - width) / STEP) as usize;
        let candidates = (0..=places).filter_map(|place| {
            let from = place as f64 * STEP;
            let [a, middle, b] = [0.0, 0.5, 1.0].map(|share| along(&line.spots, from + share * width));
            let straightness = distance(a, b) / width;
            let free = labels
                .iter()
                .map(|(spot, other)| distance(*spot, middle) - 0.5 * (width + other))
                .fold(f64::INFINITY, f64::min);
            (straightness > STRAIGHT && free > 6.0 && layout.holds(middle, 0.5 * width + 2.0)).then_some((
                straightness * 40.0 + free.min(60.0),
                a,
                middle,
                b,
            ))
        });
        let best = candidates.max_by(|one, other| one.0.total_cmp(&other.0));
        let Some((_, a, middle, b)) = best else { return };
        let mut turn_deg = (b[1] - a[1]).atan2(b[0] - a[0]).to_degrees();
        if turn_deg > 90.0 {
            turn_deg -= 180.0;
        } else if turn_deg < -90.0 {
            turn_deg += 180.0;
        }
        let (sine, cosine) = turn_deg.to_radians().sin_cos();
        let drop = 0.36 * SMALL;
        let spot = [middle[0] - drop * sine, middle[1] + drop * cosine];
        picture.words(Words::new(text.clone(), spot, SMALL).anchored(TextAnchor::Middle).turned(turn_deg).rimmed(2.2));
        labels.push((middle, width));
    }
}

/// The point at a length along a line.
fn along(spots: &[PagePoint], length: f64) -> PagePoint {
    let mut left = length;
    for pair in spots.windows(2) {
        let piece = distance(pair[0], pair[1]);
        if left <= piece && piece > 0.0 {
            let share = left / piece;
            return [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]));
        }
        left -= piece;
    }
    spots[spots.len() - 1]
}

/// Writes the values and returns the steps between the shown columns and rows.
fn draw_values(picture: &mut Picture, map: &FlatMap, layout: &MapLayout) -> [u32; 2] {
    let Some(most) = map.points.iter().max_by(|a, b| a.value.total_cmp(&b.value)) else {
        return [1, 1];
    };
    let least = map.points.iter().min_by(|a, b| a.value.total_cmp(&b.value)).unwrap_or(most);
    let text = |point: &FlatPoint| lux_alone(point.estimate());
    let width = map.points.iter().map(|point| text_width(&text(point), SMALL, false)).fold(0.0, f64::max);

    // The smallest steps over columns and rows at which no two texts touch, whichever way the grid is turned.
    let by_place: HashMap<[u32; 2], PagePoint> = map.points.iter().map(|point| (point.place, point.spot)).collect();
    let step = |axis: usize| {
        let neighbours = map.points.iter().find_map(|point| {
            let mut next = point.place;
            next[axis] += 1;
            let other = by_place.get(&next)?;
            Some([0, 1].map(|i| layout.scale * (other[i] - point.spot[i]).abs()))
        });
        neighbours.map_or(1, |[across, up]| {
            // At the edge of narrow cells numbers are moved inward.
            let moved = (0.5 * (width - across)).max(0.0);
            let share = (across / (width + moved + 7.0)).max(up / (SMALL + 6.0));
            (1.0 / share.max(1e-3)).ceil() as u32
        })
    };
    let steps = [step(0), step(1)];
    let spot_of = |point: &FlatPoint| layout.inward(layout.spot(point.spot), [0.5 * width, 0.5 * SMALL]);
    let [least_spot, most_spot] = [least, most].map(spot_of);
    for point in &map.points {
        let spot = spot_of(point);
        let is_extreme = point.place == least.place || point.place == most.place;
        let crowds =
            |other: PagePoint| (spot[0] - other[0]).abs() < width + 6.0 && (spot[1] - other[1]).abs() < SMALL + 5.0;
        let is_due = point.place.iter().zip(steps).all(|(place, step)| place % step == (step - 1) / 2);
        if is_extreme || (is_due && !crowds(least_spot) && !crowds(most_spot)) {
            let base = [spot[0], spot[1] + 0.36 * SMALL];
            let words = Words::new(text(point), base, SMALL).anchored(TextAnchor::Middle);
            if is_extreme {
                let (w, h) = (0.5 * width + 4.0, 0.5 * SMALL + 3.0);
                let [x, y] = spot;
                let ring = vec![[x - w, y - h], [x + w, y - h], [x + w, y + h], [x - w, y + h]];
                picture.area(ring.clone(), WHITE, 1.0);
                picture.ring(ring, Pen::new(BLACK, 1.0));
                picture.words(words.bold());
            } else {
                picture.words(words);
            }
        }
    }
    steps
}

/// The colour of each illuminance.
struct ColorScale {
    scale: Scale,
    /// Whether the scale ends below the greatest value.
    is_cut: bool,
}

impl ColorScale {
    fn of(map: &FlatMap) -> ColorScale {
        let mut values: Vec<f64> = map.cells.iter().filter_map(|cell| cell.value).collect();
        values.sort_by(f64::total_cmp);
        let quantile = |share: f64| values.get((share * (values.len().max(1) - 1) as f64).round() as usize);
        let (Some(low), Some(median), Some(most)) = (quantile(0.0), quantile(0.5), quantile(1.0)) else {
            return ColorScale { scale: Scale::linear(0.0, 1.0), is_cut: false };
        };
        let usual = quantile(QUANTILE).unwrap_or(most);
        let is_cut = *most > BEYOND * usual && *usual > 0.0;
        let high = if is_cut { *usual } else { *most };
        if high <= 0.0 {
            return ColorScale { scale: Scale::linear(0.0, 1.0), is_cut: false };
        }
        if *low > 0.0 && high > LOGARITHMIC_FROM * median {
            let lowest = low.max(high * 1e-4);
            return ColorScale { scale: Scale::logarithmic(lowest, high), is_cut };
        }
        let is_narrow = high - low < NARROW * high || is_even(map, [*low, high]);
        let start = if *low > FROM_ZERO * high && !is_narrow { *low } else { 0.0 };
        let step = round_step(high - start, 10);
        let (floor, ceiling) = ((start / step).floor() * step, (high / step - 1e-9).ceil() * step);
        let ceiling = if ceiling > floor { ceiling } else { floor + step };
        ColorScale { scale: Scale::linear(floor, ceiling), is_cut }
    }

    fn ink(&self, illuminance_lx: f64) -> Ink {
        let shade = (self.scale.share(illuminance_lx).clamp(0.0, 1.0) * (SHADES - 1) as f64).round();
        perceptual(shade / (SHADES - 1) as f64)
    }

    fn draw_legend(&self, picture: &mut Picture, layout: &MapLayout, levels: &[f64], unit: &str) {
        let (left, width) = (layout.left + layout.width + 22.0, 16.0);
        // A legend also fits beside a flat drawing.
        let height = layout.height.max(LEAST_LEGEND);
        let (top, bottom) = (layout.top, layout.top + height);
        let y = |share: f64| bottom - share * height;
        for shade in 0..SHADES {
            let share = |shade: usize| shade as f64 / SHADES as f64;
            let (low, high) = (y(share(shade)), y(share(shade + 1)));
            let ink = perceptual(shade as f64 / (SHADES - 1) as f64);
            picture.cells(vec![vec![[left, high], [left + width, high], [left + width, low], [left, low]]], ink);
        }
        for level in levels {
            let at = y(self.scale.share(*level));
            picture.line(vec![[left, at], [left + width, at]], Pen::new(WHITE, 2.6).faint(0.55));
            picture.line(vec![[left, at], [left + width, at]], Pen::new(BLACK, 1.1));
        }
        let ring = vec![[left, top], [left + width, top], [left + width, bottom], [left, bottom]];
        picture.ring(ring, Pen::new(BLACK, 0.8));
        for number in self.scale.ticks(((height / 34.0) as usize).clamp(2, 10)) {
            let at = y(self.scale.share(number));
            picture.line(vec![[left + width, at], [left + width + 4.0, at]], Pen::new(BLACK, 0.8));
            picture.words(Words::new(tick(rounded(number)), [left + width + 8.0, at + 4.0], TYPE));
        }
        let title = match unit.split(',').next() {
            Some(unit) if self.is_cut => say!("{} (top: and more)", unit),
            _ => unit.to_owned(),
        };
        let anchor = if title.len() <= 2 { TextAnchor::Start } else { TextAnchor::Middle };
        picture.words(Words::new(title, [left, top - 8.0], TYPE).anchored(anchor).ink(SOFT));
    }
}
