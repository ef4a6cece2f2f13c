//! What gathering adds to a map: how its look-ups scatter from memory to memory, what pooled checks correct, and what
//! coarser patches would have said.
//!
//! The eight replicas of a half gather with all eight memories of that half: a two-way layout, whose rows are the
//! gathering rays of a replica and whose columns are its chains. With y_g the mean of row g and z_m that of column m,
//! y_j + z_j − ȳ are eight values that scatter as independent replicas with rays and chains of their own would.

use super::replicas::REPLICAS;

/// Entries whose corrections are summed up together.
pub const ENTRIES_PER_BLOCK: usize = 16;
/// Share of what patches of twice the edge change that the finer ones are still wrong by: a third where the bias falls with
/// the square of the edge, as on smooth surfaces, all of it where it falls with the edge itself, as along shadows.
const BIAS_SHARE: f64 = 0.5;
/// Replicas of a half.
pub const HALF: usize = REPLICAS / 2;

/// The part of a map that gathering adds to its rows.
#[derive(Clone, Debug)]
pub struct Crossing {
    /// Sums over all rays of a half of what memory j said beyond the mean of the half's memories, in lx; slab j is
    /// replica j's column.
    pub columns: Vec<Vec<f64>>,
    /// Sums over all rays of the even and of the odd half of what coarser patches said beyond the finer ones, in lx.
    pub coarser: [Vec<f64>; 2],
    /// Sums of corrections of each block's entries in lx, replica by replica: rows, and columns beyond their mean.
    corrections: Vec<Vec<[f64; 2]>>,
    /// Samples of each block's entries so far, in every replica alike.
    samples: Vec<f64>,
    /// Entries of means; those behind them are coefficients of slopes, which pooled corrections leave alone.
    sites: usize,
    /// Correction of every replica in lx, pooled over all entries: of its row, and of its column beyond the mean.
    pooled_lx: [[f64; 2]; REPLICAS],
}

/// What the rays of one half from one entry found.
#[derive(Clone, Copy, Debug, Default)]
pub struct HalfScores {
    /// Sum of each row in lx.
    pub rows_lx: [f64; HALF],
    /// Sum over all rays of what each memory said, in lx.
    pub columns_lx: [f64; HALF],
    /// Sum over all rays of what coarser patches said beyond the finer ones, in lx.
    pub coarser_lx: f64,
}

impl HalfScores {
    /// Adds other scores times a factor.
    #[inline]
    pub fn add_times(&mut self, other: &HalfScores, factor: f64) {
        self.rows_lx.iter_mut().zip(&other.rows_lx).for_each(|(sum, lx)| *sum += factor * lx);
        self.columns_lx.iter_mut().zip(&other.columns_lx).for_each(|(sum, lx)| *sum += factor * lx);
        self.coarser_lx += factor * other.coarser_lx;
    }
}

/// What the checks of one half's rays found: corrections in lx, row by row and column by column.
#[derive(Clone, Copy, Debug, Default)]
pub struct HalfChecks {
    /// Sum of each row.
    pub rows_lx: [f64; HALF],
    /// Sum over all rays for each memory.
    pub columns_lx: [f64; HALF],
}

impl Crossing {
    /// Nothing gathered yet, for so many entries, of which the first `sites` are means.
    pub fn new(entries: usize, sites: usize) -> Crossing {
        let blocks = sites.div_ceil(ENTRIES_PER_BLOCK);
        Crossing {
            columns: vec![vec![0.0; entries]; REPLICAS],
            coarser: [vec![0.0; entries], vec![0.0; entries]],
            corrections: vec![vec![[0.0; 2]; blocks]; REPLICAS],
            samples: vec![0.0; blocks],
            sites,
            pooled_lx: [[0.0; 2]; REPLICAS],
        }
    }

    /// Adds what a half found at an entry; the rows are the caller's to keep.
    pub fn add(&mut self, parity: usize, entry: usize, scores: &HalfScores) {
        let mean_lx = scores.columns_lx.iter().sum::<f64>() / HALF as f64;
        for (memory, column_lx) in scores.columns_lx.iter().enumerate() {
            self.columns[2 * memory + parity][entry] += column_lx - mean_lx;
        }
        self.coarser[parity][entry] += scores.coarser_lx;
    }

    /// Adds what the checks of a half found in a block.
    pub fn correct(&mut self, parity: usize, block: usize, checks: &HalfChecks) {
        let mean_lx = checks.columns_lx.iter().sum::<f64>() / HALF as f64;
        for j in 0..HALF {
            let [row_lx, column_lx] = &mut self.corrections[2 * j + parity][block];
            *row_lx += checks.rows_lx[j];
            *column_lx += checks.columns_lx[j] - mean_lx;
        }
    }

    /// Counts samples of a block's entries that each replica took.
    pub fn count(&mut self, block: usize, samples: u64) {
        self.samples[block] += samples as f64;
    }

    /// Pools the corrections of every replica; to be called before values are read. They take away what all memories have
    /// wrong together, their bias and the chance of their level alike, and bring the chance of their checks.
    pub fn settle(&mut self) {
        let samples = self.samples.iter().sum::<f64>().max(1.0);
        for (pooled_lx, blocks) in self.pooled_lx.iter_mut().zip(&self.corrections) {
            let [row_lx, column_lx] =
                blocks.iter().fold([0.0; 2], |[row, column], block| [row + block[0], column + block[1]]);
            *pooled_lx = [row_lx / samples, column_lx / (HALF as f64 * samples)];
        }
    }

    /// What a replica adds to its row's mean at an entry of so many samples, in lx.
    #[inline]
    pub fn lx(&self, replica: usize, entry: usize, inverse_samples: f64) -> f64 {
        let pooled_lx = if entry < self.sites { self.pooled_lx[replica][0] } else { 0.0 };
        self.column_lx(replica, entry, inverse_samples) + pooled_lx
    }

    /// What a replica's column holds at an entry beyond the mean of its half, correction included, in lx.
    #[inline]
    pub fn column_lx(&self, replica: usize, entry: usize, inverse_samples: f64) -> f64 {
        let pooled_lx = if entry < self.sites { self.pooled_lx[replica][1] } else { 0.0 };
        self.columns[replica][entry] * inverse_samples / HALF as f64 + pooled_lx
    }

    /// Mean correction in lx.
    pub fn correction_lx(&self) -> f64 {
        self.pooled_lx.iter().map(|pooled| pooled[0]).sum::<f64>() / REPLICAS as f64
    }

    /// Estimated bias of look-ups in lx, root mean square over weighted entries of so many samples: what differs from entry
    /// to entry, since the corrections take away what is common.
    pub fn bias_lx(&self, entries: impl Iterator<Item = (usize, f64)>, inverse_samples: f64) -> f64 {
        BIAS_SHARE * self.coarsening_squared(entries, inverse_samples).max(0.0).sqrt()
    }

    /// Weighted mean square in lx² of what coarser patches change, of entries of so many samples: the product of the
    /// even and the odd half, in which chance cancels.
    fn coarsening_squared(&self, entries: impl Iterator<Item = (usize, f64)>, inverse_samples: f64) -> f64 {
        let (mut sum, mut weight_sum) = (0.0, 0.0);
        for (entry, weight) in entries {
            sum += weight * self.coarser[0][entry] * self.coarser[1][entry];
            if entry < self.sites {
                weight_sum += weight;
            }
        }
        (inverse_samples / HALF as f64).powi(2) * sum / weight_sum.max(f64::MIN_POSITIVE)
    }
}
