//! The state of a map in progress, part by part: looks at its error, its costs, and what each estimator needs.

use serde::{Deserialize, Serialize};

use super::connecting::Offered;
use super::expected::FIRST_WALKS;
use super::forecast::BeforeCut;
use super::gathering::GatheringGoal;
use super::sharing_out::BetterRays;
use crate::control::GatheringGrowth;
use crate::estimators::neighbours::Sharing;
use crate::maps::{History, Judgement, StatisticalCheck};
use crate::solver::adapt::{Adaptive, Cutting, Loss};
use crate::solver::allotment::{Allotment, Carried};
use crate::solver::coarse::CoarseElements;
use crate::solver::gathering::GatheringProgress;
use crate::solver::local::LocalPlan;
use crate::solver::pace::SliceSizes;
use crate::solver::pilot::PartCost;
use crate::solver::regions::Groups;
use crate::solver::spending::Spending;

/// Findings of the looks (error checks) at its present samples.
#[derive(Serialize, Deserialize)]
pub struct Looks {
    /// All judgements.
    pub history: History,
    /// Samples at the latest judgement.
    pub judged_samples: u64,
    /// The latest known error and the number of samples at which it was found. It comes from the latest judgement, or from a later one made
    /// only for a forecast (`Job::judge_for_forecast`).
    pub latest: Option<(Judgement, u64)>,
    /// Effective number of scores that carried the variance at that time.
    pub latest_scores: f64,
    /// Multiple of its squared error at that time that the map must tolerate so that its tail does not delay acceptance. 1 if no tail is
    /// heavy.
    pub latest_tail_spare: f64,
    /// Findings of the latest statistical checks. They are not stored: a resumed run runs the checks again.
    #[serde(skip)]
    pub checks: Vec<StatisticalCheck>,
    /// Samples at which a statistical check first refused the map.
    pub held_since: Option<u64>,
    /// Number of looks at which the stop rule accepted the map and a statistical check refused it.
    pub refusals: u64,
    /// Whether the latest look was one of them.
    pub refused: bool,
}

impl Default for Looks {
    fn default() -> Looks {
        Looks {
            history: History::default(),
            judged_samples: 0,
            latest: None,
            latest_scores: f64::INFINITY,
            latest_tail_spare: 1.0,
            checks: Vec::new(),
            held_since: None,
            refusals: 0,
            refused: false,
        }
    }
}

/// Cost of a sample of direct light and of indirect light, as measured by pilots.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Costs {
    /// Of direct light.
    pub direct: PartCost,
    /// Of indirect light by chains or walks.
    pub indirect: PartCost,
    /// Of indirect light by walks from where gathering rays start.
    pub walked: PartCost,
}

/// Rays and seconds so far.
#[derive(Default, Serialize, Deserialize)]
pub struct WorkDone {
    /// Rays traced for the map.
    pub rays: u64,
    /// Rays of the pilots that planned it, not included in `rays`.
    pub pilot_rays: u64,
    /// Those of `rays` that were for direct light since the map began or started anew.
    pub direct_rays: u64,
    /// Those of `rays` that are not in the map's samples, because it started anew, or because its samples would take fewer rays now.
    pub given_up_rays: u64,
    /// Rays and seconds by kind of work, without pilots.
    pub spending: Spending,
    /// Sizes of the next slices of work.
    pub slices: SliceSizes,
}

/// State of elements that adapt, and of other elements from which walks or rays start.
#[derive(Default, Serialize, Deserialize)]
pub struct AdaptingState {
    /// Contact-free share of each element, where walks or rays start from the given elements; these count as a whole.
    /// Otherwise empty.
    pub contact_free: Vec<f64>,
    /// Samples of direct light that each given element takes in a pass.
    pub direct_samples: Allotment,
    /// Data that elements that adapt keep beside their sums.
    pub adaptive: Option<Adaptive>,
    /// The first adaptive elements, while they are being cut before the run.
    #[serde(skip)]
    pub cutting: Option<Box<Cutting>>,
    /// Coarse elements that gather indirect light for those that adapt.
    pub coarse: Option<CoarseElements>,
    /// What adaptive elements cannot show, from the latest look.
    pub loss: Loss,
    /// Whether they cannot show what the target requires and cannot be cut further.
    pub finest: bool,
    /// What was known when the map last started anew. It is used until a look gives more than a pilot.
    pub(super) before_cut: Option<BeforeCut>,
}

/// State of a map that walks.
#[derive(Serialize, Deserialize)]
pub struct WalkingState {
    /// Walks from each point in a pass.
    pub allotment: Allotment,
    /// How neighbours share the first hits of their walks, and the groups of neighbours once they have walked.
    pub sharing: Sharing,
    #[serde(skip)]
    pub groups: Option<Groups>,
    /// Walks per replica from each point before the first look.
    pub first_walks: u64,
    /// Walks of earlier allotments.
    pub carried: Carried,
    /// Work to the target relative to even walks: the factor gained by sharing walks out so far, and the factor still expected.
    pub brought: f64,
    pub to_come: f64,
}

impl Default for WalkingState {
    fn default() -> WalkingState {
        WalkingState {
            allotment: Allotment::default(),
            sharing: Sharing::default(),
            groups: None,
            first_walks: FIRST_WALKS,
            carried: Carried::default(),
            brought: 1.0,
            to_come: 1.0,
        }
    }
}

/// State of a map that gathers.
#[derive(Default, Serialize, Deserialize)]
pub struct GatheringState {
    /// What it has gathered so far.
    pub progress: Option<GatheringProgress>,
    /// How far it goes before the next look.
    pub goal: GatheringGoal,
    /// What it needs to the target by the latest look, and the rays at that look.
    pub growth: Option<(GatheringGrowth, u64)>,
    /// Fewest and most rays, approximately, that the plan would take if the look were inaccurate.
    pub bounds: Option<[f64; 2]>,
    /// A better allotment of rays, to be taken before the next ray.
    pub better: Option<BetterRays>,
}

/// State of a map by local estimation.
#[derive(Default, Serialize, Deserialize)]
pub struct ConnectingState {
    /// Its rounds, in which vertices of chains score.
    pub plan: Option<LocalPlan>,
    /// Local estimation, once it has been considered after a look.
    #[serde(with = "crate::solver::choice::kept_offer")]
    pub offered: Option<Offered>,
}
