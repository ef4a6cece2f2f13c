//! Classes of receiver points with similar errors, formed from the mesh's own data. The error of a single point is that of its class.
//!
//! Where all mesh points of an open half ball agree, light is exact except for shadows that begin below the set. Such shadows are common at
//! the foot of a solid. Where the mesh points disagree, the error increases with the light on which they disagree.

use super::judge::MeanSquare;
use super::mesh::SetKind;
use super::tracing::EntryLight;
use crate::base::quadrature::GOLDEN;

/// Number of classes of points whose sets disagree, from the least disputed light to the most.
const LEVELS: usize = 4;
/// Number of kinds of sets.
const KINDS: usize = 3;
/// Number of classes over all kinds, including one per kind for sets that agree.
pub const CLASSES: usize = KINDS * (LEVELS + 1);
/// Least number of points of each class to check, if the class has this many.
pub const LEAST_CHECKED: usize = 128;
/// If none of n points shows a property, at most 3/n of all points have it, with 95% probability.
const RULE_OF_THREE: f64 = 3.0;
/// Share of a class's checked points that twice its error must contain: 95% of all, plus a margin for the random error of the sample.
const HELD: f64 = 0.97;

/// The classes of a map's points.
pub struct Classes {
    /// Quartiles of the disputed light of the points whose sets disagree, in the unit of the map.
    levels: [f64; LEVELS - 1],
}

impl Classes {
    /// Divides the points of a map into classes.
    pub fn of(lights: &[EntryLight]) -> Classes {
        let mut disputed: Vec<f64> = lights.iter().map(|light| light.disputed).filter(|light| *light > 0.0).collect();
        disputed.sort_by(f64::total_cmp);
        let level = |part: usize| disputed.get(part * disputed.len() / LEVELS).copied().unwrap_or(0.0);
        Classes { levels: [level(1), level(2), level(3)] }
    }

    /// Returns the class of a point.
    pub fn class(&self, light: &EntryLight) -> usize {
        let level = if light.disputed > 0.0 {
            1 + self.levels.iter().filter(|level| light.disputed >= **level).count()
        } else {
            0
        };
        kind(light.set) * (LEVELS + 1) + level
    }

    /// Returns entries of those classes with fewer than [`LEAST_CHECKED`] checked points. It returns the missing number, spread evenly over
    /// the class.
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
                // Multiples of the golden ratio are spread evenly, and not concentrated in a few columns of a grid.
                let place = |number: usize| ((number as f64 + 0.5) * GOLDEN).fract() * members.len() as f64;
                missing.extend((0..most - known).map(|number| members[place(number) as usize]));
            }
        }
        missing
    }
}

/// Returns the number of a kind of set.
pub fn kind(set: SetKind) -> usize {
    match set {
        SetKind::Open => 0,
        SetKind::Alone => 1,
        SetKind::Near => 2,
    }
}

/// Returns the mean squares of the products of each class, in the square of the map's unit.
///
/// A mean square is at least as large as its standard error, since chance could hide this much. If none of the n points of a class was off,
/// 0 would mean exact. So a share of 3/n of the other points may have the error of the whole map.
///
/// With `little_noise`, twice the error must contain most products. For example, one mesh point in eight says that a luminaire is hidden.
/// It is then really hidden in one case in eight, and the mean square is far too small.
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
