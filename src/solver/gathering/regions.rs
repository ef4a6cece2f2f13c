//! Regions of neighbours, over which walks are pooled.

use glam::DVec3;

/// Entries of a region of neighbours, about.
const ENTRIES_OF_A_REGION: usize = 24;

/// Divides places with their normals into regions of neighbours.
pub fn regions_of(places: &[(DVec3, DVec3)]) -> Vec<u32> {
    let mut regions = vec![0; places.len()];
    let mut entries: Vec<u32> = (0..places.len() as u32).collect();
    let mut count = 0;
    divide(places, &mut entries, &mut |part| {
        part.iter().for_each(|entry| regions[*entry as usize] = count);
        count += 1;
    });
    regions
}

/// Halves a set of entries along its longest axis until the parts are small; places and normals count alike.
fn divide(places: &[(DVec3, DVec3)], entries: &mut [u32], found: &mut impl FnMut(&[u32])) {
    if entries.len() <= ENTRIES_OF_A_REGION {
        return found(entries);
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
    divide(places, one, found);
    divide(places, other, found);
}
