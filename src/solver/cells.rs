//! Gathering in a run: the cells of both halves, what maps have asked them, and the sums that follow.
//!
//! Even and odd half have cells of their own, so that they know nothing of each other: their difference holds all chance there is.
//! Replicas of a half ask the same cells by rays and walks of their own; what their cells have wrong is what walks measure.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::job::Context;
use super::order::{Order, WalkOrder};
use super::sweep::stream_index;
use crate::caches::{CellGrid, CellLight, DirectionControl, DirectionSums, bin_of};
use crate::estimators::cells::{Asked, Question, Term, fill_cells, gather, look_for_place, residual_walk};
use crate::estimators::direct::Receiver;
use crate::estimators::element::Element;
use crate::estimators::reception::one_plane;
use crate::geometry::Origin;
use crate::maps::{MapKind, REPLICAS, ReplicaMap};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Elements, Quantity};

/// Entries of a region of neighbours, about.
const ENTRIES_OF_A_REGION: usize = 24;
/// Edge of a cell over the length of the ray that asks: so many times the error that maps go for, within bounds. What a cell is off
/// by grows with its edge.
const EDGES_AN_ERROR: f64 = 50.0;
const LEAST_EDGE_SHARE: f64 = 0.05;
const MOST_EDGE_SHARE: f64 = 0.5;
/// Rays, or walks, whose cells are looked up together.
const BLOCK: u64 = 64;

/// The cells of both halves, which serve all maps of a run.
pub struct CellSets {
    halves: [CellLight; 2],
    /// Samples that a cell takes at most.
    pub most_samples: u16,
}

impl CellSets {
    /// No cells yet, for an error of the maps.
    pub fn new(context: &Context, error: f64) -> CellSets {
        let edge_share = (EDGES_AN_ERROR * error).clamp(LEAST_EDGE_SHARE, MOST_EDGE_SHARE);
        let bounds_m = context.stage.tracer.bounds_m();
        let cells = |half: u32| {
            let mut stream = Stream::new(context.seed, Purpose::Cells, 1, half);
            stream.seek(0);
            CellLight::new(CellGrid::new(bounds_m, std::array::from_fn(|_| stream.fine_unit()), edge_share))
        };
        CellSets { halves: [cells(0), cells(1)], most_samples: 1 }
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

/// A range in blocks.
fn blocks(range: Range<u64>) -> impl Iterator<Item = Range<u64>> {
    let end = range.end;
    range.step_by(BLOCK as usize).map(move |first| first..(first + BLOCK).min(end))
}

/// What the rays and walks of one replica of a map found.
#[derive(Clone, Debug, Default)]
struct Records {
    /// Of every ray, pass by pass: the cell that it asked.
    terms: Vec<Term>,
    /// Part of the hemisphere into which it went.
    bins: Vec<u8>,
    /// What it found beside, in lx; empty where rays can find nothing else.
    plain_lx: Vec<f32>,
    /// Of every walk, pass by pass: what it found beside cells, in lx, and the number of terms up to its end.
    walks: Vec<(f32, u32)>,
    walk_terms: Vec<Term>,
    /// Places among the terms of rays, and of walks, whose cells are new.
    new: Vec<(u32, Question)>,
    new_of_walks: Vec<(u32, Question)>,
}

impl Records {
    /// Makes the cells that were asked for the first time.
    fn make_cells(&mut self, grid: &mut CellGrid) {
        self.new.drain(..).for_each(|(place, asks)| self.terms[place as usize] = asks.term(grid.cell(asks.key)));
        let of_walks = self.new_of_walks.drain(..);
        of_walks.for_each(|(place, asks)| self.walk_terms[place as usize] = asks.term(grid.cell(asks.key)));
    }

    /// What each of the first rays brought, by the light that cells have now, in lx.
    fn told_lx(&self, cells: &CellLight, rays: usize) -> Vec<f32> {
        let mut told: Vec<f32> =
            self.terms[..rays].iter().map(|term| term.factor * cells.value_lx(term.asked)).collect();
        told.iter_mut().zip(&self.plain_lx).for_each(|(told, plain_lx)| *told += plain_lx);
        told
    }
}

/// What a map has gathered.
pub struct CellAsks {
    records: Vec<Records>,
    /// Whether an entry sends rays.
    sees: Vec<bool>,
    order: Order,
    /// Rays that fill of either half, and rays that ask of each replica so far: a pass may stand in the middle.
    filled: u64,
    asked: u64,
    walks: WalkOrder,
    /// Numbers of the three kinds that the latest sums know.
    settled: [u64; 3],
    /// Squared error in lx² of the mean over all replicas by chance of the rays alone, by the latest sums.
    pub ray_squared_lx2: f64,
    /// Rays of gathering, of filling cells, and of walks.
    pub rays: [u64; 3],
}

/// What gathers: elements or receivers.
pub struct Asker<'a> {
    /// The run.
    pub context: &'a Context<'a>,
    /// Elements or a receiver set.
    pub kind: MapKind,
    /// The elements, where they are what gathers.
    pub elements: &'a Elements,
}

impl CellAsks {
    /// Nothing yet of so many entries, of which some walk at first.
    pub fn new(asker: &Asker, sites: usize, walkers: usize) -> CellAsks {
        let order = Order::of(sites);
        CellAsks {
            sees: (0..sites).map(|entry| asker.site(entry).is_some()).collect(),
            records: vec![Records::default(); REPLICAS],
            order,
            filled: 0,
            asked: 0,
            walks: WalkOrder::new(order, walkers),
            settled: [0; 3],
            ray_squared_lx2: 0.0,
            rays: [0; 3],
        }
    }

    /// Complete passes of rays that ask.
    pub fn passes(&self) -> u64 {
        self.asked / self.order.sites().max(1) as u64
    }

    /// Rays of a half that have filled cells.
    pub fn filled(&self) -> u64 {
        self.filled
    }

    /// Whether walks have told anything yet.
    pub fn knows_its_bias(&self) -> bool {
        self.walks.complete().1 > 0
    }

    /// Whether so many passes of walks are done by all that are to walk.
    pub fn has_walked(&self, passes: u64) -> bool {
        let (walkers, walks, _) = self.walks.complete();
        walkers == self.walks.walkers && walks >= passes
    }

    /// Lets all entries walk.
    pub fn walk_from_all(&mut self) {
        self.walks.take_all();
    }

    /// Fills cells up to a number of rays of either half, by at most so many; returns how many all rays were.
    pub fn fill(&mut self, asker: &Asker, sets: &mut CellSets, rays: u64, most: u64) -> u64 {
        let range = self.filled..rays.min(self.filled + most.max(1));
        let (order, most_samples) = (self.order, sets.most_samples);
        let halves = sets.halves.par_iter_mut().with_max_len(1).enumerate();
        let traced = halves.map(|(half, cells)| asker.fill(cells, most_samples, half as u32, order, range.clone()));
        let rays = traced.sum();
        self.filled = range.end;
        self.rays[1] += rays;
        rays
    }

    /// Sends rays up to so many passes, of every replica at most so many; returns how many rays that took.
    pub fn ask(&mut self, asker: &Asker, sets: &mut CellSets, passes: u64, most: u64) -> u64 {
        let range = self.asked..(passes * self.order.sites() as u64).min(self.asked + most.max(1));
        let order = self.order;
        let replicas = self.records.par_iter_mut().with_max_len(1).enumerate();
        let traced = replicas
            .map(|(replica, records)| asker.ask(records, &sets.of(replica).grid, replica as u32, order, range.clone()));
        let rays = traced.sum();
        self.make_cells(sets);
        self.asked = range.end;
        self.rays[0] += rays;
        rays
    }

    /// Walks up to so many passes, of every replica at most so many; returns their rays.
    pub fn walk(&mut self, asker: &Asker, sets: &mut CellSets, passes: u64, most: u64) -> u64 {
        let range = self.walks.next(passes, most);
        let walks = &self.walks;
        let replicas = self.records.par_iter_mut().with_max_len(1).enumerate();
        let traced = replicas.map(|(replica, records)| {
            asker.walk(records, &sets.of(replica).grid, replica as u32, walks, range.clone())
        });
        let rays = traced.sum();
        self.make_cells(sets);
        self.walks.done = range.end;
        self.rays[2] += rays;
        rays
    }

    /// Makes the cells that the replicas asked for the first time, in their order.
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

    /// Sums up all that complete passes found, by the light that cells have now.
    pub fn settle(&mut self, sets: &mut CellSets, map: &mut ReplicaMap, weights: &[f64]) {
        let numbers = [self.filled, self.asked, self.walks.done];
        if self.settled == numbers {
            return;
        }
        self.settled = numbers;
        sets.solve();
        let (sites, passes) = (self.order.sites(), self.passes());
        let order = self.order;
        let Some(residuals) = &mut map.residuals else {
            return;
        };
        let (walkers, walks, walk_count) = self.walks.complete();
        residuals.walks = walks;
        residuals.walkers = vec![false; sites];
        (0..walkers).for_each(|place| residuals.walkers[order.entry(place)] = true);
        let (sets, regions) = (&*sets, residuals.regions());
        let replicas = self.records.par_iter().with_max_len(1).enumerate();
        let rays = passes as usize * sites;
        let told: Vec<Vec<f32>> = replicas.map(|(replica, records)| records.told_lx(sets.of(replica), rays)).collect();
        let controls: Vec<DirectionControl> = [0, 1]
            .into_par_iter()
            .map(|half| {
                let mut sums = DirectionSums::new(residuals.region_count());
                for replica in (half..REPLICAS).step_by(2) {
                    let bins = &self.records[replica].bins;
                    let rays = order.entries(0..told[replica].len() as u64).zip(bins).zip(&told[replica]);
                    let rays = rays.filter(|(((_, entry), _), _)| self.sees[*entry]);
                    rays.for_each(|(((_, entry), bin), lx)| sums.add(regions[entry], *bin, *lx));
                }
                sums.control()
            })
            .collect();
        let told = told.into_par_iter().with_max_len(1).zip(&self.records).zip(&mut map.indirect).enumerate();
        let halves: Vec<Vec<[f64; 2]>> = told
            .map(|(replica, ((told, records), rows))| {
                rows.fill(0.0);
                let control = &controls[1 - replica % 2];
                // What the first half of the passes brought, and the second.
                let mut by_half = vec![[0.0f64; 2]; sites];
                let rays = order.entries(0..told.len() as u64).zip(&records.bins).zip(&told);
                for (((pass, entry), bin), lx) in rays {
                    let expected_lx = if self.sees[entry] { control.expected_lx(regions[entry], *bin) } else { 0.0 };
                    let lx = f64::from(lx - expected_lx);
                    by_half[entry][usize::from(pass >= passes / 2)] += lx;
                    rows[entry] += lx;
                }
                by_half
            })
            .collect();
        let replicas = self.records.par_iter().with_max_len(1).zip(&mut residuals.sums_lx).enumerate();
        replicas.for_each(|(replica, (records, walked))| {
            let cells = sets.of(replica);
            walked.fill(0.0);
            let mut first = 0;
            for ((plain_lx, end), (_, entry)) in records.walks.iter().zip(self.walks.entries(0..walk_count)) {
                let terms = &records.walk_terms[first as usize..*end as usize];
                let told: f64 =
                    terms.iter().map(|term| f64::from(term.factor) * f64::from(cells.value_lx(term.asked))).sum();
                walked[entry] += f64::from(*plain_lx) + told;
                first = *end;
            }
        });
        // How sure the cells are that an entry asks, by the rays of two replicas.
        let mut unsure_lx2 = vec![0.0; sites];
        for (replica, records) in self.records.iter().enumerate().take(2) {
            let cells = sets.of(replica);
            for ((_, entry), term) in order.entries(0..rays as u64).zip(&records.terms) {
                unsure_lx2[entry] += f64::from(term.factor * term.factor * cells.variance_lx2(term.asked));
            }
        }
        residuals.share_out(&unsure_lx2, weights);
        self.ray_squared_lx2 = ray_squared_lx2(&halves, weights, passes);
        map.indirect_samples.complete = passes;
        map.indirect_samples.ahead = 0;
        residuals.settle(weights);
    }

    /// Divides the entries of a map into regions of neighbours.
    pub fn regions_of(asker: &Asker, sites: usize) -> Vec<u32> {
        let places: Vec<(DVec3, DVec3)> = (0..sites).map(|entry| asker.middle(entry)).collect();
        let mut regions = vec![0; sites];
        let mut entries: Vec<u32> = (0..sites as u32).collect();
        let mut count = 0;
        divide(&places, &mut entries, &mut |part| {
            part.iter().for_each(|entry| regions[*entry as usize] = count);
            count += 1;
        });
        regions
    }
}

/// Adds the term of a question, or notes that its cell is new.
#[inline]
fn look_up(grid: &CellGrid, question: Option<Question>, terms: &mut Vec<Term>, new: &mut Vec<(u32, Question)>) {
    let cell = question.and_then(|question| grid.find(question.key));
    if let (Some(question), None) = (question, cell) {
        new.push((terms.len() as u32, question));
    }
    terms.push(question.zip(cell).map_or(Term::NONE, |(question, cell)| question.term(cell)));
}

/// Squared error in lx² of the mean over all replicas that rays have by chance: halves of a replica's passes ask the same cells.
fn ray_squared_lx2(halves: &[Vec<[f64; 2]>], weights: &[f64], passes: u64) -> f64 {
    let [first, second] = [passes / 2, passes - passes / 2].map(|count| count as f64);
    if first == 0.0 {
        return 0.0;
    }
    let (mut sum, mut weight_sum) = (0.0, 0.0);
    for half in halves {
        for ([one, other], weight) in half.iter().zip(weights) {
            sum += weight * (one / first - other / second).powi(2);
            weight_sum += weight;
        }
    }
    // Of independent halves the mean has a fourth of the squared difference.
    0.25 * sum / f64::max(weight_sum, f64::MIN_POSITIVE) / REPLICAS as f64
}

/// Halves a set of entries along its longest axis until the parts are small; places and normals count alike.
fn divide(places: &[(DVec3, DVec3)], entries: &mut [u32], found: &mut impl FnMut(&[u32])) {
    if entries.len() <= ENTRIES_OF_A_REGION {
        return found(entries);
    }
    let (mut least, mut most) = ([f64::INFINITY; 6], [f64::NEG_INFINITY; 6]);
    let extent = entries.iter().map(|entry| places[*entry as usize].0);
    let size_m = extent.clone().fold(DVec3::NEG_INFINITY, DVec3::max) - extent.fold(DVec3::INFINITY, DVec3::min);
    let size_m = size_m.max_element();
    let coordinate = |entry: u32, axis: usize| {
        let (point_m, normal) = places[entry as usize];
        if axis < 3 { point_m[axis] } else { 2.0 * size_m * normal[axis - 3] }
    };
    for entry in entries.iter() {
        for axis in 0..6 {
            least[axis] = f64::min(least[axis], coordinate(*entry, axis));
            most[axis] = f64::max(most[axis], coordinate(*entry, axis));
        }
    }
    let longest = (0..6).max_by(|one, other| (most[*one] - least[*one]).total_cmp(&(most[*other] - least[*other])));
    let axis = longest.unwrap_or(0);
    let middle = entries.len() / 2;
    let by = |one: &u32, other: &u32| coordinate(*one, axis).total_cmp(&coordinate(*other, axis)).then(one.cmp(other));
    entries.select_nth_unstable_by(middle, by);
    let (one, other) = entries.split_at_mut(middle);
    divide(places, one, found);
    divide(places, other, found);
}

impl Asker<'_> {
    /// Rays that fill the cells of a half; returns the rays, those of samples too.
    fn fill(&self, cells: &mut CellLight, most_samples: u16, half: u32, order: Order, range: Range<u64>) -> u64 {
        let stage = self.context.stage;
        let room = || (Stream::new(self.context.seed, Purpose::CellFills, self.kind.number(), half), Cut::default());
        let numbers = (0..(range.end - range.start) as usize).into_par_iter().with_min_len(BLOCK as usize);
        let found: Vec<(Option<Asked>, u64)> = numbers
            .map_init(room, |(stream, cut), number| {
                let (pass, entry) = order.at(range.start + number as u64);
                let Some(site) = self.site(entry) else {
                    return (None, 0);
                };
                stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                let start = self.start(&site, stream);
                let (_, asked, rays) = look_for_place(stage, &start.receiver(), cut, stream);
                (asked, rays)
            })
            .collect();
        let rays = found.iter().map(|(_, rays)| rays).sum::<u64>();
        let places = found.into_iter().filter_map(|(asked, _)| asked);
        // Samples are numbered through all maps.
        let stream = || Stream::new(self.context.seed, Purpose::Cells, 0, half);
        rays + fill_cells(stage, cells, most_samples, places, stream)
    }

    /// Rays of one replica whose values count; returns the rays.
    fn ask(&self, records: &mut Records, grid: &CellGrid, replica: u32, order: Order, range: Range<u64>) -> u64 {
        let stage = self.context.stage;
        let mut stream = Stream::new(self.context.seed, Purpose::CellRays, self.kind.number(), replica);
        let finds_more = self.finds_more_than_cells();
        let mut cut = Cut::default();
        let mut rays = 0;
        let mut questions: Vec<Option<Question>> = Vec::with_capacity(BLOCK as usize);
        for block in blocks(range) {
            for (pass, entry) in order.entries(block) {
                let (mut plain_lx, mut question, mut bin) = (0.0, None, 0);
                if let Some(site) = self.site(entry) {
                    stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                    let start = self.start(&site, &mut stream);
                    let variates = stream.pair();
                    let found = gather(stage, grid, &start.receiver(), variates, &mut cut, &mut stream);
                    plain_lx = start.weight * found.0;
                    question = found.1.map(|found| Question { factor: start.weight as f32 * found.factor, ..found });
                    bin = bin_of(variates);
                    rays += found.2;
                }
                questions.push(question);
                records.bins.push(bin);
                if finds_more {
                    records.plain_lx.push(plain_lx as f32);
                }
            }
            let asked = questions.drain(..);
            asked.for_each(|question| look_up(grid, question, &mut records.terms, &mut records.new));
        }
        rays
    }

    /// Walks of one replica; returns their rays.
    fn walk(&self, records: &mut Records, grid: &CellGrid, replica: u32, order: &WalkOrder, range: Range<u64>) -> u64 {
        let stage = self.context.stage;
        let mut stream = Stream::new(self.context.seed, Purpose::Residuals, self.kind.number(), replica);
        let mut cut = Cut::default();
        let mut rays = 0;
        let mut questions: Vec<Question> = Vec::new();
        for block in blocks(range) {
            for (pass, entry) in order.entries(block) {
                let mut plain_lx = 0.0;
                if let Some(site) = self.site(entry) {
                    stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                    let start = self.start(&site, &mut stream);
                    let ask = |question: Question| questions.push(question);
                    let walked =
                        residual_walk(stage, grid, &start.receiver(), start.weight, &mut cut, &mut stream, ask);
                    plain_lx = walked.0;
                    rays += walked.1;
                }
                records.walks.push((plain_lx as f32, (records.walk_terms.len() + questions.len()) as u32));
            }
            let asked = questions.drain(..).map(Some);
            asked.for_each(|question| look_up(grid, question, &mut records.walk_terms, &mut records.new_of_walks));
        }
        rays
    }

    /// Whether rays can find light that no cell tells: by mirrors, lobes and near luminaires.
    fn finds_more_than_cells(&self) -> bool {
        let stage = self.context.stage;
        !stage.is_diffuse() || stage.near_lights.is_some() || stage.mirrors.is_some()
    }

    /// Middle of an entry in m, and its unit normal.
    fn middle(&self, entry: usize) -> (DVec3, DVec3) {
        let stage = self.context.stage;
        match self.kind {
            MapKind::Elements => {
                let element = Element::of(stage, self.context.scene, self.elements, entry as u32);
                (element.corners_m.iter().sum::<DVec3>() / 3.0, element.normal)
            }
            MapKind::Receivers(set) => {
                let point = &self.context.scene.receivers[set].points[entry];
                (point.position_m, point.normal)
            }
        }
    }

    /// Where the rays of an entry start; `None` for a point inside a solid, and for an element that is covered.
    fn site(&self, entry: usize) -> Option<Site> {
        let stage = self.context.stage;
        match self.kind {
            MapKind::Elements => {
                let element = Element::of(stage, self.context.scene, self.elements, entry as u32);
                Some(Site::Element(element))
            }
            MapKind::Receivers(set) => {
                let receivers = &self.context.scene.receivers[set];
                let point = &receivers.points[entry];
                let origin = stage.tracer.side_origin(point.position_m, point.normal);
                let (point_m, normal, quantity) = (point.position_m, point.normal, receivers.quantity);
                (!point.inside).then_some(Site::Point { point_m, normal, origin, quantity })
            }
        }
    }

    /// Where one ray starts.
    #[inline]
    fn start(&self, site: &Site, stream: &mut Stream) -> Start {
        let stage = self.context.stage;
        match site {
            Site::Element(element) => {
                let at = element.draw(stream);
                let origin = element.origin(stage, at);
                let point_m = stage.tracer.position_m(&origin);
                Start { point_m, normal: element.normal, origin, weight: 1.0 }
            }
            Site::Point { point_m, normal, origin, quantity } => {
                let receiver = Receiver { point_m: *point_m, normal: *normal, origin };
                let (plane, weight) = one_plane(*quantity, &receiver, stream);
                Start { point_m: *point_m, normal: plane.normal, origin: *origin, weight }
            }
        }
    }
}

/// Where one gathering ray starts.
struct Start {
    point_m: DVec3,
    /// Unit normal of the plane that it is for.
    normal: DVec3,
    origin: Origin,
    /// Weight of what it brings.
    weight: f64,
}

impl Start {
    /// The plane that the ray is for.
    #[inline]
    fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.point_m, normal: self.normal, origin: &self.origin }
    }
}

/// Where gathering rays start.
enum Site {
    /// Anywhere in an element side.
    Element(Element),
    /// At a receiver.
    Point {
        /// Place in m.
        point_m: DVec3,
        /// Unit normal.
        normal: DVec3,
        /// The same place for the tracer.
        origin: Origin,
        /// What the receiver measures.
        quantity: Quantity,
    },
}
