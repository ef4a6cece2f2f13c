//! What rays and walks found, kept as numbers of cells until their light is known.

use serde::{Deserialize, Serialize};

use crate::base::memory::bytes_of_list;
use crate::caches::{CellGrid, CellLight};
use crate::estimators::cells::{Question, Term};

/// What the rays and walks of one replica of a map found.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Records {
    /// Of every ray, pass by pass: the cell that it asked.
    pub terms: Vec<Term>,
    /// Bin of the direction into which it went.
    pub bins: Vec<u8>,
    /// What it found beside, in lx.
    pub plain_lx: Vec<f32>,
    /// Where in its element it began; empty where elements show no slopes.
    pub starts: Vec<[f32; 2]>,
    /// Of every walk, pass by pass: what it found beside cells, in lx, and the number of terms up to its end.
    pub walks: Vec<(f32, u32)>,
    pub walk_terms: Vec<Term>,
    pub walk_bins: Vec<u8>,
    pub walk_starts: Vec<[f32; 2]>,
    /// Places among the terms of rays, and of walks, whose cells are new.
    pub new: Vec<(u32, Question)>,
    pub new_of_walks: Vec<(u32, Question)>,
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

    /// Makes the cells that were asked for the first time.
    pub fn make_cells(&mut self, grid: &mut CellGrid) {
        self.new.drain(..).for_each(|(place, asks)| self.terms[place as usize] = asks.term(grid.cell(asks.key)));
        let of_walks = self.new_of_walks.drain(..);
        of_walks.for_each(|(place, asks)| self.walk_terms[place as usize] = asks.term(grid.cell(asks.key)));
    }

    /// What each of the first rays brought, by the light that cells have now, in lx.
    pub fn told_lx(&self, cells: &CellLight, rays: usize) -> Vec<f32> {
        let mut told: Vec<f32> =
            self.terms[..rays].iter().map(|term| term.factor * cells.value_lx(term.cell)).collect();
        told.iter_mut().zip(&self.plain_lx).for_each(|(told, plain_lx)| *told += plain_lx);
        told
    }
}

/// Adds the term of a question, or notes that its cell is new.
#[inline]
pub fn look_up(grid: &CellGrid, question: Option<Question>, terms: &mut Vec<Term>, new: &mut Vec<(u32, Question)>) {
    let cell = question.and_then(|question| grid.find(question.key));
    if let (Some(question), None) = (question, cell) {
        new.push((terms.len() as u32, question));
    }
    terms.push(question.zip(cell).map_or(Term::NONE, |(question, cell)| question.term(cell)));
}
