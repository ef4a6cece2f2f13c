//! Streams of random numbers. Their keys depend on their purpose, never on the thread that draws them.

use std::convert::Infallible;

use rand::{RngExt, TryRng};
use rand_philox::{Philox, splitmix64};

use super::sobol::QuasiPoint;
pub use super::sobol::Square;

/// The purpose of a stream of random numbers. No two purposes share a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Forward chains of packets from the luminaires.
    Chains,
    /// Direct light, sampled.
    Direct,
    /// Walks from the receivers back towards the luminaires.
    Walks,
    /// Pilot runs and surveys. Their numbers never enter a result's sum.
    Pilot,
    /// Points of light meshes, and their checks.
    LightMesh = 5,
    /// Samples of cells.
    Cells,
    /// Gathering rays.
    CellRays,
    /// Walks that measure the error of cells.
    Residuals,
    /// Rays that fill cells.
    CellFills,
    /// No stream of its own: the seeds of the shares of a run.
    Shares,
    /// The seeds of runs that divide the receivers among them.
    ReceiversParts,
    /// Walks that gather daylight coefficients.
    DaylightWalks,
    /// Points from which the suns of a year are searched, and points of the suns' disks.
    SunPlaces,
    /// Gathering rays, and direct light, after they were shared out among the entries.
    AllottedRays,
    AllottedDirect,
}

/// Returns the seed of the streams of one share of a run. It differs for every share and does not depend on the number of shares.
pub fn seed_of_share(seed: u64, number: u32) -> u64 {
    key_of(seed, Purpose::Shares, number)
}

/// Returns the seed of the streams of a run that computes one part of the receivers.
pub fn seed_of_receivers_part(seed: u64, number: u32) -> u64 {
    key_of(seed, Purpose::ReceiversParts, number)
}

/// Two rounds of the mixer keep neighbouring seeds and purposes apart.
fn key_of(seed: u64, purpose: Purpose, map: u32) -> u64 {
    let purpose_and_map = ((purpose as u64) << 32) | u64::from(map);
    splitmix64(splitmix64(seed.wrapping_add(0x9E37_79B9_7F4A_7C15)) ^ splitmix64(!purpose_and_map))
}

/// One stream: Philox 4×32-10 keyed by (seed, purpose, map). Its counter is split into replica, index and draw.
///
/// Streams of different (seed, purpose, map, replica, index) never overlap. One index has 2³⁴ numbers, and there are 2⁶⁴ indices.
#[derive(Clone, Debug)]
pub struct Stream {
    philox: Philox,
    replica: u32,
    /// Scrambles quasi-random points. Every seed, purpose, map and replica has a different key.
    quasi_key: u64,
    quasi: Option<QuasiPoint>,
    lot: Lot,
}

/// A position among the coordinates of a quasi-random point.
#[derive(Clone, Copy, Debug)]
pub struct Mark(Option<QuasiPoint>);

/// One variate for many decisions. After each decision the remaining interval is stretched to [0, 1).
#[derive(Clone, Copy, Debug)]
struct Lot {
    value: f64,
    /// Length of the remaining interval. Below [`LEAST_LOT`] a new variate is drawn.
    length: f64,
}

/// Bits of a stream's index that count samples. The bits above them give the point or the element.
pub const SAMPLE_BITS: u32 = 32;

/// A variate of 53 bits still has 24 bits after the 29 halvings that this limit allows.
const LEAST_LOT: f64 = 1.0 / 536_870_912.0;

/// 2⁻³², the spacing of a 32-bit variate.
const SPACING_32: f64 = 1.0 / 4_294_967_296.0;
/// 2⁻⁵³, the spacing of a 53-bit variate.
const SPACING_53: f64 = 1.0 / 9_007_199_254_740_992.0;

impl Stream {
    /// Makes the streams of one purpose in one map and replica. Choose an index by [`Stream::seek`] before drawing.
    pub fn new(seed: u64, purpose: Purpose, map: u32, replica: u32) -> Stream {
        let key = key_of(seed, purpose, map);
        let quasi_key = splitmix64(key ^ splitmix64(u64::from(replica)));
        let philox = Philox::new([key as u32, (key >> 32) as u32], u128::from(replica) << 96);
        Stream { philox, replica, quasi_key, quasi: None, lot: Lot { value: 0.0, length: 0.0 } }
    }

    /// Goes to the start of the numbers that belong to an index (a chain, a walk, a sample).
    #[inline]
    pub fn seek(&mut self, index: u64) {
        self.quasi = None;
        self.philox.seek((u128::from(self.replica) << 96) | (u128::from(index) << 32));
    }

    /// Goes to an index as [`Stream::seek`] does, but the first numbers are the coordinates of a scrambled Sobol point. It is the point
    /// `number` of the sequence that belongs to `sequence`. Every sequence has its own scramble, independent of all others.
    #[inline]
    pub fn seek_quasi(&mut self, index: u64, sequence: u64, number: u64) {
        self.seek(index);
        self.lot.length = 0.0;
        let key = splitmix64(self.quasi_key ^ splitmix64(sequence));
        self.quasi = Some(QuasiPoint::new(key, number));
    }

    /// Returns the stream's position among the coordinates of its quasi-random point.
    #[inline]
    pub fn mark(&self) -> Mark {
        Mark(self.quasi)
    }

    /// Goes to an index as [`Stream::seek`] does, and back to the mark in a branch of its point.
    #[inline]
    pub fn branch(&mut self, mark: &Mark, index: u64, branch: u32) {
        self.seek(index);
        self.lot.length = 0.0;
        self.quasi = mark.0.map(|point| point.branch(branch));
    }

    /// Moves a quasi-random stream to the same point of another sequence, so that the next decisions use the first, best distributed
    /// dimensions again. Other streams do not change.
    #[inline]
    pub fn turn_to(&mut self, sequence: u64) {
        if let Some(point) = &mut self.quasi {
            *point = point.of_sequence(sequence);
        }
    }

    /// Moves to the same point of another sequence, with its next two numbers confined to a square. A stream that is not quasi-random goes
    /// to a random point.
    #[inline]
    pub fn turn_to_square(&mut self, sequence: u64, square: Square) {
        let point = match self.quasi {
            Some(point) => point.of_sequence(sequence),
            None => QuasiPoint::new(self.philox.next_u64(), 0),
        };
        self.quasi = Some(point.confined(square));
    }

    /// Returns the next two numbers of a quasi-random stream without drawing them; ½ for each where none are left.
    #[inline]
    pub fn next_pair(&self) -> [f64; 2] {
        let mut point = self.quasi;
        std::array::from_fn(|_| {
            let next = point.as_mut().and_then(QuasiPoint::next_coordinate);
            next.map_or(0.5, |next| f64::from(next) * SPACING_32)
        })
    }

    /// A variate in [0, 1) with 32 bits.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        f64::from(self.random::<u32>()) * SPACING_32
    }

    /// A variate in [0, 1) with 53 bits, for choices among many.
    #[inline]
    pub fn fine_unit(&mut self) -> f64 {
        self.random()
    }

    /// Draws whether something of this probability happens.
    ///
    /// A quasi-random stream uses one variate for all decisions of this kind. The survival of a chain at its first, second and third
    /// reflection is then distributed over the chains as evenly as a single variate. Light samples must not use it: a stream keeps this variate
    /// from one light sample to the next ([`Stream::unit`] serves there).
    #[inline]
    pub fn happens(&mut self, probability: f64) -> bool {
        if self.quasi.is_none() {
            return self.unit() < probability;
        }
        if self.lot.length < LEAST_LOT {
            self.lot = Lot { value: self.fine_unit(), length: 1.0 };
        }
        let happens = self.lot.value < probability;
        let (start, share) = if happens { (0.0, probability) } else { (probability, 1.0 - probability) };
        // Division can round up to 1, so the value is kept below 1.
        self.lot.value = ((self.lot.value - start) / share).min(1.0 - SPACING_53);
        self.lot.length *= share;
        happens
    }

    /// Two variates in [0, 1).
    #[inline]
    pub fn pair(&mut self) -> [f64; 2] {
        [self.unit(), self.unit()]
    }
}

/// Makes a stream a generator of the crate rand, so that rand's distributions can draw from it. A quasi-random stream first returns the
/// coordinates of its point, each as the upper 32 bits of the requested number.
impl TryRng for Stream {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.quasi.as_mut().and_then(QuasiPoint::next_coordinate).unwrap_or_else(|| self.philox.next_u32()))
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(match self.quasi.as_mut().and_then(QuasiPoint::next_coordinate) {
            Some(high) => (u64::from(high) << 32) | (self.philox.next_u64() >> 32),
            None => self.philox.next_u64(),
        })
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(4) {
            let word = self.try_next_u32()?.to_le_bytes();
            chunk.copy_from_slice(&word[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square::chi_square_p;

    #[test]
    fn the_same_key_gives_the_same_numbers_and_any_other_key_others() {
        let draw = |seed, purpose, map, replica, index| {
            let mut stream = Stream::new(seed, purpose, map, replica);
            stream.seek(index);
            stream.unit()
        };
        let first = draw(0, Purpose::Chains, 0, 0, 0);
        assert_eq!(first, draw(0, Purpose::Chains, 0, 0, 0));
        let others = [
            draw(1, Purpose::Chains, 0, 0, 0),
            draw(0, Purpose::Walks, 0, 0, 0),
            draw(0, Purpose::Chains, 1, 0, 0),
            draw(0, Purpose::Chains, 0, 1, 0),
            draw(0, Purpose::Chains, 0, 0, 1),
            draw(0, Purpose::Chains, 0, 0, 1 << 32),
        ];
        for (i, other) in others.iter().enumerate() {
            assert_ne!(first, *other);
            assert!(others[..i].iter().all(|earlier| earlier != other));
        }
    }

    #[test]
    fn variates_are_uniform_past_the_two_to_the_32nd_index() {
        // χ² over 64 bins, N = 64,000, α = 1e-4, and again for counts that are too even.
        let mut stream = Stream::new(7, Purpose::Chains, 0, 3);
        let mut counts = [0.0; 64];
        for index in 0..64_000u64 {
            stream.seek((1 << 33) + index);
            counts[(stream.unit() * 64.0) as usize] += 1.0;
        }
        let p = chi_square_p(&counts, &[1000.0; 64]);
        assert!((1e-4..1.0 - 1e-4).contains(&p), "{p}");
    }
}
