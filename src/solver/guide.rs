//! Directions that light comes from, as learned for gathering rays and residual walks.
//! Entries of a region of neighbours share a density of first directions. It is learned at every look from all samples so far, and is used
//! from then on. The expected value of a sample does not depend on the density, so the sums stay unbiased and replicas stay uncorrelated.

use serde::{Deserialize, Serialize};

use crate::sampling::guide::{BINS, Density};

/// Samples of a region per bin from which on a density is learned.
const SAMPLES_OF_A_BIN: f64 = 4.0;
/// Weight of the region's mean square, in samples, in the estimate of a bin: few samples of a bin are unreliable.
const SAMPLES_OF_THE_MEAN: f64 = 2.0;
/// A density is used if it reduces the variance to this share of the variance with even directions or less. Evenly spread points of a
/// sequence have less random error than these moments predict, and lose a part of that advantage.
const WORTHWHILE: f64 = 0.67;

/// Samples whose first ray went through a bin: their number, and the sums of their scores in lx and of the squares.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct BinTally {
    count: f64,
    sum: f64,
    squares: f64,
}

/// Densities of the first directions of a map's samples.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Guide {
    /// Region of every entry.
    regions: Vec<u32>,
    #[serde(with = "in_a_row")]
    tallies: Vec<[BinTally; BINS]>,
    densities: Vec<Option<Density>>,
}

/// Writes the tallies of all regions as one list, and reads them again.
mod in_a_row {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{BINS, BinTally};

    pub fn serialize<S: Serializer>(regions: &[[BinTally; BINS]], serializer: S) -> Result<S::Ok, S::Error> {
        regions.as_flattened().serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<[BinTally; BINS]>, D::Error> {
        let tallies = Vec::<BinTally>::deserialize(deserializer)?;
        Ok(tallies.as_chunks().0.to_vec())
    }
}

impl Guide {
    /// Creates a guide that has learned nothing, for entries in these regions of neighbours.
    pub fn new(regions: Vec<u32>) -> Guide {
        let count = regions.iter().max().map_or(0, |last| *last as usize + 1);
        Guide { regions, tallies: vec![[BinTally::default(); BINS]; count], densities: vec![None; count] }
    }

    /// The density of first directions from an entry; `None` if the directions are even.
    #[inline]
    pub fn density_at(&self, entry: usize) -> Option<&Density> {
        self.densities.get(*self.regions.get(entry)? as usize)?.as_ref()
    }

    /// Counts the light in lx that a sample from an entry brought through a bin, without the sample's weight.
    #[inline]
    fn add(&mut self, entry: usize, bin: usize, lx: f64) {
        let Some(region) = self.regions.get(entry) else {
            return;
        };
        let tally = &mut self.tallies[*region as usize][bin];
        tally.count += 1.0;
        tally.sum += lx;
        tally.squares += lx * lx;
    }

    /// Counts a sample that was drawn by the present densities, from its weighted light in lx.
    #[inline]
    pub fn add_weighted(&mut self, entry: usize, bin: usize, lx: f64) {
        let weight = self.density_at(entry).map_or(1.0, |density| density.weight(bin));
        self.add(entry, bin, lx / weight);
    }

    /// Learns the densities from what was counted.
    pub fn learn(&mut self) {
        for (density, bins) in self.densities.iter_mut().zip(&self.tallies) {
            *density = learned(bins);
        }
    }
}

/// The density of least variance for walks through these bins, if the reduction is large enough.
fn learned(bins: &[BinTally; BINS]) -> Option<Density> {
    let count: f64 = bins.iter().map(|bin| bin.count).sum();
    if count < SAMPLES_OF_A_BIN * BINS as f64 {
        return None;
    }
    let mean_of = |what: &dyn Fn(&BinTally) -> f64| {
        bins.iter().map(|bin| what(bin) / bin.count.max(1.0)).sum::<f64>() / BINS as f64
    };
    let (mean, square) = (mean_of(&|bin| bin.sum), mean_of(&|bin| bin.squares));
    let squares: [f64; BINS] = std::array::from_fn(|bin| {
        let BinTally { count, squares, .. } = bins[bin];
        (squares + SAMPLES_OF_THE_MEAN * square) / (count + SAMPLES_OF_THE_MEAN)
    });
    let density = Density::of(&squares.map(f64::sqrt))?;
    let even = squares.iter().sum::<f64>() / BINS as f64;
    let is_worthwhile = density.second_moment(&squares) - mean * mean < WORTHWHILE * (even - mean * mean);
    is_worthwhile.then_some(density)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::guide::bin_of;
    use crate::sampling::random::{Purpose, Stream};

    /// A small bright source in front of a dim background: a tenth of a bin brings more than all the rest.
    fn arriving_lx([u, v]: [f64; 2]) -> f64 {
        if (0.50..0.54).contains(&u) && (0.25..0.29).contains(&v) { 1000.0 } else { 1.0 }
    }
    const MEAN_LX: f64 = 1.0 + 999.0 * 0.04 * 0.04;

    #[test]
    fn guided_walks_keep_the_mean_and_lose_most_of_the_variance() {
        // One region of 8 points, 1,024 walks of each to learn from and 32,768 more, seed 5. The mean is within 4.5 standard errors (α =
        // 7e-6), with at most a quarter of the even variance. Planted fault: without the weights it is not.
        let mut guide = Guide::new(vec![0; 8]);
        let mut stream = Stream::new(5, Purpose::Walks, 0, 0);
        assert!(guide.density_at(3).is_none());
        for walk in 0..8192 {
            let at = stream.pair();
            guide.add(walk % 8, bin_of(at), arriving_lx(at));
        }
        guide.learn();
        let density = guide.density_at(3).expect("it has learned");
        let scores: Vec<[f64; 2]> = (0..32_768)
            .map(|_| {
                let (at, weight) = density.warp(stream.pair());
                [weight * arriving_lx(at), arriving_lx(at)]
            })
            .collect();
        let moments = |which: usize| {
            let mean = scores.iter().map(|score| score[which]).sum::<f64>() / scores.len() as f64;
            let square = scores.iter().map(|score| score[which].powi(2)).sum::<f64>() / scores.len() as f64;
            (mean, square - mean * mean)
        };
        let (mean, variance) = moments(0);
        let error = (variance / scores.len() as f64).sqrt();
        assert!((mean - MEAN_LX).abs() < 4.5 * error, "{mean} ± {error}");
        let even = 1e6 * 0.04 * 0.04 - MEAN_LX * MEAN_LX;
        assert!(variance < 0.25 * even, "{variance} {even}");
        assert!((moments(1).0 - MEAN_LX).abs() > 4.5 * error, "the fault passed");
    }

    #[test]
    fn even_light_is_left_to_even_directions() {
        let mut guide = Guide::new(vec![0]);
        let mut stream = Stream::new(6, Purpose::Walks, 0, 0);
        for _ in 0..4096 {
            let at = stream.pair();
            guide.add(0, bin_of(at), 10.0 + 4.0 * stream.unit());
        }
        guide.learn();
        assert!(guide.density_at(0).is_none());
    }
}
