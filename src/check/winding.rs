//! Winding numbers of closed shells, in a time that grows with the square root of their number of triangles.

use glam::DVec3;

use super::box_tree::{Box3, Budget};

/// Largest number of triangles that are tested one by one.
const LEAF: usize = 16;

/// The triangles of a closed shell in a tree of boxes.
///
/// For a point outside of a box, the triangles in the box have the same solid angle as any other surface in the box with the same rim. Here
/// that surface is the fan from the box's middle over the edges of the rim, which are far fewer.
///
/// Source: A. Jacobson, L. Kavan, O. Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized Winding Numbers" (2013),
/// section 4.1.
#[derive(Clone, Debug)]
pub(super) struct WindingTree {
    nodes: Vec<WindingNode>,
    triangles: Vec<[DVec3; 3]>,
}

#[derive(Clone, Debug)]
struct WindingNode {
    low_m: DVec3,
    high_m: DVec3,
    /// Edges of the rim. Each is repeated as often as the triangles use it more in one direction than in the other.
    rim: Vec<[DVec3; 2]>,
    /// The triangles of a leaf: index of the first, and their number.
    first: usize,
    count: usize,
    /// The second child of an inner node; the first child follows the node itself.
    second: usize,
}

/// Directed edges, given by their vertices, with their counts.
type Rim = Vec<(u32, u32, i32)>;

impl WindingTree {
    /// Builds a tree over triangles given by their vertices; `place_m` returns the position of a vertex.
    pub fn of(triangles: Vec<[u32; 3]>, place_m: impl Fn(u32) -> DVec3) -> WindingTree {
        let mut tree = WindingTree { nodes: Vec::new(), triangles: Vec::with_capacity(triangles.len()) };
        let mut items: Vec<([u32; 3], DVec3)> =
            triangles.into_iter().map(|triangle| (triangle, triangle.map(&place_m).iter().sum::<DVec3>())).collect();
        tree.build(&mut items, &place_m);
        tree
    }

    fn build(&mut self, items: &mut [([u32; 3], DVec3)], place_m: &impl Fn(u32) -> DVec3) -> Rim {
        let own = self.nodes.len();
        let (first, count) = (self.triangles.len(), if items.len() <= LEAF { items.len() } else { 0 });
        self.nodes.push(WindingNode {
            low_m: DVec3::INFINITY,
            high_m: DVec3::NEG_INFINITY,
            rim: Vec::new(),
            first,
            count,
            second: 0,
        });
        let rim = if count > 0 {
            self.triangles.extend(items.iter().map(|(triangle, _)| triangle.map(place_m)));
            let corners = || self.triangles[first..].iter().flatten().copied();
            self.nodes[own].low_m = corners().fold(DVec3::INFINITY, DVec3::min);
            self.nodes[own].high_m = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
            let edges = items.iter().flat_map(|([a, b, c], _)| [(*a, *b), (*b, *c), (*c, *a)]);
            netted(edges.map(|(from, to)| if from < to { (from, to, 1) } else { (to, from, -1) }).collect())
        } else {
            let middles = || items.iter().map(|(_, middle)| *middle);
            let extent = middles().fold(DVec3::NEG_INFINITY, DVec3::max) - middles().fold(DVec3::INFINITY, DVec3::min);
            let axis = (0..3).max_by(|one, other| extent[*one].total_cmp(&extent[*other])).unwrap_or(0);
            let half = items.len() / 2;
            items.select_nth_unstable_by(half, |one, other| one.1[axis].total_cmp(&other.1[axis]));
            let (left, right) = items.split_at_mut(half);
            let mut rim = self.build(left, place_m);
            let second = self.nodes.len();
            rim.extend(self.build(right, place_m));
            self.nodes[own].second = second;
            self.nodes[own].low_m = self.nodes[own + 1].low_m.min(self.nodes[second].low_m);
            self.nodes[own].high_m = self.nodes[own + 1].high_m.max(self.nodes[second].high_m);
            netted(rim)
        };
        let edge = |(from, to, times): &(u32, u32, i32)| {
            let ends = if *times > 0 { [*from, *to] } else { [*to, *from] };
            std::iter::repeat_n(ends.map(place_m), times.unsigned_abs() as usize)
        };
        self.nodes[own].rim = rim.iter().flat_map(edge).collect();
        rim
    }

    /// Returns the signed solid angle in sr of the shell at a point off its surface. Each tested triangle, edge and node costs one step of
    /// the budget.
    pub fn solid_angle_sr(&self, point_m: DVec3, budget: &mut Budget) -> f64 {
        let mut sum_sr = 0.0;
        let mut open = vec![0];
        while let Some(number) = open.pop() {
            let node = &self.nodes[number];
            let outside = point_m.cmplt(node.low_m).any() || point_m.cmpgt(node.high_m).any();
            let by_rim = outside && (node.count == 0 || node.rim.len() < node.count);
            if !budget.take(1 + if by_rim { node.rim.len() } else { node.count } as u64) {
                break;
            }
            if by_rim {
                let middle_m = 0.5 * (node.low_m + node.high_m);
                sum_sr += node.rim.iter().map(|[a, b]| triangle_sr([middle_m, *a, *b], point_m)).sum::<f64>();
            } else if node.count > 0 {
                let leaf = &self.triangles[node.first..node.first + node.count];
                sum_sr += leaf.iter().map(|triangle| triangle_sr(*triangle, point_m)).sum::<f64>();
            } else {
                open.extend([number + 1, node.second]);
            }
        }
        sum_sr
    }

    /// Returns a distance in m such that no triangle is nearer to the point: the distance to the nearest box of a leaf.
    pub fn clear_m(&self, point_m: DVec3, budget: &mut Budget) -> f64 {
        let distance_m = |node: &WindingNode| point_m.distance(point_m.clamp(node.low_m, node.high_m));
        let mut nearest_m = f64::INFINITY;
        let mut open = vec![0];
        while let Some(number) = open.pop() {
            let node = &self.nodes[number];
            if !budget.take(1) {
                return 0.0;
            }
            let away_m = distance_m(node);
            if away_m >= nearest_m {
                continue;
            }
            if node.count > 0 {
                nearest_m = away_m;
                continue;
            }
            // The nearer child is examined first.
            let children = [number + 1, node.second];
            let [one_m, other_m] = children.map(|child| distance_m(&self.nodes[child]));
            open.extend(if one_m < other_m { [children[1], children[0]] } else { children });
        }
        nearest_m
    }

    /// Whether a triangle may come within `tolerance_m` of a box: neither the axes nor the triangle's plane separate them.
    pub fn may_cut(&self, [low_m, high_m]: Box3, tolerance_m: f64, budget: &mut Budget) -> bool {
        let (low_m, high_m) = (low_m - tolerance_m, high_m + tolerance_m);
        let (middle_m, half_m) = (low_m.midpoint(high_m), 0.5 * (high_m - low_m));
        let cuts = |[a, b, c]: &[DVec3; 3]| {
            let is_beside = a.min(*b).min(*c).cmpgt(high_m).any() || a.max(*b).max(*c).cmplt(low_m).any();
            let normal = (*b - *a).cross(*c - *a);
            !is_beside && normal.dot(middle_m - *a).abs() <= normal.abs().dot(half_m) + tolerance_m * normal.length()
        };
        let is_near = |node: &WindingNode| !(low_m.cmpgt(node.high_m).any() || high_m.cmplt(node.low_m).any());
        self.any(is_near, budget, cuts)
    }

    /// Whether a triangle comes within `tolerance_m` of a point, by the given distance function.
    pub fn any_near(
        &self,
        point_m: DVec3,
        tolerance_m: f64,
        budget: &mut Budget,
        distance_m: impl Fn([DVec3; 3]) -> f64,
    ) -> bool {
        let is_near = |node: &WindingNode| {
            !(point_m.cmplt(node.low_m - tolerance_m).any() || point_m.cmpgt(node.high_m + tolerance_m).any())
        };
        self.any(is_near, budget, |triangle| distance_m(*triangle) <= tolerance_m)
    }

    /// Whether a triangle in a box that `is_near` accepts satisfies `is_found`, as far as the budget suffices.
    fn any(
        &self,
        is_near: impl Fn(&WindingNode) -> bool,
        budget: &mut Budget,
        is_found: impl Fn(&[DVec3; 3]) -> bool,
    ) -> bool {
        let mut open = vec![0];
        while let Some(number) = open.pop() {
            let node = &self.nodes[number];
            if !budget.take(1 + node.count as u64) {
                break;
            }
            if !is_near(node) {
                continue;
            }
            if node.count == 0 {
                open.extend([number + 1, node.second]);
            }
            if self.triangles[node.first..node.first + node.count].iter().any(&is_found) {
                return true;
            }
        }
        false
    }
}

/// Returns the solid angle of a triangle as seen from a point, in sr; positive where the point sees its back.
///
/// Source: A. Van Oosterom, J. Strackee, "The Solid Angle of a Plane Triangle" (1983).
fn triangle_sr(corners: [DVec3; 3], point_m: DVec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point_m);
    let [length_a, length_b, length_c] = [a, b, c].map(DVec3::length);
    let volume = a.dot(b.cross(c));
    let cosine = length_a * length_b * length_c + a.dot(b) * length_c + b.dot(c) * length_a + c.dot(a) * length_b;
    2.0 * volume.atan2(cosine)
}

/// Returns the edges that are used more often in one direction than in the other.
fn netted(mut edges: Rim) -> Rim {
    edges.sort_unstable();
    let sums = edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1));
    let net = sums.map(|same| (same[0].0, same[0].1, same.iter().map(|edge| edge.2).sum()));
    net.filter(|edge| edge.2 != 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::icosphere;

    #[test]
    fn the_tree_gives_the_sum_over_all_triangles() {
        let shape = icosphere(DVec3::new(0.3, 0.2, 0.1), 1.0, true, 9);
        let triangles = shape.parts[0].triangles.clone();
        let corners = |triangle: [u32; 3]| triangle.map(|vertex| shape.vertices[vertex as usize]);
        let tree = WindingTree::of(triangles.clone(), |vertex| shape.vertices[vertex as usize]);
        for step in 0..400u32 {
            let turn = f64::from(step) * 0.7;
            let point =
                DVec3::new(turn.sin(), (1.3 * turn).cos(), (0.37 * turn).sin()) * (0.2 + 0.004 * f64::from(step));
            let whole: f64 = triangles.iter().map(|triangle| triangle_sr(corners(*triangle), point)).sum();
            let found = tree.solid_angle_sr(point, &mut Budget::of_steps(u64::MAX));
            assert!((found - whole).abs() < 1e-10, "{point}: {found} for {whole}");
            // The triangles lie slightly inside the sphere, and boxes of leaves extend further in.
            let clear_m = tree.clear_m(point, &mut Budget::of_steps(u64::MAX));
            let away_m = (point.distance(DVec3::new(0.3, 0.2, 0.1)) - 1.0).abs();
            assert!(clear_m <= away_m + 0.01 && (away_m < 0.5 || clear_m > 0.0), "{point}: {clear_m} of {away_m}");
        }
    }
}
