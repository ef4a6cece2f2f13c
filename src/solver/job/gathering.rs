//! Jobs that gather: how they begin, go forward and are summed up, and what they need next.

use serde::{Deserialize, Serialize};

use super::{Engine, Job, Method};
use crate::control::{GatheringGrowth, GatheringParts, KINDS};
use crate::maps::{MapKind, REPLICAS, ReplicaMap, Residuals, Unit};
use crate::scene::Elements;
use crate::solver::adapt::{Adaptive, slope_from_m};
use crate::solver::allotment::Allotment;
use crate::solver::coarse::CoarseElements;
use crate::solver::context::Context;
use crate::solver::empty_maps::{element_map, element_weights_m2, numbers_per_site};
use crate::solver::gathering::{CellSets, Gatherer, GatheringProgress, ray_squared_lx2};
use crate::solver::pilot::{DirectShare, walk_cost_in_elements};
use crate::solver::regions::regions_of;
use crate::solver::spending::Activity;
use crate::solver::starts::Starts;

/// Rays of all replicas before the first look, and the fewest and most passes over the entries that they make.
const FIRST_RAYS: u64 = 400_000;
pub(super) const LEAST_PASSES: u64 = 2;
const MOST_PASSES: u64 = 6;
/// Rays of a half that fill cells, per entry, before the first look for an error of 1 % or less; the most of them in a half; and walks of
/// each entry that walks.
const FIRST_FILLS: u64 = 4;
const MOST_FILLS: u64 = 1 << 20;
const ERROR_OF_FIRST_FILLS: f64 = 0.01;
const WALKS_OF_A_WALKER: u64 = 4;
/// Error for which a map that the target does not bind takes its first look, at least: it is only shown.
const ERROR_OF_UNBOUND: f64 = 0.05;
/// Most entries that walk at first: with equally many walks, a thousand entries would determine the mean square half as well. Fewer entries
/// walk if walks are so long that they would take more rays than all other work.
const FIRST_WALKERS: f64 = 256.0;
const LEAST_WALKERS: f64 = 16.0;
/// Ratio of the walks of one entry that determine its bias well enough to those that determine its illuminance; and rays of all kinds per
/// gathering ray. Measured in six rooms of the proving ground.
const WALKS_OF_AN_ENTRY: f64 = 0.4;
const RAYS_OF_A_RAY: f64 = 1.0;
/// Work of a gathering ray relative to a ray of a walk. It looks cells up, which are solved and judged at every look. Measured in eleven
/// kinds of rooms: 1.2 to 2. With 1.0 to 1.3 `auto` takes as long in the mean (eleven rooms to 1 %), and longer in furnished rooms.
const WORK_OF_A_GATHERING_RAY: f64 = 1.6;
/// Approximate rays for one ray that fills cells, and for one walk.
const RAYS_OF_A_FILL: f64 = 5.0;
const RAYS_OF_A_WALK: f64 = 5.0;
/// Most samples of a cell, relative to the rays per entry that fill cells; and an upper limit for them.
const SAMPLES_OF_A_FILL: u64 = 4;
const MOST_SAMPLES: u64 = 4096;
/// A first look at cells is taken in any case if it takes up to this share of the work without cells. The work by cells then counts as at
/// most the second share.
pub const SHARE_OF_A_LOOK: f64 = 0.1;
const WORTH_A_LOOK: f64 = 0.99;
/// Share of the squared error that direct light may have at the first look, if few passes achieve it.
const DIRECT_SHARE: f64 = 0.3;
/// A kind of work grows by at most the first factor from one look to the next. If it grows at all, it grows by at least the second factor.
const MOST_GROWTH: f64 = 4.0;
const LEAST_GROWTH: f64 = 1.1;

/// Number of coarse elements that gather for elements that adapt: at first at an error of 1 %, and at least.
const COARSE_AT_ONE_PERCENT: f64 = 200.0;
const FEWEST_COARSE: f64 = 128.0;
/// Smallest share of the squared target that is planned for random error, however much elements cannot show.
const LEAST_SHARE_OF_CHANCE: f64 = 0.2;

/// How far a map that gathers goes before it is judged, in passes over its entries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GatheringGoal {
    /// Passes of direct light.
    pub direct: u64,
    /// Rays of a half that fill cells. This is a number of rays, not of passes, since a part of the entries may be enough.
    pub fills: u64,
    /// Passes of gathering rays.
    pub rays: u64,
    /// Passes of residual walks.
    pub walks: u64,
}

/// What gathers: the elements or points of a map, or the coarse elements that gather for those that adapt.
fn gatherer_of<'a>(
    context: &'a Context<'a>,
    kind: MapKind,
    given: (&'a Elements, &'a [f64]),
    coarse: Option<&'a CoarseElements>,
) -> Gatherer<'a> {
    Gatherer { starts: starts_of(context, kind, given, coarse), slopes: coarse.is_some() }
}

/// Where rays and walks start: in the elements or points of a map, or in the coarse elements that gather for those that adapt.
pub(super) fn starts_of<'a>(
    context: &'a Context<'a>,
    kind: MapKind,
    (elements, contact_free): (&'a Elements, &'a [f64]),
    coarse: Option<&'a CoarseElements>,
) -> Starts<'a> {
    let given = Starts { context, kind, elements, contact_free, as_wholes: true, number: kind.number() };
    match coarse {
        Some(CoarseElements { elements, contact_free, shape, .. }) => {
            Starts { elements, contact_free, as_wholes: false, number: shape.stream_number(), ..given }
        }
        None => given,
    }
}

/// The kind of work that comes next on the way to a goal.
fn next_of(progress: &GatheringProgress, goal: &GatheringGoal) -> Option<Activity> {
    if progress.filled() < goal.fills {
        Some(Activity::Cells)
    } else if progress.passes() < goal.rays {
        Some(Activity::Gathering)
    } else {
        (!progress.has_walked(goal.walks)).then_some(Activity::ResidualWalks)
    }
}

impl Job {
    /// Whether cells can give all light of the map. They cannot give what an eye sees, nor light on elements that only chains find.
    pub fn can_gather(&self, context: &Context) -> bool {
        let finds_all = self.kind != MapKind::Elements || context.world.paths_not_found.is_empty();
        let counts = self.weights.iter().any(|weight| *weight > 0.0);
        finds_all && counts && !self.black && !self.is_seen(context)
    }

    /// Whether cells can give the light of the map, and its pilot found light.
    pub fn has_light_to_gather(&self, context: &Context) -> bool {
        self.can_gather(context) && self.mean_without_gathering() > 0.0
    }

    /// Prepares gathering for a target error: elements that adapt get coarse ones, and a pilot measures walks from elements.
    pub fn prepare_gathering(&mut self, context: &Context, error: f64) {
        // Before elements are cut, no contact occlusion is known. This is enough for a forecast.
        let contact_free = vec![1.0; if self.is_to_be_cut() { self.elements.len() } else { 0 }];
        let adapts_to = match &self.adapting.adaptive {
            Some(adaptive) => Some((adaptive.target_error(), &adaptive.contact_free)),
            None => self.is_to_be_cut().then_some((context.target_error, &contact_free)),
        };
        if let Some((target_error, contact_free)) = adapts_to {
            let elements = (COARSE_AT_ONE_PERCENT * 0.01 / error).max(FEWEST_COARSE);
            let edge_m = (2.0 * context.world.area_m2 / elements).sqrt();
            let edges_m = [edge_m, slope_from_m(context, target_error)];
            self.adapting.coarse =
                Some(CoarseElements::first(context, &self.elements, contact_free, edges_m, self.costs.indirect.mean));
        }
        if self.kind == MapKind::Elements {
            let coarse = self.adapting.coarse.as_ref();
            let (elements, contact_free) =
                coarse.map_or((&self.elements, &[][..]), |coarse| (&coarse.elements, &coarse.contact_free));
            let numbers = numbers_per_site(self.gathered_weights(), self.gathered().len());
            self.costs.walked = walk_cost_in_elements(context, elements, contact_free).times(numbers);
            self.work.pilot_rays += self.costs.walked.pilot_rays;
        }
    }

    /// Rays of a walk, as counted by the pilot.
    pub fn rays_of_a_walk(&self) -> f64 {
        self.costs.walked.rays
    }

    /// The map that holds its indirect light: its own, or that of coarse elements.
    pub fn gathered(&self) -> &ReplicaMap {
        self.adapting.coarse.as_ref().map_or(&self.map, |coarse| &coarse.map)
    }

    /// Areas or weights of all entries of [`Job::gathered`].
    pub(super) fn gathered_weights(&self) -> &[f64] {
        self.adapting.coarse.as_ref().map_or(&self.weights, |coarse| &coarse.weights_m2)
    }

    /// Work by cells to an error, in rays, from what the pilot measured of walks.
    ///
    /// A gathering ray has about the variance of a walk; `RAYS_OF_A_RAY` includes the rays that fill cells. Walks must measure the bias to a
    /// share of the squared error: over K entries they determine the mean square with √(2K) times the walks of one entry. Choosing
    /// luminaires takes work beside rays, which counts as it does for walks.
    pub fn work_by_gathering(&self, context: &Context, error: f64) -> f64 {
        let absolute_error = error * self.mean_without_gathering();
        let to_first_look = self.rays_to_first_look(error);
        let rays = self.indirect_rays_by_gathering(error);
        let learns_by_cell = context.world.would_learn_selection_by_cell(rays);
        let choosing = if learns_by_cell { 0.0 } else { self.costs.walked.choosing / self.costs.walked.rays.max(1.0) };
        let work = self.rays_with_direct(WORK_OF_A_GATHERING_RAY * rays * (1.0 + choosing), absolute_error);
        // If a look is cheap relative to walks it is taken: it shows more than the pilot of walks can.
        let without = self.work_without_gathering(context, absolute_error);
        if to_first_look < SHARE_OF_A_LOOK * without { work.min(WORTH_A_LOOK * without) } else { work }
    }

    /// Rays by cells to an error, direct light included, from what the pilot measured of walks.
    pub fn rays_by_gathering(&self, error: f64) -> f64 {
        self.rays_with_direct(self.indirect_rays_by_gathering(error), error * self.mean_without_gathering())
    }

    /// The same for indirect light alone.
    fn indirect_rays_by_gathering(&self, error: f64) -> f64 {
        let absolute_error = error * self.mean_without_gathering();
        let entries = self.gathered().len() as f64;
        let of_one = self.costs.walked.variance / (absolute_error * absolute_error);
        let walks = WALKS_OF_AN_ENTRY * self.costs.walked.rays * (2.0 * entries).sqrt();
        self.rays_to_first_look(error).max(RAYS_OF_A_RAY * of_one * (entries + walks))
    }

    /// Rays of indirect light before the first look, approximately.
    pub fn rays_to_first_look(&self, error: f64) -> f64 {
        let first = self.first_goal(error);
        let filled = 2.0 * first.fills as f64 * RAYS_OF_A_FILL;
        let gathered = first.rays as f64 * self.gathered().len() as f64;
        let walked = (first.walks * self.first_walkers() as u64) as f64 * self.costs.walked.rays;
        filled + REPLICAS as f64 * (gathered + walked)
    }

    /// Rays that gathering still takes by the latest plan; `None` if there is no plan yet.
    pub fn rays_left_to_gather(&self) -> Option<f64> {
        self.gathering
            .growth
            .as_ref()
            .map(|(growth, planned_at)| (growth.rays - (self.work.rays - planned_at) as f64).max(0.0))
    }

    /// Work that gathering still takes to `absolute_error` by the latest look, for comparison with the work of other methods. Direct light
    /// takes what the pilot measured of it, as in their work: its error at a first look, before elements are cut further, is no measure.
    pub fn work_left_to_gather(&self, absolute_error: f64) -> Option<f64> {
        let indirect = self.gathering_parts()?.growth_of_indirect(absolute_error).rays;
        Some(self.rays_with_direct(WORK_OF_A_GATHERING_RAY * indirect, absolute_error))
    }

    /// What a map does before its first look. An unbound map is only shown, so it does least.
    fn first_goal(&self, error: f64) -> GatheringGoal {
        let error = self.error_to_begin_with(error);
        let entries = self.gathered().len().max(1) as u64;
        let most_passes = if self.bound { MOST_PASSES } else { LEAST_PASSES };
        let passes = (FIRST_RAYS / (entries * REPLICAS as u64)).clamp(LEAST_PASSES, most_passes);
        let fills = (FIRST_FILLS as f64 * entries as f64 * (ERROR_OF_FIRST_FILLS / error).min(1.0)).ceil() as u64;
        GatheringGoal { direct: 1, fills: fills.min(MOST_FILLS), rays: passes, walks: WALKS_OF_A_WALKER }
    }

    /// Error for which a map takes its first look in a run to `error`.
    fn error_to_begin_with(&self, error: f64) -> f64 {
        if self.bound { error } else { error.max(ERROR_OF_UNBOUND) }
    }

    /// Entries that walk before the first look.
    fn first_walkers(&self) -> usize {
        let affordable =
            FIRST_RAYS as f64 / ((WALKS_OF_A_WALKER * REPLICAS as u64) as f64 * self.costs.walked.rays.max(1.0));
        affordable.clamp(LEAST_WALKERS, FIRST_WALKERS).min(self.gathered().len() as f64) as usize
    }

    /// Begins to gather, for an error or with as many rays as a number of chains.
    pub fn start_gathering(&mut self, context: &Context, error: f64, chains: Option<u64>) {
        let mean = self.mean_without_gathering();
        let squared_lx2 = DIRECT_SHARE * (self.error_to_begin_with(error) * mean).powi(2) * REPLICAS as f64;
        let direct = (self.costs.direct.variance / squared_lx2.max(f64::MIN_POSITIVE)).ceil() as u64;
        let most_direct = (FIRST_RAYS as f64 / self.rays_of_a_pass().max(1.0)) as u64;
        let mut goal = self.first_goal(error);
        if let Some(chains) = chains {
            let entries = self.gathered().len().max(1) as u64;
            let rays = chains.div_ceil(REPLICAS as u64 * entries).max(1);
            goal = GatheringGoal { direct: 1, fills: rays * entries, rays, walks: rays.div_ceil(4) };
        }
        self.gathering.goal = GatheringGoal { direct: direct.clamp(1, most_direct.max(1)), ..goal };
        self.engine = Engine::Gather;
        self.begin_gathering(context);
    }

    /// Begins gathering anew on the present elements. Cells are kept.
    pub fn begin_gathering(&mut self, context: &Context) {
        self.map.indirect_unit = Unit::Scores;
        if let (Some(coarse), Some(adaptive)) = (&self.adapting.coarse, &mut self.adapting.adaptive) {
            adaptive.stand_on(coarse);
            self.weights = element_weights_m2(context, &self.elements, Some(adaptive.shows()));
        }
        self.find_contact(context);
        let (sites, walkers) = (self.gathered().len(), self.first_walkers());
        let allotment =
            self.adapting.coarse.as_ref().map_or_else(Allotment::default, |coarse| coarse.shape.rays.clone());
        self.gathering.better = None;
        let gatherer = gatherer_of(
            context,
            self.kind,
            (&self.elements, &self.adapting.contact_free),
            self.adapting.coarse.as_ref(),
        );
        let places: Vec<_> = (0..sites).map(|entry| gatherer.starts.middle(entry)).collect();
        let regions = regions_of(&places);
        self.gathering.progress = Some(match &self.gathering.progress {
            Some(progress) => progress.anew(&gatherer, &regions, walkers, allotment),
            None => GatheringProgress::new(&gatherer, &regions, walkers, allotment),
        });
        let map = self.gathered_mut();
        map.residuals = Some(Residuals::new(regions, map.entries()));
    }

    /// Does one slice towards the goal. Returns whether the goal is reached.
    pub(super) fn gather_a_slice(&mut self, context: &Context, sets: &mut CellSets) -> bool {
        self.share_out_rays();
        let goal = self.gathering.goal;
        let entries = self.gathered().len().max(1) as u64;
        let gatherer = gatherer_of(
            context,
            self.kind,
            (&self.elements, &self.adapting.contact_free),
            self.adapting.coarse.as_ref(),
        );
        let Some(progress) = &mut self.gathering.progress else {
            return true;
        };
        let most_rays = context.pace.rays_per_slice();
        let per_replica = |rays: f64| (most_rays / (rays * REPLICAS as f64)) as u64;
        let most_samples = SAMPLES_OF_A_FILL * goal.fills.div_ceil(entries);
        sets.most_samples = sets.most_samples.max(most_samples.min(MOST_SAMPLES) as u16);
        self.work.rays += match next_of(progress, &goal) {
            Some(Activity::Cells) => {
                progress.fill(&gatherer, sets, goal.fills, (most_rays / (2.0 * RAYS_OF_A_FILL)) as u64)
            }
            Some(Activity::Gathering) => progress.gather(&gatherer, sets, goal.rays, per_replica(1.0)),
            Some(_) => progress.walk(&gatherer, sets, goal.walks, per_replica(RAYS_OF_A_WALK)),
            None => 0,
        };
        next_of(progress, &goal).is_none()
    }

    /// Bytes of what it has gathered.
    pub fn bytes_of_gathering(&self) -> usize {
        self.gathering.progress.as_ref().map_or(0, GatheringProgress::bytes)
    }

    /// Kind of work in the next slice of a map that gathers.
    pub(super) fn next_of_gathering(&self) -> Activity {
        let next = self.gathering.progress.as_ref().and_then(|progress| next_of(progress, &self.gathering.goal));
        next.unwrap_or(Activity::Gathering)
    }

    /// Whether walks have passed at least once over the entries that must walk, so that the map's bias is known.
    pub fn knows_its_bias(&self) -> bool {
        self.gathering.progress.as_ref().is_none_or(|progress| progress.passes() > 0 && progress.knows_its_bias())
    }

    /// Changes to walks or counting. Direct light keeps its samples.
    pub fn stop_gathering(&mut self, context: &Context) {
        (self.gathering.progress, self.gathering.growth, self.adapting.coarse) = (None, None, None);
        self.map.forget_gathered();
        self.map.forget_indirect_scores();
        if self.kind == MapKind::Elements {
            let shows = self.adapting.adaptive.as_ref().map(Adaptive::shows);
            self.map.indirect_unit = element_map(context, &self.elements, shows).0.indirect_unit;
        }
        if let Some(adaptive) = &mut self.adapting.adaptive {
            adaptive.detail.restart_indirect();
        }
        self.forget_looks();
        self.give_up_samples();
        self.engine = Engine::unbiased(context.scene, self.kind, Method::Auto);
        self.share = DirectShare::of(self.costs.direct, self.costs.indirect, [self.map.len(); 2]);
        self.samples = 0;
    }

    /// Sums up the light from cells, so that it can be judged and read.
    pub fn settle_gathering(&mut self, sets: Option<&mut CellSets>) {
        let (Some(sets), Some(progress)) = (sets, &mut self.gathering.progress) else {
            return;
        };
        match (&mut self.adapting.coarse, &mut self.adapting.adaptive) {
            (Some(coarse), Some(adaptive)) => {
                progress.settle(sets, &mut coarse.map, &coarse.weights_m2, Some(&mut coarse.shape));
                self.map.take_indirect(&coarse.map, &coarse.sloped, &coarse.children);
                adaptive.detail.take_indirect(&coarse.shape.detail, &coarse.children);
            }
            _ => progress.settle(sets, &mut self.map, &self.weights, None),
        }
        self.samples = self.gathered().indirect_samples.complete;
    }

    /// What the latest look has shown of a map that gathers.
    pub(super) fn gathering_parts(&self) -> Option<GatheringParts> {
        let progress = self.gathering.progress.as_ref().filter(|progress| progress.passes() > 0)?;
        let residuals = self.gathered().residuals.as_ref()?.state();
        let direct_lx2 = self.direct_variance / REPLICAS as f64;
        let walks_lx2 = residuals.correction_variance / REPLICAS as f64;
        let rays_lx2 = ray_squared_lx2(&progress.ray_variances_lx2, self.gathered_weights());
        let [rays, fills, walks] = progress.rays.map(|rays| rays as f64);
        let parts = GatheringParts {
            squared_lx2: [direct_lx2, rays_lx2, walks_lx2],
            rays: [(self.work.direct_rays as f64).max(1.0), rays, fills, walks],
            residuals,
            degrees_of_freedom: self.judgement.degrees_of_freedom,
        };
        Some(self.gathering.better.as_ref().map_or(parts, |better| better.parts(&parts)))
    }

    /// Plans the way to a target by the latest look, and sets the next goal. Without a target all work doubles. A map that a check refused
    /// has too few scores of direct light or of rays. The kind whose single scores weigh more is doubled.
    pub fn plan_gathering(&mut self, target: Option<f64>) {
        let Some(parts) = self.gathering_parts() else {
            return;
        };
        let growth = match target.filter(|_| !self.looks.refused && self.judgement.mean > 0.0) {
            // What elements cannot show takes its part of the target.
            Some(target) => {
                let share = (1.0 - (self.judgement.discretisation / target).powi(2)).max(LEAST_SHARE_OF_CHANCE);
                let chance_lx = share.sqrt() * target * self.judgement.mean;
                let growth = parts.growth(chance_lx);
                self.gathering.better = self.better_rays(&growth);
                let (parts, growth) = match &self.gathering.better {
                    None => (parts, growth),
                    Some(better) => {
                        let parts = better.parts(&parts);
                        (parts, better.growth(&parts, parts.growth(chance_lx)))
                    }
                };
                self.gathering.bounds = Some(parts.bounds(chance_lx));
                growth
            }
            None if self.looks.refused => {
                let [of_direct, of_rays] = self.score_parts().map(|part| part.fourth);
                let few = usize::from(of_rays > of_direct);
                let mut factors = [1.0; KINDS];
                factors[few] = 2.0;
                GatheringGrowth { factors, all_walk: false, rays: parts.rays[few], reaches: true }
            }
            None => {
                GatheringGrowth { factors: [2.0; 4], all_walk: true, rays: parts.rays.iter().sum(), reaches: false }
            }
        };
        self.gathering.growth = Some((growth, self.work.rays));
        let more = |now: u64, factor: f64| {
            let factor = factor.min(MOST_GROWTH);
            if factor < LEAST_GROWTH { now } else { ((now as f64 * factor).ceil() as u64).max(now + 1) }
        };
        if growth.all_walk
            && let Some(progress) = &mut self.gathering.progress
        {
            progress.walk_from_all();
        }
        let now = self.gathering.goal;
        let [direct, rays, fills, walks] = growth.factors;
        let goal = GatheringGoal {
            direct: more(now.direct, direct),
            fills: more(now.fills, fills),
            rays: match &self.gathering.better {
                Some(better) => better.passes(rays.min(MOST_GROWTH)),
                None => more(now.rays, rays),
            },
            walks: more(now.walks, walks),
        };
        // If the predicted work is done and the map is still not accepted, a little more of everything.
        let eighth = |now: u64| now + now.div_ceil(8);
        self.gathering.goal = if goal == now {
            GatheringGoal {
                direct: eighth(now.direct),
                fills: eighth(now.fills),
                rays: eighth(now.rays),
                walks: eighth(now.walks),
            }
        } else {
            goal
        };
        self.next_judgement = self.gathering.goal.rays;
    }
}
