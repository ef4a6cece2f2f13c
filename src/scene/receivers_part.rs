//! Parts of a scene's receivers, for runs that share the points: every n-th point of each set.
//!
//! Neighbours go to different parts, so each part is a sample of the whole. Its mean, contrast and error differ from those of the set
//! only by chance. Observers of glare and intensities of the far field need all their points together. Such a set goes to one part as a
//! whole.

use serde::{Deserialize, Serialize};

/// One of several parts of the receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ReceiversPart {
    /// Its number, counted from 1.
    pub number: u32,
    /// Number of parts.
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

    /// Index in the whole set of the `local`-th point of this part.
    #[inline]
    pub fn nth(self, local: usize) -> usize {
        self.first() + local * self.of as usize
    }

    /// Number of points in this part, for a set of `points` points.
    pub fn count_of(self, points: usize) -> usize {
        (self.first()..points).step_by(self.of as usize).len()
    }

    /// Index of the first point of a set that is in this part.
    pub fn first(self) -> usize {
        self.number as usize - 1
    }
}
