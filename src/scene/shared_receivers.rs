//! Receiver sets in a run that computes one part of them: the points in that part, and a scene without the others.

use super::receivers_part::ReceiversPart;
use super::{Quantity, ReceiverLayout, ReceiverSet, Scene};

impl ReceiversPart {
    /// Number of points of a set that are in this part. `index` is the set's index in its scene.
    pub fn points_of(self, set: &ReceiverSet, index: usize) -> usize {
        match is_shared_out(set) {
            true => self.count_of(set.points.len()),
            false if index % self.of as usize == self.first() => set.points.len(),
            false => 0,
        }
    }
}

impl ReceiverSet {
    /// Index of a point in the complete set of the scene file.
    pub fn index_of(&self, point: usize) -> usize {
        match self.layout {
            ReceiverLayout::Part(part) => part.nth(point),
            _ => point,
        }
    }
}

impl Scene {
    /// Keeps only the points of one part. Sets that go to one part as a whole do not change.
    ///
    /// The requirements of a shared set are removed: they are checked once all its points are together.
    pub fn keep_part(&mut self, part: ReceiversPart) {
        for set in self.receivers.iter_mut().filter(|set| is_shared_out(set)) {
            set.points = set.points.iter().skip(part.first()).step_by(part.of as usize).copied().collect();
            set.layout = ReceiverLayout::Part(part);
            set.requirements.clear();
        }
    }
}

/// Whether the points of a set can be computed independently.
fn is_shared_out(set: &ReceiverSet) -> bool {
    set.quantity.is_illuminance() || set.quantity == Quantity::Luminance
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene_from_json;

    const TEXT: &str = r#"{"version": 1, "materials": {"paint": {"type": "diffuse", "reflectance": 0.5}},
        "geometry": [{"name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "paint"}],
        "luminaires": [{"name": "lamp", "type": "point", "position": [2,2,1], "luminous_flux_lm": 1000}],
        "receivers": [{"name": "floor", "type": "grid", "origin": [1,1,0], "u": [2,0,0], "v": [0,1,0], "columns": 5, "rows": 2},
            {"name": "desk", "type": "ugr", "position": [1, 1, 1.2], "view_direction": [1, 0, 0]},
            {"name": "view", "type": "luminance", "position": [1, 1, 1.2], "directions": [[1, 0, 0], [0, 1, 0]]}]}"#;

    #[test]
    fn parts_have_every_point_once() {
        let whole = scene_from_json(TEXT, None, Path::new(".")).expect("a scene");
        for of in [1, 2, 3, 4, 7] {
            let mut seen: Vec<Vec<u32>> = whole.receivers.iter().map(|set| vec![0; set.points.len()]).collect();
            for number in 1..=of {
                let part = ReceiversPart { number, of };
                let mut scene = whole.clone();
                scene.keep_part(part);
                for (index, (set, all)) in scene.receivers.iter().zip(&whole.receivers).enumerate() {
                    let count = part.points_of(all, index);
                    assert!(count == set.points.len() || all.name == "desk");
                    for local in 0..count {
                        let place = set.index_of(local);
                        seen[index][place] += 1;
                        assert_eq!(set.points[local].position_m, all.points[place].position_m);
                        assert_eq!(set.points[local].normal, all.points[place].normal);
                    }
                }
            }
            assert!(seen.iter().flatten().all(|count| *count == 1), "{of} parts: {seen:?}");
        }
    }
}
