//! Light of cells without samples, taken from larger cells.

use serde::{Deserialize, Serialize};

use super::{CellGrid, CellKey, NO_ENCLOSURE};
use crate::base::memory::bytes_of_list;

/// Cells of all sizes that contain samples, each with its light.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LargerCells {
    /// Grid of these cells, in a table of their own: most cells that rays look up have no samples and would slow the search.
    grid: CellGrid,
    /// Light of each cell in lx: its own if it has samples itself, else the mean of all samples within it.
    gathered_lx: Vec<f32>,
    /// For each enclosure, the mean light of all its samples in lx, used if no larger cell has samples either.
    usual_lx: Vec<f32>,
}

impl LargerCells {
    /// Builds the larger cells of each enclosure from the cells that have samples: number of the cell, number of its enclosure and of its
    /// samples, and its light in lx.
    pub fn of(grid: &CellGrid, sampled: impl Iterator<Item = (u32, u8, u16, f32)>) -> LargerCells {
        let mut held = LargerCells { grid: grid.emptied(), gathered_lx: Vec::new(), usual_lx: Vec::new() };
        let mut by_level: Vec<Vec<u32>> = vec![Vec::new(); grid.levels()];
        // Sum of light over the samples within, and the number of samples.
        let (mut sums, mut wholes) = (Vec::new(), [[0.0; 2]; NO_ENCLOSURE as usize + 1]);
        for (cell, enclosure, count, lx) in sampled {
            let key = grid.key_of(cell).within(enclosure);
            let own = [f64::from(count) * f64::from(lx), f64::from(count)];
            by_level[key.level() as usize].push(held.grid.cell(key));
            sums.push(own);
            held.gathered_lx.push(lx);
            add(&mut wholes[usize::from(enclosure)], own);
        }
        let with_own = sums.len();
        for level in 0..by_level.len() {
            for cell in std::mem::take(&mut by_level[level]) {
                let own = sums[cell as usize];
                let Some(key) = held.grid.above(held.grid.key_of(cell)) else {
                    continue;
                };
                let above = held.grid.cell(key);
                if sums.len() <= above as usize {
                    sums.push([0.0; 2]);
                    by_level[level + 1].push(above);
                }
                add(&mut sums[above as usize], own);
            }
        }
        held.gathered_lx.extend(sums[with_own..].iter().map(|sum| mean_lx(*sum)));
        held.usual_lx = wholes.map(mean_lx).to_vec();
        held
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.grid.bytes() + bytes_of_list(&self.gathered_lx) + bytes_of_list(&self.usual_lx)
    }

    /// Light of a cell of an enclosure without samples, in lx: that of the smallest cell with samples of the enclosure that contains it.
    pub fn tell_lx(&self, key: CellKey, enclosure: u8) -> f32 {
        let mut at = Some(key.within(enclosure));
        while let Some(key) = at {
            if let Some(cell) = self.grid.find(key) {
                return self.gathered_lx[cell as usize];
            }
            at = self.grid.above(key);
        }
        self.usual_lx.get(usize::from(enclosure)).copied().unwrap_or(0.0)
    }
}

fn add(sum: &mut [f64; 2], more: [f64; 2]) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}

fn mean_lx([lx, count]: [f64; 2]) -> f32 {
    (lx / count.max(1.0)) as f32
}
