//! Decisions of walks that are left to chance, because doing them in every walk costs more rays than it is worth.

use crate::sampling::random::Stream;

/// Weight below which walks end by chance if nothing is known of a scene.
const USUAL_SAFE_WEIGHT: f64 = 0.4;

/// Decisions of walks that are left to chance: where walks end, and how often they make a light-path connection to nearby luminaires
/// (docs/methods.md (48), (49)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// A walk whose next weight is at least this always continues. A lighter walk continues by chance, and a survivor has this weight.
    pub safe_weight: f64,
    /// Probability in (0, 1] of a light-path connection at each vertex.
    pub connection_chance: f64,
    /// Ratio of the surfaces that a walk meets to those that it would meet if each surface ended it by its absorptance.
    pub longer: f64,
    /// Rays spent on finding these values.
    pub pilot_rays: u64,
}

impl Roulette {
    /// Weight with which a walk continues after roulette; `weight` is what every walk would have without it. `None` if the walk ends.
    #[inline]
    pub fn survivor_weight(&self, weight: f64, stream: &mut Stream) -> Option<f64> {
        if weight >= self.safe_weight {
            return Some(weight);
        }
        stream.happens(weight / self.safe_weight).then_some(self.safe_weight)
    }
}

impl Default for Roulette {
    fn default() -> Roulette {
        Roulette { safe_weight: USUAL_SAFE_WEIGHT, connection_chance: 1.0, longer: 1.0, pilot_rays: 0 }
    }
}
