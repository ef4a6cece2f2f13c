//! A tree over many emitters: one choice costs the logarithm of their number instead of the number.
//!
//! After Conty Estevez and Kulla, 2018, "Importance sampling of many lights with adaptive tree splitting". Near groups, whose bound is
//! poor, are opened; a far group is treated as one emitter. A group is chosen in proportion to its importance. Within the group, the
//! descent goes to either child in proportion to the children's importances.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

pub use super::few_beacons::BeaconMask;
use super::few_beacons::{FewBeacons, Weights};
use super::importance::{Beacon, NEAR_RADIUS_PER_DISTANCE, Profile};

/// A node: an emitter, or two children.
#[derive(Clone, Debug)]
struct EmitterNode {
    beacon: Beacon,
    content: Content,
    /// Its leaves, as a range of indices in the order of the leaves.
    leaves: Range<u32>,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    Emitter(u32),
    Children(u32, u32),
}

/// With more emitters than `MANY`, groups count as near from the share `NEAR_OF_MANY` on. A point amid thousands of emitters would open
/// groups of every size, and weighing them takes more time than the finer choice saves (docs/performance.md).
const MANY: usize = 512;
const NEAR_OF_MANY: f64 = 0.5;

/// About the number of emitters that `FewBeacons` weighs in the time of one group.
const WEIGHED_AT_A_TIME: usize = 4;

/// A sum that has shrunk to this share of its original value is only rounding error.
const NOTHING_LEFT: f64 = 1e-13;

/// The groups that are available for choices at one point, with reusable storage, so that choosing allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    open: Vec<u32>,
    groups: Vec<NodeGroup>,
    /// Weights, where the emitters are few.
    weights: Weights,
    /// Number of groups and emitters weighed so far, for all choices made with this cut.
    pub weighed: u64,
}

impl Cut {
    /// Returns the importance of all groups together.
    fn total(&self) -> f64 {
        self.groups.last().map_or(0.0, |group| group.cumulative)
    }

    /// Lessens the weights w of the emitters of a mask, from [`EmitterTree::mask`], to w/(1 + w `per_lx`).
    #[inline]
    pub fn lessen(&mut self, mask: &BeaconMask, per_lx: f64) {
        self.weights.lessen(mask, per_lx);
    }
}

#[derive(Clone, Copy, Debug)]
struct NodeGroup {
    node: u32,
    cumulative: f64,
}

/// A node, ordered by its importance.
#[derive(Clone, Copy, Debug)]
struct WeighedNode {
    importance: f64,
    node: u32,
}

impl Ord for WeighedNode {
    fn cmp(&self, other: &WeighedNode) -> Ordering {
        self.importance.total_cmp(&other.importance).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for WeighedNode {
    fn partial_cmp(&self, other: &WeighedNode) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for WeighedNode {
    fn eq(&self, other: &WeighedNode) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for WeighedNode {}

/// Emitters in a binary tree by position.
#[derive(Clone, Debug)]
pub(super) struct EmitterTree {
    nodes: Vec<EmitterNode>,
    /// Index of every emitter in the order of the leaves.
    place_of: Vec<u32>,
    /// Groups with a radius above this share of their distance are opened.
    near: f64,
    /// The emitters in blocks, where they are few.
    few: Option<FewBeacons>,
}

/// About the largest number of groups that are open at a time while `strongest_first` shows the emitters.
const MOST_OPEN: usize = 4096;
/// Number of groups opened in a row without finding light, after which the rest is assumed to give none. All of a million luminaires may
/// shine away from a point, while the bounds of their groups are just above 0.
const MOST_IN_VAIN: usize = 16_384;

impl EmitterTree {
    /// Builds the tree over beacons; `None` over none.
    pub fn of(beacons: &[&Beacon]) -> Option<EmitterTree> {
        let mut order: Vec<u32> = (0..beacons.len() as u32).collect();
        let near = if beacons.len() > MANY { NEAR_OF_MANY } else { NEAR_RADIUS_PER_DISTANCE };
        let nodes = Vec::with_capacity(2 * beacons.len());
        let mut tree = EmitterTree { nodes, place_of: vec![0; beacons.len()], near, few: FewBeacons::of(beacons) };
        (!order.is_empty()).then(|| {
            tree.build(beacons, &mut order, 0);
            tree
        })
    }

    /// Adds the subtree over `order`, whose first leaf has the index `place`. Returns the number of its root. Children come before their
    /// parent.
    fn build(&mut self, beacons: &[&Beacon], order: &mut [u32], place: u32) -> u32 {
        let leaves = place..place + order.len() as u32;
        if let [only] = order {
            let beacon = beacons[*only as usize].clone();
            self.place_of[*only as usize] = place;
            self.nodes.push(EmitterNode { beacon, content: Content::Emitter(*only), leaves });
            return self.nodes.len() as u32 - 1;
        }
        let centers = order.iter().map(|index| beacons[*index as usize].center_m);
        let low = centers.clone().fold(DVec3::INFINITY, DVec3::min);
        let high = centers.fold(DVec3::NEG_INFINITY, DVec3::max);
        let axis = (high - low).max_position();
        let at = |index: &u32| beacons[*index as usize].center_m[axis];
        // No two keys are equal, so this gives the same halves as sorting.
        order.select_nth_unstable_by(order.len() / 2, |a, b| at(a).total_cmp(&at(b)).then(a.cmp(b)));
        let (first, second) = order.split_at_mut(order.len() / 2);
        let middle = place + first.len() as u32;
        let (left, right) = (self.build(beacons, first, place), self.build(beacons, second, middle));
        let beacon = joined(&self.nodes[left as usize].beacon, &self.nodes[right as usize].beacon);
        self.nodes.push(EmitterNode { beacon, content: Content::Children(left, right), leaves });
        self.nodes.len() as u32 - 1
    }

    /// Chooses an emitter by a variate in [0, 1), at the point and normal for which `cut` was opened. Returns it with the probability of
    /// the choice, or `None` where the descent ends at emitters that give no light.
    pub fn choose(&self, point_m: DVec3, normal: DVec3, variate: f64, cut: &Cut) -> Option<(u32, f64)> {
        if let Some(few) = &self.few {
            return few.choose(variate, &cut.weights);
        }
        let total = cut.total();
        if total <= 0.0 {
            return None;
        }
        let aim = variate * total;
        let chosen = cut.groups.partition_point(|group| group.cumulative <= aim).min(cut.groups.len() - 1);
        let before = if chosen == 0 { 0.0 } else { cut.groups[chosen - 1].cumulative };
        let importance = cut.groups[chosen].cumulative - before;
        if importance <= 0.0 {
            return None;
        }
        let rest = ((aim - before) / importance).clamp(0.0, 1.0);
        self.descend(cut.groups[chosen].node, point_m, normal, rest, importance / total)
    }

    /// Returns the probability with which [`EmitterTree::choose`] chooses an emitter, at the point and normal for which `cut` was opened.
    pub fn probability(&self, emitter: u32, point_m: DVec3, normal: DVec3, cut: &Cut) -> f64 {
        if let Some(few) = &self.few {
            return few.probability(emitter, &cut.weights);
        }
        let place = self.place_of[emitter as usize];
        let total = cut.total();
        let mut before = 0.0;
        for group in &cut.groups {
            let mut node = &self.nodes[group.node as usize];
            if !node.leaves.contains(&place) {
                before = group.cumulative;
                continue;
            }
            let mut probability = (group.cumulative - before) / total;
            while let Content::Children(left, right) = node.content {
                let (left, right) = (&self.nodes[left as usize], &self.nodes[right as usize]);
                let left_importance = left.beacon.importance_lx(point_m, normal);
                let sum = left_importance + right.beacon.importance_lx(point_m, normal);
                if sum <= 0.0 {
                    return 0.0;
                }
                let share = left_importance / sum;
                (node, probability) = if left.leaves.contains(&place) {
                    (left, probability * share)
                } else {
                    (right, probability * (1.0 - share))
                };
            }
            return probability;
        }
        0.0
    }

    /// Shows the emitters that may light a point, roughly the strongest first, each with its importance and the importance of all emitters
    /// not yet shown. Ends when `show` returns `false` or when very many groups in a row contain no light. Returns the number of emitters
    /// and groups that it examined.
    pub fn strongest_first(&self, point_m: DVec3, normal: DVec3, mut show: impl FnMut(u32, f64, f64) -> bool) -> usize {
        let weighed = |node: u32| WeighedNode {
            importance: self.nodes[node as usize].beacon.importance_lx(point_m, normal),
            node,
        };
        let mut open = BinaryHeap::from([weighed(self.nodes.len() as u32 - 1)]);
        let all = open.iter().map(|top| top.importance).sum::<f64>();
        let (mut rest, mut opened, mut in_vain) = (all, 0, 0);
        while let Some(mut strongest) = open.pop() {
            (opened, in_vain) = (opened + 1, in_vain + 1);
            if in_vain > MOST_IN_VAIN {
                break;
            }
            // With very many open groups, it does not open all of them before it shows the first emitter.
            while open.len() > MOST_OPEN
                && let Content::Children(left, right) = self.nodes[strongest.node as usize].content
            {
                let [left, right] = [weighed(left), weighed(right)];
                rest += left.importance + right.importance - strongest.importance;
                let (stronger, weaker) = if left < right { (right, left) } else { (left, right) };
                strongest = stronger;
                open.push(weaker);
            }
            rest -= strongest.importance;
            if rest <= NOTHING_LEFT * all {
                rest = 0.0;
            }
            match self.nodes[strongest.node as usize].content {
                Content::Emitter(emitter) => {
                    if strongest.importance > 0.0 {
                        in_vain = 0;
                        if !show(emitter, strongest.importance, rest) {
                            break;
                        }
                    }
                }
                Content::Children(left, right) => {
                    for child in [weighed(left), weighed(right)] {
                        rest += child.importance;
                        open.push(child);
                    }
                }
            }
        }
        opened
    }

    /// Returns the mask of the emitters that `is_in` accepts; `None` if emitters are too many to be weighed one by one.
    pub fn mask(&self, is_in: impl Fn(u32) -> bool) -> Option<BeaconMask> {
        self.few.as_ref().map(|few| few.mask(is_in))
    }

    /// Prepares `cut` for any number of choices at a point with a unit normal. It lists the groups that are far enough to be treated as one
    /// emitter, with the running sum of their importances. Where the emitters are few, it weighs all of them.
    pub fn open(&self, point_m: DVec3, normal: DVec3, cut: &mut Cut) {
        if let Some(few) = &self.few {
            cut.weighed += few.len().div_ceil(WEIGHED_AT_A_TIME) as u64;
            return few.weigh(point_m, normal, &mut cut.weights);
        }
        cut.groups.clear();
        cut.open.clear();
        cut.open.push(self.nodes.len() as u32 - 1);
        let mut cumulative = 0.0;
        while let Some(index) = cut.open.pop() {
            cut.weighed += 1;
            let node = &self.nodes[index as usize];
            if let Content::Children(left, right) = node.content
                && node.beacon.spans(point_m, self.near)
            {
                cut.open.push(right);
                cut.open.push(left);
                continue;
            }
            let importance = node.beacon.importance_lx(point_m, normal);
            if importance > 0.0 {
                cumulative += importance;
                cut.groups.push(NodeGroup { node: index, cumulative });
            }
        }
    }

    fn descend(
        &self,
        start: u32,
        point_m: DVec3,
        normal: DVec3,
        mut variate: f64,
        mut probability: f64,
    ) -> Option<(u32, f64)> {
        let mut node = &self.nodes[start as usize];
        loop {
            let (left, right) = match node.content {
                Content::Emitter(emitter) => return Some((emitter, probability)),
                Content::Children(left, right) => (&self.nodes[left as usize], &self.nodes[right as usize]),
            };
            let left_importance = left.beacon.importance_lx(point_m, normal);
            let right_importance = right.beacon.importance_lx(point_m, normal);
            let total = left_importance + right_importance;
            if total <= 0.0 {
                return None;
            }
            let share = left_importance / total;
            (node, variate, probability) = if variate < share {
                (left, variate / share, probability * share)
            } else {
                (right, (variate - share) / (1.0 - share), probability * (1.0 - share))
            };
        }
    }
}

/// Returns a beacon that replaces two others: a ball around both, with a common profile if they aim alike.
fn joined(first: &Beacon, second: &Beacon) -> Beacon {
    let between = second.center_m - first.center_m;
    let distance = between.length();
    let radius_m = (0.5 * (distance + first.radius_m + second.radius_m)).max(first.radius_m).max(second.radius_m);
    let along = if distance > 0.0 { between / distance } else { DVec3::ZERO };
    let lead = if radius_m == first.radius_m {
        0.0
    } else if radius_m == second.radius_m {
        distance
    } else {
        radius_m - first.radius_m
    };
    let center_m = first.center_m + along * lead;
    match first.profile_with(second) {
        Some((intensity_cd, profile)) => {
            Beacon { center_m, radius_m, axis: first.axis, intensity_cd, profile, parts: Arc::default() }
        }
        None => Beacon {
            center_m,
            radius_m,
            axis: DVec3::Z,
            intensity_cd: first.largest_intensity_cd() + second.largest_intensity_cd(),
            profile: Profile::Uniform,
            parts: Arc::default(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beacons(count: i32) -> Vec<Beacon> {
        (0..count)
            .map(|i| Beacon {
                center_m: DVec3::new(f64::from(i % 7), f64::from(i / 7), 3.0 + 0.1 * f64::from(i % 3)),
                radius_m: 0.05 * f64::from(i % 2),
                axis: -DVec3::Z,
                intensity_cd: 10f64.powi(i % 5),
                profile: if i % 3 == 0 { Profile::Cosine } else { Profile::Uniform },
                parts: Arc::default(),
            })
            .collect()
    }

    #[test]
    fn every_emitter_that_brings_something_is_chosen_with_the_probability_reported() {
        choices_follow_their_probabilities(37);
    }

    #[test]
    fn so_it_is_among_so_many_that_groups_open_late() {
        choices_follow_their_probabilities(MANY as i32 + 100);
    }

    /// 90,000 downward luminaires give a ceiling above them almost no light in every group, so the search gives up. From below, the search
    /// finds the strongest at once and ends with them.
    #[test]
    fn a_search_among_many_that_shine_away_ends() {
        let downward = |i: i32| Beacon {
            center_m: DVec3::new(f64::from(i % 300), f64::from(i / 300), 5.0),
            radius_m: 0.0,
            axis: -DVec3::Z,
            intensity_cd: 100.0,
            profile: Profile::Cosine,
            parts: Arc::default(),
        };
        let beacons: Vec<Beacon> = (0..90_000).map(downward).collect();
        let tree = EmitterTree::of(&beacons.iter().collect::<Vec<_>>()).expect("there are beacons");
        let search = |z: f64, normal: DVec3| {
            let mut shown = 0;
            let opened = tree.strongest_first(DVec3::new(150.3, 150.4, z), normal, |_, _, _| {
                shown += 1;
                shown < 32
            });
            (shown, opened)
        };
        let (shown, opened) = search(6.0, -DVec3::Z);
        assert!(shown == 0 && opened <= MOST_IN_VAIN + 1, "{shown} {opened}");
        let (shown, opened) = search(0.0, DVec3::Z);
        assert!(shown == 32 && opened < MOST_IN_VAIN, "{shown} {opened}");
    }

    fn choices_follow_their_probabilities(count: i32) {
        let beacons = beacons(count);
        let tree = EmitterTree::of(&beacons.iter().collect::<Vec<_>>()).expect("there are beacons");
        for (point, normal) in [(DVec3::ZERO, DVec3::Z), (DVec3::new(3.0, 3.0, 3.05), DVec3::X)] {
            const N: u32 = 400_000;
            let mut cut = Cut::default();
            tree.open(point, normal, &mut cut);
            let mut counts = vec![0u32; beacons.len()];
            let mut probabilities = vec![0.0; beacons.len()];
            for i in 0..N {
                if let Some((emitter, probability)) =
                    tree.choose(point, normal, (f64::from(i) + 0.5) / f64::from(N), &cut)
                {
                    counts[emitter as usize] += 1;
                    probabilities[emitter as usize] = probability;
                }
            }
            let total: f64 = beacons.iter().map(|beacon| beacon.importance_lx(point, normal)).sum();
            for (emitter, beacon) in beacons.iter().enumerate() {
                // The variates are equidistant, so each share is exact to within a few of them.
                let share = f64::from(counts[emitter]) / f64::from(N);
                assert!(
                    (share - probabilities[emitter]).abs() < 8.0 / f64::from(N),
                    "{emitter}: {share} {}",
                    probabilities[emitter]
                );
                let queried = tree.probability(emitter as u32, point, normal, &cut);
                assert!(
                    probabilities[emitter] == 0.0 || (queried / probabilities[emitter] - 1.0).abs() < 1e-12,
                    "{emitter}: {queried}"
                );
                let brings = beacon.importance_lx(point, normal) > 0.0;
                let expected = brings && beacon.importance_lx(point, normal) > 1e-4 * total;
                assert!(!expected || probabilities[emitter] > 0.0, "emitter {emitter} is never chosen");
            }
        }
    }
}
