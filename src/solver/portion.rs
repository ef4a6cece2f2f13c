//! Portions of a run, each with streams of its own, and what a map of one leaves for a merge.

use serde::{Deserialize, Serialize};

use super::ends::Ends;
use super::job::Job;
use crate::maps::{CellsError, MapKind, Measured, PartScores, REPLICAS, Tally, Unit};
use crate::sampling::random::{seed_of_receivers_part, seed_of_share};
use crate::scene::ReceiversPart;

/// One of many independent shares of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Share {
    /// Its number, counted from 1. What it draws depends on nothing else, so that others can join later.
    pub number: u32,
    /// How many there are to be.
    pub of: u32,
}

impl Share {
    /// A run as a whole.
    pub const WHOLE: Share = Share { number: 1, of: 1 };
}

/// What of a run is computed by itself: a share of the work, a part of the receivers, or a share of the work on a part of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Portion {
    /// Which share of the work; without one, all that the stop rule asks for.
    pub share: Option<Share>,
    /// Which part of the receivers; without one, all of them.
    pub part: Option<ReceiversPart>,
}

impl Portion {
    /// Seed of its streams in a run with this seed. A part without a share is that of the first one, so that others can join.
    pub fn seed(self, seed: u64) -> u64 {
        match (self.share, self.part) {
            (None, None) => seed,
            (Some(share), None) => seed_of_share(seed, share.number),
            (share, Some(part)) => {
                seed_of_receivers_part(seed_of_share(seed, share.unwrap_or(Share::WHOLE).number), part.number)
            }
        }
    }
}

impl From<Share> for Portion {
    fn from(share: Share) -> Portion {
        Portion { share: Some(share), part: None }
    }
}

impl From<ReceiversPart> for Portion {
    fn from(part: ReceiversPart) -> Portion {
        Portion { share: None, part: Some(part) }
    }
}

/// What a share says of a map beside its sums.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MapOfShare {
    /// `elements`, or the receiver set's name.
    pub name: String,
    /// Elements or a receiver set.
    pub kind: MapKind,
    /// Whether the target binds it.
    pub bound: bool,
    /// Name of the estimator of its indirect light.
    pub method: String,
    /// Elements or points.
    pub entries: usize,
    /// Chains spent on it.
    pub chains: u64,
    /// Rays traced for it.
    pub rays: u64,
    /// Whether the sums of indirect light count packets; else they are in lx.
    pub counts_packets: bool,
    /// Whether chains counted its direct light too, for want of time.
    pub counts_direct: bool,
    /// Samples of direct light.
    pub direct_samples: Tally,
    /// Samples of indirect light.
    pub indirect_samples: Tally,
    /// What walks say of the cells' error; nothing where nothing gathered.
    pub cells_error: Option<Measured>,
    /// Single scores of direct and of indirect light.
    pub scores: [PartScores; 2],
    /// How its packets ended, replica by replica.
    pub ends: [Ends; REPLICAS],
}

/// The sums of a share's map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapSums {
    /// One slab a replica: sums of direct scores in lx.
    pub direct: Vec<Vec<f64>>,
    /// One slab a replica: sums of indirect scores (lx, or counts of packets).
    pub indirect: Vec<Vec<f64>>,
    /// How unsure the cells are at every element or point, over their root mean square; empty where nothing gathered.
    pub cells_profile: Vec<f64>,
}

impl MapSums {
    /// Whether all replicas are equal.
    pub(super) fn are_without_chance(&self) -> bool {
        let are_equal = |slabs: &[Vec<f64>]| slabs.windows(2).all(|pair| pair[0] == pair[1]);
        are_equal(&self.direct) && are_equal(&self.indirect)
    }
}

impl MapOfShare {
    /// Whether samples of both maps are of one kind, so that their sums may be added as they are.
    pub fn is_like(&self, other: &MapOfShare) -> bool {
        self.method == other.method
            && self.counts_packets == other.counts_packets
            && self.counts_direct == other.counts_direct
    }

    /// Whether both are of one map, or of parts of its points, whatever estimated them.
    pub fn is_of_same_map(&self, other: &MapOfShare) -> bool {
        (&self.name, self.kind, self.bound) == (&other.name, other.kind, other.bound)
    }
}

/// What a finished job leaves for a merge.
pub(super) fn sums_of(job: Job) -> (MapOfShare, MapSums) {
    let map = &job.map;
    let counts_packets = matches!(map.indirect_unit_lx, Unit::Packets { .. });
    let about = MapOfShare {
        name: job.name.clone(),
        kind: job.kind,
        bound: job.bound,
        method: job.engine.name().to_owned(),
        entries: map.len(),
        chains: job.chains(),
        rays: job.all_rays(),
        counts_packets,
        // Passes over direct light are far fewer than chains, and never as many.
        counts_direct: counts_packets && !job.is_black() && map.direct_samples == map.indirect_samples,
        direct_samples: map.direct_samples,
        indirect_samples: map.indirect_samples,
        cells_error: map.cells_error.as_ref().map(|error| error.measured),
        scores: map.scores.clone(),
        ends: job.ends,
    };
    let cells_profile = map.cells_error.as_ref().map_or_else(Vec::new, CellsError::profile);
    (about, MapSums { direct: job.map.direct, indirect: job.map.indirect, cells_profile })
}
