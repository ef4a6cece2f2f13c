//! Kinds of places whose errors are alike, by what the mesh itself knows of them: the error of a single place is that of its kind.
//!
//! Where all points of an open half ball agree, light is exact but for shadows that begin below the set. At the foot of a solid such shadows are
//! common. Where the points disagree, the error grows with the light that they disagree about.

use super::judge::MeanSquare;
use super::mesh::SetKind;
use super::tracing::EntryLight;

/// Classes of places whose sets disagree, from the least disputed light to the most.
const LEVELS: usize = 4;
/// Kinds of sets.
const KINDS: usize = 3;
/// Classes of all kinds: one more for those that agree.
pub const CLASSES: usize = KINDS * (LEVELS + 1);
/// Places of each class that are checked at least, if it has so many.
pub const LEAST_CHECKED: usize = 128;
/// With nothing found in n places, what is looked for is in 3/n of all at most, with 95% probability.
const RULE_OF_THREE: f64 = 3.0;
/// Part of the checked places of a class that twice its error should hold: 95% of all, with what the sample's chance may hide.
const HELD: f64 = 0.97;

/// The classes of a map's places.
pub struct Classes {
    /// Disputed light of a quarter, a half and three quarters of the places whose sets disagree, in lx.
    levels_lx: [f64; LEVELS - 1],
}

impl Classes {
    /// Parts the places of a map.
    pub fn of(lights: &[EntryLight]) -> Classes {
        let mut disputed_lx: Vec<f64> = lights.iter().map(|light| light.disputed_lx).filter(|lx| *lx > 0.0).collect();
        disputed_lx.sort_by(f64::total_cmp);
        let level = |part: usize| disputed_lx.get(part * disputed_lx.len() / LEVELS).copied().unwrap_or(0.0);
        Classes { levels_lx: [level(1), level(2), level(3)] }
    }

    /// The class of a place.
    pub fn class(&self, light: &EntryLight) -> usize {
        let level = if light.disputed_lx > 0.0 {
            1 + self.levels_lx.iter().filter(|level_lx| light.disputed_lx >= **level_lx).count()
        } else {
            0
        };
        kind(light.set) * (LEVELS + 1) + level
    }

    /// Entries of classes of which fewer than [`LEAST_CHECKED`] are among those checked: every so manyth of the class, so
    /// many as are missing.
    pub fn missing(&self, lights: &[EntryLight], weights: &[f64], checked: &[usize]) -> Vec<usize> {
        let mut members: [Vec<usize>; CLASSES] = std::array::from_fn(|_| Vec::new());
        let counted = lights.iter().enumerate().filter(|(entry, light)| weights[*entry] > 0.0 && !light.is_known);
        counted.for_each(|(entry, light)| members[self.class(light)].push(entry));
        let mut known = [0; CLASSES];
        checked.iter().for_each(|entry| known[self.class(&lights[*entry])] += 1);
        let mut missing = Vec::new();
        for (members, known) in members.iter().zip(known) {
            let most = LEAST_CHECKED.min(members.len());
            if known < most {
                // The golden mean's multiples fall evenly, and into no few columns of a grid.
                let place = |number: usize| ((number as f64 + 0.5) * GOLDEN).fract() * members.len() as f64;
                missing.extend((0..most - known).map(|number| members[place(number) as usize]));
            }
        }
        missing
    }
}

/// 1/φ.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Number of a kind of set.
pub fn kind(set: SetKind) -> usize {
    match set {
        SetKind::Open => 0,
        SetKind::Alone => 1,
        SetKind::Near => 2,
    }
}

/// Mean squares of the products of each class, in lx²: what chance hides counts as large as chance could hide it, and where none of so many
/// places was off, a few of the rest may be by as much as the map as a whole: 0 would mean exact. Where the products have `little_noise`, twice
/// the error holds most of them: a luminaire that one point in eight says is hidden is so in one case in eight, and then the mean square is far too small.
pub fn squares_of<const N: usize>(products: &[(usize, f64)], whole: &MeanSquare, little_noise: bool) -> [f64; N] {
    std::array::from_fn(|class| {
        let mut of_class: Vec<f64> =
            products.iter().filter(|(of, _)| *of == class).map(|(_, product)| *product).collect();
        if of_class.is_empty() {
            return whole.mean.max(whole.standard_error);
        }
        let found = MeanSquare::of(&of_class);
        let hidden = (RULE_OF_THREE / of_class.len() as f64).min(1.0) * whole.mean.max(0.0);
        of_class.sort_by(|one, other| one.abs().total_cmp(&other.abs()));
        let held = of_class[(HELD * of_class.len() as f64) as usize].abs();
        let of_held = if little_noise { held / 4.0 } else { 0.0 };
        found.mean.max(found.standard_error).max(hidden).max(of_held)
    })
}
