//! Jobs that shares have done: their sums are added, and judged like those of any other.

use super::{CellGoal, DirectShare, Ends, ErrorHistory, Expectations, History, Judgement, Loss, PartCost, Spending};
use super::{Context, Engine, Job, PACKETS_OF_A_BOUND, REPLICAS};
use crate::control::accepts;
use crate::maps::{MapKind, PastJudgement, ReplicaMap, Unit, judge};
use crate::scene::Elements;
use crate::solver::local::Kernel;

impl Engine {
    /// The engine of this name; where shares had several, the unbiased one of the map.
    pub fn named(name: Option<&str>, kind: MapKind, method: crate::solver::Method) -> Engine {
        let unbiased = Engine::unbiased(kind, method);
        let all = [
            Engine::Gathering,
            Engine::Walking,
            Engine::Connecting(Kernel::Bounded),
            Engine::Connecting(Kernel::Naive),
        ];
        all.into_iter().find(|engine| Some(engine.name()) == name).unwrap_or(unbiased)
    }
}

impl Job {
    /// A job whose sums are yet to come: no pilot, no plan.
    pub fn to_merge(context: &Context, kind: MapKind, bound: bool, engine: Engine, counts_packets: bool) -> Job {
        let (mut map, weights, elements) = match kind {
            MapKind::Elements => {
                let (map, weights) = super::element_map(context, &context.stage.elements, None);
                (map, weights, context.stage.elements.clone())
            }
            MapKind::Receivers(set) => {
                let points = &context.scene.receivers[set].points;
                let weights = points.iter().map(|point| if point.inside { 0.0 } else { point.weight }).collect();
                (ReplicaMap::new(points.len(), Unit::Lux), weights, Elements::default())
            }
        };
        if !counts_packets {
            map.indirect_unit_lx = Unit::Lux;
        }
        Job {
            name: kind.name(context.scene).to_owned(),
            kind,
            elements,
            adaptive: None,
            broad: None,
            map,
            weights,
            bound,
            met: false,
            finest: false,
            before_cut: None,
            samples: 0,
            next_judgement: 0,
            rays: 0,
            pilot_rays: 0,
            direct_rays: 0,
            offered: None,
            given_up_rays: 0,
            spending: Spending::default(),
            ends: [Ends::default(); REPLICAS],
            judgement: Judgement::default(),
            history: History::default(),
            checks: Vec::new(),
            held_since: None,
            refusals: 0,
            refused: false,
            engine,
            method_reason: String::new(),
            direct_variance: 0.0,
            asks: None,
            cell_goal: CellGoal::default(),
            cell_growth: None,
            plan_bounds: None,
            judged_samples: 0,
            seen: None,
            pace: ErrorHistory::default(),
            direct: PartCost::default(),
            indirect: PartCost::default(),
            walked: PartCost::default(),
            share: DirectShare::default(),
            expectations: Expectations::default(),
            guide: None,
            loss: Loss::default(),
            local: None,
            black: !context.stage.reflects(),
        }
    }

    /// Judges sums that so many chains have made. Shares know nothing of each other, so that the looks after each are a history.
    pub fn judge_merged(&mut self, context: &Context, chains: u64) {
        let map = &self.map;
        self.samples = if self.black { map.direct_samples.complete } else { map.indirect_samples.complete };
        self.judged_samples = self.samples;
        self.judgement = judge(map, self.weights.iter().copied().enumerate());
        if self.judgement.unseen && !self.judgement.dark && self.engine != Engine::Gathering {
            let bound = PACKETS_OF_A_BOUND / chains.max(1) as f64 * self.flux_over_map(context);
            self.judgement.halves_error = self.judgement.halves_error.max(bound);
            self.judgement.expected_error = self.judgement.expected_error.max(bound);
            self.judgement.unseen = false;
        }
        self.history.add(PastJudgement {
            samples: self.samples,
            rays: self.rays,
            squared_error: (self.judgement.expected_error * self.judgement.mean_lx).powi(2),
            degrees_of_freedom: self.judgement.degrees_of_freedom,
            means_lx: self.judgement.means_lx,
        });
    }

    /// Holds merged sums against the target, and against the statistical checks.
    pub fn settle_merged(&mut self, target_error: Option<f64>) {
        let passes = self.passes_checks(target_error);
        let accepted = target_error.is_some_and(|target| accepts(target, &self.judgement));
        self.met = accepted && passes;
        self.refused = accepted && !passes;
        self.refusals = u64::from(self.refused);
    }
}
