//! Parts of a scene's receivers, for runs that share them out: every n-th point of each set.
//!
//! Neighbours go to different parts, so that each part is a sample of the whole: its mean, its contrast and its error are those of the set
//! but for chance. Observers of glare and intensities of the far field are told by all their points together: such a set goes to one part.

use serde::{Deserialize, Serialize};

/// One of several parts of the receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ReceiversPart {
    /// Its number, counted from 1.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Default for ReceiversPart {
    fn default() -> ReceiversPart {
        ReceiversPart::WHOLE
    }
}

impl ReceiversPart {
    /// All receivers as one part.
    pub const WHOLE: ReceiversPart = ReceiversPart { number: 1, of: 1 };

    /// Which point of a set that is shared out the `local`-th one of this part is.
    #[inline]
    pub fn nth(self, local: usize) -> usize {
        self.first() + local * self.of as usize
    }

    /// How many of so many points are in this part.
    pub fn count_of(self, points: usize) -> usize {
        (self.first()..points).step_by(self.of as usize).len()
    }

    /// The first point of a set that is in this part.
    pub fn first(self) -> usize {
        self.number as usize - 1
    }
}
