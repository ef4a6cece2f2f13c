//! What holds up the error of a map that is gathered.

use super::judge::PairProducts;
use super::{HALF, REPLICAS, ReplicaMap};

/// Standard error of tr C² by the products of all pairs of differences, as a share of it, about: √(2/28).
const UNSURE_SQUARES: f64 = 0.27;
/// Standard errors of the cells' own part that are not taken for the columns'.
const SURE_OF_CELLS: f64 = 2.0;

/// Variances in lx² of a replica of a map that is gathered, weighted means over elements or points.
#[derive(Clone, Copy, Debug, Default)]
pub struct CrossedVariances {
    /// By chance of the gathering rays.
    pub rows: f64,
    /// By chance of the chains.
    pub columns: f64,
    /// By chance of which rays ask which chains: it falls with both.
    pub cells: f64,
    /// Degrees of freedom of the mean square that is by chance of the chains.
    pub degrees_of_columns: f64,
}

/// Columns of a map, summed over its entries.
#[derive(Default)]
struct Columns {
    /// Sum of their mean squares, of either half.
    squares: f64,
    products: PairProducts,
}

impl Columns {
    /// Adds what each column holds beyond the mean of its half at an entry with its weight, in lx.
    fn add(&mut self, weight: f64, columns_lx: &[f64; REPLICAS]) {
        self.squares += weight * columns_lx.iter().map(|lx| lx * lx).sum::<f64>() / (HALF - 1) as f64;
        // Differences within a half: what it has in common is not in them.
        let pairs = std::array::from_fn(|pair| {
            let (parity, memory) = (pair % 2, pair / 2 * 2);
            columns_lx[2 * (memory + 1) + parity] - columns_lx[2 * memory + parity]
        });
        self.products.add(weight, &pairs);
    }

    /// Their own part and its degrees of freedom beside that of the cells, which they hold too and which is independent from entry to
    /// entry: only what surely is not the cells' is theirs. So many entries count.
    fn own(&self, cells: f64, entries: f64) -> (f64, f64) {
        let all_degrees = self.products.degrees_of_freedom();
        // At a first look cells are a hundred times what columns will turn out to be: what chance leaves of them is no column.
        let cells = cells * (1.0 + SURE_OF_CELLS * (2.0 / all_degrees).sqrt());
        let own = (self.squares - cells).max(0.0);
        let squares = (1.0 - UNSURE_SQUARES) * self.squares * self.squares / all_degrees;
        let squares = (squares - cells * cells / entries).max(own * own / entries);
        (own, (own * own / squares.max(f64::MIN_POSITIVE)).max(1.0))
    }
}

impl ReplicaMap {
    /// What holds up the error of a map that is gathered: variances of one replica.
    pub fn crossed_variances(&self, weights: &[f64]) -> CrossedVariances {
        let Some(crossing) = &self.crossing else {
            return CrossedVariances::default();
        };
        let (mut rows, mut cells, mut weight_sum, mut weight_squares) = (0.0, 0.0, 0.0, 0.0);
        let [mut found, mut corrected] = [Columns::default(), Columns::default()];
        for (entry, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let inverse = self.indirect_samples.inverse(self.site_of(entry));
            rows += weight * inverse * inverse * crossing.ray_squared(entry, &self.indirect);
            cells += weight * inverse * inverse * crossing.cell_squared(entry);
            found.add(*weight, &std::array::from_fn(|replica| crossing.found_column_lx(replica, entry, inverse)));
            corrected.add(*weight, &std::array::from_fn(|replica| crossing.column_lx(replica, entry, inverse)));
            if entry < self.len() {
                weight_sum += weight;
                weight_squares += weight * weight;
            }
        }
        // Corrections take off what chains have wrong everywhere, and bring the chance of their checks, which is not that of chains.
        let columns = if corrected.squares < found.squares { corrected } else { found };
        let entries = weight_sum * weight_sum / f64::max(weight_squares, f64::MIN_POSITIVE);
        let (of_columns, degrees_of_columns) = columns.own(cells, entries);
        // Either half has a mean square of its own.
        let mean = |sum: f64| sum.max(0.0) / f64::max(2.0 * weight_sum, f64::MIN_POSITIVE);
        CrossedVariances {
            rows: mean(rows - cells),
            columns: mean(of_columns),
            cells: mean(cells.min(rows)),
            degrees_of_columns,
        }
    }
}
