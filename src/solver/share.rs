//! Shares of a run, and runs that share out its receivers: each has streams of its own, and leaves behind what a merge needs.

use serde::{Deserialize, Serialize};

use super::portion::{MapOfShare, MapSums, Portion};
use super::run::{GoingOn, Observer, solve_as};
use super::spending::Spending;
use super::{Settings, Solution};
use crate::maps::MapKind;
use crate::scene::{ReceiversPart, Scene};

/// What a share did.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ShareRecord {
    /// Chains traced, all maps.
    pub chains: u64,
    /// Rays traced, all kinds.
    pub rays: u64,
    /// Seconds of computing.
    pub compute_s: f64,
    /// Rays and seconds by what they were for.
    pub spending: Spending,
    /// Whether chance has no part in its maps, so that all shares tell the same.
    pub is_exact: bool,
    /// Which receivers it has.
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

    /// Of a share that has ended.
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

/// Solves one of many independent shares of a run, and tells what a merge needs: what it did, and the sums of its maps.
///
/// Chains or a time limit say how much of the work a share is; the target is that of the merged maps, for which it plans. A part of the
/// receivers that is no share goes on to the target, as a run of its own. The scene has no others than those of the part.
pub fn solve_share(
    scene: &Scene,
    settings: &Settings,
    portion: impl Into<Portion>,
    observer: &dyn Observer,
) -> (Solution, ShareRecord, Vec<MapSums>) {
    let portion = portion.into();
    told(portion, solve_as(scene, settings, Some(portion), None, observer))
}

/// Goes on with a share from where it was kept.
pub fn resume_share(
    scene: &Scene,
    settings: &Settings,
    portion: Portion,
    going_on: GoingOn,
    observer: &dyn Observer,
) -> (Solution, ShareRecord, Vec<MapSums>) {
    told(portion, solve_as(scene, settings, Some(portion), Some(going_on), observer))
}

/// What a share tells once it has ended.
fn told(
    portion: Portion,
    (solution, maps): (Solution, Vec<(MapOfShare, MapSums)>),
) -> (Solution, ShareRecord, Vec<MapSums>) {
    let (maps, sums): (Vec<MapOfShare>, Vec<MapSums>) = maps.into_iter().unzip();
    let record = ShareRecord::of(&solution, portion, maps, sums.iter().all(MapSums::are_without_chance));
    (solution, record, sums)
}
