//! Isolines of values at the corners of triangles.

use std::collections::HashMap;

use super::picture::PagePoint;

/// A field given by values at nodes, linear over the triangles between them.
#[derive(Clone, Debug, Default)]
pub struct Field {
    /// Positions of the nodes.
    pub nodes: Vec<PagePoint>,
    /// Value at every node.
    pub values: Vec<f64>,
    /// Nodes of every triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// A line along which the field has one value.
#[derive(Clone, Debug, PartialEq)]
pub struct Isoline {
    /// Value of the field along the line.
    pub level: f64,
    /// Points of the line; the last one of a closed line repeats the first.
    pub spots: Vec<PagePoint>,
}

/// An edge between two nodes, the smaller number first.
type NodeEdge = (u32, u32);

impl Field {
    /// Lowest and highest value of the nodes that triangles use.
    pub fn range(&self) -> Option<[f64; 2]> {
        let used = self.triangles.iter().flatten().map(|node| self.values[*node as usize]);
        used.fold(None, |range, value| match range {
            None => Some([value, value]),
            Some([low, high]) => Some([f64::min(low, value), f64::max(high, value)]),
        })
    }

    /// All lines of a level, each as long as possible.
    ///
    /// A triangle with one corner on the other side of the level than the two others is crossed by one segment, from edge to edge.
    /// Segments that meet on an edge form one line.
    pub fn isolines(&self, level: f64) -> Vec<Isoline> {
        let above = |node: u32| self.values[node as usize] >= level;
        let mut neighbours: HashMap<NodeEdge, Vec<NodeEdge>> = HashMap::new();
        let mut order: Vec<NodeEdge> = Vec::new();
        for [a, b, c] in &self.triangles {
            let crossed: Vec<NodeEdge> = [(*a, *b), (*b, *c), (*c, *a)]
                .into_iter()
                .filter(|(from, to)| above(*from) != above(*to))
                .map(|(from, to)| (from.min(to), from.max(to)))
                .collect();
            if let [first, second] = crossed[..] {
                neighbours.entry(first).or_default().push(second);
                neighbours.entry(second).or_default().push(first);
                order.extend([first, second]);
            }
        }

        // Open lines come first, from their ends. The remaining lines are closed.
        let ends: Vec<NodeEdge> = order.iter().copied().filter(|edge| neighbours[edge].len() == 1).collect();
        let mut lines = Vec::new();
        for start in ends.into_iter().chain(order) {
            let mut spots = vec![self.crossing(start, level)];
            let mut here = start;
            while let Some(next) = neighbours.get_mut(&here).and_then(Vec::pop) {
                if let Some(back) = neighbours.get_mut(&next)
                    && let Some(index) = back.iter().position(|edge| *edge == here)
                {
                    back.swap_remove(index);
                }
                spots.push(self.crossing(next, level));
                here = next;
            }
            if spots.len() > 1 {
                lines.push(Isoline { level, spots });
            }
        }
        lines
    }

    fn crossing(&self, (from, to): NodeEdge, level: f64) -> PagePoint {
        let [low, high] = [from, to].map(|node| self.values[node as usize]);
        let [a, b] = [from, to].map(|node| self.nodes[node as usize]);
        let share = ((level - low) / (high - low)).clamp(0.0, 1.0);
        [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
    }
}

impl Isoline {
    /// Whether the line is closed.
    pub fn is_closed(&self) -> bool {
        self.spots.len() > 2 && self.spots.first() == self.spots.last()
    }

    /// Its length.
    pub fn length(&self) -> f64 {
        self.spots.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
    }

    /// The line with its corners cut twice (Chaikin 1974), which moves it by less than an eighth of the length of its segments.
    pub fn smoothed(&self) -> Isoline {
        let once = cut_corners(&self.spots, self.is_closed());
        Isoline { level: self.level, spots: cut_corners(&once, self.is_closed()) }
    }
}

fn cut_corners(spots: &[PagePoint], closed: bool) -> Vec<PagePoint> {
    if spots.len() < 3 {
        return spots.to_vec();
    }
    let between = |a: PagePoint, b: PagePoint, share: f64| [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
    let mut cut: Vec<PagePoint> =
        spots.windows(2).flat_map(|pair| [0.25, 0.75].map(|share| between(pair[0], pair[1], share))).collect();
    if closed {
        cut.push(cut[0]);
    } else {
        let last = cut.len() - 1;
        (cut[0], cut[last]) = (spots[0], spots[spots.len() - 1]);
    }
    cut
}

/// Distance between two points of the page.
pub fn distance([x0, y0]: PagePoint, [x1, y1]: PagePoint) -> f64 {
    (x1 - x0).hypot(y1 - y0)
}

/// Levels on the steps 1–2–3–5 between two values. If these are too few to show the course of the light, levels are evenly spaced.
pub fn isolux_levels([low, high]: [f64; 2]) -> Vec<f64> {
    const FEWEST: usize = 4;
    const EVEN_STEPS: usize = 7;
    // A level closer to an end than this share of the range gives only a spot, or noise around it.
    let room = 0.02 * (high - low);
    let within = |level: &f64| *level > low + room && *level < high - room && *level > 0.0;
    if high <= 0.0 || high - low < 1e-3 * high {
        return Vec::new();
    }
    let lowest = low.max(high * 0.01);
    let (first, last) = (lowest.log10().floor() as i32, high.log10().ceil() as i32);
    let steps: Vec<f64> = (first..=last)
        .flat_map(|power| [1.0, 2.0, 3.0, 5.0].map(|multiple| multiple * 10f64.powi(power)))
        .filter(within)
        .collect();
    if steps.len() >= FEWEST {
        return steps;
    }
    super::numbers::round_ticks(low, high, EVEN_STEPS).into_iter().filter(within).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field over a square of cells, each divided into four triangles.
    fn field(count: u32, value: impl Fn(PagePoint) -> f64) -> Field {
        let mut field = Field::default();
        let mut node = |spot: PagePoint| {
            field.nodes.push(spot);
            field.values.push(value(spot));
            field.nodes.len() as u32 - 1
        };
        let at = |i: u32| f64::from(i) / f64::from(count) * 2.0 - 1.0;
        let corners: Vec<u32> =
            (0..=count).flat_map(|j| (0..=count).map(move |i| (i, j))).map(|(i, j)| node([at(i), at(j)])).collect();
        let mut triangles = Vec::new();
        for j in 0..count {
            for i in 0..count {
                let first = j * (count + 1) + i;
                let ring = [first, first + 1, first + count + 2, first + count + 1].map(|k| corners[k as usize]);
                let half = 1.0 / f64::from(count);
                let middle = node([at(i) + half, at(j) + half]);
                triangles.extend((0..4).map(|k| [ring[k], ring[(k + 1) % 4], middle]));
            }
        }
        field.triangles = triangles;
        field
    }

    #[test]
    fn the_isolines_of_a_cone_are_circles() {
        let cone = field(40, |[x, y]| 1.0 - x.hypot(y));
        let lines = cone.isolines(0.5);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].is_closed());
        assert!(lines[0].spots.iter().all(|[x, y]| (x.hypot(*y) - 0.5).abs() < 2e-3));
        let smooth = lines[0].smoothed();
        assert!(smooth.is_closed() && (smooth.length() - std::f64::consts::PI).abs() < 0.02);

        // The circle of radius 1.2 extends beyond the square: it leaves four arcs in the corners.
        let arcs = cone.isolines(-0.2);
        assert_eq!(arcs.len(), 4);
        assert!(arcs.iter().all(|arc| !arc.is_closed()));
    }

    #[test]
    fn a_plane_gives_one_straight_line_even_through_nodes() {
        let plane = field(10, |[x, _]| x);
        for level in [0.0, 0.13] {
            let lines = plane.isolines(level);
            assert_eq!(lines.len(), 1, "level {level}");
            assert!((lines[0].length() - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn levels_stand_on_the_usual_steps() {
        assert_eq!(isolux_levels([4.0, 800.0]), [20.0, 30.0, 50.0, 100.0, 200.0, 300.0, 500.0]);
        assert_eq!(isolux_levels([173.0, 431.0]), [200.0, 250.0, 300.0, 350.0, 400.0]);
        assert!(isolux_levels([0.0, 0.0]).is_empty() && isolux_levels([5.0, 5.0]).is_empty());
    }
}
