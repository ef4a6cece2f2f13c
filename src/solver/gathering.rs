//! Gathering in a run: the cells of both halves, what maps have gathered from them, and the sums that follow.
//! Even and odd half have separate cells, so the halves are independent: their difference contains all random error. Replicas of a half
//! look up the same cells with their own rays and walks. Residual walks measure the error of the cells.

mod enclosures;
mod gatherer;
mod records;
mod settle;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::gatherer::Gatherer;
use self::records::Records;
pub use self::settle::ray_squared_lx2;
use super::allotment::Allotment;
use super::context::Context;
use super::guide::Guide;
use super::order::{Order, RayOrder, WalkOrder};
use crate::caches::{CellGrid, CellLight};
use crate::maps::REPLICAS;
use crate::sampling::random::{Purpose, Stream};

/// Ratio of a cell's edge to the length of the ray that looks it up: this factor times the error that maps aim at, within bounds. The error
/// of a cell grows with its edge.
const EDGES_AN_ERROR: f64 = 120.0;
/// Longest walks, in rays, for which that holds. In longer walks light is reflected more often, and each reflection adds the error of cells
/// again. So edges are shorter by the factor by which walks are longer.
const RAYS_OF_A_SHORT_WALK: f64 = 5.0;
const LEAST_EDGE_SHARE: f64 = 0.12;
const MOST_EDGE_SHARE: f64 = 0.6;

/// The cells of both halves, used by all maps of a run.
#[derive(Serialize, Deserialize)]
pub struct CellSets {
    halves: [CellLight; 2],
    /// Most samples of a cell.
    pub most_samples: u16,
}

impl CellSets {
    /// Creates empty cells, for a target error of the maps and the mean number of rays of a walk.
    pub fn new(context: &Context, error: f64, rays_of_a_walk: f64) -> CellSets {
        let reflected_seldom = (RAYS_OF_A_SHORT_WALK / rays_of_a_walk).min(1.0);
        let edge_share = (EDGES_AN_ERROR * error * reflected_seldom).clamp(LEAST_EDGE_SHARE, MOST_EDGE_SHARE);
        let bounds_m = context.scene.bounds_m();
        let cells = |half: u32| {
            let mut stream = Stream::new(context.seed, Purpose::Cells, 1, half);
            stream.seek(0);
            CellLight::new(CellGrid::new(bounds_m, std::array::from_fn(|_| stream.fine_unit()), edge_share))
        };
        CellSets { halves: [cells(0), cells(1)], most_samples: 1 }
    }

    /// Bytes that the cells of both halves take.
    pub fn bytes(&self) -> usize {
        self.halves.iter().map(CellLight::bytes).sum()
    }

    /// Cells of a replica's half.
    fn of(&self, replica: usize) -> &CellLight {
        &self.halves[replica % 2]
    }

    /// Solves for the light of all cells.
    fn solve(&mut self) {
        self.halves.par_iter_mut().with_max_len(1).for_each(CellLight::solve);
    }
}

/// What a map has gathered.
#[derive(Serialize, Deserialize)]
pub struct GatheringProgress {
    records: Vec<Records>,
    /// Whether each entry sends rays.
    sees: Vec<bool>,
    order: RayOrder,
    /// Rays of either half that fill cells, and gathering rays of each replica so far. A pass may be unfinished.
    filled: u64,
    gathered: u64,
    walks: WalkOrder,
    /// The directions from which rays get light, and those in which walks find errors of cells; and the numbers of rays of each replica,
    /// and of walks, from which they have learned.
    guides: [Guide; 2],
    learned: [u64; 2],
    /// Numbers of the three kinds that the latest sums include.
    settled: [u64; 3],
    /// For every entry, from the even and the odd half, by the latest sums: the variance of a replica's mean from the random error of rays
    /// alone, in lx², times the entry's weight. The variances of an element's slopes are included.
    pub ray_variances_lx2: Vec<[f64; 2]>,
    /// Rays for gathering, for filling cells, and of walks. Rays that were given up are left out.
    pub rays: [u64; 3],
}

impl GatheringProgress {
    /// Creates the empty progress of entries in these regions of neighbours, with `walkers` entries that walk at first.
    pub fn new(gatherer: &Gatherer, regions: &[u32], walkers: usize, allotment: Allotment) -> GatheringProgress {
        let sites = regions.len();
        let order = Order::of(sites);
        let guide = if gatherer.starts.has_one_hemisphere() { Guide::new(regions.to_vec()) } else { Guide::default() };
        GatheringProgress {
            guides: [guide.clone(), guide],
            learned: [0; 2],
            sees: (0..sites).map(|entry| gatherer.starts.site(entry).is_some()).collect(),
            records: vec![Records::default(); REPLICAS],
            order: RayOrder::new(order, allotment),
            filled: 0,
            gathered: 0,
            walks: WalkOrder::new(order, walkers),
            settled: [0; 3],
            ray_variances_lx2: Vec::new(),
            rays: [0; 3],
        }
    }

    /// Starts anew for other elements of the same surfaces: their cells are already filled.
    pub fn anew(
        &self,
        gatherer: &Gatherer,
        regions: &[u32],
        walkers: usize,
        allotment: Allotment,
    ) -> GatheringProgress {
        let fresh = GatheringProgress::new(gatherer, regions, walkers, allotment);
        GatheringProgress { filled: self.filled, rays: [0, self.rays[1], 0], ..fresh }
    }

    /// Gives up all rays, and shares those to come out among the entries. Returns the number of the rays given up.
    pub fn share_out_rays(&mut self, allotment: Allotment) -> u64 {
        self.records.iter_mut().for_each(Records::forget_rays);
        self.order = RayOrder::new(self.order.order, allotment);
        (self.gathered, self.learned[0]) = (0, 0);
        std::mem::take(&mut self.rays[0])
    }

    /// How many rays each entry sends in a pass.
    pub fn allotment(&self) -> &Allotment {
        &self.order.allotment
    }

    /// Bytes of the records.
    pub fn bytes(&self) -> usize {
        self.records.iter().map(Records::bytes).sum()
    }

    /// Complete passes of gathering rays.
    pub fn passes(&self) -> u64 {
        self.gathered / self.order.rays_of_a_pass().max(1)
    }

    /// Rays of a half that have filled cells.
    pub fn filled(&self) -> u64 {
        self.filled
    }

    /// Whether walks have given any result yet.
    pub fn knows_its_bias(&self) -> bool {
        self.walks.complete().1 > 0
    }

    /// Whether all entries that must walk have done `passes` passes of walks.
    pub fn has_walked(&self, passes: u64) -> bool {
        let (walkers, walks, _) = self.walks.complete();
        walkers == self.walks.walkers && walks >= passes
    }

    /// Lets all entries walk.
    pub fn walk_from_all(&mut self) {
        self.walks.take_all();
    }

    /// Fills cells up to `rays` rays of either half, with at most `most` new ones. Returns the rays traced in all.
    pub fn fill(&mut self, gatherer: &Gatherer, sets: &mut CellSets, rays: u64, most: u64) -> u64 {
        let range = self.filled..rays.min(self.filled + most.max(1));
        let (order, guide, most_samples) = (self.order.order, &self.guides[0], sets.most_samples);
        let halves = sets.halves.par_iter_mut().with_max_len(1).enumerate();
        let traced = halves
            .map(|(half, cells)| gatherer.fill(cells, (half as u32, most_samples), (order, guide), range.clone()));
        let rays = traced.sum();
        self.filled = range.end;
        self.rays[1] += rays;
        rays
    }

    /// Sends rays up to `passes` passes, at most `most` of each replica. Returns the rays traced.
    pub fn gather(&mut self, gatherer: &Gatherer, sets: &mut CellSets, passes: u64, most: u64) -> u64 {
        let range = self.gathered..(passes * self.order.rays_of_a_pass()).min(self.gathered + most.max(1));
        let (order, guide) = (&self.order, &self.guides[0]);
        let replicas = self.records.par_iter_mut().with_max_len(1).enumerate();
        let traced = replicas.map(|(replica, records)| {
            gatherer.gather(records, (replica as u32, &sets.of(replica).grid), (order, guide), range.clone())
        });
        let rays = traced.sum();
        self.make_cells(sets);
        self.gathered = range.end;
        self.rays[0] += rays;
        rays
    }

    /// Walks up to `passes` passes, at most `most` walks of each replica. Returns the rays traced.
    pub fn walk(&mut self, gatherer: &Gatherer, sets: &mut CellSets, passes: u64, most: u64) -> u64 {
        let range = self.walks.next(passes, most);
        let (walks, guide) = (&self.walks, &self.guides[1]);
        let replicas = self.records.par_iter_mut().with_max_len(1).enumerate();
        let traced = replicas.map(|(replica, records)| {
            gatherer.walk(records, (replica as u32, &sets.of(replica).grid), (walks, guide), range.clone())
        });
        let rays = traced.sum();
        self.make_cells(sets);
        self.walks.done = range.end;
        self.rays[2] += rays;
        rays
    }

    /// Makes the cells that the replicas looked up for the first time, in the order of the replicas.
    fn make_cells(&mut self, sets: &mut CellSets) {
        let (mut even, mut odd) = (Vec::new(), Vec::new());
        for (replica, records) in self.records.iter_mut().enumerate() {
            if replica % 2 == 0 { even.push(records) } else { odd.push(records) }
        }
        let halves = [even, odd].into_par_iter().with_max_len(1).zip(&mut sets.halves);
        halves.for_each(|(records, cells)| {
            records.into_iter().for_each(|records| records.make_cells(&mut cells.grid));
        });
    }
}
