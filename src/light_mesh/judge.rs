//! Measures the error of the mesh: a random part of a map's points is computed again with shadow rays and walks of their own, which enter
//! no result.

use rayon::prelude::*;

use super::anew::{sample_direct, sample_indirect};
use super::entries::Entries;
use super::exact::light_samples_are_exact;
use super::mesh::Surroundings;
use super::options::Stop;
use super::tracing::EntryLight;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, SAMPLE_BITS, Stream};
use crate::transport::Traced;

/// Number of points at which indirect light is computed again during planning. Noise falls faster with more walks than with more points.
pub const INDIRECT_PLACES: usize = 128;
/// Number of points at which indirect light is computed again at the end. Only many points include the features that few points have.
pub const LAST_INDIRECT_PLACES: usize = 512;
/// Samples of each half for direct light with random error: normally, and after the run has been ended.
const DIRECT_SAMPLES: [u64; 2] = [32, 4];
/// Walks of each half over all points between two checks of the clock. At least one round is done.
const WALKS_OF_PIECE: u64 = 1 << 13;
/// Bit of a stream's index that separates the halves.
const HALF_BIT: u32 = 31;
/// Quantile of the normal distribution that one value in sixty exceeds. With three mesh maps, each checked against the target, in nineteen
/// runs of twenty none passes that misses it.
pub const ONE_IN_SIXTY: f64 = 2.128;

/// A mean of squares, in the squared unit of the map's values, with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanSquare {
    /// The mean. Random error can make it negative.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Skewness of the mean: the skewness of the averaged values divided by the root of their number.
    pub skewness: f64,
}

impl MeanSquare {
    /// Returns the mean of products.
    pub fn of(products: &[f64]) -> MeanSquare {
        if products.is_empty() {
            return MeanSquare::default();
        }
        let count = products.len() as f64;
        let mean = products.iter().sum::<f64>() / count;
        let squares: f64 = products.iter().map(|product| (product - mean).powi(2)).sum();
        let cubes: f64 = products.iter().map(|product| (product - mean).powi(3)).sum();
        let skewness = if squares > 0.0 { cubes / squares.powf(1.5) } else { 0.0 };
        MeanSquare { mean, standard_error: (squares / (count * (count - 1.0).max(1.0))).sqrt(), skewness }
    }

    /// Returns the root in the unit of the map's values; 0 where the mean is negative.
    pub fn root(&self) -> f64 {
        self.mean.max(0.0).sqrt()
    }

    /// Returns an upper bound of the root in the unit of the map's values, with the probability of a quantile of the normal distribution. A
    /// few products far above the others make most means too small, and their standard errors too. The skewness corrects for both.
    ///
    /// Source: Johnson (1978), "Modified t tests and confidence intervals for asymmetrical populations".
    pub fn upper_root(&self, quantile: f64) -> f64 {
        let with_skewness = quantile + self.skewness.max(0.0) * (1.0 + 2.0 * quantile * quantile) / 6.0;
        (self.mean + with_skewness * self.standard_error).max(0.0).sqrt()
    }
}

/// Difference between a map and light computed without a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredDifference {
    /// Direct part.
    pub direct: MeanSquare,
    /// Indirect part.
    pub indirect: MeanSquare,
    /// Rays used.
    pub rays: u64,
}

impl MeasuredDifference {
    /// Returns the sum of both parts, whose errors are independent.
    pub fn total(&self) -> MeanSquare {
        let standard_error = self.direct.standard_error.hypot(self.indirect.standard_error);
        let cubes = |part: &MeanSquare| part.skewness * part.standard_error.powi(3);
        MeanSquare {
            mean: self.direct.mean.max(0.0) + self.indirect.mean.max(0.0),
            standard_error,
            skewness: (cubes(&self.direct) + cubes(&self.indirect)) / standard_error.powi(3).max(f64::MIN_POSITIVE),
        }
    }
}

/// Chooses points of a map in proportion to their weights: a random one from every part of equal weight. A map with at most this many
/// points of equal weight is taken completely. Equal steps would fall into a few columns of a grid.
pub fn choose(entries: &Entries, most: usize, seed: u64, map: u32) -> Vec<usize> {
    let total: f64 = entries.weights.iter().sum();
    let counted = entries.weights.iter().filter(|weight| **weight > 0.0).count();
    if total <= 0.0 {
        return Vec::new();
    }
    let step = total / most.min(counted) as f64;
    let mut stream = Stream::new(seed, Purpose::LightMesh, map, 0);
    stream.seek(u64::MAX >> SAMPLE_BITS);
    let mut part = 0.0;
    let mut next = stream.fine_unit() * step;
    let mut chosen = Vec::new();
    let mut before = 0.0;
    for (entry, weight) in entries.weights.iter().enumerate() {
        before += weight;
        while next < before {
            chosen.push(entry);
            part += 1.0;
            next = (part + stream.fine_unit()) * step;
        }
    }
    chosen
}

/// Returns the samples of each half for direct light with random error: more where gloss is seen, few after the run has been ended.
pub fn samples_until(entries: &Entries, stop: Stop) -> u64 {
    let gloss = entries.lines_of_sight.as_ref().and_then(|lines| lines.gloss);
    if stop() {
        DIRECT_SAMPLES[1]
    } else {
        gloss.map_or(DIRECT_SAMPLES[0], |gloss| gloss.checks.max(DIRECT_SAMPLES[0]))
    }
}

/// Measures the error of direct light. For every chosen point it multiplies the deviations from two independent estimates. The mean of
/// these products is the squared deviation without the estimates' own noise. The products are returned too.
pub fn measure_direct(
    around: &Surroundings,
    entries: &Entries,
    chosen: &[(usize, EntryLight)],
    samples: u64,
    seed: u64,
    map: u32,
) -> (MeasuredDifference, Vec<f64>) {
    let exact = light_samples_are_exact(around.world) && !entries.are_means() && !entries.have_chance();
    let samples = if exact { 1 } else { samples };
    let judged: Vec<Traced> = chosen
        .par_iter()
        .map(|(entry, light)| {
            if (around.give_up)() {
                return Traced::default();
            }
            let mut stream = Stream::new(seed, Purpose::LightMesh, map, 1);
            let mut rays = 0;
            let mut half_of = |half: u64| {
                let mut sum = Traced::default();
                for sample in 0..samples {
                    let index = ((*entry as u64) << SAMPLE_BITS) | (half * samples + sample);
                    stream.seek_quasi(index, 2 * *entry as u64 + half, sample);
                    sum += sample_direct(around, entries, *entry, &mut stream);
                }
                rays += sum.rays;
                sum.value / samples as f64
            };
            let first = half_of(0);
            let second = if exact { first } else { half_of(1) };
            let direct = light.direct_mean();
            Traced { value: (direct - first) * (direct - second), rays }
        })
        .collect();
    let products: Vec<f64> = judged.iter().map(|product| product.value).collect();
    let rays = judged.iter().map(|product| product.rays).sum();
    (MeasuredDifference { direct: MeanSquare::of(&products), indirect: MeanSquare::default(), rays }, products)
}

/// Indirect light of chosen points from walks of their own, in two independent halves. A mesh is compared with it.
pub struct Checked {
    /// The chosen points.
    pub chosen: Vec<usize>,
    /// Walks in each half.
    pub walks: u64,
    /// Rays used.
    pub rays: u64,
    halves: Vec<[f64; 2]>,
    seed: u64,
    map: u32,
}

impl Checked {
    /// Creates a check of chosen points, without walks yet.
    pub fn of(chosen: Vec<usize>, seed: u64, map: u32) -> Checked {
        let halves = vec![[0.0; 2]; chosen.len()];
        Checked { chosen, walks: 0, rays: 0, halves, seed, map }
    }

    /// Adds `more` walks in each half. It stops early when the run is ended, but not before the first walks.
    pub fn add(&mut self, around: &Surroundings, entries: &Entries, more: u64, stop: Stop) {
        let all = self.walks + more;
        let of_piece = (WALKS_OF_PIECE / self.chosen.len().max(1) as u64).max(1);
        while self.walks < all && (self.walks == 0 || !stop()) {
            self.add_piece(around, entries, of_piece.min(all - self.walks));
        }
    }

    fn add_piece(&mut self, around: &Surroundings, entries: &Entries, more: u64) {
        let (done, all) = (self.walks, self.walks + more);
        let (seed, map) = (self.seed, self.map);
        let places = self.chosen.par_iter().zip(&mut self.halves);
        let rays = places.map(|(entry, halves)| {
            let mut stream = Stream::new(seed, Purpose::LightMesh, map, 2);
            let mut cut = Cut::default();
            let mut rays = 0;
            for (half, estimate) in (0u64..).zip(halves) {
                let mut sum = Traced { value: done as f64 * *estimate, rays: 0 };
                for walk in done..all {
                    if (around.give_up)() {
                        break;
                    }
                    let index = ((*entry as u64) << SAMPLE_BITS) | (half << HALF_BIT) | walk;
                    stream.seek_quasi(index, 2 * *entry as u64 + half, walk);
                    sum += sample_indirect(around, entries, *entry, &mut cut, &mut stream);
                }
                rays += sum.rays;
                *estimate = sum.value / all.max(1) as f64;
            }
            rays
        });
        self.rays += rays.sum::<u64>();
        self.walks = all;
    }

    /// Returns the mean light of the points in the unit of the map's values.
    pub fn mean(&self) -> f64 {
        let count = self.halves.len().max(1) as f64;
        self.halves.iter().map(|[first, second]| 0.5 * (first + second)).sum::<f64>() / count
    }

    /// Returns the variance of one walk from a point in the squared unit of the map's values, from the difference of the halves. It is the
    /// variance of the mean of all walks times their number, so it includes the gain from evenly spread walks.
    pub fn variance_of_walk(&self) -> f64 {
        let count = self.halves.len().max(1) as f64;
        let squares: f64 = self.halves.iter().map(|[first, second]| (first - second).powi(2)).sum();
        0.5 * squares / count * self.walks as f64
    }

    /// Returns the rays of a walk, or of the walks of one entry's points together.
    pub fn rays_per_walk(&self) -> f64 {
        self.rays as f64 / (2 * self.walks.max(1) * self.chosen.len().max(1) as u64) as f64
    }

    /// Returns the mean square error of a mesh's light.
    pub fn compare(&self, lights: impl Iterator<Item = EntryLight>) -> MeanSquare {
        MeanSquare::of(&self.products(lights))
    }

    /// Returns the products of this mean, point by point.
    pub fn products(&self, lights: impl Iterator<Item = EntryLight>) -> Vec<f64> {
        let product = |(light, [first, second]): (EntryLight, &[f64; 2])| {
            let indirect = light.indirect_mean();
            (indirect - first) * (indirect - second)
        };
        lights.zip(&self.halves).map(product).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::MapKind;

    fn grid(columns: usize, rows: usize) -> Entries {
        Entries {
            kind: MapKind::Receivers(0),
            weights: vec![1.0; columns * rows],
            area_m2: None,
            bounds_m: [glam::DVec3::ZERO; 2],
            normals: None,
            lines_of_sight: None,
        }
    }

    /// Points chosen in a grid lie in as many columns as random ones. 128 points in 200 columns leave 105 empty on average, with a standard
    /// deviation of 4.2 (seeds 1 to 20). Equal steps of 250, the planted fault, meet four columns. A map with exactly the requested number
    /// of points is taken completely.
    #[test]
    fn chosen_places_are_spread_over_columns() {
        let entries = grid(200, 160);
        for seed in 1..=20 {
            let chosen = choose(&entries, 128, seed, 0);
            assert_eq!(chosen.len(), 128);
            let columns: std::collections::BTreeSet<usize> = chosen.iter().map(|entry| entry % 200).collect();
            assert!((78..=112).contains(&columns.len()), "{} columns", columns.len());
        }
        let steps: std::collections::BTreeSet<usize> = (0..128).map(|number| (17 + 250 * number) % 200).collect();
        assert_eq!(steps.len(), 4);
        assert_eq!(choose(&grid(16, 8), 128, 1, 0), (0..128).collect::<Vec<usize>>());
    }

    /// 2,000 means of 512 squares, where one square in fifty is a hundred times the others. At least nine in ten upper bounds for one in
    /// sixty lie above the true mean of 2.98 (seed 5). Without the skewness, the planted fault, it is 85%.
    #[test]
    fn bounds_of_uneven_squares_hold() {
        let mut stream = Stream::new(5, Purpose::Pilot, 0, 0);
        let (mut held, mut held_without) = (0, 0);
        for trial in 0..2000 {
            stream.seek(trial);
            let squares: Vec<f64> = (0..512)
                .map(|_| {
                    let of_few = if stream.fine_unit() < 0.02 { 100.0 } else { 1.0 };
                    // The square of a normal variate, by Box and Muller.
                    let radius_squared = -2.0 * (1.0 - stream.fine_unit()).ln();
                    of_few * radius_squared * (std::f64::consts::TAU * stream.fine_unit()).cos().powi(2)
                })
                .collect();
            let mean = MeanSquare::of(&squares);
            held += u32::from(mean.upper_root(ONE_IN_SIXTY).powi(2) >= 2.98);
            held_without += u32::from(mean.mean + ONE_IN_SIXTY * mean.standard_error >= 2.98);
        }
        assert!(held >= 1770, "{held} of 2000 hold");
        assert!(held_without < 1770, "{held_without} of 2000 without the skewness");
    }
}
