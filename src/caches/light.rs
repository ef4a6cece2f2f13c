//! The light in cells: samples taken where rays asked, and one linear system for all bounces.
//!
//! Cells tell indirect light alone: it changes little from place to place, where direct light has edges. A sample at a place of
//! cell c sends a ray that meets a surface of reflectance ρ in cell z. What it finds without asking a cell is P: direct light at
//! that surface among it. The indirect illuminance of the cell is I_c = mean(P + ρ I_z): a sparse system that sweeps solve without
//! a ray.

use serde::{Deserialize, Serialize};

use super::CellGrid;
use crate::base::memory::bytes_of_list;

/// Relative change of the sum of all cells in a sweep below which the system counts as solved.
const SOLVED: f64 = 1e-6;
/// Sweeps, at most: beside the scaling of the whole they converge as bounces do.
const MOST_SWEEPS: usize = 400;
/// Bounds of the scaling after a sweep: beyond them rounding has spoilt the sums.
const LEAST_SCALE: f64 = 0.5;
const MOST_SCALE: f64 = 1e4;

/// Samples from which on a cell's own spread is believed, and for how many what larger cells tell counts in one without any.
const ENOUGH_SAMPLES: f64 = 4.0;
const OF_NO_SAMPLE: f64 = 0.5;

/// The number that stands for no cell: nothing was met whose light a cell tells.
pub const NO_CELL: u32 = u32::MAX;

/// What a ray from a place of a cell found.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct CellSample {
    /// Cell that the place belongs to.
    pub cell: u32,
    /// What it found without asking a cell, in lx.
    pub plain_lx: f32,
    /// Reflectance of what the ray met.
    pub reflectance: f32,
    /// Its cell, or [`NO_CELL`].
    pub next: u32,
}

/// Cells of one half and their light.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CellLight {
    /// Where they lie.
    pub grid: CellGrid,
    /// Samples in the order in which they were taken.
    samples: Vec<CellSample>,
    /// Number of samples of each cell.
    counts: Vec<u16>,
    /// Indirect illuminance in lx by the latest solution.
    values_lx: Vec<f32>,
    /// Variance in lx² of it by chance of their samples.
    variances_lx2: Vec<f32>,
    /// Samples and cells that the latest solution knows.
    solved: usize,
    filled: usize,
}

impl CellLight {
    /// No cells yet.
    pub fn new(grid: CellGrid) -> CellLight {
        CellLight {
            grid,
            samples: Vec::new(),
            counts: Vec::new(),
            values_lx: Vec::new(),
            variances_lx2: Vec::new(),
            solved: 0,
            filled: 0,
        }
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

    /// Bytes that cells and samples take.
    pub fn bytes(&self) -> usize {
        self.grid.bytes()
            + bytes_of_list(&self.samples)
            + bytes_of_list(&self.counts)
            + bytes_of_list(&self.values_lx)
            + bytes_of_list(&self.variances_lx2)
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

    /// Indirect illuminance of a cell in lx; none of [`NO_CELL`].
    #[inline]
    pub fn value_lx(&self, cell: u32) -> f32 {
        self.values_lx.get(cell as usize).copied().unwrap_or(0.0)
    }

    /// Its variance in lx², about.
    #[inline]
    pub fn variance_lx2(&self, cell: u32) -> f32 {
        self.variances_lx2.get(cell as usize).copied().unwrap_or(0.0)
    }

    /// Solves for the light of all cells, if there are samples or cells that the latest solution does not know.
    pub fn solve(&mut self) {
        if (self.solved, self.filled) == (self.samples.len(), self.grid.len()) {
            return;
        }
        self.counts.resize(self.grid.len(), 0);
        self.values_lx.resize(self.grid.len(), 0.0);
        if self.solved < self.samples.len() {
            self.solved = self.samples.len();
            let system = System::of(&self.samples, &self.counts);
            for _ in 0..MOST_SWEEPS {
                if self.sweep(&system) {
                    break;
                }
            }
        }
        self.fill_unsampled();
        self.tell_variances();
    }

    /// Variances of cells by the spread of their samples; where these are few, by the relative spread that is usual.
    fn tell_variances(&mut self) {
        // Of every cell the sums of its samples' light and of its square.
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
        for cell in 0..sums.len() {
            if let Some(own) = spread_of(cell) {
                spread += own;
                squares += f64::from(self.values_lx[cell]).powi(2);
            }
        }
        let usual = if spread > 0.0 { spread / squares } else { 1.0 };
        let variance = |cell: usize| {
            let lx2 = usual * f64::from(self.values_lx[cell]).powi(2);
            spread_of(cell).unwrap_or(lx2) / f64::from(self.counts[cell]).max(OF_NO_SAMPLE)
        };
        self.variances_lx2 = (0..sums.len()).map(|cell| variance(cell) as f32).collect();
    }

    /// One sweep over all cells, and a scaling of all light that balances its sum; whether nothing changes any more.
    fn sweep(&mut self, system: &System) -> bool {
        let (mut change_lx, mut held_lx) = (0.0, 0.0);
        for (cell, own_lx) in system.own_lx.iter().enumerate() {
            let range = system.firsts[cell] as usize..system.firsts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let count = range.len() as f64;
            let sent = |(next, reflectance): &(u32, f32)| f64::from(*reflectance) * f64::from(self.value_lx(*next));
            let sent_lx: f64 = system.links[range].iter().map(sent).sum();
            let new_lx = (own_lx + sent_lx) / count;
            change_lx += count * (new_lx - f64::from(self.values_lx[cell])).abs();
            held_lx += count * new_lx;
            self.values_lx[cell] = new_lx as f32;
        }
        if change_lx <= SOLVED * held_lx {
            return true;
        }
        // What samples hold by themselves must be what cells hold beyond what is sent.
        let own_lx: f64 = system.own_lx.iter().sum();
        let sent_lx: f64 = self.values_lx.iter().zip(&system.asked).map(|(lx, asked)| asked * f64::from(*lx)).sum();
        let scale = own_lx / (held_lx - sent_lx);
        if (LEAST_SCALE..MOST_SCALE).contains(&scale) {
            self.values_lx.iter_mut().for_each(|lx| *lx *= scale as f32);
        }
        false
    }

    /// What the cell that a sample asked sends to it, in lx.
    #[inline]
    fn sent_lx(&self, sample: &CellSample) -> f64 {
        f64::from(sample.reflectance) * f64::from(self.value_lx(sample.next))
    }

    /// Gives cells without samples a value: the mean of the samples within them, else the value of the next larger cell.
    fn fill_unsampled(&mut self) {
        // Sum over the samples within, and their number.
        let held = |light: &CellLight, cell: usize| {
            let count = f64::from(light.counts[cell]);
            [count * f64::from(light.values_lx[cell]), count]
        };
        let mut sums: Vec<[f64; 2]> = (0..self.counts.len()).map(|cell| held(self, cell)).collect();
        let mut by_level: Vec<Vec<u32>> = vec![Vec::new(); self.grid.levels()];
        for cell in 0..sums.len() as u32 {
            by_level[self.grid.level(cell) as usize].push(cell);
        }
        for level in 0..by_level.len() {
            for cell in std::mem::take(&mut by_level[level]) {
                let own = sums[cell as usize];
                if own[1] == 0.0 {
                    continue;
                }
                let Some(parent) = self.grid.parent(cell) else {
                    continue;
                };
                if sums.len() <= parent as usize {
                    sums.resize(parent as usize + 1, [0.0; 2]);
                    by_level[level + 1].push(parent);
                }
                sums[parent as usize].iter_mut().zip(own).for_each(|(sum, more)| *sum += more);
            }
        }
        self.values_lx.resize(sums.len(), 0.0);
        self.counts.resize(sums.len(), 0);
        let mean = |[lx, count]: [f64; 2]| (lx / count.max(1.0)) as f32;
        // Where no larger cell has samples either, all cells together tell what is usual.
        let whole = (0..sums.len())
            .map(|cell| held(self, cell))
            .fold([0.0; 2], |sum: [f64; 2], own| [sum[0] + own[0], sum[1] + own[1]]);
        for cell in 0..sums.len() {
            if self.counts[cell] == 0 {
                let mut teller = Some(cell as u32);
                while let Some(larger) = teller
                    && sums[larger as usize][1] == 0.0
                {
                    teller = self.grid.larger(larger);
                }
                let told = teller.map_or(whole, |teller| match self.counts[teller as usize] {
                    0 => sums[teller as usize],
                    _ => held(self, teller as usize),
                });
                self.values_lx[cell] = mean(told);
            }
        }
        self.filled = self.grid.len();
    }
}

/// The linear system of all samples, in the order of their cells, so that a sweep reads memory in a row.
struct System {
    /// Number of the first link of every cell, and of all.
    firsts: Vec<u32>,
    /// Of every sample: the cell that it asked, and the reflectance there.
    links: Vec<(u32, f32)>,
    /// Of every cell, sum over its samples of what they found by themselves, in lx.
    own_lx: Vec<f64>,
    /// Of every cell, sum of the reflectances of the links that ask it.
    asked: Vec<f64>,
}

impl System {
    fn of(samples: &[CellSample], counts: &[u16]) -> System {
        let mut firsts = vec![0u32; counts.len() + 1];
        for (cell, count) in counts.iter().enumerate() {
            firsts[cell + 1] = firsts[cell] + u32::from(*count);
        }
        let mut next = firsts.clone();
        let mut links = vec![(NO_CELL, 0.0); samples.len()];
        let (mut own_lx, mut asked) = (vec![0.0; counts.len()], vec![0.0; counts.len()]);
        for sample in samples {
            let cell = sample.cell as usize;
            links[next[cell] as usize] = (sample.next, sample.reflectance);
            next[cell] += 1;
            own_lx[cell] += f64::from(sample.plain_lx);
            if let Some(asked) = asked.get_mut(sample.next as usize) {
                *asked += f64::from(sample.reflectance);
            }
        }
        System { firsts, links, own_lx, asked }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::Lookup;
    use super::*;

    fn cells(count: u32) -> CellLight {
        let mut light = CellLight::new(CellGrid::new([DVec3::ZERO, DVec3::splat(8.0)], [0.2, 0.3, 0.4], 0.5));
        for cell in 0..count {
            let point_m = DVec3::new(f64::from(cell), 0.0, 0.0);
            let lookup = Lookup { point_m, normal: DVec3::Z, direction: -DVec3::Z, distance_m: 1.0 };
            assert_eq!(light.grid.ask(&lookup), cell);
        }
        light
    }

    /// A sample of a cell that found some light, and asked another cell.
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
    fn larger_cells_that_nobody_asked_tell_the_mean_of_what_they_hold() {
        let mut light = cells(2);
        for (cell, plain_lx) in [(0, 10.0), (0, 20.0), (1, 60.0)] {
            sampled(&mut light, cell, plain_lx, 0.0, NO_CELL);
        }
        light.solve();
        let mut above = [0, 1];
        while above[0] != above[1] {
            above = above.map(|cell| light.grid.parent(cell).expect("cubes of a metre meet below the top"));
        }
        assert!((light.value_lx(above[0]) - 30.0).abs() < 1e-4);
    }

    #[test]
    fn cells_without_samples_ask_larger_ones() {
        let mut light = cells(1);
        sampled(&mut light, 0, 10.0, 0.0, NO_CELL);
        let ask = |light: &mut CellLight, normal: DVec3| {
            let lookup = Lookup { point_m: DVec3::X, normal, direction: -DVec3::Z, distance_m: 0.05 };
            light.grid.ask(&lookup)
        };
        let [finer, other] = [DVec3::Z, DVec3::X].map(|normal| ask(&mut light, normal));
        light.solve();
        // The other faces a way of which nothing is known.
        assert_eq!([finer, other].map(|cell| light.value_lx(cell)), [10.0; 2]);
    }
}
