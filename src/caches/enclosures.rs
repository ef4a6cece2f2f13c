//! Enclosures: cells between which light passes. No light gets from one enclosure to another.

use serde::{Deserialize, Serialize};

use super::{CellSample, NO_CELL};
use crate::base::linked_sets::LinkedSets;

/// Samples from which on linked cells count as an enclosure. Cells whose rays all leave the scene are linked to nothing.
const LEAST_SAMPLES: u64 = 64;
/// Most enclosures that are told apart.
const MOST_ENCLOSURES: usize = u8::MAX as usize;
/// Number of cells that belong to no enclosure.
pub const NO_ENCLOSURE: u8 = u8::MAX;

/// Cells that are linked by rays between them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LinkedCells {
    linked: LinkedSets,
    /// Number of samples that were seen.
    seen: usize,
}

impl LinkedCells {
    /// Links the cells of new samples, among `cells` cells in all.
    pub fn see(&mut self, samples: &[CellSample], cells: usize) {
        self.linked.extend_to(cells);
        let new = samples[self.seen..].iter().filter(|sample| sample.next != NO_CELL);
        new.for_each(|sample| self.linked.link(sample.cell, sample.next));
        self.seen = samples.len();
    }

    /// Puts a cell without samples into the enclosure of another one, unless it is in one already.
    pub fn put(&mut self, unsampled: u32, known: u32) {
        if self.linked.root(unsampled) == unsampled {
            self.linked.link(known, unsampled);
        }
    }

    /// Number of the enclosure of every cell, from the number of samples of each: the one with most samples is 0. `None` if there is only one.
    pub fn numbers(&mut self, counts: &[u16]) -> Option<Vec<u8>> {
        let roots: Vec<u32> = (0..counts.len() as u32).map(|cell| self.linked.root(cell)).collect();
        let mut samples = vec![0u64; counts.len()];
        roots.iter().zip(counts).for_each(|(root, count)| samples[*root as usize] += u64::from(*count));
        let mut largest: Vec<u32> =
            (0..counts.len() as u32).filter(|root| samples[*root as usize] >= LEAST_SAMPLES).collect();
        if largest.len() < 2 {
            return None;
        }
        largest.sort_by_key(|root| (std::cmp::Reverse(samples[*root as usize]), *root));
        let mut number_of_root = vec![NO_ENCLOSURE; counts.len()];
        let told_apart = largest.iter().take(MOST_ENCLOSURES);
        told_apart.zip(0u8..).for_each(|(root, number)| number_of_root[*root as usize] = number);
        Some(roots.iter().map(|root| number_of_root[*root as usize]).collect())
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.linked.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(cell: u32, next: u32) -> CellSample {
        CellSample { cell, plain_lx: 0.0, reflectance: 0.5, next }
    }

    /// Cells 0 to 3 see one another, and 4 and 5 do. Cell 6 has no link until it is put beside cell 4.
    #[test]
    fn linked_cells_with_enough_samples_are_enclosures() {
        let mut enclosures = LinkedCells::default();
        let mut samples =
            [(0, 1), (1, 2), (3, 2), (4, 5), (5, NO_CELL)].map(|(cell, next)| sample(cell, next)).to_vec();
        enclosures.see(&samples, 7);
        assert_eq!(enclosures.numbers(&[90, 10, 0, 0, 60, 3, 0]), None, "63 samples are too few");
        let counts = [60, 10, 0, 0, 64, 90, 0];
        assert_eq!(enclosures.numbers(&counts), Some(vec![1, 1, 1, 1, 0, 0, NO_ENCLOSURE]));
        enclosures.put(6, 4);
        enclosures.put(6, 0);
        assert_eq!(enclosures.numbers(&counts), Some(vec![1, 1, 1, 1, 0, 0, 0]), "it is in one enclosure only");
        samples.push(sample(3, 5));
        enclosures.see(&samples, 7);
        assert_eq!(enclosures.numbers(&counts), None, "light passes between all");
    }
}
