//! Numbers of random streams: which entry, sample, round and chain uses which stream.

use crate::maps::MapKind;
use crate::sampling::random::{SAMPLE_BITS, Stream};

/// Number of the element map's streams after `rounds` rounds of cuts. A map that starts anew uses new random numbers.
pub fn stream_number(rounds: u32) -> u32 {
    if rounds == 0 { MapKind::Elements.number() } else { u32::MAX - rounds }
}

pub fn stream_index(entry: usize, sample: u64) -> u64 {
    ((entry as u64) << SAMPLE_BITS) | sample
}

/// Index of the stream that shifts a replica's choices of emitters: the last index, which no chain reaches.
const SHIFT_INDEX: u64 = u64::MAX >> 32;

/// The random shift of a replica's emitter choices.
pub fn emission_shift(stream: &mut Stream) -> f64 {
    stream.seek(SHIFT_INDEX << 32);
    stream.fine_unit()
}

/// Choice of the emitter for a chain: the van der Corput sequence, with a random shift for each replica. So any range of chains is shared
/// out among the luminaires in proportion to flux, and each choice alone is uniform.
pub fn spread_choice(chain: u64, shift: f64) -> f64 {
    let van_der_corput = (chain.reverse_bits() >> 11) as f64 / (1u64 << 53) as f64;
    let choice = van_der_corput + shift;
    if choice >= 1.0 { choice - 1.0 } else { choice }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_spread_evenly_and_stay_below_one() {
        for shift in [0.0, 0.3, 1.0 - 2f64.powi(-53)] {
            for first in [0, (1u64 << 32) - 32, 5 << 40] {
                let mut counts = [0; 8];
                for chain in first..first + 64 {
                    let choice = spread_choice(chain, shift);
                    assert!((0.0..1.0).contains(&choice));
                    counts[(choice * 8.0) as usize] += 1;
                }
                assert!(counts.iter().all(|count| (7..=9).contains(count)), "{counts:?}");
            }
        }
    }
}
