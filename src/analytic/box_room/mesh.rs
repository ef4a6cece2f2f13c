//! One mesh of a room: its exchange areas, its solution, and what the solution says at a point.

use super::BoxRoom;
use super::faces::RoomFace;
use crate::base::form_factors::{
    parallel_corner_m2, perpendicular_corner_m2, point_parallel_corner, point_perpendicular_corner,
};

/// A room's faces cut into n × n rectangles each, with the illuminance of every one.
///
/// Element (i, j) of a face, i along its first axis, stands at i·n + j.
#[derive(Clone, Debug)]
pub(super) struct RoomMesh {
    size_m: [f64; 3],
    divisions: usize,
    /// Edges of the elements along the three axes, n + 1 each.
    edges: [Vec<f64>; 3],
    /// Mean direct and indirect illuminance of the elements, by face.
    direct_lx: [Vec<f64>; 6],
    indirect_lx: [Vec<f64>; 6],
    /// Exitance of the elements by reflection, by face.
    reflected_lm_m2: [Vec<f64>; 6],
    /// Slopes of that along the face's two axes, lm/m² per m, from the neighbours.
    slopes: [Vec<[f64; 2]>; 6],
}

/// The exchange areas between the elements of two faces, row by row of the first.
struct Exchange {
    first: usize,
    second: usize,
    exchange_m2: Vec<f64>,
}

/// The residual of the solution, as a part of the first one's, at which it is done.
const RESIDUAL: f64 = 1e-12;

/// Conjugate gradients take some tens of steps; with reflectances near 1 some more.
const MOST_STEPS: usize = 2000;

impl RoomMesh {
    /// Meshes and solves a room.
    pub fn solved(room: &BoxRoom, divisions: usize) -> RoomMesh {
        let edges = room.size_m.map(|length| graded_edges(length, divisions));
        let mut mesh = RoomMesh {
            size_m: room.size_m,
            divisions,
            edges,
            direct_lx: Default::default(),
            indirect_lx: Default::default(),
            reflected_lm_m2: Default::default(),
            slopes: Default::default(),
        };
        for face in RoomFace::ALL {
            mesh.direct_lx[face.index()] = (0..divisions * divisions)
                .map(|element| {
                    let stretches = mesh.stretches(face, element);
                    room.sources.iter().map(|s| s.rectangle_mean_lx(room.size_m, face, stretches)).sum()
                })
                .collect();
        }
        let pairs = [[0, 1], [2, 3], [4, 5]].map(|[low, _]| mesh.opposite(low));
        let corners = [[0, 2], [0, 4], [2, 4]].into_iter().flat_map(|[one, two]| mesh.adjacent(one, two));
        let exchanges: Vec<Exchange> = pairs.into_iter().chain(corners).collect();
        mesh.solve(room.reflectances, &exchanges);
        mesh.slopes = RoomFace::ALL.map(|face| mesh.slopes_of(face));
        mesh
    }

    fn stretches(&self, face: RoomFace, element: usize) -> [[f64; 2]; 2] {
        let [u, v] = face.other_axes();
        let (i, j) = (element / self.divisions, element % self.divisions);
        [[self.edges[u][i], self.edges[u][i + 1]], [self.edges[v][j], self.edges[v][j + 1]]]
    }

    fn area_m2(&self, face: RoomFace, element: usize) -> f64 {
        self.stretches(face, element).iter().map(|s| s[1] - s[0]).product()
    }

    /// The exchange areas of two opposite faces: the fourfold differences of the corner function on the mesh's lines.
    fn opposite(&self, low: usize) -> Exchange {
        let n = self.divisions;
        let gap = self.size_m[low / 2];
        let [u, v] = RoomFace::ALL[low].other_axes();
        let table = PairTable::new(
            n,
            |i, k| (self.edges[u][i] - self.edges[u][k]).abs(),
            |j, l| (self.edges[v][j] - self.edges[v][l]).abs(),
            |du, dv| parallel_corner_m2(du, dv, gap),
        );
        let mut exchange_m2 = vec![0.0; n.pow(4)];
        table.for_each(|i, k, j, l, value| exchange_m2[(i * n + j) * n * n + k * n + l] = value);
        Exchange { first: low, second: low + 1, exchange_m2 }
    }

    /// The exchange areas of the faces of two axes, four pairs: the mesh is symmetric, so that they differ only in
    /// which end the elements are counted from.
    fn adjacent(&self, low_one: usize, low_two: usize) -> [Exchange; 4] {
        let n = self.divisions;
        let (one, two) = (RoomFace::ALL[low_one], RoomFace::ALL[low_two]);
        // Along the other face's axis the first face runs off the common edge, and the other way round.
        let (off_one, off_two) = (&self.edges[two.axis()], &self.edges[one.axis()]);
        let common = 3 - one.axis() - two.axis();
        let table = PairTable::new(
            n,
            |i, k| off_one[i] * off_one[i] + off_two[k] * off_two[k],
            |j, l| (self.edges[common][j] - self.edges[common][l]).abs(),
            perpendicular_corner_m2,
        );
        let one_runs_off_first = one.other_axes()[0] == two.axis();
        let two_runs_off_first = two.other_axes()[0] == one.axis();
        let ends = [[false, false], [false, true], [true, false], [true, true]];
        let mut exchanges = ends.map(|[one_high, two_high]| Exchange {
            first: low_one + usize::from(one_high),
            second: low_two + usize::from(two_high),
            exchange_m2: vec![0.0; n.pow(4)],
        });
        table.for_each(|i, k, j, l, value| {
            for ([one_high, two_high], exchange) in ends.iter().zip(&mut exchanges) {
                let i = if *two_high { n - 1 - i } else { i };
                let k = if *one_high { n - 1 - k } else { k };
                let a = if one_runs_off_first { i * n + j } else { j * n + i };
                let b = if two_runs_off_first { k * n + l } else { l * n + k };
                exchange.exchange_m2[a * n * n + b] = value;
            }
        });
        exchanges
    }

    /// Solves A E = A E₀ + K ρE for the elements' illuminances by conjugate gradients in x = √ρ E, where the
    /// system is symmetric, then takes E from what x sends.
    fn solve(&mut self, reflectances: [f64; 6], exchanges: &[Exchange]) {
        let per_face = self.divisions * self.divisions;
        let total = 6 * per_face;
        let area: Vec<f64> = (0..total).map(|i| self.area_m2(RoomFace::ALL[i / per_face], i % per_face)).collect();
        let root: Vec<f64> = (0..total).map(|i| reflectances[i / per_face].sqrt()).collect();
        let direct: Vec<f64> = self.direct_lx.concat();

        let send = |sent: &[f64]| {
            let mut received = vec![0.0; total];
            for exchange in exchanges {
                let (a, b) = (exchange.first * per_face, exchange.second * per_face);
                for (i, row) in exchange.exchange_m2.chunks_exact(per_face).enumerate() {
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
            let elements = face * per_face..(face + 1) * per_face;
            self.reflected_lm_m2[face] = sent[elements.clone()].to_vec();
            self.indirect_lx[face] = elements.map(|i| received[i] / area[i]).collect();
        }
    }

    /// Slopes of a face's exitance: of the parabola through an element and its neighbours, at its middle.
    fn slopes_of(&self, face: RoomFace) -> Vec<[f64; 2]> {
        let n = self.divisions;
        let [middle_u, middle_v] = face.other_axes().map(|axis| middles(&self.edges[axis]));
        let values = &self.reflected_lm_m2[face.index()];
        let slope = |middles: &[f64], at: usize, value: &dyn Fn(usize) -> f64| {
            let first = at.clamp(1, n - 2) - 1;
            let [x0, x1, x2] = [middles[first], middles[first + 1], middles[first + 2]];
            let left = (value(first + 1) - value(first)) / (x1 - x0);
            let right = (value(first + 2) - value(first + 1)) / (x2 - x1);
            left + (right - left) * (2.0 * middles[at] - x0 - x1) / (x2 - x0)
        };
        let element = |e: usize| {
            let (i, j) = (e / n, e % n);
            [slope(&middle_u, i, &|i| values[i * n + j]), slope(&middle_v, j, &|j| values[i * n + j])]
        };
        (0..n * n).map(element).collect()
    }

    /// Mean direct illuminance of a face.
    pub fn face_direct_lx(&self, face: RoomFace) -> f64 {
        self.face_mean(face, &self.direct_lx)
    }

    /// Mean indirect illuminance of a face.
    pub fn face_indirect_lx(&self, face: RoomFace) -> f64 {
        self.face_mean(face, &self.indirect_lx)
    }

    fn face_mean(&self, face: RoomFace, values: &[Vec<f64>; 6]) -> f64 {
        let [u, v] = face.other_axes();
        let area: f64 = self.size_m[u] * self.size_m[v];
        values[face.index()].iter().enumerate().map(|(i, e)| e * self.area_m2(face, i)).sum::<f64>() / area
    }

    /// Indirect illuminance at a place of a face: the exact factors to all elements in sight times their exitances.
    ///
    /// Elements that are near for their size do not count as even: they are cut finer, and sloped.
    pub fn indirect_at_lx(&self, face: RoomFace, place: [f64; 2]) -> f64 {
        let position = face.position(self.size_m, place).to_array();
        let n = self.divisions;
        let mut corner = vec![0.0; (n + 1) * (n + 1)];
        let mut sum = 0.0;
        for other in RoomFace::ALL {
            if other == face {
                continue;
            }
            let view = PointView { size_m: self.size_m, face, other, position };
            let [lines_u, lines_v] = other.other_axes().map(|axis| &self.edges[axis]);
            for (i, u) in lines_u.iter().enumerate() {
                for (j, v) in lines_v.iter().enumerate() {
                    corner[i * (n + 1) + j] = view.corner(*u, *v);
                }
            }
            let off = position[other.axis()] - other.at(self.size_m);
            let reflected = &self.reflected_lm_m2[other.index()];
            for i in 0..n {
                let (low, high) = (&corner[i * (n + 1)..][..n + 1], &corner[(i + 1) * (n + 1)..][..n + 1]);
                let (u0, u1) = (lines_u[i], lines_u[i + 1]);
                let away_u = position[other.other_axes()[0]] - 0.5 * (u0 + u1);
                for j in 0..n {
                    sum += reflected[i * n + j] * (high[j + 1] - high[j] - low[j + 1] + low[j]).abs();
                    let (v0, v1) = (lines_v[j], lines_v[j + 1]);
                    let away_v = position[other.other_axes()[1]] - 0.5 * (v0 + v1);
                    let size2 = (u1 - u0).powi(2) + (v1 - v0).powi(2);
                    if off * off + away_u * away_u + away_v * away_v < NEAR * NEAR * size2 {
                        sum += view.slope_part([[u0, u1], [v0, v1]], self.slopes[other.index()][i * n + j]);
                    }
                }
            }
        }
        sum
    }
}

/// Elements nearer than this many of their diagonals are sloped.
const NEAR: f64 = 1.5;

/// Into how many parts a near element is cut each way.
const CUTS: usize = 4;

/// What a point of one face sees of another.
struct PointView {
    size_m: [f64; 3],
    face: RoomFace,
    other: RoomFace,
    position: [f64; 3],
}

impl PointView {
    /// The corner function of the point and a corner on the other face; its twofold difference is a factor but for the
    /// sign.
    #[inline]
    fn corner(&self, u: f64, v: f64) -> f64 {
        let [axis_u, axis_v] = self.other.other_axes();
        if self.other.axis() == self.face.axis() {
            let gap = self.size_m[self.face.axis()];
            return point_parallel_corner(u - self.position[axis_u], v - self.position[axis_v], gap);
        }
        let off = (self.position[self.other.axis()] - self.other.at(self.size_m)).abs();
        let height = |x: f64| (x - self.face.at(self.size_m)).abs();
        if axis_u == self.face.axis() {
            point_perpendicular_corner(off, height(u), v - self.position[axis_v])
        } else {
            point_perpendicular_corner(off, height(v), u - self.position[axis_u])
        }
    }

    /// What a slope of the exitance adds to an element's part; its mean stays.
    fn slope_part(&self, [u, v]: [[f64; 2]; 2], slope: [f64; 2]) -> f64 {
        let line = |x: [f64; 2], k: usize| x[0] + (x[1] - x[0]) * k as f64 / CUTS as f64;
        let corners: [[f64; CUTS + 1]; CUTS + 1] =
            std::array::from_fn(|i| std::array::from_fn(|j| self.corner(line(u, i), line(v, j))));
        let mut sum = 0.0;
        for i in 0..CUTS {
            for j in 0..CUTS {
                let factor = (corners[i + 1][j + 1] - corners[i + 1][j] - corners[i][j + 1] + corners[i][j]).abs();
                let from_middle = |x: [f64; 2], k: usize| (x[1] - x[0]) * ((k as f64 + 0.5) / CUTS as f64 - 0.5);
                sum += factor * (slope[0] * from_middle(u, i) + slope[1] * from_middle(v, j));
            }
        }
        sum
    }
}

/// Middles between neighbouring lines.
fn middles(edges: &[f64]) -> Vec<f64> {
    edges.windows(2).map(|e| 0.5 * (e[0] + e[1])).collect()
}

/// Values of a corner function on all pairs of lines in two directions, (i, k) in one and (j, l) in the other, where
/// (j, l) may be exchanged.
struct PairTable {
    divisions: usize,
    values: Vec<f64>,
}

impl PairTable {
    fn new(
        divisions: usize,
        first: impl Fn(usize, usize) -> f64,
        second: impl Fn(usize, usize) -> f64,
        corner: impl Fn(f64, f64) -> f64,
    ) -> PairTable {
        let lines = divisions + 1;
        let mut values = Vec::with_capacity(lines.pow(4));
        for i in 0..lines {
            for k in 0..lines {
                let along = first(i, k);
                let start = values.len();
                for j in 0..lines {
                    for l in 0..j {
                        values.push(values[start + l * lines + j]);
                    }
                    for l in j..lines {
                        values.push(corner(along, second(j, l)));
                    }
                }
            }
        }
        PairTable { divisions, values }
    }

    /// Calls with every fourfold difference's size; the sign only tells which way the lines are numbered.
    fn for_each(&self, mut call: impl FnMut(usize, usize, usize, usize, f64)) {
        let (n, lines) = (self.divisions, self.divisions + 1);
        let at = |i: usize, k: usize, j: usize, l: usize| self.values[((i * lines + k) * lines + j) * lines + l];
        let across = |i: usize, k: usize, j: usize, l: usize| {
            at(i + 1, k + 1, j, l) - at(i + 1, k, j, l) - at(i, k + 1, j, l) + at(i, k, j, l)
        };
        for i in 0..n {
            for k in 0..n {
                for j in 0..n {
                    for l in 0..n {
                        let value = across(i, k, j + 1, l + 1) - across(i, k, j + 1, l) - across(i, k, j, l + 1)
                            + across(i, k, j, l);
                        call(i, k, j, l, value.abs());
                    }
                }
            }
        }
    }
}

/// Lines from 0 to `length`, close together at both ends, where the light changes fastest; those of half as many
/// divisions are among them.
fn graded_edges(length: f64, divisions: usize) -> Vec<f64> {
    let line = |i: usize| {
        let quarter = 0.5 * std::f64::consts::PI * i as f64 / divisions as f64;
        length * quarter.sin().powi(2)
    };
    let mut edges: Vec<f64> = (0..=divisions).map(line).collect();
    edges[divisions] = length;
    edges
}
