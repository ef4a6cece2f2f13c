//! The light in cells: samples taken where rays asked, and one linear system for all bounces.
//!
//! A sample at a place of cell c found direct light D, light that needs no cell P, and a surface of reflectance ρ in cell z.
//! The illuminance of the cell is H_c = mean(D + P + ρ H_z): a sparse system that sweeps solve without a ray.

use super::CellGrid;

/// Relative change of the sum of all cells in a sweep below which the system counts as solved.
const SOLVED: f64 = 1e-6;
/// Sweeps, at most: beside the scaling of the whole they converge as bounces do.
const MOST_SWEEPS: usize = 400;
/// Bounds of the scaling after a sweep: beyond them rounding, or light that asks for indirect light alone, has spoilt the sums.
const LEAST_SCALE: f64 = 0.5;
const MOST_SCALE: f64 = 1e4;

/// A cell and what of its light is asked for: all, or indirect light alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellRef(u32);

impl CellRef {
    /// Nothing was met whose light a cell tells.
    pub const NONE: CellRef = CellRef(u32::MAX);

    /// All light of a cell, or its indirect light alone.
    #[inline]
    pub fn new(cell: u32, indirect_alone: bool) -> CellRef {
        CellRef(cell << 1 | u32::from(indirect_alone))
    }

    /// Number of the cell.
    #[inline]
    pub fn cell(self) -> u32 {
        self.0 >> 1
    }

    /// Whether direct light is left out.
    #[inline]
    pub fn is_indirect_alone(self) -> bool {
        self.0 & 1 == 1
    }
}

/// What a ray from a place of a cell found.
#[derive(Clone, Copy, Debug)]
pub struct CellSample {
    /// Cell that the place belongs to.
    pub cell: u32,
    /// Direct light in lx.
    pub direct_lx: f32,
    /// Indirect light that no cell tells, in lx.
    pub plain_lx: f32,
    /// Reflectance of what the ray met.
    pub reflectance: f32,
    /// Its cell.
    pub next: CellRef,
}

/// Cells of one replica and their light.
#[derive(Clone, Debug)]
pub struct CellLight {
    /// Where they lie.
    pub grid: CellGrid,
    /// Samples in the order in which they were taken.
    samples: Vec<CellSample>,
    /// Number of samples of each cell.
    counts: Vec<u16>,
    /// Illuminance in lx by the latest solution: all, and indirect alone.
    values_lx: Vec<[f32; 2]>,
    /// Samples that the latest solution knows.
    solved: usize,
}

impl CellLight {
    /// No cells yet.
    pub fn new(grid: CellGrid) -> CellLight {
        CellLight { grid, samples: Vec::new(), counts: Vec::new(), values_lx: Vec::new(), solved: 0 }
    }

    /// Samples of a cell.
    #[inline]
    pub fn count(&self, cell: u32) -> u16 {
        self.counts.get(cell as usize).copied().unwrap_or(0)
    }

    /// Samples of all cells.
    pub fn sample_count(&self) -> usize {
        self.samples.len()
    }

    /// Samples in cells that have as many as they take at most, and all samples.
    pub fn samples_in_full_cells(&self, most_samples: u16) -> [usize; 2] {
        let full = self.counts.iter().filter(|count| **count >= most_samples);
        [full.map(|count| usize::from(*count)).sum(), self.samples.len()]
    }

    /// Bytes that cells and samples take.
    pub fn bytes(&self) -> usize {
        self.grid.bytes()
            + self.samples.capacity() * size_of::<CellSample>()
            + self.counts.capacity() * size_of::<u16>()
            + self.values_lx.capacity() * size_of::<[f32; 2]>()
    }

    /// Books a sample of a cell before it is taken; returns its number within the cell.
    #[inline]
    pub fn book(&mut self, cell: u32) -> u16 {
        if self.counts.len() <= cell as usize {
            self.counts.resize(self.grid.len(), 0);
        }
        let count = &mut self.counts[cell as usize];
        *count += 1;
        *count - 1
    }

    /// Adds a sample that was booked.
    #[inline]
    pub fn add(&mut self, sample: CellSample) {
        self.samples.push(sample);
    }

    /// Illuminance in lx that a look-up tells.
    #[inline]
    pub fn value_lx(&self, asked: CellRef) -> f32 {
        if asked == CellRef::NONE {
            return 0.0;
        }
        self.values_lx.get(asked.cell() as usize).map_or(0.0, |lx| lx[usize::from(asked.is_indirect_alone())])
    }

    /// Solves for the light of all cells, if there are samples that the latest solution does not know.
    pub fn solve(&mut self) {
        if self.solved == self.samples.len() {
            return;
        }
        self.solved = self.samples.len();
        let asked = self.grid.len();
        self.counts.resize(asked, 0);
        self.values_lx.resize(asked, [0.0; 2]);
        let by_cell = self.samples_by_cell();
        for _ in 0..MOST_SWEEPS {
            if self.sweep(&by_cell) {
                break;
            }
        }
        self.fill_parents();
    }

    /// Numbers of samples in the order of their cells, behind the first of every cell.
    fn samples_by_cell(&self) -> (Vec<u32>, Vec<u32>) {
        let mut firsts = vec![0u32; self.counts.len() + 1];
        for (cell, count) in self.counts.iter().enumerate() {
            firsts[cell + 1] = firsts[cell] + u32::from(*count);
        }
        let mut next = firsts.clone();
        let mut order = vec![0u32; self.samples.len()];
        for (index, sample) in self.samples.iter().enumerate() {
            let place = &mut next[sample.cell as usize];
            order[*place as usize] = index as u32;
            *place += 1;
        }
        (firsts, order)
    }

    /// One sweep over all cells, and a scaling of all light that balances its sum; whether nothing changes any more.
    fn sweep(&mut self, (firsts, order): &(Vec<u32>, Vec<u32>)) -> bool {
        let (mut change_lx, mut held_lx) = (0.0, 0.0);
        for cell in 0..self.counts.len() {
            let range = firsts[cell] as usize..firsts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let count = range.len() as f64;
            let (mut direct, mut indirect) = (0.0, 0.0);
            for index in &order[range] {
                let sample = &self.samples[*index as usize];
                indirect += f64::from(sample.plain_lx) + self.sent_lx(sample);
                direct += f64::from(sample.direct_lx);
            }
            let new_lx = [(direct + indirect) / count, indirect / count];
            change_lx += count * (new_lx[0] - f64::from(self.values_lx[cell][0])).abs();
            held_lx += count * new_lx[0];
            self.values_lx[cell] = new_lx.map(|lx| lx as f32);
        }
        if change_lx <= SOLVED * held_lx {
            return true;
        }
        // What samples hold by themselves must be what cells hold beyond what is sent.
        let own = |sample: &CellSample| f64::from(sample.direct_lx) + f64::from(sample.plain_lx);
        let own_lx: f64 = self.samples.iter().map(own).sum();
        let sent_lx: f64 = self.samples.iter().map(|sample| self.sent_lx(sample)).sum();
        let scale = own_lx / (held_lx - sent_lx);
        if (LEAST_SCALE..MOST_SCALE).contains(&scale) {
            self.values_lx.iter_mut().flatten().for_each(|lx| *lx *= scale as f32);
        }
        false
    }

    /// What the cell that a sample asked sends to it, in lx.
    #[inline]
    fn sent_lx(&self, sample: &CellSample) -> f64 {
        f64::from(sample.reflectance) * f64::from(self.value_lx(sample.next))
    }

    /// Gives larger cells, which nobody asked, the mean of the samples within them.
    fn fill_parents(&mut self) {
        let asked = self.counts.len();
        let mut sums: Vec<[f64; 3]> = (0..asked)
            .map(|cell| {
                let count = f64::from(self.counts[cell]);
                let [all, indirect] = self.values_lx[cell].map(|lx| count * f64::from(lx));
                [all, indirect, count]
            })
            .collect();
        for cell in 0..asked {
            let own = sums[cell];
            if self.counts[cell] == 0 {
                continue;
            }
            let mut above = cell as u32;
            for _ in 0..PARENTS {
                let Some(parent) = self.grid.parent(above) else {
                    break;
                };
                above = parent;
                if sums.len() <= above as usize {
                    sums.resize(above as usize + 1, [0.0; 3]);
                }
                // A cell that was asked itself tells by its own samples alone.
                if self.count(above) == 0 {
                    sums[above as usize].iter_mut().zip(own).for_each(|(sum, more)| *sum += more);
                }
            }
        }
        self.values_lx.resize(self.grid.len(), [0.0; 2]);
        self.counts.resize(self.grid.len(), 0);
        for (cell, [all, indirect, count]) in sums.into_iter().enumerate() {
            if self.counts[cell] == 0 && count > 0.0 {
                self.values_lx[cell] = [(all / count) as f32, (indirect / count) as f32];
            }
        }
    }
}

/// Levels of larger cells that are filled above each that was asked.
const PARENTS: usize = 3;

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::Lookup;
    use super::*;

    fn cells(count: u32) -> CellLight {
        let mut light = CellLight::new(CellGrid::new([DVec3::ZERO, DVec3::splat(8.0)], [0.2, 0.3, 0.4]));
        for cell in 0..count {
            let point_m = DVec3::new(f64::from(cell), 0.0, 0.0);
            let lookup = Lookup { point_m, normal: DVec3::Z, direction: -DVec3::Z, distance_m: 1.0, edge_share: 0.5 };
            assert_eq!(light.grid.ask(&lookup), cell);
        }
        light
    }

    #[test]
    fn two_cells_that_light_each_other_have_all_bounces() {
        // H₀ = 100 + 0.9 H₁, H₁ = 0.9 H₀: H₀ = 100/(1 − 0.81).
        for reflectance in [0.5f32, 0.9, 0.999] {
            let mut light = cells(2);
            for (cell, direct_lx) in [(0, 100.0), (1, 0.0)] {
                light.book(cell);
                let next = CellRef::new(1 - cell, false);
                light.add(CellSample { cell, direct_lx, plain_lx: 0.0, reflectance, next });
            }
            light.solve();
            let expected = 100.0 / (1.0 - f64::from(reflectance).powi(2));
            let found = f64::from(light.value_lx(CellRef::new(0, false)));
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
            let indirect = f64::from(light.value_lx(CellRef::new(0, true)));
            assert!((indirect - (found - 100.0)).abs() < 1e-3 * expected, "{indirect}");
        }
    }

    #[test]
    fn larger_cells_that_nobody_asked_tell_the_mean_of_what_they_hold() {
        let mut light = cells(2);
        for (cell, direct_lx) in [(0, 10.0), (0, 20.0), (1, 60.0)] {
            light.book(cell);
            light.add(CellSample { cell, direct_lx, plain_lx: 0.0, reflectance: 0.0, next: CellRef::NONE });
        }
        light.solve();
        let mut above = [0, 1];
        while above[0] != above[1] {
            above = above.map(|cell| light.grid.parent(cell).expect("cubes of a metre meet below the top"));
        }
        let told = light.value_lx(CellRef::new(above[0], false));
        assert!(told == 0.0 || (told - 30.0).abs() < 1e-4, "{told}");
    }
}
