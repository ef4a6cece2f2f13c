//! Boxes in a tree: which of them contain or meet a point, a line segment or another box. Every test costs a step of a budget, so that a
//! search ends for any mesh.

use glam::DVec3;

/// Largest number of boxes that are tested one by one.
const LEAF: usize = 8;

/// Steps that a search may still take. A search without steps left stops, and its caller reports that.
#[derive(Clone, Debug)]
pub(super) struct Budget {
    given: u64,
    left: u64,
    is_spent: bool,
}

impl Budget {
    /// Makes a budget of steps: tests of a box, a triangle or a pair of them.
    pub fn of_steps(steps: u64) -> Budget {
        Budget { given: steps, left: steps, is_spent: false }
    }

    /// Takes steps, and returns whether there were enough.
    pub fn take(&mut self, steps: u64) -> bool {
        self.is_spent |= self.left < steps;
        self.left = self.left.saturating_sub(steps);
        !self.is_spent
    }

    /// Whether more steps were required than available. Then the search may be incomplete.
    pub fn is_spent(&self) -> bool {
        self.is_spent
    }

    /// Returns the number of steps taken.
    pub fn taken(&self) -> u64 {
        self.given - self.left
    }
}

/// Lowest and highest corner.
pub(super) type Box3 = [DVec3; 2];

/// Boxes, split in the middle of their number, so that even boxes that all lie in one place make a balanced tree.
#[derive(Clone, Debug)]
pub(super) struct BoxTree {
    nodes: Vec<BoxNode>,
    /// The boxes with their numbers, leaf by leaf.
    items: Vec<(Box3, u32)>,
}

#[derive(Clone, Debug)]
struct BoxNode {
    bounds: Box3,
    first: usize,
    count: usize,
    /// The second child of an inner node; the first child follows the node itself. 0 for a leaf.
    second: usize,
}

impl BoxTree {
    /// Builds a tree over boxes, which are numbered from 0.
    pub fn of(boxes: impl IntoIterator<Item = Box3>) -> BoxTree {
        let items: Vec<(Box3, u32)> = boxes.into_iter().zip(0u32..).collect();
        let mut tree = BoxTree { nodes: Vec::with_capacity(items.len() / 2), items };
        if !tree.items.is_empty() {
            tree.build(0, tree.items.len());
        }
        tree
    }

    /// Builds a tree over points.
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> BoxTree {
        BoxTree::of(points.into_iter().map(|point| [point, point]))
    }

    fn build(&mut self, first: usize, count: usize) {
        let own = self.nodes.len();
        let items = &mut self.items[first..first + count];
        let low = items.iter().fold(DVec3::INFINITY, |low, (bounds, _)| low.min(bounds[0]));
        let high = items.iter().fold(DVec3::NEG_INFINITY, |high, (bounds, _)| high.max(bounds[1]));
        self.nodes.push(BoxNode { bounds: [low, high], first, count, second: 0 });
        if count <= LEAF {
            return;
        }
        let middle = |bounds: &Box3| bounds[0] + bounds[1];
        let lowest = items.iter().fold(DVec3::INFINITY, |low, (bounds, _)| low.min(middle(bounds)));
        let highest = items.iter().fold(DVec3::NEG_INFINITY, |high, (bounds, _)| high.max(middle(bounds)));
        let axis = (highest - lowest).max_position();
        let half = count / 2;
        items.select_nth_unstable_by(half, |(one, one_number), (other, other_number)| {
            middle(one)[axis].total_cmp(&middle(other)[axis]).then(one_number.cmp(other_number))
        });
        self.build(first, half);
        self.nodes[own].second = self.nodes.len();
        self.build(first + half, count - half);
    }

    fn items_of(&self, node: &BoxNode) -> &[(Box3, u32)] {
        &self.items[node.first..node.first + node.count]
    }

    /// Shows the numbers of the boxes that contain a point or are within `tolerance` of it.
    pub fn around(&self, point: DVec3, tolerance: f64, budget: &mut Budget, show: impl FnMut(u32)) {
        let is_in = |[low, high]: &Box3| point.cmpge(*low - tolerance).all() && point.cmple(*high + tolerance).all();
        self.search(is_in, budget, show);
    }

    /// Shows the numbers of the boxes that have a point in common with a box.
    pub fn meeting(&self, [from, to]: Box3, budget: &mut Budget, show: impl FnMut(u32)) {
        self.search(|[low, high]| from.cmple(*high).all() && to.cmpge(*low).all(), budget, show);
    }

    /// Shows the numbers of the boxes within `tolerance` of the straight line between two points (or a little farther, at corners).
    pub fn along(&self, ends: [DVec3; 2], tolerance: f64, budget: &mut Budget, show: impl FnMut(u32)) {
        let [from, to] = ends;
        let way = to - from;
        let is_met = |[low, high]: &Box3| {
            let (mut first, mut last) = (0.0f64, 1.0f64);
            for axis in 0..3 {
                let (low, high) = (low[axis] - tolerance - from[axis], high[axis] + tolerance - from[axis]);
                if way[axis] == 0.0 {
                    if low > 0.0 || high < 0.0 {
                        return false;
                    }
                    continue;
                }
                let (one, other) = (low / way[axis], high / way[axis]);
                first = first.max(one.min(other));
                last = last.min(one.max(other));
            }
            first <= last
        };
        self.search(is_met, budget, show);
    }

    fn search(&self, meets: impl Fn(&Box3) -> bool, budget: &mut Budget, mut show: impl FnMut(u32)) {
        let mut open: Vec<usize> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(number) = open.pop() {
            let node = &self.nodes[number];
            if !budget.take(1) {
                return;
            }
            if !meets(&node.bounds) {
                continue;
            }
            if node.second != 0 {
                open.extend([node.second, number + 1]);
                continue;
            }
            if !budget.take(node.count as u64) {
                return;
            }
            self.items_of(node).iter().filter(|(bounds, _)| meets(bounds)).for_each(|(_, number)| show(*number));
        }
    }

    /// Shows once every pair of boxes that overlap by more than `tolerance` along each axis, as long as the budget lasts.
    pub fn pairs(&self, tolerance: f64, budget: &mut Budget, mut show: impl FnMut(u32, u32, &mut Budget)) {
        let overlap = |one: &Box3, other: &Box3| {
            (one[1].min(other[1]) - one[0].max(other[0])).cmpgt(DVec3::splat(tolerance)).all()
        };
        let mut open: Vec<[usize; 2]> = if self.nodes.is_empty() { Vec::new() } else { vec![[0, 0]] };
        while let Some([one, other]) = open.pop() {
            let (node, other_node) = (&self.nodes[one], &self.nodes[other]);
            if !budget.take(1) {
                return;
            }
            if one == other && node.second != 0 {
                open.extend([[one + 1, node.second], [node.second, node.second], [one + 1, one + 1]]);
                continue;
            }
            if !overlap(&node.bounds, &other_node.bounds) {
                continue;
            }
            if node.second != 0 && (node.count >= other_node.count || other_node.second == 0) {
                open.extend([[node.second, other], [one + 1, other]]);
                continue;
            }
            if other_node.second != 0 {
                open.extend([[one, other_node.second], [one, other + 1]]);
                continue;
            }
            for (rank, (bounds, number)) in self.items_of(node).iter().enumerate() {
                let others = if one == other { &self.items_of(node)[rank + 1..] } else { self.items_of(other_node) };
                if !budget.take(others.len() as u64) {
                    return;
                }
                for (_, other_number) in others.iter().filter(|(other, _)| overlap(bounds, other)) {
                    show(*number, *other_number, budget);
                    if budget.is_spent() {
                        return;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of all sizes near a few places. A plain sine is random enough here.
    fn boxes(count: u32) -> Vec<Box3> {
        let wave = |number: u32, speed: f64| (speed * f64::from(number)).sin();
        let boxed = |number: u32| {
            let low = DVec3::new(wave(number, 1.3), wave(number, 2.7), wave(number, 0.61)) * 4.0;
            let size = DVec3::new(wave(number, 3.1), wave(number, 5.9), wave(number, 7.7)).abs() * 1.5;
            [low, low + size * size]
        };
        (0..count).map(boxed).collect()
    }

    #[test]
    fn searches_find_what_tests_of_all_boxes_find() {
        let boxes = boxes(300);
        let tree = BoxTree::of(boxes.iter().copied());
        let mut budget = Budget::of_steps(1_000_000);
        let mut found = Vec::new();
        tree.pairs(0.01, &mut budget, |one, other, _| found.push([one.min(other), one.max(other)]));
        found.sort_unstable();
        let overlap = |one: &Box3, other: &Box3| (one[1].min(other[1]) - one[0].max(other[0])).min_element() > 0.01;
        let all = (0..300u32).flat_map(|one| (one + 1..300).map(move |other| [one, other]));
        let expected: Vec<[u32; 2]> =
            all.filter(|[one, other]| overlap(&boxes[*one as usize], &boxes[*other as usize])).collect();
        assert!(expected.len() > 100 && found == expected, "{} of {}", found.len(), expected.len());

        for number in 0..200 {
            let point = DVec3::new(f64::from(number).sin(), f64::from(number).cos(), 0.5) * 3.0;
            let mut found = Vec::new();
            tree.around(point, 0.1, &mut budget, |number| found.push(number));
            found.sort_unstable();
            let near = |[low, high]: &Box3| point.clamp(*low, *high).distance(point) <= 0.1;
            let expected: Vec<u32> = (0..300u32).filter(|number| near(&boxes[*number as usize])).collect();
            assert!(expected.iter().all(|number| found.contains(number)), "{point}");

            // Points at steps of a thousandth along the line find no box that the search missed.
            let ends = [point, DVec3::new(-point.y, -point.z, -point.x)];
            let mut met = Vec::new();
            tree.along(ends, 0.0, &mut budget, |number| met.push(number));
            for step in 0..=1000 {
                let place = ends[0].lerp(ends[1], f64::from(step) / 1000.0);
                let inside = |[low, high]: &Box3| place.cmpge(*low).all() && place.cmple(*high).all();
                assert!((0..300u32).all(|number| !inside(&boxes[number as usize]) || met.contains(&number)));
            }
        }
        assert!(!budget.is_spent());
    }

    #[test]
    fn a_search_ends_with_its_budget() {
        let tree = BoxTree::of((0..2000).map(|_| [DVec3::ZERO, DVec3::ONE]));
        let (mut budget, mut pairs) = (Budget::of_steps(50_000), 0);
        tree.pairs(0.0, &mut budget, |_, _, _| pairs += 1);
        assert!(budget.is_spent() && (10_000..=50_000).contains(&pairs), "{pairs}");
        let (mut budget, mut found) = (Budget::of_steps(100), 0);
        tree.around(DVec3::splat(0.5), 0.0, &mut budget, |_| found += 1);
        assert!(budget.is_spent() && found <= 100);
    }
}
