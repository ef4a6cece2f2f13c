//! What gathering adds to a map: how its look-ups scatter from memory to memory, what pooled checks correct, and what
//! coarser patches would have said.
//!
//! The eight replicas of a half gather with all eight memories of that half: a two-way layout, whose rows are the
//! gathering rays of a replica and whose columns are its chains. With y_g the mean of row g and z_m that of column m,
//! y_j + z_j − ȳ are eight values that scatter as independent replicas with rays and chains of their own would.

use super::replicas::REPLICAS;

/// Entries whose corrections are summed up together.
pub const ENTRIES_PER_BLOCK: usize = 16;
/// Share of what coarser patches change that the finer ones are still wrong by: the bias falls at least with the square of
/// the edge, and theirs is twice as long.
const BIAS_SHARE: f64 = 1.0 / 3.0;
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

/// What the checks of one half's rays found: corrections in lx, row by row and column by column.
#[derive(Clone, Copy, Debug, Default)]
pub struct HalfChecks {
    /// Sum of each row.
    pub rows_lx: [f64; HALF],
    /// Sum over all rays for each memory.
    pub columns_lx: [f64; HALF],
}

impl Crossing {
    /// Nothing gathered yet, for so many entries.
    pub fn new(entries: usize) -> Crossing {
        let blocks = entries.div_ceil(ENTRIES_PER_BLOCK);
        Crossing {
            columns: vec![vec![0.0; entries]; REPLICAS],
            coarser: [vec![0.0; entries], vec![0.0; entries]],
            corrections: vec![vec![[0.0; 2]; blocks]; REPLICAS],
            samples: vec![0.0; blocks],
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

    /// Pools the corrections over entries with weights; to be called before values are read.
    ///
    /// A correction takes away what all memories have wrong together, bias and the chance of their level alike, and brings
    /// the chance of its checks. Each half weighs it by what the other half says of both: σ²/(σ² + σ_check²).
    pub fn settle(&mut self, weights: &[f64], inverse_samples: f64) {
        let samples = self.samples.iter().sum::<f64>().max(1.0);
        let weight_sum = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let mut levels_lx = [0.0; REPLICAS];
        for (replica, blocks) in self.corrections.iter().enumerate() {
            let [row_lx, column_lx] =
                blocks.iter().fold([0.0; 2], |[row, column], block| [row + block[0], column + block[1]]);
            self.pooled_lx[replica] = [row_lx / samples, column_lx / (HALF as f64 * samples)];
            let sum_lx: f64 = self.columns[replica].iter().zip(weights).map(|(lx, weight)| weight * lx).sum();
            levels_lx[replica] = sum_lx * inverse_samples / (HALF as f64 * weight_sum);
        }
        let counted = weights.iter().copied().enumerate();
        let bias_squared = self.coarsening_squared(counted, inverse_samples).max(0.0) * BIAS_SHARE * BIAS_SHARE;
        let shares = [1, 0].map(|other| {
            let of_half = |value: &dyn Fn(usize) -> f64| -> [f64; HALF] { std::array::from_fn(|j| value(2 * j + other)) };
            let level_squared = variance_of_mean(&of_half(&|replica| levels_lx[replica])) + bias_squared;
            let check_squared = variance_of_mean(&of_half(&|replica| self.pooled_lx[replica][0]));
            if level_squared > 0.0 { level_squared / (level_squared + check_squared) } else { 0.0 }
        });
        for (replica, pooled_lx) in self.pooled_lx.iter_mut().enumerate() {
            *pooled_lx = pooled_lx.map(|lx| lx * shares[replica % 2]);
        }
    }

    /// What a replica adds to its row's mean at an entry of so many samples, in lx.
    #[inline]
    pub fn lx(&self, replica: usize, entry: usize, inverse_samples: f64) -> f64 {
        self.column_lx(replica, entry, inverse_samples) + self.pooled_lx[replica][0]
    }

    /// What a replica's column holds at an entry beyond the mean of its half, correction included, in lx.
    #[inline]
    pub fn column_lx(&self, replica: usize, entry: usize, inverse_samples: f64) -> f64 {
        self.columns[replica][entry] * inverse_samples / HALF as f64 + self.pooled_lx[replica][1]
    }

    /// Mean correction in lx.
    pub fn correction_lx(&self) -> f64 {
        self.pooled_lx.iter().map(|pooled| pooled[0]).sum::<f64>() / REPLICAS as f64
    }

    /// Estimated bias of look-ups in lx, root mean square over weighted entries of so many samples.
    pub fn bias_lx(&self, entries: impl Iterator<Item = (usize, f64)>, inverse_samples: f64) -> f64 {
        BIAS_SHARE * self.coarsening_squared(entries, inverse_samples).max(0.0).sqrt()
    }

    /// Weighted mean square in lx² of what coarser patches change, of entries of so many samples: the product of the
    /// even and the odd half, in which chance cancels.
    fn coarsening_squared(&self, entries: impl Iterator<Item = (usize, f64)>, inverse_samples: f64) -> f64 {
        let (mut sum, mut weight_sum) = (0.0, 0.0);
        for (entry, weight) in entries {
            sum += weight * self.coarser[0][entry] * self.coarser[1][entry];
            weight_sum += weight;
        }
        (inverse_samples / HALF as f64).powi(2) * sum / weight_sum.max(f64::MIN_POSITIVE)
    }
}

/// Variance of the mean of a half's replicas.
fn variance_of_mean(values: &[f64; HALF]) -> f64 {
    let mean = values.iter().sum::<f64>() / HALF as f64;
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (HALF * (HALF - 1)) as f64
}
