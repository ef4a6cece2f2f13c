//! What walks leave to chance, since it would cost more rays than it is worth in every one of them.

use crate::sampling::random::Stream;

/// Weight below which walks end by chance where nothing is known of a scene.
const USUAL_SAFE_WEIGHT: f64 = 0.4;

/// What walks leave to chance: where they end, and how often they look back from what near luminaires light (docs/methods.md (48), (49)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// A walk that goes on with at least this weight does so in any case; with less, by chance, and a survivor has this weight.
    pub safe_weight: f64,
    /// Chance in (0, 1] of looking back at each vertex.
    pub look_back_chance: f64,
    /// Surfaces that a walk meets over those that it would meet if each ended it by its absorptance.
    pub longer: f64,
    /// Rays that it took to find these out.
    pub pilot_rays: u64,
}

impl Roulette {
    /// The weight that a walk goes on with which would have this one in every walk; `None` where it ends.
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
        Roulette { safe_weight: USUAL_SAFE_WEIGHT, look_back_chance: 1.0, longer: 1.0, pilot_rays: 0 }
    }
}
