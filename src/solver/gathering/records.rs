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
    /// Start of the ray in its element; empty if elements show no slopes.
    pub starts: Vec<[f32; 2]>,
    /// For every walk, pass by pass: light that it found without cells, in lx, and the number of terms up to its end.
    pub walks: Vec<(f32, u32)>,
    pub walk_terms: Vec<Term>,
    pub walk_bins: Vec<u8>,
    pub walk_starts: Vec<[f32; 2]>,
    /// Positions among the terms of rays, and of walks, whose cells are new.
    pub new: Vec<(u32, PendingTerm)>,
    pub new_of_walks: Vec<(u32, PendingTerm)>,
}

impl Records {
    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        bytes_of_list(&self.terms)
            + bytes_of_list(&self.bins)
            + bytes_of_list(&self.walk_bins)
            + bytes_of_list(&self.plain_lx)
            + bytes_of_list(&self.starts)
            + bytes_of_list(&self.walks)
            + bytes_of_list(&self.walk_terms)
            + bytes_of_list(&self.walk_starts)
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
