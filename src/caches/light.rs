//! The light in cells: samples taken at points where rays looked cells up, and one linear system for all bounces.
//!
//! Cells hold only indirect light, since it varies little from point to point, while direct light has edges. A sample at a point of cell c
//! sends a ray that meets a surface of reflectance ρ in cell z. The light that it finds without a cell is P, which includes the direct
//! light at that surface. The indirect illuminance of the cell is I_c = mean(P + ρ I_z). This is a sparse system that sweeps solve without
//! a ray.

use serde::{Deserialize, Serialize};

use super::CellGrid;
use super::enclosures::LinkedCells;
use super::larger::LargerCells;
use super::system::{CellSample, System};
use crate::base::memory::bytes_of_list;

/// Samples from which on a cell's own spread is used, and number of samples for which the value from larger cells counts in a cell without
/// any.
const ENOUGH_SAMPLES: f64 = 4.0;
const OF_NO_SAMPLE: f64 = 0.5;

/// Cells of one half of the samples, and their light.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CellLight {
    /// Grid of the cells.
    pub grid: CellGrid,
    /// Samples in the order in which they were taken.
    samples: Vec<CellSample>,
    /// Number of samples of each cell.
    counts: Vec<u16>,
    /// Indirect illuminance of each cell in lx, from the latest solution.
    values_lx: Vec<f32>,
    /// Variance of it in lx² from the randomness of the samples.
    variances_lx2: Vec<f32>,
    /// Which cells light passes between.
    linked: LinkedCells,
    /// Number of samples and cells included in the latest solution.
    solved: usize,
    filled: usize,
    /// Usual variance of a sample over the square of its cell's light.
    usual_spread: f64,
    /// Light for cells without samples, from larger cells of the latest solution.
    larger: LargerCells,
}

impl CellLight {
    /// Creates the light of a grid without samples.
    pub fn new(grid: CellGrid) -> CellLight {
        CellLight {
            larger: LargerCells::of(&grid, std::iter::empty()),
            grid,
            samples: Vec::new(),
            counts: Vec::new(),
            values_lx: Vec::new(),
            variances_lx2: Vec::new(),
            linked: LinkedCells::default(),
            solved: 0,
            filled: 0,
            usual_spread: 1.0,
        }
    }

    /// Number of samples of a cell.
    #[inline]
    pub fn count(&self, cell: u32) -> u16 {
        self.counts.get(cell as usize).copied().unwrap_or(0)
    }

    /// Number of samples of all cells.
    pub fn sample_count(&self) -> usize {
        self.samples.len()
    }

    /// Memory of cells and samples in bytes.
    pub fn bytes(&self) -> usize {
        self.grid.bytes()
            + bytes_of_list(&self.samples)
            + bytes_of_list(&self.counts)
            + bytes_of_list(&self.values_lx)
            + bytes_of_list(&self.variances_lx2)
            + self.linked.bytes()
            + self.larger.bytes()
    }

    /// Books a sample of a cell before it is taken. Returns its number within the cell.
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

    /// Indirect illuminance of a cell in lx. 0 for [`NO_CELL`].
    #[inline]
    pub fn value_lx(&self, cell: u32) -> f32 {
        self.values_lx.get(cell as usize).copied().unwrap_or(0.0)
    }

    /// Approximate variance of that illuminance in lx².
    #[inline]
    pub fn variance_lx2(&self, cell: u32) -> f32 {
        self.variances_lx2.get(cell as usize).copied().unwrap_or(0.0)
    }

    /// Number of the enclosure of every cell, or [`super::NO_ENCLOSURE`]. `None` if there is only one enclosure.
    pub fn enclosures(&mut self) -> Option<Vec<u8>> {
        self.counts.resize(self.grid.len(), 0);
        self.linked.see(&self.samples, self.grid.len());
        self.linked.numbers(&self.counts)
    }

    /// Puts a cell without samples into the enclosure of another one, unless it is in one already.
    pub fn put(&mut self, unsampled: u32, known: u32) {
        self.linked.put(unsampled, known);
    }

    /// Solves for the light of all cells, if there are samples or cells that the latest solution does not include.
    pub fn solve(&mut self) {
        if (self.solved, self.filled) == (self.samples.len(), self.grid.len()) {
            return;
        }
        let enclosures = self.enclosures();
        let enclosure_of = |cell: u32| enclosures.as_ref().map_or(0, |numbers| numbers[cell as usize]);
        self.values_lx.resize(self.grid.len(), 0.0);
        self.variances_lx2.resize(self.grid.len(), 0.0);
        if self.solved < self.samples.len() {
            self.solve_sampled(enclosure_of);
            // The values of cells without samples are out of date.
            self.filled = 0;
        }
        self.fill_unsampled(enclosure_of);
    }

    /// Solves for the light of the cells that have samples.
    fn solve_sampled(&mut self, enclosure_of: impl Fn(u32) -> u8) {
        let mut system = System::of(&self.samples, &self.counts, &self.values_lx);
        system.solve();
        system.cells.iter().zip(&system.values_lx).for_each(|(cell, lx)| self.values_lx[*cell as usize] = *lx);
        self.tell_variances(&system.cells);
        let sampled = system.cells.iter().zip(&system.values_lx);
        let sampled = sampled.map(|(cell, lx)| (*cell, enclosure_of(*cell), self.counts[*cell as usize], *lx));
        self.larger = LargerCells::of(&self.grid, sampled);
        self.solved = self.samples.len();
    }

    /// Computes the variances of cells that have samples from the spread of the samples. Cells with few samples use the usual relative
    /// spread.
    fn tell_variances(&mut self, sampled: &[u32]) {
        // For every cell, the sum of its samples' light and of its square.
        let mut sums = vec![[0.0f64; 2]; self.counts.len()];
        for sample in &self.samples {
            let lx = f64::from(sample.plain_lx) + self.sent_lx(sample);
            let sum = &mut sums[sample.cell as usize];
            *sum = [sum[0] + lx, sum[1] + lx * lx];
        }
        let spread_of = |cell: usize| {
            let (count, [sum, squares]) = (f64::from(self.counts[cell]), sums[cell]);
            (count >= ENOUGH_SAMPLES).then(|| (squares - sum * sum / count).max(0.0) / (count - 1.0))
        };
        let (mut spread, mut squares) = (0.0, f64::MIN_POSITIVE);
        for cell in sampled.iter().map(|cell| *cell as usize) {
            if let Some(own) = spread_of(cell) {
                spread += own;
                squares += f64::from(self.values_lx[cell]).powi(2);
            }
        }
        self.usual_spread = if spread > 0.0 { spread / squares } else { 1.0 };
        for cell in sampled.iter().map(|cell| *cell as usize) {
            let lx2 = spread_of(cell).unwrap_or(self.usual_spread * f64::from(self.values_lx[cell]).powi(2));
            self.variances_lx2[cell] = (lx2 / f64::from(self.counts[cell])) as f32;
        }
    }

    /// Light that the looked-up cell sends to a sample, in lx.
    #[inline]
    fn sent_lx(&self, sample: &CellSample) -> f64 {
        f64::from(sample.reflectance) * f64::from(self.value_lx(sample.next))
    }

    /// Gives new cells without samples the light of larger cells.
    fn fill_unsampled(&mut self, enclosure_of: impl Fn(u32) -> u8) {
        for cell in self.filled..self.counts.len() {
            if self.counts[cell] == 0 {
                let lx = self.larger.tell_lx(self.grid.key_of(cell as u32), enclosure_of(cell as u32));
                self.values_lx[cell] = lx;
                self.variances_lx2[cell] = (self.usual_spread * f64::from(lx).powi(2) / OF_NO_SAMPLE) as f32;
            }
        }
        self.filled = self.counts.len();
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::{Lookup, NO_CELL};
    use super::*;

    fn cells(count: u32) -> CellLight {
        let mut light = CellLight::new(CellGrid::new([DVec3::ZERO, DVec3::splat(8.0)], [0.2, 0.3, 0.4], 0.5));
        for cell in 0..count {
            let point_m = DVec3::new(f64::from(cell), 0.0, 0.0);
            let key = light.grid.key(&Lookup { point_m, normal: DVec3::Z, distance_m: 1.0 }, |_| true);
            assert_eq!(light.grid.cell(key), cell);
        }
        light
    }

    /// Adds a sample of a cell that found some light and looked up another cell.
    fn sampled(light: &mut CellLight, cell: u32, plain_lx: f32, reflectance: f32, next: u32) {
        light.book(cell);
        light.add(CellSample { cell, plain_lx, reflectance, next });
    }

    #[test]
    fn two_cells_that_light_each_other_have_all_bounces() {
        // I₀ = 100 + 0.9 I₁, I₁ = 0.9 I₀: I₀ = 100/(1 − 0.81).
        for reflectance in [0.5f32, 0.9, 0.999] {
            let mut light = cells(2);
            sampled(&mut light, 0, 100.0, reflectance, 1);
            sampled(&mut light, 1, 0.0, reflectance, 0);
            light.solve();
            let expected = 100.0 / (1.0 - f64::from(reflectance).powi(2));
            let found = [0, 1].map(|cell| f64::from(light.value_lx(cell)));
            assert!((found[0] / expected - 1.0).abs() < 1e-3, "{found:?} {expected}");
            assert!((found[1] / expected - f64::from(reflectance)).abs() < 1e-3, "{found:?} {expected}");
        }
    }

    #[test]
    fn larger_cells_that_nobody_looked_up_tell_the_mean_of_what_they_hold() {
        let mut light = cells(2);
        for (cell, plain_lx) in [(0, 10.0), (0, 20.0), (1, 60.0)] {
            sampled(&mut light, cell, plain_lx, 0.0, NO_CELL);
        }
        let mut above = [0, 1].map(|cell| light.grid.key_of(cell));
        while above[0] != above[1] {
            above = above.map(|key| light.grid.above(key).expect("cubes of a metre meet below the top"));
        }
        let cell = light.grid.cell(above[0]);
        light.solve();
        assert!((light.value_lx(cell) - 30.0).abs() < 1e-4);
    }

    #[test]
    fn cells_without_samples_ask_larger_ones() {
        let mut light = cells(1);
        sampled(&mut light, 0, 10.0, 0.0, NO_CELL);
        let look_up = |light: &mut CellLight, normal: DVec3| {
            let key = light.grid.key(&Lookup { point_m: DVec3::X, normal, distance_m: 0.05 }, |_| true);
            light.grid.cell(key)
        };
        let [finer, other] = [DVec3::Z, DVec3::X].map(|normal| look_up(&mut light, normal));
        light.solve();
        // The other cell faces a direction of which nothing is known.
        assert_eq!([finer, other].map(|cell| light.value_lx(cell)), [10.0; 2]);
        // The values are renewed with the samples, and cells that come later get them too.
        sampled(&mut light, 0, 30.0, 0.0, NO_CELL);
        light.solve();
        let later = look_up(&mut light, DVec3::Y);
        light.solve();
        assert_eq!([finer, other, later].map(|cell| light.value_lx(cell)), [20.0; 3]);
    }
}
