//! What a map in the making keeps, part by part: looks at its error, its costs, and what each way of estimating it needs.

use serde::{Deserialize, Serialize};

use super::connecting::Offered;
use super::expected::FIRST_WALKS;
use super::forecast::BeforeCut;
use super::gathering::GatheringGoal;
use crate::control::GatheringGrowth;
use crate::estimators::neighbours::Sharing;
use crate::maps::{History, Judgement, StatisticalCheck};
use crate::solver::adapt::{Adaptive, Cutting, Loss};
use crate::solver::allotment::Allotment;
use crate::solver::coarse::CoarseElements;
use crate::solver::gathering::GatheringProgress;
use crate::solver::local::LocalPlan;
use crate::solver::pace::SliceSizes;
use crate::solver::pilot::PartCost;
use crate::solver::regions::Groups;
use crate::solver::spending::Spending;

/// What looks at the error of its present samples have found.
#[derive(Serialize, Deserialize)]
pub struct Looks {
    /// All judgements.
    pub history: History,
    /// Samples at the latest.
    pub judged_samples: u64,
    /// What is known of the error, and the samples of which it is known: the latest judgement, or one for forecasts
    /// alone since (`Job::judge_for_forecast`).
    pub latest: Option<(Judgement, u64)>,
    /// Scores that carried its variance then, effectively.
    pub latest_scores: f64,
    /// Times its squared error that it would have to bear then for its tail not to hold it up.
    pub latest_tail_spare: f64,
    /// What the statistical checks found when they were last run: they are run again where a run goes on.
    #[serde(skip)]
    pub checks: Vec<StatisticalCheck>,
    /// Samples at which a statistical check first refused the map.
    pub held_since: Option<u64>,
    /// Looks at which the stop rule accepted it and a statistical check refused.
    pub refusals: u64,
    /// Whether the latest was one of them.
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

/// What a sample of either kind of light costs, as pilots measured.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Costs {
    /// Of direct light.
    pub direct: PartCost,
    /// Of indirect light by chains or walks.
    pub indirect: PartCost,
    /// The same of walks from where gathering rays start.
    pub walked: PartCost,
}

/// Rays and seconds so far.
#[derive(Default, Serialize, Deserialize)]
pub struct WorkDone {
    /// Rays traced for the map.
    pub rays: u64,
    /// Rays of the pilots that planned it, beside these.
    pub pilot_rays: u64,
    /// Of its rays, those of direct light since the map began or started anew.
    pub direct_rays: u64,
    /// Of its rays, those whose samples were given up when the map started anew.
    pub given_up_rays: u64,
    /// Rays and seconds by what they were for, those of pilots left out.
    pub spending: Spending,
    /// How large the next slices of work are.
    pub slices: SliceSizes,
}

/// Of elements that adapt, and of others from which walks or rays start.
#[derive(Default, Serialize, Deserialize)]
pub struct AdaptingState {
    /// Share of each that is exposed, where walks or rays start from elements as given: these count as a whole. Else empty.
    pub exposed: Vec<f64>,
    /// What elements that adapt keep beside their sums.
    pub adaptive: Option<Adaptive>,
    /// The first of these in the making, before the run.
    #[serde(skip)]
    pub cutting: Option<Box<Cutting>>,
    /// The elements that gather indirect light for those that adapt.
    pub coarse: Option<CoarseElements>,
    /// What adaptive elements cannot show, by the latest look.
    pub loss: Loss,
    /// Whether they cannot show what the target asks for, and can be cut no further.
    pub finest: bool,
    /// What was known when the map was last begun anew: until the next look that says more than a pilot.
    pub(super) before_cut: Option<BeforeCut>,
}

/// Of a map that walks.
#[derive(Serialize, Deserialize)]
pub struct WalkingState {
    /// Walks of each point in a pass.
    pub allotment: Allotment,
    /// How neighbours share what their walks meet first, and their groups once they have walked.
    pub sharing: Sharing,
    #[serde(skip)]
    pub groups: Option<Groups>,
    /// Walks of a replica from each point before the first look.
    pub first_walks: u64,
    /// How often walks have begun anew.
    pub beginnings: u32,
    /// Work to the target over what even walks would take: what sharing them out has brought, and what it is expected to bring.
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
            beginnings: 0,
            brought: 1.0,
            to_come: 1.0,
        }
    }
}

/// Of a map that gathers.
#[derive(Default, Serialize, Deserialize)]
pub struct GatheringState {
    /// What it has gathered so far.
    pub progress: Option<GatheringProgress>,
    /// How far it is to go before the next look.
    pub goal: GatheringGoal,
    /// What it needs to the target by the latest look, and the rays at that.
    pub growth: Option<(GatheringGrowth, u64)>,
    /// Least and most rays, about, that the plan would take if the look were off.
    pub bounds: Option<[f64; 2]>,
}

/// Of a map by local estimation.
#[derive(Default, Serialize, Deserialize)]
pub struct ConnectingState {
    /// Its rounds, where vertices of chains score.
    pub plan: Option<LocalPlan>,
    /// Local estimation, once it has been weighed after a look.
    #[serde(with = "crate::solver::choice::kept_offer")]
    pub offered: Option<Offered>,
}
