//! Results of cell samples, and the linear system of all of them, which sweeps solve.

use serde::{Deserialize, Serialize};

/// Relative change in a sweep, summed over all cells, below which the system counts as solved.
const SOLVED: f64 = 1e-6;
/// Maximum number of sweeps. Apart from the scaling of the whole they converge as bounces do.
const MOST_SWEEPS: usize = 400;
/// Bounds of the scaling after a sweep. Beyond them rounding has spoilt the sums.
const LEAST_SCALE: f64 = 0.5;
const MOST_SCALE: f64 = 1e4;

/// Marks the absence of a cell: the ray met nothing whose light a cell holds.
pub const NO_CELL: u32 = u32::MAX;

/// Result of a ray from a surface point of a cell.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct CellSample {
    /// Cell that the point belongs to.
    pub cell: u32,
    /// Light found without a cell, in lx.
    pub plain_lx: f32,
    /// Reflectance of the surface that the ray met.
    pub reflectance: f32,
    /// Cell of that surface point, or [`NO_CELL`].
    pub next: u32,
}

/// Marks a cell without samples.
const UNSAMPLED: u32 = u32::MAX;

/// The system, in the order of the cells that have samples. These are renumbered so that a sweep reads little memory in sequence.
pub struct System {
    /// Cells that have samples.
    pub cells: Vec<u32>,
    /// Light of each cell in lx.
    pub values_lx: Vec<f32>,
    /// Index of the first link of each cell, and the total number of links.
    firsts: Vec<u32>,
    /// For every sample that looked up a cell with samples: the number of that cell, and the reflectance there.
    links: Vec<(u32, f32)>,
    /// For each cell, the sum over its samples of the light found otherwise, in lx.
    own_lx: Vec<f64>,
    /// Number of samples of each cell.
    counts: Vec<u16>,
    /// Sum of the reflectances of the links that lead to each cell.
    looked_up: Vec<f64>,
}

impl System {
    /// Builds the system from the samples, the number of samples of each cell, and the previous light of all cells in lx. Cells without
    /// samples keep their light.
    pub fn of(samples: &[CellSample], counts: &[u16], known_lx: &[f32]) -> System {
        let mut number_of = vec![UNSAMPLED; counts.len()];
        let mut cells = Vec::new();
        for (cell, _) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            number_of[cell] = cells.len() as u32;
            cells.push(cell as u32);
        }
        let number_of = |cell: u32| number_of.get(cell as usize).copied().unwrap_or(UNSAMPLED);
        let mut firsts = vec![0u32; cells.len() + 1];
        let linked = samples.iter().filter(|sample| number_of(sample.next) != UNSAMPLED);
        linked.for_each(|sample| firsts[number_of(sample.cell) as usize + 1] += 1);
        (0..cells.len()).for_each(|number| firsts[number + 1] += firsts[number]);
        let mut free = firsts.clone();
        let mut links = vec![(0, 0.0); firsts[cells.len()] as usize];
        let (mut own_lx, mut looked_up) = (vec![0.0; cells.len()], vec![0.0; cells.len()]);
        for sample in samples {
            let (number, next) = (number_of(sample.cell) as usize, number_of(sample.next));
            own_lx[number] += f64::from(sample.plain_lx);
            if next == UNSAMPLED {
                let known_lx = known_lx.get(sample.next as usize).copied().unwrap_or(0.0);
                own_lx[number] += f64::from(sample.reflectance) * f64::from(known_lx);
            } else {
                links[free[number] as usize] = (next, sample.reflectance);
                free[number] += 1;
                looked_up[next as usize] += f64::from(sample.reflectance);
            }
        }
        let values_lx = cells.iter().map(|cell| known_lx[*cell as usize]).collect();
        let counts = cells.iter().map(|cell| counts[*cell as usize]).collect();
        System { cells, values_lx, firsts, links, own_lx, counts, looked_up }
    }

    /// Sweeps until almost nothing changes any more.
    pub fn solve(&mut self) {
        for _ in 0..MOST_SWEEPS {
            if self.sweep() {
                break;
            }
        }
    }

    /// One sweep over all cells, and a scaling of all light that balances its sum. Returns whether nothing changes any more.
    fn sweep(&mut self) -> bool {
        let (mut change_lx, mut held_lx) = (0.0, 0.0);
        for (number, own_lx) in self.own_lx.iter().enumerate() {
            let range = self.firsts[number] as usize..self.firsts[number + 1] as usize;
            let sent =
                |(next, reflectance): &(u32, f32)| f64::from(*reflectance) * f64::from(self.values_lx[*next as usize]);
            let sent_lx: f64 = self.links[range].iter().map(sent).sum();
            let count = f64::from(self.counts[number]);
            let new_lx = (own_lx + sent_lx) / count;
            change_lx += count * (new_lx - f64::from(self.values_lx[number])).abs();
            held_lx += count * new_lx;
            self.values_lx[number] = new_lx as f32;
        }
        if change_lx <= SOLVED * held_lx {
            return true;
        }
        // The light of the samples themselves must equal the light of the cells minus the light sent between them.
        let own_lx: f64 = self.own_lx.iter().sum();
        let sent_lx: f64 =
            self.values_lx.iter().zip(&self.looked_up).map(|(lx, looked_up)| looked_up * f64::from(*lx)).sum();
        let scale = own_lx / (held_lx - sent_lx);
        if (LEAST_SCALE..MOST_SCALE).contains(&scale) {
            self.values_lx.iter_mut().for_each(|lx| *lx *= scale as f32);
        }
        false
    }
}
