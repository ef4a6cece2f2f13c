//! Findings of rays and walks, stored as numbers of cells until the light of the cells is known.

use serde::{Deserialize, Serialize};

use crate::base::memory::bytes_of_list;
use crate::caches::{CellGrid, CellLight};
use crate::estimators::gathering::{PendingTerm, Term};

/// Findings of the rays and walks of one replica of a map.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Records {
    /// For every ray, pass by pass: the cell that it looked up.
    pub terms: Vec<Term>,
    /// Bin of the direction of the ray.
    pub bins: Vec<u8>,
    /// Light that the ray found without cells, in lx.
    pub plain_lx: Vec<f32>,
    /// Where the ray started and how far it went; empty if elements show no slopes.
    pub flights: Vec<Flight>,
    /// What every walk found, pass by pass.
    pub walks: Vec<WalkRecord>,
    pub walk_terms: Vec<Term>,
    pub walk_bins: Vec<u8>,
    pub walk_starts: Vec<[f32; 2]>,
    /// Positions among the terms of rays, and of walks, whose cells are new.
    pub new: Vec<(u32, PendingTerm)>,
    pub new_of_walks: Vec<(u32, PendingTerm)>,
}

/// Where a ray started and how far it went.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Flight {
    /// Its start in its element: the weights of the second and third corner.
    pub at: [f32; 2],
    /// Its length in m; infinite if it met no surface.
    pub length_m: f32,
}

/// Findings of a walk.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct WalkRecord {
    /// Light that it found without cells, in lx: as a whole, and by its first step.
    pub plain_lx: f32,
    pub plain_of_step_lx: f32,
    /// Number of terms of all walks up to its end.
    pub end: u32,
}

/// Terms of the first step of a walk: the cell of the point that it met, and the cell of the next point.
const TERMS_OF_A_STEP: usize = 2;

impl WalkRecord {
    /// Result of the walk and of its first step in lx, from its terms and the present light of cells.
    pub fn found_lx(&self, terms: &[Term], cells: &CellLight) -> [f64; 2] {
        let sum_lx = |terms: &[Term]| -> f64 {
            terms.iter().map(|term| f64::from(term.factor) * f64::from(cells.value_lx(term.cell))).sum()
        };
        let (of_step, later) = terms.split_at(terms.len().min(TERMS_OF_A_STEP));
        let of_step_lx = sum_lx(of_step);
        let whole_lx = f64::from(self.plain_lx) + of_step_lx + sum_lx(later);
        [whole_lx, f64::from(self.plain_of_step_lx) + of_step_lx]
    }
}

impl Records {
    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        bytes_of_list(&self.terms)
            + bytes_of_list(&self.bins)
            + bytes_of_list(&self.walk_bins)
            + bytes_of_list(&self.plain_lx)
            + bytes_of_list(&self.flights)
            + bytes_of_list(&self.walks)
            + bytes_of_list(&self.walk_terms)
            + bytes_of_list(&self.walk_starts)
    }

    /// Forgets the rays. Walks stay.
    pub fn forget_rays(&mut self) {
        let Records { walks, walk_terms, walk_bins, walk_starts, new_of_walks, .. } = std::mem::take(self);
        *self = Records { walks, walk_terms, walk_bins, walk_starts, new_of_walks, ..Records::default() };
    }

    /// Makes the cells that were looked up for the first time.
    pub fn make_cells(&mut self, grid: &mut CellGrid) {
        self.new.drain(..).for_each(|(place, term)| self.terms[place as usize] = term.of_cell(grid.cell(term.key)));
        let of_walks = self.new_of_walks.drain(..);
        of_walks.for_each(|(place, term)| self.walk_terms[place as usize] = term.of_cell(grid.cell(term.key)));
    }

    /// Light that each of the first `rays` rays brought in lx, from the present light of cells.
    pub fn gathered_lx(&self, cells: &CellLight, rays: usize) -> Vec<f32> {
        let mut gathered_lx: Vec<f32> =
            self.terms[..rays].iter().map(|term| term.factor * cells.value_lx(term.cell)).collect();
        gathered_lx.iter_mut().zip(&self.plain_lx).for_each(|(gathered_lx, plain_lx)| *gathered_lx += plain_lx);
        gathered_lx
    }
}

/// Looks up the cell of a term and adds the term, or records that the cell is new.
#[inline]
pub fn look_up(
    grid: &CellGrid,
    pending: Option<PendingTerm>,
    terms: &mut Vec<Term>,
    new: &mut Vec<(u32, PendingTerm)>,
) {
    let cell = pending.and_then(|term| grid.find(term.key));
    if let (Some(term), None) = (pending, cell) {
        new.push((terms.len() as u32, term));
    }
    terms.push(pending.zip(cell).map_or(Term::NONE, |(term, cell)| term.of_cell(cell)));
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::caches::{CellSample, Lookup, NO_CELL};

    #[test]
    fn a_walk_is_its_first_step_and_the_later_ones() {
        // Three cells of 10, 20 and 40 lx. A first step from the first to the second, and a second step from there to the third.
        let mut cells = CellLight::new(CellGrid::new([DVec3::ZERO, DVec3::splat(8.0)], [0.2, 0.3, 0.4], 0.5));
        let numbers = [10.0, 20.0, 40.0].map(|plain_lx| {
            let point_m = DVec3::X * f64::from(plain_lx) / 10.0;
            let key = cells.grid.key(&Lookup { point_m, normal: DVec3::Z, distance_m: 1.0 }, |_| true);
            let cell = cells.grid.cell(key);
            cells.book(cell);
            cells.add(CellSample { cell, plain_lx, reflectance: 0.0, next: NO_CELL });
            cell
        });
        cells.solve();
        let [one, two, three] = numbers;
        let terms = [(one, -0.8), (two, 0.4), (two, -0.8), (three, 0.4)].map(|(cell, factor)| Term { cell, factor });
        let found = |plain_lx: f32, of_step_lx: f32, count: usize| {
            let record = WalkRecord { plain_lx, plain_of_step_lx: of_step_lx, end: count as u32 };
            record.found_lx(&terms[..count], &cells).map(|lx| (lx * 1e3).round() / 1e3)
        };
        assert_eq!(found(5.0, 3.0, 4), [5.0, 3.0], "-8 + 8, then -16 + 16");
        assert_eq!(found(3.0, 3.0, 2), [3.0, 3.0], "it ends after its first step");
        assert_eq!(found(3.0, 3.0, 1), [-5.0, -5.0], "its ray met no cell");
        assert_eq!(found(0.0, 0.0, 0), [0.0, 0.0], "it met nothing");
    }
}
