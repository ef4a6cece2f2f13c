//! Results of a run on an observer's glare.

use crate::base::glare::LEAST_RATING;
use crate::base::position_index::Outside;
use crate::maps::Estimate;

/// The rating of one observer.
#[derive(Clone, Debug)]
pub struct GlareRating {
    /// Index of the receiver among the scene's receiver sets.
    pub set: usize,
    /// Index of the observer in the set.
    pub observer: usize,
    /// UGR with its standard error; `None` if no luminaire in view has a position index or nothing lights the background.
    pub ugr: Option<Estimate>,
    /// Background luminance in cd/m²: the mean indirect illuminance at the set's points over π.
    pub background_cd_m2: Estimate,
    /// Σ L²ω/p² of the luminaires in view in cd²·sr/m⁴.
    pub glare_sum: Estimate,
    /// Contributions of luminaires to that sum, with their index in the scene; the greatest first, without those of 0.
    pub contributions: Vec<(usize, f64)>,
    /// Luminaires that shine into the eye and do not count, with the reason.
    pub outside: Vec<(usize, Outside)>,
}

impl GlareRating {
    /// Whether the rating is below 10, where the scale has no values.
    pub fn is_low(&self) -> bool {
        let is_lit = self.background_cd_m2.value > 0.0;
        self.ugr.map_or(is_lit && self.glare_sum.value <= 0.0, |ugr| ugr.value < LEAST_RATING)
    }
}

/// The worst rating of every set with the number of rated observers of the set, in the order of their maps.
pub fn worst_of_sets(ratings: &[GlareRating]) -> Vec<(&GlareRating, usize)> {
    let level = |rating: &GlareRating| rating.ugr.map_or(f64::NEG_INFINITY, |ugr| ugr.value);
    let of_one_set = ratings.chunk_by(|one, other| one.set == other.set);
    of_one_set
        .filter_map(|set| {
            // Of equal ratings, the first one.
            let worst = set.iter().rev().max_by(|one, other| level(one).total_cmp(&level(other)))?;
            Some((worst, set.len()))
        })
        .collect()
}
