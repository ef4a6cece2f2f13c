//! Emitters that stand close to surfaces, and which of them a packet comes from.

use glam::DVec3;

/// Share of packets that are drawn by flux alone, not by the distance of the emitter; and most emitters that are weighed by distance.
const BY_FLUX: f64 = 0.25;
const MOST_WEIGHED: usize = 32;

/// The emitters that stand close to surfaces.
#[derive(Clone, Debug)]
pub struct NearEmitters {
    /// Place of each emitter of the scene among the near ones.
    places: Vec<Option<u32>>,
    /// The near emitters, and their cumulative flux up to and including each, in lm.
    emitters: Vec<NearEmitter>,
    cumulative_flux_lm: Vec<f64>,
}

/// An emitter that stands close to surfaces.
#[derive(Clone, Copy, Debug)]
pub struct NearEmitter {
    /// Its number in the scene.
    pub number: u32,
    /// Its centre in m.
    pub center_m: DVec3,
    /// Its flux in lm.
    pub luminous_flux_lm: f64,
    /// Mean square of the distance in m² from its centre to the surfaces that its packets light.
    pub spots_m2: f64,
}

impl NearEmitter {
    /// What its spots bring to a point, approximately, up to a common factor: docs/methods.md (54).
    #[inline]
    fn weight_at(&self, from_m: DVec3) -> f64 {
        self.luminous_flux_lm / (from_m.distance_squared(self.center_m) + self.spots_m2)
    }
}

impl NearEmitters {
    /// At least one near emitter, among `all` emitters of a scene.
    pub fn new(emitters: Vec<NearEmitter>, all: usize) -> NearEmitters {
        let mut places = vec![None; all];
        emitters.iter().zip(0..).for_each(|(emitter, place)| places[emitter.number as usize] = Some(place));
        let cumulative_flux_lm = emitters.iter().scan(0.0, |sum_lm, emitter| {
            *sum_lm += emitter.luminous_flux_lm;
            Some(*sum_lm)
        });
        let cumulative_flux_lm = cumulative_flux_lm.collect();
        NearEmitters { places, emitters, cumulative_flux_lm }
    }

    /// Numbers of these emitters in the scene, in order.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        self.emitters.iter().map(|emitter| emitter.number)
    }

    /// Whether an emitter of the scene is one of them.
    #[inline]
    pub fn contains(&self, emitter: u32) -> bool {
        self.places[emitter as usize].is_some()
    }

    /// Flux of all of them in lm.
    fn luminous_flux_lm(&self) -> f64 {
        self.cumulative_flux_lm.last().copied().unwrap_or(0.0)
    }

    /// Probability that a packet drawn in proportion to flux comes from an emitter, over that emitter's flux in lm.
    #[inline]
    pub fn drawn_by_flux_per_lm(&self) -> f64 {
        1.0 / self.luminous_flux_lm()
    }

    /// Draws one for a point in m by a variate in [0, 1). Returns its number and the probability of the draw over its flux in lm.
    #[inline]
    pub fn draw(&self, from_m: DVec3, variate: f64) -> (u32, f64) {
        let weights = self.weights_at(from_m);
        if weights.is_none() {
            return self.draw_by_flux(variate);
        }
        let mut left = variate;
        let is_it = |emitter: &NearEmitter| {
            left -= self.probability(emitter, from_m, weights);
            left < 0.0
        };
        let place = self.emitters.iter().position(is_it).unwrap_or(self.emitters.len() - 1);
        let emitter = &self.emitters[place];
        (emitter.number, self.probability_per_lm(emitter, from_m, weights))
    }

    /// Draws one in proportion to its flux, and returns the same.
    #[inline]
    pub fn draw_by_flux(&self, variate: f64) -> (u32, f64) {
        let aim_lm = variate * self.luminous_flux_lm();
        let place = self.cumulative_flux_lm.partition_point(|sum_lm| *sum_lm <= aim_lm).min(self.emitters.len() - 1);
        let emitter = &self.emitters[place];
        (emitter.number, self.probability_per_lm(emitter, emitter.center_m, None))
    }

    /// Probability that a packet drawn for a point in m comes from an emitter, over the emitter's flux in lm. 0 if it is not near.
    #[inline]
    pub fn drawn_per_lm(&self, emitter: u32, from_m: DVec3) -> f64 {
        self.places[emitter as usize].map_or(0.0, |place| {
            self.probability_per_lm(&self.emitters[place as usize], from_m, self.weights_at(from_m))
        })
    }

    /// Sum of the emitters' weights at a point in m; `None` if they are drawn by flux alone: if there is only one, or so many that weighing
    /// them takes longer than it saves.
    #[inline]
    fn weights_at(&self, from_m: DVec3) -> Option<f64> {
        let sum = || self.emitters.iter().map(|emitter| emitter.weight_at(from_m)).sum();
        (2..=MOST_WEIGHED).contains(&self.emitters.len()).then(sum)
    }

    #[inline]
    fn probability_per_lm(&self, emitter: &NearEmitter, from_m: DVec3, weights: Option<f64>) -> f64 {
        self.probability(emitter, from_m, weights) / emitter.luminous_flux_lm
    }

    /// Probability of an emitter, given the sum of all weights.
    #[inline]
    fn probability(&self, emitter: &NearEmitter, from_m: DVec3, weights: Option<f64>) -> f64 {
        let by_flux = emitter.luminous_flux_lm / self.luminous_flux_lm();
        weights.map_or(by_flux, |sum| BY_FLUX * by_flux + (1.0 - BY_FLUX) * emitter.weight_at(from_m) / sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// Each of three emitters is drawn as often as its probability says, which is greatest for the nearest. 100,000 draws, seed 2: each
    /// share is within 4.5 σ (α = 7e-6 each), and shares of flux alone are rejected.
    #[test]
    fn emitters_are_drawn_with_their_probability() {
        let near = |(number, luminous_flux_lm): (u32, f64)| {
            let center_m = DVec3::new(0.5 + 2.0 * f64::from(number), 2.0, 2.9);
            NearEmitter { number, center_m, luminous_flux_lm, spots_m2: 0.1 }
        };
        let near = NearEmitters::new([(0, 2000.0), (1, 1000.0), (2, 1000.0)].map(near).to_vec(), 3);
        let from_m = DVec3::new(4.2, 2.0, 2.0);
        let mut stream = Stream::new(2, Purpose::Pilot, 0, 0);
        const DRAWN: usize = 100_000;
        let mut counts = [0.0; 3];
        let probabilities =
            [0, 1, 2].map(|number| near.drawn_per_lm(number, from_m) * near.emitters[number as usize].luminous_flux_lm);
        for _ in 0..DRAWN {
            let (number, per_lm) = near.draw(from_m, stream.fine_unit());
            assert_eq!(per_lm, near.drawn_per_lm(number, from_m));
            counts[number as usize] += 1.0 / DRAWN as f64;
        }
        assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(probabilities[2] > probabilities[0] && probabilities[0] > 0.5 * BY_FLUX);
        let off = |expected: [f64; 3]| {
            let sigma = |p: f64| (p * (1.0 - p) / DRAWN as f64).sqrt();
            counts.iter().zip(expected).map(|(share, p)| (share - p).abs() / sigma(p)).fold(0.0, f64::max)
        };
        assert!(off(probabilities) < 4.5, "{counts:?} {probabilities:?}");
        assert!(off([0.5, 0.25, 0.25]) > 4.5);
    }
}
