//! The enclosures of cells without samples: those of the entries that look them up.

use super::{CellSets, GatheringProgress};
use crate::caches::{NO_CELL, NO_ENCLOSURE};

/// What is known of the enclosure of an entry.
#[derive(Clone, Copy)]
enum SeenByEntry {
    Nothing,
    /// A cell in it.
    Cell(u32),
    /// An element on both sides of a wall sees cells of two enclosures.
    Several,
}

impl GatheringProgress {
    /// Puts cells without samples into the enclosure of the entry whose rays or walks looked them up, if there are several enclosures.
    pub(super) fn put_unsampled(&self, sets: &mut CellSets) {
        for (half, cells) in sets.halves.iter_mut().enumerate() {
            let Some(enclosures) = cells.enclosures() else {
                continue;
            };
            let of = |cell: u32| Some(enclosures[cell as usize]).filter(|number| *number != NO_ENCLOSURE);
            let mut seen = vec![SeenByEntry::Nothing; self.order.sites()];
            self.looked_up(half, |entry, cell| {
                if let Some(own) = of(cell) {
                    seen[entry] = match seen[entry] {
                        SeenByEntry::Nothing => SeenByEntry::Cell(cell),
                        SeenByEntry::Cell(known) if of(known) == Some(own) => SeenByEntry::Cell(known),
                        _ => SeenByEntry::Several,
                    };
                }
            });
            self.looked_up(half, |entry, cell| {
                if let (None, SeenByEntry::Cell(known)) = (of(cell), seen[entry])
                    && cells.count(cell) == 0
                {
                    cells.put(cell, known);
                }
            });
        }
    }

    /// Passes each entry of a half and the cells that its rays and walks looked up.
    fn looked_up(&self, half: usize, mut tell: impl FnMut(usize, u32)) {
        for records in self.records.iter().skip(half).step_by(2) {
            let rays = self.order.entries(0..records.terms.len() as u64).zip(&records.terms);
            rays.filter(|(_, term)| term.cell != NO_CELL).for_each(|((_, entry), term)| tell(entry, term.cell));
            let mut first = 0;
            for ((_, entry), walk) in self.walks.entries(0..records.walks.len() as u64).zip(&records.walks) {
                let terms = &records.walk_terms[first as usize..walk.end as usize];
                terms.iter().for_each(|term| tell(entry, term.cell));
                first = walk.end;
            }
        }
    }
}
