//! Neighbours among points: regions over which walks are pooled, and groups that share what their walks meet.

use std::ops::Range;

use glam::DVec3;

use crate::scene::ReceiverPoint;

/// Approximate number of entries in a region of neighbours.
const ENTRIES_OF_A_REGION: usize = 24;
/// Consecutive points of a set among which groups are formed. A slice of work does whole blocks.
pub const POINTS_OF_A_BLOCK: usize = 4096;

/// Divides points with their normals into regions of neighbours. Returns the region of each point.
pub fn regions_of(places: &[(DVec3, DVec3)]) -> Vec<u32> {
    let mut regions = vec![0; places.len()];
    let mut entries: Vec<u32> = (0..places.len() as u32).collect();
    for (count, part) in (0..).zip(divided(places, &mut entries, ENTRIES_OF_A_REGION)) {
        entries[part].iter().for_each(|entry| regions[*entry as usize] = count);
    }
    regions
}

/// Entries of points that are not inside solids, in groups of neighbours.
pub struct Groups {
    entries: Vec<u32>,
    parts: Vec<Range<usize>>,
    /// Number of groups before each block, and of all groups.
    before: Vec<usize>,
}

impl Groups {
    /// Divides a range of points, block by block, into groups of at most `most` points.
    pub fn of(points: &[ReceiverPoint], range: Range<usize>, most: usize) -> Groups {
        let mut groups = Groups { entries: Vec::with_capacity(range.len()), parts: Vec::new(), before: vec![0] };
        for first in range.clone().step_by(POINTS_OF_A_BLOCK) {
            let block = first..(first + POINTS_OF_A_BLOCK).min(range.end);
            let outside: Vec<usize> = block.filter(|entry| !points[*entry].inside).collect();
            let places: Vec<_> =
                outside.iter().map(|entry| (points[*entry].position_m, points[*entry].normal)).collect();
            let mut order: Vec<u32> = (0..places.len() as u32).collect();
            let before = groups.entries.len();
            let parts = divided(&places, &mut order, most);
            groups.parts.extend(parts.into_iter().map(|part| before + part.start..before + part.end));
            groups.entries.extend(order.into_iter().map(|place| outside[place as usize] as u32));
            groups.before.push(groups.parts.len());
        }
        groups
    }

    /// The groups, one after the other.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.parts.iter().map(|part| &self.entries[part.clone()])
    }

    /// The groups of some blocks of points, if all points were divided.
    pub fn within(&self, points: Range<usize>) -> Vec<&[u32]> {
        let [first, last] =
            [points.start / POINTS_OF_A_BLOCK, points.end.div_ceil(POINTS_OF_A_BLOCK)].map(|block| self.before[block]);
        self.parts[first..last].iter().map(|part| &self.entries[part.clone()]).collect()
    }
}

/// Halves points along the longest axis, and the halves again, until no part has more than `most`. Positions and normals are both axes.
/// Sorts `entries` by parts.
fn divided(places: &[(DVec3, DVec3)], entries: &mut [u32], most: usize) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    divide(places, entries, most, 0, &mut parts);
    parts
}

/// Parts of `count` points, halved until none has more than `most`. The groups of [`Groups`] are halved further in the same way.
pub fn halved(count: usize, most: usize) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    halve(0..count, most.max(1), &mut parts);
    parts
}

fn halve(part: Range<usize>, most: usize, parts: &mut Vec<Range<usize>>) {
    if part.len() <= most {
        return parts.push(part);
    }
    let middle = part.start + part.len() / 2;
    halve(part.start..middle, most, parts);
    halve(middle..part.end, most, parts);
}

fn divide(
    places: &[(DVec3, DVec3)],
    entries: &mut [u32],
    most_entries: usize,
    first: usize,
    parts: &mut Vec<Range<usize>>,
) {
    if entries.len() <= most_entries {
        if !entries.is_empty() {
            parts.push(first..first + entries.len());
        }
        return;
    }
    let (mut least, mut most) = ([f64::INFINITY; 6], [f64::NEG_INFINITY; 6]);
    let extent = entries.iter().map(|entry| places[*entry as usize].0);
    let size_m = extent.clone().fold(DVec3::NEG_INFINITY, DVec3::max) - extent.fold(DVec3::INFINITY, DVec3::min);
    let size_m = size_m.max_element();
    let coordinate = |entry: u32, axis: usize| {
        let (point_m, normal) = places[entry as usize];
        if axis < 3 { point_m[axis] } else { 2.0 * size_m * normal[axis - 3] }
    };
    for entry in entries.iter() {
        for axis in 0..6 {
            least[axis] = f64::min(least[axis], coordinate(*entry, axis));
            most[axis] = f64::max(most[axis], coordinate(*entry, axis));
        }
    }
    let longest = (0..6).max_by(|one, other| (most[*one] - least[*one]).total_cmp(&(most[*other] - least[*other])));
    let axis = longest.unwrap_or(0);
    let middle = entries.len() / 2;
    let by = |one: &u32, other: &u32| coordinate(*one, axis).total_cmp(&coordinate(*other, axis)).then(one.cmp(other));
    entries.select_nth_unstable_by(middle, by);
    let (one, other) = entries.split_at_mut(middle);
    divide(places, one, most_entries, first, parts);
    divide(places, other, most_entries, first + middle, parts);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 40 × 30 points in rows, of which every seventh is inside a solid. Every other point is in one group of at most 16. Groups
    /// are within 6 × 6 steps, and halving a group gives the groups of 8.
    #[test]
    fn groups_are_of_neighbours_and_hold_every_point_once() {
        let point = |index: usize| ReceiverPoint {
            position_m: DVec3::new((index % 40) as f64, (index / 40) as f64, 1.0),
            normal: DVec3::Z,
            weight: 1.0,
            inside: index.is_multiple_of(7),
        };
        let points: Vec<ReceiverPoint> = (0..1200).map(point).collect();
        let of = |most: usize| Groups::of(&points, 0..1200, most).iter().map(<[u32]>::to_vec).collect::<Vec<_>>();
        let groups = of(16);
        let mut entries: Vec<u32> = groups.concat();
        entries.sort_unstable();
        assert!(entries.iter().copied().eq((0..1200).filter(|entry| entry % 7 != 0)));
        for group in &groups {
            let along = |axis: usize| {
                let places = group.iter().map(|entry| points[*entry as usize].position_m[axis]);
                places.clone().fold(f64::MIN, f64::max) - places.fold(f64::MAX, f64::min)
            };
            assert!(group.len() <= 16 && along(0) < 6.0 && along(1) < 6.0, "{group:?}");
        }
        let sizes = groups.iter().flat_map(|group| halved(group.len(), 8)).map(|part| part.len());
        assert!(sizes.eq(of(8).iter().map(Vec::len)));
        assert_eq!(halved(12, 4), [0..3, 3..6, 6..9, 9..12]);
    }
}
