//! What the mesh changes, measured: a random part of a map's places is computed again with shadow rays and walks of its
//! own, which enter no result.

use rayon::prelude::*;

use super::anew::{sample_direct, sample_indirect};
use super::entries::Entries;
use super::exact::looks_are_exact;
use super::mesh::Surroundings;
use super::options::Stop;
use super::tracing::EntryLight;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};

/// Places at which indirect light is computed again while a plan is made; noise shrinks faster with walks than with places.
pub const INDIRECT_PLACES: usize = 128;
/// Places at which it is computed again at the end: what a few places have that others have not is met only by many.
pub const LAST_INDIRECT_PLACES: usize = 512;
/// Looks of each half at direct light that has chance in it, and those after the run has been ended.
const LOOKS: [u64; 2] = [32, 4];
/// Walks of each half over all places between two looks at the clock, and the least number of them.
const WALKS_OF_PIECE: u64 = 1 << 13;
/// Bits of a stream's index that count samples.
const SAMPLE_BITS: u32 = 32;
/// Bit of a stream's index that tells the halves apart.
const HALF_BIT: u32 = 31;
/// Quantile of the normal distribution of which one in twenty is above.
pub const ONE_IN_TWENTY: f64 = 1.645;
/// The quantile of which one in sixty is above: of three maps with a mesh, each checked for the target, none that misses it
/// passes in nineteen runs of twenty.
pub const ONE_IN_SIXTY: f64 = 2.128;

/// A mean of squares, in lx², with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanSquare {
    /// The mean; chance can leave it below 0.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Skewness of the mean: that of what it is a mean of over the root of their number.
    pub skewness: f64,
}

impl MeanSquare {
    /// The mean of products.
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

    /// Root in lx, 0 where chance left nothing.
    pub fn root_lx(&self) -> f64 {
        self.mean.max(0.0).sqrt()
    }

    /// What the root stays below, in lx, but for the chance that a quantile of the normal distribution leaves. A few products far
    /// above the others make a mean that is mostly too small, and then its standard error too: the skewness makes up for both.
    ///
    /// Source: Johnson (1978), "Modified t tests and confidence intervals for asymmetrical populations".
    pub fn upper_root_lx(&self, quantile: f64) -> f64 {
        let with_skewness = quantile + self.skewness.max(0.0) * (1.0 + 2.0 * quantile * quantile) / 6.0;
        (self.mean + with_skewness * self.standard_error).max(0.0).sqrt()
    }
}

/// What a map differs by from light computed without a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredDifference {
    /// Direct part.
    pub direct: MeanSquare,
    /// Indirect part.
    pub indirect: MeanSquare,
    /// Rays that it took.
    pub rays: u64,
}

impl MeasuredDifference {
    /// Both parts: their errors have nothing to do with each other.
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

/// Chooses places of a map in proportion to their weights: a random one of every part of equal weight, so that a map of fewer
/// places of equal weight is taken whole. Equal steps would fall into a few columns of a grid.
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

/// Looks of each half at direct light that has chance in it: more where gloss is seen, few after the run has been ended.
pub fn looks_until(entries: &Entries, stop: Stop) -> u64 {
    let gloss = entries.sights.as_ref().and_then(|sights| sights.gloss);
    if stop() { LOOKS[1] } else { gloss.map_or(LOOKS[0], |gloss| gloss.checks.max(LOOKS[0])) }
}

/// Measures direct light: for every chosen place the product of its deviations from two independent estimates, whose
/// mean is the square of the deviation without the estimates' own noise. The products are returned too.
pub fn measure_direct(
    around: &Surroundings,
    entries: &Entries,
    chosen: &[(usize, EntryLight)],
    looks: u64,
    seed: u64,
    map: u32,
) -> (MeasuredDifference, Vec<f64>) {
    let exact = looks_are_exact(around.stage) && !entries.are_means() && !entries.have_chance();
    let looks = if exact { 1 } else { looks };
    let judged: Vec<(f64, u64)> = chosen
        .par_iter()
        .map(|(entry, light)| {
            if (around.give_up)() {
                return (0.0, 0);
            }
            let mut stream = Stream::new(seed, Purpose::LightMesh, map, 1);
            let mut rays = 0;
            let mut half_lx = |half: u64| {
                let mut sum_lx = 0.0;
                for look in 0..looks {
                    let index = ((*entry as u64) << SAMPLE_BITS) | (half * looks + look);
                    stream.seek_quasi(index, 2 * *entry as u64 + half, look);
                    let (lx, look_rays) = sample_direct(around, entries, *entry, &mut stream);
                    sum_lx += lx;
                    rays += look_rays;
                }
                sum_lx / looks as f64
            };
            let first_lx = half_lx(0);
            let second_lx = if exact { first_lx } else { half_lx(1) };
            let direct_lx = light.direct_mean_lx();
            ((direct_lx - first_lx) * (direct_lx - second_lx), rays)
        })
        .collect();
    let products: Vec<f64> = judged.iter().map(|(product, _)| *product).collect();
    let rays = judged.iter().map(|(_, rays)| rays).sum();
    (MeasuredDifference { direct: MeanSquare::of(&products), indirect: MeanSquare::default(), rays }, products)
}

/// Indirect light of chosen places by walks of their own, in two independent halves: what a mesh is compared with.
pub struct Checked {
    /// The places.
    pub chosen: Vec<usize>,
    /// Walks of each half.
    pub walks: u64,
    /// Rays that they took.
    pub rays: u64,
    halves_lx: Vec<[f64; 2]>,
    seed: u64,
    map: u32,
}

impl Checked {
    /// Chosen places, without walks yet.
    pub fn of(chosen: Vec<usize>, seed: u64, map: u32) -> Checked {
        let halves_lx = vec![[0.0; 2]; chosen.len()];
        Checked { chosen, walks: 0, rays: 0, halves_lx, seed, map }
    }

    /// So many more walks in each half, or as many as there are when the run is ended.
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
        let places = self.chosen.par_iter().zip(&mut self.halves_lx);
        let rays = places.map(|(entry, halves_lx)| {
            let mut stream = Stream::new(seed, Purpose::LightMesh, map, 2);
            let mut cut = Cut::default();
            let mut rays = 0;
            for (half, half_lx) in (0u64..).zip(halves_lx) {
                let mut sum_lx = done as f64 * *half_lx;
                for walk in done..all {
                    if (around.give_up)() {
                        break;
                    }
                    let index = ((*entry as u64) << SAMPLE_BITS) | (half << HALF_BIT) | walk;
                    stream.seek_quasi(index, 2 * *entry as u64 + half, walk);
                    let (lx, walk_rays) = sample_indirect(around, entries, *entry, &mut cut, &mut stream);
                    sum_lx += lx;
                    rays += walk_rays;
                }
                *half_lx = sum_lx / all.max(1) as f64;
            }
            rays
        });
        self.rays += rays.sum::<u64>();
        self.walks = all;
    }

    /// Mean of the places' light in lx.
    pub fn mean_lx(&self) -> f64 {
        let count = self.halves_lx.len().max(1) as f64;
        self.halves_lx.iter().map(|[first, second]| 0.5 * (first + second)).sum::<f64>() / count
    }

    /// Variance of one walk from a place in lx², as far as the halves' difference tells. It is that of the mean of all
    /// walks times their number: what evenly spread walks save is in it.
    pub fn variance_of_walk(&self) -> f64 {
        let count = self.halves_lx.len().max(1) as f64;
        let squares: f64 = self.halves_lx.iter().map(|[first, second]| (first - second).powi(2)).sum();
        0.5 * squares / count * self.walks as f64
    }

    /// Rays of a walk, or of those of one entry's places together.
    pub fn rays_per_walk(&self) -> f64 {
        self.rays as f64 / (2 * self.walks.max(1) * self.chosen.len().max(1) as u64) as f64
    }

    /// Mean square of what a mesh's light is off by.
    pub fn compare(&self, lights: impl Iterator<Item = EntryLight>) -> MeanSquare {
        MeanSquare::of(&self.products(lights))
    }

    /// What that is the mean of, place by place.
    pub fn products(&self, lights: impl Iterator<Item = EntryLight>) -> Vec<f64> {
        let product = |(light, [first_lx, second_lx]): (EntryLight, &[f64; 2])| {
            let indirect_lx = light.indirect_mean_lx();
            (indirect_lx - first_lx) * (indirect_lx - second_lx)
        };
        lights.zip(&self.halves_lx).map(product).collect()
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
            sights: None,
        }
    }

    /// Places chosen in a grid lie in as many columns as chance puts them in: 128 in 200 columns leave 105 empty, on average,
    /// with a standard deviation of 4.2 (seeds 1 to 20). Equal steps of 250, the planted fault, meet four columns. A map of as
    /// many places as are asked for is taken whole.
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

    /// Of 2,000 means of 512 squares, one in fifty of which is a hundred times the others, at least nine in ten lie above
    /// the true mean of 2.98 with their bound for one in sixty (seed 5). Without the skewness, the planted fault, it is 85%.
    #[test]
    fn bounds_of_uneven_squares_hold() {
        let mut stream = Stream::new(5, Purpose::Pilot, 0, 0);
        let (mut held, mut held_without) = (0, 0);
        for trial in 0..2000 {
            stream.seek(trial);
            let squares: Vec<f64> = (0..512)
                .map(|_| {
                    let of_few = if stream.fine_unit() < 0.02 { 100.0 } else { 1.0 };
                    // The square of a normal number, by Box and Muller.
                    let radius_squared = -2.0 * (1.0 - stream.fine_unit()).ln();
                    of_few * radius_squared * (std::f64::consts::TAU * stream.fine_unit()).cos().powi(2)
                })
                .collect();
            let mean = MeanSquare::of(&squares);
            held += u32::from(mean.upper_root_lx(ONE_IN_SIXTY).powi(2) >= 2.98);
            held_without += u32::from(mean.mean + ONE_IN_SIXTY * mean.standard_error >= 2.98);
        }
        assert!(held >= 1770, "{held} of 2000 hold");
        assert!(held_without < 1770, "{held_without} of 2000 without the skewness");
    }
}
