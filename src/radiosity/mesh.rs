//! One mesh of a room: its exchange areas, its solution, and the illuminance at a point from the solution.

use glam::DVec3;
use rayon::prelude::*;

use super::faces::RoomFace;
use crate::base::form_factors::{
    parallel_corner_m2, perpendicular_corner_m2, point_parallel_corner, point_perpendicular_corner,
};
use crate::base::polygon::polygon_illuminance_factor;

/// A room's faces cut into rectangles, with the illuminance of every rectangle.
///
/// Element (i, j) of a face has index i·m + j. i counts along the face's first axis, and m is the number of parts along its second
/// axis.
#[derive(Clone, Debug)]
pub struct RoomMesh {
    size_m: [f64; 3],
    /// Edges of the elements along the three axes, m.
    edges: [Vec<f64>; 3],
    /// Mean direct and indirect illuminance of the elements, by face.
    direct_lx: [Vec<f64>; 6],
    indirect_lx: [Vec<f64>; 6],
    /// Exitance of the elements by reflection, by face.
    reflected_lm_m2: [Vec<f64>; 6],
    /// Slopes of the exitance along the face's two axes, lm/m² per m, from the neighbouring elements.
    slopes: [Vec<[f64; 2]>; 6],
}

/// The exchange areas between the elements of two faces, row by row of the first.
struct Exchange {
    first: usize,
    second: usize,
    exchange_m2: Vec<f64>,
}

/// Relative residual of the solution at which the solver stops.
const RESIDUAL: f64 = 1e-12;

/// Conjugate gradients take some tens of steps, and some more with reflectances near 1.
const MOST_STEPS: usize = 2000;

impl RoomMesh {
    /// Solves a room from the origin to `size_m`. The faces are cut at `edges` along each axis (rising, from 0 to the room's
    /// length), the same on all faces.
    ///
    /// The two functions give the reflectance and the mean direct illuminance in lx of a rectangle, from its face and its stretches
    /// along the other axes. At least one face must absorb.
    pub fn solved(
        size_m: [f64; 3],
        edges: [Vec<f64>; 3],
        reflectance: impl Fn(RoomFace, [[f64; 2]; 2]) -> f64,
        direct_lx: impl Fn(RoomFace, [[f64; 2]; 2]) -> f64,
    ) -> RoomMesh {
        let mut mesh = RoomMesh {
            size_m,
            edges,
            direct_lx: Default::default(),
            indirect_lx: Default::default(),
            reflected_lm_m2: Default::default(),
            slopes: Default::default(),
        };
        let mut reflectances: [Vec<f64>; 6] = Default::default();
        for face in RoomFace::ALL {
            let elements = 0..mesh.count(face);
            reflectances[face.index()] = elements.clone().map(|e| reflectance(face, mesh.stretches(face, e))).collect();
            mesh.direct_lx[face.index()] = elements.map(|e| direct_lx(face, mesh.stretches(face, e))).collect();
        }
        let pairs: Vec<[usize; 2]> =
            (0..6).flat_map(|first| (first + 1..6).map(move |second| [first, second])).collect();
        let exchanges: Vec<Exchange> =
            pairs.into_par_iter().map(|pair| mesh.exchange(pair.map(|f| RoomFace::ALL[f]))).collect();
        mesh.solve(&reflectances, &exchanges);
        mesh.slopes = RoomFace::ALL.map(|face| mesh.slopes_of(face, &reflectances[face.index()]));
        mesh
    }

    /// Number of rectangles in all.
    pub fn len(&self) -> usize {
        RoomFace::ALL.into_iter().map(|face| self.count(face)).sum()
    }

    /// Returns whether there is no rectangle; always `false` for a room.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of parts of a face along its other two axes.
    fn parts(&self, face: RoomFace) -> [usize; 2] {
        face.other_axes().map(|axis| self.edges[axis].len() - 1)
    }

    fn count(&self, face: RoomFace) -> usize {
        self.parts(face).iter().product()
    }

    fn stretches(&self, face: RoomFace, element: usize) -> [[f64; 2]; 2] {
        let [u, v] = face.other_axes();
        let across = self.parts(face)[1];
        let (i, j) = (element / across, element % across);
        [[self.edges[u][i], self.edges[u][i + 1]], [self.edges[v][j], self.edges[v][j + 1]]]
    }

    fn area_m2(&self, face: RoomFace, element: usize) -> f64 {
        self.stretches(face, element).iter().map(|s| s[1] - s[0]).product()
    }

    fn exchange(&self, [one, two]: [RoomFace; 2]) -> Exchange {
        if one.axis() == two.axis() { self.opposite(one, two) } else { self.adjacent(one, two) }
    }

    /// The exchange areas of two opposite faces: fourfold differences of the corner function on the lines of the mesh.
    fn opposite(&self, low: RoomFace, high: RoomFace) -> Exchange {
        let gap = self.size_m[low.axis()];
        let [u, v] = low.other_axes().map(|axis| &self.edges[axis]);
        let table = PairTable::new(
            [u.len(), u.len(), v.len()],
            |i, k| (u[i] - u[k]).abs(),
            |j, l| (v[j] - v[l]).abs(),
            |du, dv| parallel_corner_m2(du, dv, gap),
        );
        let (count, across) = (self.count(low), v.len() - 1);
        let mut exchange_m2 = vec![0.0; count * count];
        table.for_each(|i, k, j, l, value| exchange_m2[(i * across + j) * count + k * across + l] = value);
        Exchange { first: low.index(), second: high.index(), exchange_m2 }
    }

    /// The exchange areas of two faces with a common edge.
    fn adjacent(&self, one: RoomFace, two: RoomFace) -> Exchange {
        // The first face extends from the common edge along the axis of the other face, and vice versa.
        let off = |face: RoomFace| -> Vec<f64> {
            self.edges[face.axis()].iter().map(|x| (x - face.at(self.size_m)).abs()).collect()
        };
        let (off_one, off_two) = (off(two), off(one));
        let along = &self.edges[3 - one.axis() - two.axis()];
        let table = PairTable::new(
            [off_one.len(), off_two.len(), along.len()],
            |i, k| off_one[i] * off_one[i] + off_two[k] * off_two[k],
            |j, l| (along[j] - along[l]).abs(),
            perpendicular_corner_m2,
        );
        let one_runs_off_first = one.other_axes()[0] == two.axis();
        let two_runs_off_first = two.other_axes()[0] == one.axis();
        let (across_one, across_two) = (self.parts(one)[1], self.parts(two)[1]);
        let count_two = self.count(two);
        let mut exchange_m2 = vec![0.0; self.count(one) * count_two];
        table.for_each(|i, k, j, l, value| {
            let a = if one_runs_off_first { i * across_one + j } else { j * across_one + i };
            let b = if two_runs_off_first { k * across_two + l } else { l * across_two + k };
            exchange_m2[a * count_two + b] = value;
        });
        Exchange { first: one.index(), second: two.index(), exchange_m2 }
    }

    /// Solves A E = A E₀ + K ρE for the elements' illuminances by conjugate gradients in x = √ρ E, where the system is symmetric.
    /// Then computes E from the light that x sends.
    fn solve(&mut self, reflectances: &[Vec<f64>; 6], exchanges: &[Exchange]) {
        let mut starts = [0; 7];
        for face in 0..6 {
            starts[face + 1] = starts[face] + self.count(RoomFace::ALL[face]);
        }
        let total = starts[6];
        let area: Vec<f64> =
            RoomFace::ALL.iter().flat_map(|f| (0..self.count(*f)).map(|e| self.area_m2(*f, e))).collect();
        let root: Vec<f64> = reflectances.concat().iter().map(|r| r.sqrt()).collect();
        let direct: Vec<f64> = self.direct_lx.concat();

        let send = |sent: &[f64]| {
            let mut received = vec![0.0; total];
            for exchange in exchanges {
                let (a, b) = (starts[exchange.first], starts[exchange.second]);
                let across = starts[exchange.second + 1] - b;
                for (i, row) in exchange.exchange_m2.chunks_exact(across).enumerate() {
                    let from = sent[a + i];
                    let mut sum = 0.0;
                    for (j, k) in row.iter().enumerate() {
                        sum += k * sent[b + j];
                        received[b + j] += k * from;
                    }
                    received[a + i] += sum;
                }
            }
            received
        };
        let operator = |x: &[f64]| {
            let sent: Vec<f64> = x.iter().zip(&root).map(|(x, r)| r * x).collect();
            let received = send(&sent);
            (0..total).map(|i| area[i] * x[i] - root[i] * received[i]).collect::<Vec<f64>>()
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();

        let mut x = vec![0.0; total];
        let mut residual: Vec<f64> = (0..total).map(|i| root[i] * area[i] * direct[i]).collect();
        let scaled = |residual: &[f64]| residual.iter().zip(&area).map(|(r, a)| r / a).collect::<Vec<f64>>();
        let mut preconditioned = scaled(&residual);
        let mut direction = preconditioned.clone();
        let mut size = dot(&residual, &preconditioned);
        let done = size * RESIDUAL * RESIDUAL;
        for _ in 0..MOST_STEPS {
            if size <= done {
                break;
            }
            let image = operator(&direction);
            let step = size / dot(&direction, &image);
            for i in 0..total {
                x[i] += step * direction[i];
                residual[i] -= step * image[i];
            }
            preconditioned = scaled(&residual);
            let next = dot(&residual, &preconditioned);
            for i in 0..total {
                direction[i] = preconditioned[i] + next / size * direction[i];
            }
            size = next;
        }

        let sent: Vec<f64> = x.iter().zip(&root).map(|(x, r)| r * x).collect();
        let received = send(&sent);
        for face in 0..6 {
            let elements = starts[face]..starts[face + 1];
            self.reflected_lm_m2[face] = sent[elements.clone()].to_vec();
            self.indirect_lx[face] = elements.map(|i| received[i] / area[i]).collect();
        }
    }

    /// Slopes of a face's exitance: the reflectance times the slope at the element's middle of a parabola. The parabola passes
    /// through the illuminances of the element and its neighbours.
    fn slopes_of(&self, face: RoomFace, reflectances: &[f64]) -> Vec<[f64; 2]> {
        let [middle_u, middle_v] = face.other_axes().map(|axis| middles(&self.edges[axis]));
        let across = middle_v.len();
        let (direct, indirect) = (&self.direct_lx[face.index()], &self.indirect_lx[face.index()]);
        let value = |i: usize, j: usize| direct[i * across + j] + indirect[i * across + j];
        let slope = |middles: &[f64], at: usize, value: &dyn Fn(usize) -> f64| {
            let n = middles.len();
            if n < 3 {
                return if n < 2 { 0.0 } else { (value(1) - value(0)) / (middles[1] - middles[0]) };
            }
            let first = at.clamp(1, n - 2) - 1;
            let [x0, x1, x2] = [middles[first], middles[first + 1], middles[first + 2]];
            let left = (value(first + 1) - value(first)) / (x1 - x0);
            let right = (value(first + 2) - value(first + 1)) / (x2 - x1);
            left + (right - left) * (2.0 * middles[at] - x0 - x1) / (x2 - x0)
        };
        let element = |e: usize| {
            let (i, j) = (e / across, e % across);
            [slope(&middle_u, i, &|i| value(i, j)), slope(&middle_v, j, &|j| value(i, j))].map(|s| reflectances[e] * s)
        };
        (0..self.count(face)).map(element).collect()
    }

    /// Mean direct illuminance of a face, lx.
    pub fn face_direct_lx(&self, face: RoomFace) -> f64 {
        self.face_mean(face, &self.direct_lx)
    }

    /// Mean indirect illuminance of a face, lx.
    pub fn face_indirect_lx(&self, face: RoomFace) -> f64 {
        self.face_mean(face, &self.indirect_lx)
    }

    fn face_mean(&self, face: RoomFace, values: &[Vec<f64>; 6]) -> f64 {
        let [u, v] = face.other_axes();
        let area: f64 = self.size_m[u] * self.size_m[v];
        values[face.index()].iter().enumerate().map(|(i, e)| e * self.area_m2(face, i)).sum::<f64>() / area
    }

    /// Indirect illuminance in lx at a point in or on the room, for a unit normal. It sums the exact factors to all visible
    /// elements times their exitances.
    ///
    /// Elements that are near compared with their size do not count as uniform. They are cut finer and get a slope. A point on a
    /// face must lie exactly on it.
    pub fn indirect_at_lx(&self, position: DVec3, normal: DVec3) -> f64 {
        let along = (0..3).find(|axis| normal[*axis].abs() == 1.0);
        RoomFace::ALL
            .into_iter()
            .map(|other| {
                let eye = Viewpoint { size_m: self.size_m, other, position, normal };
                match along {
                    Some(axis) => self.by_corners_lx(&eye, axis),
                    None => self.by_polygons_lx(&eye),
                }
            })
            .sum()
    }

    /// Contribution of a face to a point whose normal is along an axis, in lx, by one corner function for the whole mesh.
    fn by_corners_lx(&self, eye: &Viewpoint, axis: usize) -> f64 {
        let other = eye.other;
        if other.axis() == axis && eye.height(other.at(self.size_m), axis) <= 0.0 {
            return 0.0;
        }
        let [lines_u, lines_v] = other.other_axes().map(|axis| &self.edges[axis]);
        let [_, across] = self.parts(other);
        let row = |u: f64| -> Vec<f64> { lines_v.iter().map(|v| eye.corner(axis, u, *v)).collect() };
        let mut low = row(lines_u[0]);
        let mut sum = 0.0;
        for (i, u) in lines_u.windows(2).enumerate() {
            let high = row(u[1]);
            for (j, v) in lines_v.windows(2).enumerate() {
                let element = i * across + j;
                let stretches = [[u[0], u[1]], [v[0], v[1]]];
                let factor = (high[j + 1] - high[j] - low[j + 1] + low[j]).abs();
                sum += self.reflected_lm_m2[other.index()][element] * factor;
                if eye.is_near(stretches) {
                    let corners: [[f64; CUTS + 1]; CUTS + 1] = std::array::from_fn(|i| {
                        std::array::from_fn(|j| eye.corner(axis, cut(stretches[0], i), cut(stretches[1], j)))
                    });
                    let factor = |i: usize, j: usize| {
                        (corners[i + 1][j + 1] - corners[i + 1][j] - corners[i][j + 1] + corners[i][j]).abs()
                    };
                    sum += slope_part(stretches, self.slopes[other.index()][element], factor);
                }
            }
            low = high;
        }
        sum
    }

    /// Contribution of a face to a point with any normal, in lx, by Lambert's polygon formula.
    fn by_polygons_lx(&self, eye: &Viewpoint) -> f64 {
        let other = eye.other;
        let factor = |stretches: [[f64; 2]; 2]| {
            polygon_illuminance_factor(eye.position, eye.normal, &other.corners(self.size_m, stretches))
        };
        let element_lx = |element: usize| {
            let stretches = self.stretches(other, element);
            let even_lx = self.reflected_lm_m2[other.index()][element] * factor(stretches);
            if !eye.is_near(stretches) {
                return even_lx;
            }
            let part = |i: usize, j: usize| {
                let [u, v] = stretches;
                factor([[cut(u, i), cut(u, i + 1)], [cut(v, j), cut(v, j + 1)]])
            };
            even_lx + slope_part(stretches, self.slopes[other.index()][element], part)
        };
        (0..self.count(other)).map(element_lx).sum()
    }
}

/// Elements nearer than this multiple of their diagonal get a slope.
const NEAR_DIAGONALS: f64 = 1.5;

/// Number of parts of a near element in each direction.
const CUTS: usize = 4;

/// A point and its normal, as seen from a face (`other`) that lights it.
struct Viewpoint {
    size_m: [f64; 3],
    other: RoomFace,
    position: DVec3,
    normal: DVec3,
}

impl Viewpoint {
    /// Height of a coordinate above the point's horizon, m; 0 below it.
    fn height(&self, x: f64, axis: usize) -> f64 {
        (self.normal[axis] * (x - self.position[axis])).max(0.0)
    }

    /// The corner function between the point, whose normal is along `axis`, and a corner on the other face. Its twofold difference
    /// is a factor up to the sign.
    #[inline]
    fn corner(&self, axis: usize, u: f64, v: f64) -> f64 {
        let [axis_u, axis_v] = self.other.other_axes();
        let at = self.other.at(self.size_m);
        if self.other.axis() == axis {
            let gap = self.height(at, axis);
            return point_parallel_corner(u - self.position[axis_u], v - self.position[axis_v], gap);
        }
        let off = (self.position[self.other.axis()] - at).abs();
        if axis_u == axis {
            point_perpendicular_corner(off, self.height(u, axis), v - self.position[axis_v])
        } else {
            point_perpendicular_corner(off, self.height(v, axis), u - self.position[axis_u])
        }
    }

    fn is_near(&self, [u, v]: [[f64; 2]; 2]) -> bool {
        let [axis_u, axis_v] = self.other.other_axes();
        let off = self.position[self.other.axis()] - self.other.at(self.size_m);
        let away_u = self.position[axis_u] - 0.5 * (u[0] + u[1]);
        let away_v = self.position[axis_v] - 0.5 * (v[0] + v[1]);
        let size2 = (u[1] - u[0]).powi(2) + (v[1] - v[0]).powi(2);
        off * off + away_u * away_u + away_v * away_v < NEAR_DIAGONALS * NEAR_DIAGONALS * size2
    }
}

/// Position of line `k` that cuts a near element's stretch into parts.
fn cut(stretch: [f64; 2], k: usize) -> f64 {
    stretch[0] + (stretch[1] - stretch[0]) * k as f64 / CUTS as f64
}

/// Illuminance that the slope of the exitance adds to an element's contribution, from the factors of its parts. The mean exitance
/// is unchanged.
fn slope_part([u, v]: [[f64; 2]; 2], slope: [f64; 2], factor: impl Fn(usize, usize) -> f64) -> f64 {
    let from_middle = |x: [f64; 2], k: usize| (x[1] - x[0]) * ((k as f64 + 0.5) / CUTS as f64 - 0.5);
    let mut sum = 0.0;
    for i in 0..CUTS {
        for j in 0..CUTS {
            sum += factor(i, j) * (slope[0] * from_middle(u, i) + slope[1] * from_middle(v, j));
        }
    }
    sum
}

/// Smallest relative error that is stated: the rounding of the sums and the solver's error.
const LEAST_ERROR: f64 = 1e-9;

/// The limit of the values of three meshes and its estimated error. Each mesh has about a quarter of the error of the one before.
///
/// The difference of the limits from the coarse pair and from the fine pair is about the error of the coarse pair's limit. That is
/// at least four times the error of the fine pair's limit, since the error left by the extrapolation falls no slower than before.
/// Half of the difference is stated.
///
/// Source: docs/methods.md (12).
pub fn extrapolated([coarse, middle, fine]: [f64; 3]) -> (f64, f64) {
    let limit = |coarse: f64, fine: f64| fine + (fine - coarse) / 3.0;
    let value = limit(middle, fine);
    (value, 0.5 * (value - limit(coarse, middle)).abs() + LEAST_ERROR * value.abs())
}

/// Middles between neighbouring lines.
fn middles(edges: &[f64]) -> Vec<f64> {
    edges.windows(2).map(|e| 0.5 * (e[0] + e[1])).collect()
}

/// Values of a corner function on all pairs of lines in two directions: (i, k) in one and (j, l) in the other. The function is
/// symmetric in j and l.
struct PairTable {
    /// Numbers of lines for i, for k, and for both j and l.
    lines: [usize; 3],
    values: Vec<f64>,
}

impl PairTable {
    fn new(
        lines: [usize; 3],
        first: impl Fn(usize, usize) -> f64,
        second: impl Fn(usize, usize) -> f64,
        corner: impl Fn(f64, f64) -> f64,
    ) -> PairTable {
        let [lines_i, lines_k, lines_j] = lines;
        let mut values = Vec::with_capacity(lines_i * lines_k * lines_j * lines_j);
        for i in 0..lines_i {
            for k in 0..lines_k {
                let along = first(i, k);
                let start = values.len();
                for j in 0..lines_j {
                    for l in 0..j {
                        values.push(values[start + l * lines_j + j]);
                    }
                    for l in j..lines_j {
                        values.push(corner(along, second(j, l)));
                    }
                }
            }
        }
        PairTable { lines, values }
    }

    /// Calls `call` with the absolute value of every fourfold difference. The sign only depends on the direction in which the lines
    /// are numbered.
    fn for_each(&self, mut call: impl FnMut(usize, usize, usize, usize, f64)) {
        let [lines_i, lines_k, lines_j] = self.lines;
        let at = |i: usize, k: usize, j: usize, l: usize| self.values[((i * lines_k + k) * lines_j + j) * lines_j + l];
        let across = |i: usize, k: usize, j: usize, l: usize| {
            at(i + 1, k + 1, j, l) - at(i + 1, k, j, l) - at(i, k + 1, j, l) + at(i, k, j, l)
        };
        for i in 0..lines_i - 1 {
            for k in 0..lines_k - 1 {
                for j in 0..lines_j - 1 {
                    for l in 0..lines_j - 1 {
                        let value = across(i, k, j + 1, l + 1) - across(i, k, j + 1, l) - across(i, k, j, l + 1)
                            + across(i, k, j, l);
                        call(i, k, j, l, value.abs());
                    }
                }
            }
        }
    }
}

/// Lines through all `breaks` (rising), with about `divisions` stretches in all. They are close together at every break, where the
/// light changes fastest. The lines of half as many divisions are among them if `divisions` is a multiple of 8.
pub fn graded_edges(breaks: &[f64], divisions: usize) -> Vec<f64> {
    let length = breaks[breaks.len() - 1] - breaks[0];
    let mut edges = vec![breaks[0]];
    for stretch in breaks.windows(2) {
        // Shares are rounded to quarters of the whole, so that doubling the divisions halves every stretch.
        let quarters = (4.0 * (stretch[1] - stretch[0]) / length).round().max(1.0) as usize;
        let count = (quarters * divisions).div_ceil(4);
        let line = |i: usize| {
            let quarter_turn = 0.5 * std::f64::consts::PI * i as f64 / count as f64;
            stretch[0] + (stretch[1] - stretch[0]) * quarter_turn.sin().powi(2)
        };
        edges.extend((1..count).map(line));
        edges.push(stretch[1]);
    }
    edges
}
