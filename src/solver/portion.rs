//! Portions of a run, each with streams of its own, and what a map of a portion leaves for a merge.

use serde::{Deserialize, Serialize};

use super::ends::Ends;
use super::job::Job;
use crate::maps::{CellsError, MapKind, Measured, PartScores, REPLICAS, Tally, Unit};
use crate::sampling::random::{seed_of_receivers_part, seed_of_share};
use crate::scene::ReceiversPart;

/// One of many independent shares of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Share {
    /// Its number, counted from 1. Its random numbers depend on nothing else, so that other shares can join later.
    pub number: u32,
    /// Planned number of shares.
    pub of: u32,
}

impl Share {
    /// A run as a whole.
    pub const WHOLE: Share = Share { number: 1, of: 1 };
}

/// A separately computed portion of a run: a share of the work, a part of the receivers, or a share of the work on a part of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Portion {
    /// The share of the work; `None` is all work that the stop rule requires.
    pub share: Option<Share>,
    /// The part of the receivers; `None` is all of them.
    pub part: Option<ReceiversPart>,
}

impl Portion {
    /// Seed of its streams in a run with this seed. A part without a share has the seed of the first share, so that others can join.
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

/// Data of a share's map, except its sums.
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
    /// Whether the sums of indirect light count packets; otherwise they are sums of scores.
    pub counts_packets: bool,
    /// Whether chains counted its direct light too, because time was short.
    pub counts_direct: bool,
    /// Samples of direct light.
    pub direct_samples: Tally,
    /// Samples of indirect light.
    pub indirect_samples: Tally,
    /// Findings of walks on the cells' error; `None` if nothing gathered.
    pub cells_error: Option<Measured>,
    /// Single scores of direct and of indirect light.
    pub scores: [PartScores; 2],
    /// Ends of its packets for each replica.
    pub ends: [Ends; REPLICAS],
}

/// The sums of a share's map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapSums {
    /// Sums of direct scores, in the unit of the map's quantity, one slab per replica.
    pub direct: Vec<Vec<f64>>,
    /// Sums of indirect scores (in the same unit, or counts of packets), one slab per replica.
    pub indirect: Vec<Vec<f64>>,
    /// Uncertainty of the cells at every element or point, relative to its root mean square; empty if nothing gathered.
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
    /// Whether samples of both maps are of the same kind, so that their sums can be added directly.
    pub fn is_like(&self, other: &MapOfShare) -> bool {
        self.method == other.method
            && self.counts_packets == other.counts_packets
            && self.counts_direct == other.counts_direct
    }

    /// Whether both are of the same map, or of parts of its points, whatever estimated them.
    pub fn is_of_same_map(&self, other: &MapOfShare) -> bool {
        (&self.name, self.kind, self.bound) == (&other.name, other.kind, other.bound)
    }
}

/// What a finished job leaves for a merge.
pub(super) fn sums_of(job: Job) -> (MapOfShare, MapSums) {
    let map = &job.map;
    let counts_packets = matches!(map.indirect_unit, Unit::Packets { .. });
    let about = MapOfShare {
        name: job.name.clone(),
        kind: job.kind,
        bound: job.bound,
        method: job.engine.name().to_owned(),
        entries: map.len(),
        chains: job.chains(),
        rays: job.all_rays(),
        counts_packets,
        // Passes over direct light are far fewer than chains, never equally many.
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
