//! How the tree is built: obvhs' very slow build, step by step, or halving where that would not end.

use glam::{DVec3, Vec3};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::ploc::PlocBuilder;
use obvhs::ploc::morton::morton_encode_u64_unorm;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;

use super::ball::Ball;
use super::nodes::Nodes;

/// Padding of the boxes under the tree on every side, in scaled coordinates. The node test uses differences of coordinates up to 2 with
/// four roundings (2⁻²⁴ of a value each) on either plane: less than 2⁻²⁰.
const PADDING: f32 = 1.0 / (1u32 << 19) as f32;

/// Number of levels that fit the stack of the walks.
pub(super) const DEEPEST: usize = 30;

/// Number of boxes on either side in which clustering searches the best partner of a box: obvhs' medium search distance.
const PARTNERS: usize = 14;
/// Limits of the boxes that all rounds of clustering may examine, per box and in any case. Usually a third of the boxes pair up in a round
/// and the number per box is 3. Where nested boxes pair up one by one, it is half the number of boxes.
const MOST_TESTS_A_BOX: usize = 12;
const TESTS_IN_ANY_CASE: usize = 1_000_000;

/// Number of boxes up to which every node is moved to its best position. With more boxes, this number of the largest nodes is moved. It
/// takes about 20 µs of processor time per node, and small nodes deep in the tree gain least.
const MOST_IN_BEST_PLACE: f32 = 500_000.0;

/// Mean number of nodes that a line through the whole meets, up to which the search for a node's best position is fast. Long triangles that
/// cross each other make it thousands. Then every search goes through much of the tree, and the total time would grow nearly with the
/// square of the number of triangles.
const MOST_MET: f64 = 500.0;

/// Builds the tree over triangles and balls. Boxes are padded after they are split, and temporary data are freed early.
///
/// Some scenes make the tree too deep for the walk's stack. They are built without the optimisation that deepens the tree. Scenes whose
/// boxes pair up one by one (thousands of triangles nested or in one place) are built by halving.
pub(super) fn build(triangles: u32, corners: impl Fn(u32) -> [Vec3; 3] + Copy, balls: &[Ball]) -> Nodes {
    // A ball is entered as a degenerate triangle: see `Block::set`.
    let corners_or_middle = |primitive: u32| match primitive.checked_sub(triangles) {
        Some(ball) => [balls[ball as usize].center.as_vec3(); 3],
        None => corners(primitive),
    };
    let eight_wide = |pairs: Bvh2| Nodes::of(&pairs, corners_or_middle);
    // Boxes are freed as soon as a tree is built over them. The next attempt, which few scenes need, makes them again.
    let boxes_anew = || padded_boxes((0..triangles).map(corners), balls);
    let (boxes, indices) = boxes_anew();
    if !pairs_up(&boxes) {
        return eight_wide(halved(&boxes, indices));
    }
    let params = BvhBuildParams::very_slow_build();
    let placed = params.reinsertion_batch_ratio.min(MOST_IN_BEST_PLACE / boxes.len().max(1) as f32);
    let tree = eight_wide(clustered(BvhBuildParams { reinsertion_batch_ratio: placed, ..params }, boxes, indices));
    if tree.depth() <= DEEPEST {
        return tree;
    }
    let (boxes, indices) = boxes_anew();
    let tree = eight_wide(clustered(BvhBuildParams { reinsertion_batch_ratio: 0.0, ..params }, boxes, indices));
    if tree.depth() <= DEEPEST {
        return tree;
    }
    let (boxes, indices) = boxes_anew();
    eight_wide(halved(&boxes, indices))
}

/// Returns boxes of all triangles, then of all balls, then of the parts cut off large slanted triangles, and the number of the triangle or
/// ball in each box.
///
/// obvhs uses these numbers as indices of boxes, so whole triangles and balls keep the index of their own number.
fn padded_boxes(corners: impl ExactSizeIterator<Item = [Vec3; 3]>, balls: &[Ball]) -> (Vec<Aabb>, Vec<u32>) {
    let first_ball = corners.len();
    let (mut boxes, mut indices) = split_boxes(corners);
    let around =
        |ball: &Ball| Aabb { min: (ball.center - ball.radius).as_vec3a(), max: (ball.center + ball.radius).as_vec3a() };
    boxes.splice(first_ball..first_ball, balls.iter().map(around));
    indices.splice(first_ball..first_ball, first_ball as u32..(first_ball + balls.len()) as u32);
    for aabb in &mut boxes {
        *aabb = Aabb { min: aabb.min - PADDING, max: aabb.max + PADDING };
    }
    (boxes, indices)
}

/// Builds the tree by locally ordered clustering and moves its nodes to better positions.
fn clustered(params: BvhBuildParams, boxes: Vec<Aabb>, indices: Vec<u32>) -> Bvh2 {
    let mut bvh2 = PlocBuilder::new().build(
        params.ploc_search_distance,
        &boxes,
        indices,
        params.sort_precision,
        params.search_depth_threshold,
    );
    drop(boxes);
    bvh2.uses_spatial_splits = params.pre_split;
    let placed = params.reinsertion_batch_ratio * share_to_place(&bvh2);
    ReinsertionOptimizer::default().run(&mut bvh2, placed, None);
    bvh2
}

/// Returns the share of the usual nodes for which the best position is searched.
fn share_to_place(bvh2: &Bvh2) -> f32 {
    let half_area = |node: &Bvh2Node| f64::from(node.aabb().half_area());
    let Some(whole) = bvh2.nodes.first().map(half_area) else {
        return 1.0;
    };
    let met = bvh2.nodes.iter().map(half_area).sum::<f64>() / whole;
    (MOST_MET / met).min(1.0) as f32
}

/// Whether locally ordered clustering of these boxes ends soon. It runs the rounds of clustering without building the tree, and counts.
///
/// Source: D. Meister, J. Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction" (2018).
fn pairs_up(boxes: &[Aabb]) -> bool {
    let mut left = TESTS_IN_ANY_CASE.max(MOST_TESTS_A_BOX * boxes.len());
    let mut clusters = in_morton_order(boxes);
    let mut next: Vec<Aabb> = Vec::with_capacity(clusters.len());
    let mut reach = 1;
    while clusters.len() > 1 {
        let Some(rest) = left.checked_sub(clusters.len()) else {
            return false;
        };
        left = rest;
        let best: Vec<usize> = (0..clusters.len()).map(|index| best_partner(&clusters, index, reach)).collect();
        next.clear();
        for (index, partner) in best.iter().enumerate() {
            match best[*partner] == index {
                true if *partner < index => next.push(clusters[*partner].union(&clusters[index])),
                true => {}
                false => next.push(clusters[index]),
            }
        }
        std::mem::swap(&mut clusters, &mut next);
        reach = PARTNERS;
    }
    true
}

fn in_morton_order(boxes: &[Aabb]) -> Vec<Aabb> {
    let whole = boxes.iter().fold(Aabb::empty(), |whole, aabb| whole.union(aabb));
    let (low, size) = (whole.min.as_dvec3(), whole.diagonal().as_dvec3());
    let code = |aabb: &Aabb| {
        let place = (aabb.center().as_dvec3() - low) / size;
        morton_encode_u64_unorm(place.clamp(DVec3::ZERO, DVec3::ONE))
    };
    let mut ordered: Vec<(u64, Aabb)> = boxes.iter().map(|aabb| (code(aabb), *aabb)).collect();
    ordered.sort_by_key(|(code, _)| *code);
    ordered.into_iter().map(|(_, aabb)| aabb).collect()
}

/// Returns the box that makes the smallest union with the box at `index`, among `reach` boxes on either side. Among equals it returns the
/// last.
fn best_partner(boxes: &[Aabb], index: usize, reach: usize) -> usize {
    let (mut best, mut best_cost) = (index, f32::INFINITY);
    for other in index.saturating_sub(reach)..(index + reach + 1).min(boxes.len()) {
        let cost = boxes[index].union(&boxes[other]).half_area();
        if other != index && cost <= best_cost {
            (best, best_cost) = (other, cost);
        }
    }
    best
}

/// Builds a balanced tree, whatever the boxes: it halves their number along the axis on which their centres spread most.
fn halved(boxes: &[Aabb], indices: Vec<u32>) -> Bvh2 {
    let mut bvh2 = Bvh2::zeroed(boxes.len());
    bvh2.primitive_indices = indices;
    bvh2.uses_spatial_splits = true;
    bvh2.children_are_ordered_after_parents = true;
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut open = if boxes.is_empty() { vec![] } else { vec![(0, 0..boxes.len())] };
    let mut used = 1;
    while let Some((node, range)) = open.pop() {
        let part = &mut order[range.clone()];
        let of = |number: u32| &boxes[number as usize];
        let whole = part.iter().fold(Aabb::empty(), |whole, number| whole.union(of(*number)));
        if let [number] = part {
            bvh2.nodes[node] = Bvh2Node::new(whole, 1, *number);
            continue;
        }
        let middles = part.iter().fold(Aabb::empty(), |middles, number| {
            let middle = of(*number).center();
            middles.union(&Aabb { min: middle, max: middle })
        });
        let axis = middles.largest_axis();
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |one, other| {
            of(*one).center()[axis].total_cmp(&of(*other).center()[axis]).then(one.cmp(other))
        });
        bvh2.nodes[node] = Bvh2Node::new(whole, 0, used as u32);
        let middle = range.start + half;
        open.extend([(used, range.start..middle), (used + 1, middle..range.end)]);
        used += 2;
    }
    bvh2
}

/// Returns boxes of the triangles, with large slanted triangles cut into several boxes, and the triangle of every box.
fn split_boxes(corners: impl ExactSizeIterator<Item = [Vec3; 3]>) -> (Vec<Aabb>, Vec<u32>) {
    let triangles: Vec<Triangle> =
        corners.map(|[a, b, c]| Triangle { v0: a.into(), v1: b.into(), v2: c.into() }).collect();
    let mut boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
    let mut indices: Vec<u32> = (0..triangles.len() as u32).collect();
    let largest = boxes.iter().map(Aabb::half_area).fold(0.0, f32::max);
    let mean = boxes.iter().map(Aabb::half_area).sum::<f32>() / boxes.len().max(1) as f32;
    split_aabbs_preset(&mut boxes, &mut indices, &triangles, mean, largest);
    (boxes, indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes around one centre, each a little larger: the best partner of each is the one before it.
    fn in_one_another(count: u32) -> Vec<Aabb> {
        (0..count)
            .map(|number| {
                let size = glam::Vec3A::splat(0.1 + 0.8 * number as f32 / count as f32);
                Aabb { min: -size, max: size }
            })
            .collect()
    }

    fn side_by_side(count: u32) -> Vec<Aabb> {
        let low = |number: u32| glam::vec3a((number % 300) as f32, (number / 300) as f32, 0.0) / 300.0;
        (0..count).map(|number| Aabb { min: low(number), max: low(number) + 0.003 }).collect()
    }

    fn corners(aabb: &Aabb) -> [Vec3; 3] {
        let (low, high) = (Vec3::from(aabb.min), Vec3::from(aabb.max));
        [low, Vec3::new(high.x, low.y, high.z), high]
    }

    #[test]
    fn boxes_that_pair_up_one_by_one_are_halved_and_others_are_not() {
        assert!(pairs_up(&side_by_side(30_000)) && pairs_up(&[]) && pairs_up(&in_one_another(1000)));
        let one_place = vec![Aabb { min: glam::Vec3A::ZERO, max: glam::Vec3A::ONE }; 20_000];
        for boxes in [in_one_another(20_000), one_place] {
            assert!(!pairs_up(&boxes));
            let tree = build(boxes.len() as u32, |triangle| corners(&boxes[triangle as usize]), &[]);
            assert!(tree.depth() <= 12, "{} levels", tree.depth());
            let mut found: Vec<u32> = tree.filled().map(|(_, primitive)| primitive).collect();
            found.sort_unstable();
            found.dedup();
            assert!(found.into_iter().eq(0..boxes.len() as u32));
        }
    }

    /// For boxes side by side, all are moved to their best positions. For long boxes that cross each other, every search would pass through
    /// all others, so fewer are moved the more there are. Twice the boxes then take less than four times the work.
    #[test]
    fn fewer_nodes_are_placed_where_a_search_would_pass_through_most_of_the_tree() {
        let share = |boxes: &[Aabb]| {
            let indices = (0..boxes.len() as u32).collect();
            let BvhBuildParams { ploc_search_distance, sort_precision, search_depth_threshold, .. } =
                BvhBuildParams::very_slow_build();
            let bvh2 =
                PlocBuilder::new().build(ploc_search_distance, boxes, indices, sort_precision, search_depth_threshold);
            share_to_place(&bvh2)
        };
        let crossing = |count: u32| -> Vec<Aabb> {
            let shift = |number: u32, step: u32| (number * step % 997) as f32 / 997.0 - 0.5;
            let low = |number: u32| glam::vec3a(shift(number, 331), shift(number, 577), shift(number, 709)) - 0.25;
            (0..count).map(|number| Aabb { min: low(number), max: low(number) + 0.5 }).collect()
        };
        assert_eq!(share(&side_by_side(30_000)), 1.0);
        let [few, many] = [10_000, 20_000].map(|count| share(&crossing(count)));
        assert!(few < 0.5 && many < 0.6 * few, "{few}, {many}");
    }

    #[test]
    fn every_triangle_and_ball_has_a_leaf_where_large_triangles_are_split() {
        let slanted = [Vec3::new(-1.0, -1.0, -1.0), Vec3::new(1.0, 1.0, 1.0), Vec3::new(0.9, 1.0, 1.0)];
        let small = side_by_side(500);
        let all: Vec<[Vec3; 3]> = std::iter::once(slanted).chain(small.iter().map(corners)).collect();
        let ball =
            |number: u32| Ball { center: DVec3::splat(0.1 * f64::from(number)), radius: 0.05, luminaire: number };
        let balls: Vec<Ball> = (0..5).map(ball).collect();
        let tree = build(all.len() as u32, |triangle| all[triangle as usize], &balls);
        let mut found: Vec<u32> = tree.filled().map(|(_, primitive)| primitive).collect();
        assert!(found.len() > 506, "the large triangle is split");
        found.sort_unstable();
        found.dedup();
        assert!(found.into_iter().eq(0..506));
    }
}
