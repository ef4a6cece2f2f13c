//! Shares of a run, and runs that share out its receivers. Each has streams of its own and leaves what a merge needs.

use serde::{Deserialize, Serialize};

use super::portion::{MapOfShare, MapSums, Portion};
use super::run::{GoingOn, Observer, solve_as};
use super::spending::Spending;
use super::{Settings, Solution};
use crate::maps::MapKind;
use crate::scene::{ReceiversPart, Scene};

/// Record of what a share did.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ShareRecord {
    /// Chains traced, all maps.
    pub chains: u64,
    /// Rays traced, all kinds.
    pub rays: u64,
    /// Seconds of computing.
    pub compute_s: f64,
    /// Rays and seconds by kind of work.
    pub spending: Spending,
    /// Whether its maps have no random error, so that all shares are equal.
    pub is_exact: bool,
    /// The part of the receivers that it has.
    #[serde(default)]
    pub part: ReceiversPart,
    /// Its maps: elements first, then receivers in file order.
    pub maps: Vec<MapOfShare>,
}

impl ShareRecord {
    /// Its map of this kind, if it has one.
    pub fn map(&self, kind: MapKind) -> Option<&MapOfShare> {
        self.maps.iter().find(|map| map.kind == kind)
    }

    /// Record of a share that has ended.
    fn of(solution: &Solution, portion: Portion, maps: Vec<MapOfShare>, is_exact: bool) -> ShareRecord {
        ShareRecord {
            chains: solution.chains,
            rays: solution.rays,
            compute_s: solution.compute_s,
            spending: solution.spending,
            is_exact,
            part: portion.part.unwrap_or(ReceiversPart::WHOLE),
            maps,
        }
    }
}

/// Solves one of many independent shares of a run. Returns its solution and what a merge needs: a record of what it did, and the sums of
/// its maps.
/// Chains or a time limit determine how much of the work a share is. The target is that of the merged maps, for which it plans. A part of
/// the receivers without a share goes on to the target, as a run of its own. The scene must have only the receivers of the part.
pub fn solve_share(
    scene: &Scene,
    settings: &Settings,
    portion: impl Into<Portion>,
    observer: &dyn Observer,
) -> (Solution, ShareRecord, Vec<MapSums>) {
    let portion = portion.into();
    as_share(portion, solve_as(scene, settings, Some(portion), None, observer))
}

/// Resumes a stored share.
pub fn resume_share(
    scene: &Scene,
    settings: &Settings,
    portion: Portion,
    going_on: GoingOn,
    observer: &dyn Observer,
) -> (Solution, ShareRecord, Vec<MapSums>) {
    as_share(portion, solve_as(scene, settings, Some(portion), Some(going_on), observer))
}

/// The results of a share once it has ended.
fn as_share(
    portion: Portion,
    (solution, maps): (Solution, Vec<(MapOfShare, MapSums)>),
) -> (Solution, ShareRecord, Vec<MapSums>) {
    let (maps, sums): (Vec<MapOfShare>, Vec<MapSums>) = maps.into_iter().unzip();
    let record = ShareRecord::of(&solution, portion, maps, sums.iter().all(MapSums::are_without_chance));
    (solution, record, sums)
}
