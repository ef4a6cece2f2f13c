//! A job whose rays ask cells: how it begins, goes forward, is summed up, and what it needs next.

use super::{Context, Engine, Job, RAYS_PER_SLICE, element_map};
use crate::control::{CellGrowth, CellParts};
use crate::maps::{MapKind, REPLICAS, Residuals, Unit};
use crate::solver::cells::{Asker, CellAsks, CellSets};

/// Rays of an entry in each replica, walks, and rays that fill, with which a map begins that goes for an error of 1%.
const FIRST_PASSES: f64 = 6.0;
const FIRST_WALKS: f64 = 4.0;
const FIRST_FILLS: f64 = 2.0;
/// Rays, about, that a ray takes which fills cells, and that a walk takes.
const RAYS_OF_A_FILL: f64 = 5.0;
const RAYS_OF_A_WALK: f64 = 5.0;
/// Samples that a cell takes at most, over the passes that fill cells.
const SAMPLES_OF_A_FILL: u64 = 4;
const MOST_SAMPLES: u64 = 4096;
/// Share of the squared error that direct light may have at the first look, and its passes until then, at most.
const DIRECT_SHARE: f64 = 0.3;
const MOST_DIRECT: u64 = 64;
/// A kind of work grows by this factor at most from one look to the next, and by this one at least where it grows at all.
const MOST_GROWTH: f64 = 4.0;
const LEAST_GROWTH: f64 = 1.1;
/// Share of the squared error that cells have at least.
const LEAST_CELLS: f64 = 0.05;

/// How far a map whose rays ask cells is to go before it is judged, in passes over its entries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellGoal {
    /// Of direct light.
    pub direct: u64,
    /// Of rays that fill cells.
    pub fills: u64,
    /// Of rays that ask cells.
    pub rays: u64,
    /// Of residual walks.
    pub walks: u64,
}

fn asker_of<'a>(context: &'a Context<'a>, job_kind: MapKind, elements: &'a crate::scene::Elements) -> Asker<'a> {
    Asker { context, kind: job_kind, elements }
}

impl Job {
    /// Whether cells can tell all light of the map: not of what an eye sees, nor of light that only chains find on elements.
    pub fn can_ask_cells(&self, context: &Context) -> bool {
        let finds_all = self.kind != MapKind::Elements || context.stage.paths_not_found.is_empty();
        let counts = self.weights.iter().any(|weight| *weight > 0.0);
        finds_all && counts && self.adaptive.is_none() && !self.black && !self.is_luminance(context)
    }

    /// Begins to ask cells, for an error or with as many rays as a number of chains.
    pub fn start_asking(&mut self, context: &Context, error: f64, chains: Option<u64>) {
        let finer = (0.01 / error).sqrt();
        let mean_lx = self.mean_without_gathering_lx();
        let squared_lx2 = DIRECT_SHARE * (error * mean_lx).powi(2) * REPLICAS as f64;
        let direct = (self.direct.variance / squared_lx2.max(f64::MIN_POSITIVE)).ceil() as u64;
        let (fills, rays, walks) = match chains {
            Some(chains) => {
                let rays = chains.div_ceil((REPLICAS * self.map.len().max(1)) as u64).max(1);
                (rays.div_ceil(8), rays, rays.div_ceil(4))
            }
            None => {
                let passes = |usual: f64, most: f64| (usual * finer).round().clamp(1.0, most) as u64;
                (passes(FIRST_FILLS, 16.0), passes(FIRST_PASSES, 64.0).max(2), passes(FIRST_WALKS, 16.0))
            }
        };
        self.cell_goal = CellGoal { direct: direct.clamp(1, MOST_DIRECT), fills, rays, walks };
        self.map.indirect_unit_lx = Unit::Lux;
        let asker = asker_of(context, self.kind, &self.elements);
        self.map.residuals = Some(Residuals::new(CellAsks::regions_of(&asker, self.map.len())));
        self.asks = Some(CellAsks::new(&asker, self.map.len()));
        self.engine = Engine::Cells;
    }

    /// A slice on the way to the goal; whether it is there.
    pub(super) fn ask_cells(&mut self, context: &Context, sets: &mut CellSets) -> bool {
        let goal = self.cell_goal;
        let asker = asker_of(context, self.kind, &self.elements);
        let Some(asks) = &mut self.asks else {
            return true;
        };
        let per_replica = |rays: f64| (RAYS_PER_SLICE / (rays * REPLICAS as f64)) as u64;
        let [fills, rays, _] = asks.passes();
        sets.most_samples = sets.most_samples.max((SAMPLES_OF_A_FILL * goal.fills).min(MOST_SAMPLES) as u16);
        self.rays += if fills < goal.fills {
            asks.fill(&asker, sets, goal.fills, per_replica(RAYS_OF_A_FILL))
        } else if rays < goal.rays {
            asks.ask(&asker, sets, goal.rays, per_replica(1.0))
        } else if !asks.has_walked(goal.walks) {
            asks.walk(&asker, sets, goal.walks, per_replica(RAYS_OF_A_WALK))
        } else {
            0
        };
        let [fills, rays, _] = asks.passes();
        fills >= goal.fills && rays >= goal.rays && asks.has_walked(goal.walks)
    }

    /// Whether walks have passed over all entries at least once, so that the map's bias is known.
    pub fn knows_its_bias(&self) -> bool {
        self.asks.as_ref().is_none_or(|asks| asks.passes().iter().all(|passes| *passes > 0))
    }

    /// Goes over to walks or counting; direct light stays as far as it is.
    pub fn stop_asking(&mut self, context: &Context) {
        self.asks = None;
        self.cell_growth = None;
        self.map.residuals = None;
        self.stop_gathering();
        if self.kind == MapKind::Elements {
            self.map.indirect_unit_lx = element_map(context, &self.elements, None).0.indirect_unit_lx;
        }
    }

    /// Sums up what cells told, to be judged and read.
    pub fn settle_cells(&mut self, sets: Option<&mut CellSets>) {
        if let (Some(sets), Some(asks)) = (sets, &mut self.asks) {
            asks.settle(sets, &mut self.map, &self.weights);
            self.samples = asks.passes()[1];
        }
    }

    /// What the latest look has shown of a map that asks cells.
    fn cell_parts(&self) -> Option<CellParts> {
        let asks = self.asks.as_ref()?;
        let mean_lx = self.judgement.mean_lx;
        let residuals = self.map.residuals.as_ref()?.state();
        let all_lx2 = (self.judgement.expected_error * mean_lx).powi(2);
        let direct_lx2 = self.direct_variance / REPLICAS as f64;
        let walks_lx2 = residuals.correction_variance / REPLICAS as f64;
        let rays_lx2 = asks.ray_squared_lx2;
        let cells_lx2 = (all_lx2 - direct_lx2 - walks_lx2 - rays_lx2).max(LEAST_CELLS * all_lx2);
        let [rays, fills, walks] = asks.rays.map(|rays| rays as f64);
        let direct = self.rays as f64 - (rays + fills + walks);
        Some(CellParts {
            squared_lx2: [direct_lx2, rays_lx2, cells_lx2, walks_lx2],
            rays: [direct.max(1.0), rays, fills, walks],
            residuals,
            degrees_of_freedom: self.judgement.degrees_of_freedom,
        })
    }

    /// Plans the way to a target by the latest look, and sets the next goal; without a target all work doubles.
    pub fn plan_cells(&mut self, target: Option<f64>) {
        let Some(parts) = self.cell_parts() else {
            return;
        };
        let growth = match target.filter(|_| !self.refused && self.judgement.mean_lx > 0.0) {
            Some(target) => parts.growth(target * self.judgement.mean_lx),
            None => CellGrowth { factors: [2.0; 4], all_walk: true, rays: parts.rays.iter().sum(), reaches: false },
        };
        self.cell_growth = Some(growth);
        let more = |now: u64, factor: f64| {
            let factor = factor.min(MOST_GROWTH);
            if factor < LEAST_GROWTH { now } else { ((now as f64 * factor).ceil() as u64).max(now + 1) }
        };
        if growth.all_walk
            && let Some(asks) = &mut self.asks
        {
            asks.walk_from_all();
        }
        let now = self.cell_goal;
        let [direct, rays, fills, walks] = growth.factors;
        let goal = CellGoal {
            direct: more(now.direct, direct),
            fills: more(now.fills, fills),
            rays: more(now.rays, rays),
            walks: more(now.walks, walks),
        };
        // Where the prediction was met and the judgement was not, a little more of everything.
        let eighth = |now: u64| now + now.div_ceil(8);
        self.cell_goal = if goal == now {
            CellGoal {
                direct: eighth(now.direct),
                fills: eighth(now.fills),
                rays: eighth(now.rays),
                walks: eighth(now.walks),
            }
        } else {
            goal
        };
        self.next_judgement = self.cell_goal.rays;
    }
}
