//! Gathering in a run: the cells of every replica, what maps have asked them, and the sums that follow.
//!
//! A replica is a task. It has cells, samples, rays and walks of its own, so that replicas know nothing of each other: their spread
//! holds all chance there is, and what they share is the bias that walks measure.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::job::Context;
use super::sweep::stream_index;
use crate::caches::{CellGrid, CellLight};
use crate::estimators::cells::{CellSampler, Term, residual_walk};
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

/// The cells of all replicas, which serve all maps of a run.
pub struct CellSets {
    cells: Vec<CellLight>,
    /// Samples that a cell takes at most.
    pub most_samples: u16,
    /// Rays of the cells' samples.
    pub rays: u64,
}

impl CellSets {
    /// No cells yet.
    pub fn new(context: &Context, most_samples: u16) -> CellSets {
        let bounds_m = context.stage.tracer.bounds_m();
        let cells = |replica: u32| {
            let mut stream = Stream::new(context.seed, Purpose::Cells, 1, replica);
            stream.seek(0);
            CellLight::new(CellGrid::new(bounds_m, std::array::from_fn(|_| stream.fine_unit())))
        };
        CellSets { cells: (0..REPLICAS as u32).map(cells).collect(), most_samples, rays: 0 }
    }

    /// Solves for the light of all cells.
    fn solve(&mut self) {
        self.cells.par_iter_mut().with_max_len(1).for_each(CellLight::solve);
    }

    /// Share of the samples that lie in cells which want no more.
    pub fn full_share(&self) -> f64 {
        let most = self.most_samples;
        let [full, all] = self
            .cells
            .par_iter()
            .map(|cells| cells.samples_in_full_cells(most))
            .reduce(|| [0; 2], |one, other| [one[0] + other[0], one[1] + other[1]]);
        full as f64 / all.max(1) as f64
    }
}

/// What the rays and walks of one replica of a map found.
#[derive(Clone, Debug, Default)]
struct Records {
    /// Of every ray, pass by pass: the cell that it asked.
    terms: Vec<Term>,
    /// What it found beside, in lx; empty where rays can find nothing else.
    plain_lx: Vec<f32>,
    /// Of every walk, pass by pass: what it found beside cells, in lx, and the number of terms up to its end.
    walks: Vec<(f32, u32)>,
    walk_terms: Vec<Term>,
}

/// The order in which the entries of a map ask: scattered, so that a cell's first samples come from all over the map.
#[derive(Clone, Copy, Debug)]
struct Order {
    sites: usize,
    stride: usize,
}

impl Order {
    fn of(sites: usize) -> Order {
        // The golden section scatters best; the stride must share no divisor with the number of entries.
        let divides = |mut a: usize, mut b: usize| {
            while b > 0 {
                (a, b) = (b, a % b);
            }
            a > 1
        };
        let mut stride = ((sites as f64 * 0.618_034) as usize).max(1);
        while divides(stride, sites) {
            stride += 1;
        }
        Order { sites, stride }
    }

    /// The entry at a place of a pass.
    #[inline]
    fn entry(self, place: u64) -> usize {
        ((u128::from(place) * self.stride as u128) % self.sites as u128) as usize
    }

    /// Pass and entry of the rays of a range.
    fn entries(self, range: Range<u64>) -> impl Iterator<Item = (u64, usize)> {
        let sites = self.sites as u64;
        range.map(move |index| (index / sites, self.entry(index % sites)))
    }
}

/// What a map has gathered.
pub struct CellAsks {
    records: Vec<Records>,
    order: Order,
    /// Rays of each replica, and walks, so far: a pass may stand in the middle.
    asked: u64,
    walked: u64,
    /// Squared error in lx² of the mean over all replicas by chance of the rays alone, by the latest sums.
    pub ray_squared_lx2: f64,
    /// Rays of gathering, of the samples of cells that it asked for, and of walks.
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
    /// Nothing yet of so many entries.
    pub fn new(sites: usize) -> CellAsks {
        CellAsks {
            records: vec![Records::default(); REPLICAS],
            order: Order::of(sites),
            asked: 0,
            walked: 0,
            ray_squared_lx2: 0.0,
            rays: [0; 3],
        }
    }

    /// Complete passes of rays.
    pub fn passes(&self) -> u64 {
        self.asked / self.order.sites.max(1) as u64
    }

    /// Complete passes of walks.
    pub fn walks(&self) -> u64 {
        self.walked / self.order.sites.max(1) as u64
    }

    /// Sends rays up to so many passes, of every replica at most so many; returns how many rays that took, those of samples too.
    pub fn ask(&mut self, asker: &Asker, sets: &mut CellSets, passes: u64, most: u64) -> u64 {
        let range = self.asked..(passes * self.order.sites as u64).min(self.asked + most.max(1));
        let (order, most_samples) = (self.order, sets.most_samples);
        let replicas = self.records.par_iter_mut().with_max_len(1).zip(&mut sets.cells).enumerate();
        let traced = replicas.map(|(replica, (records, cells))| {
            asker.ask(records, cells, most_samples, replica as u32, order.entries(range.clone()))
        });
        let rays = traced.reduce(|| [0; 2], |one, other| [one[0] + other[0], one[1] + other[1]]);
        self.asked = range.end;
        self.rays[0] += rays[0];
        self.rays[1] += rays[1];
        sets.rays += rays[1];
        rays[0] + rays[1]
    }

    /// Walks up to so many passes, of every replica at most so many; returns their rays. Cells must be solved.
    pub fn walk(&mut self, asker: &Asker, sets: &mut CellSets, passes: u64, most: u64) -> u64 {
        if self.walked.is_multiple_of(self.order.sites as u64) {
            // Larger cells, which tell of places that nobody asked, come with the solution.
            sets.solve();
        }
        let range = self.walked..(passes * self.order.sites as u64).min(self.walked + most.max(1));
        let order = self.order;
        let replicas = self.records.par_iter_mut().with_max_len(1).zip(&sets.cells).enumerate();
        let traced = replicas.map(|(replica, (records, cells))| {
            asker.walk(records, cells, replica as u32, order.entries(range.clone()))
        });
        let rays = traced.sum();
        self.walked = range.end;
        self.rays[2] += rays;
        rays
    }

    /// Sums up all that complete passes found, by the light that cells have now.
    pub fn settle(&mut self, sets: &mut CellSets, map: &mut ReplicaMap, weights: &[f64]) {
        sets.solve();
        let (sites, passes, walks) = (self.order.sites, self.passes(), self.walks());
        let order = self.order;
        let Some(residuals) = &mut map.residuals else {
            return;
        };
        residuals.walks = walks;
        let replicas = self.records.par_iter().with_max_len(1).zip(&sets.cells).zip(&mut map.indirect);
        let halves = replicas.zip(&mut residuals.sums_lx).map(|(((records, cells), rows), walked)| {
            rows.fill(0.0);
            // What the first half of the passes brought, and the second.
            let mut by_half = vec![[0.0f64; 2]; sites];
            for (index, (pass, entry)) in order.entries(0..passes * sites as u64).enumerate() {
                let term = records.terms[index];
                let told_lx = term.factor * cells.value_lx(term.asked);
                let lx = f64::from(told_lx + records.plain_lx.get(index).copied().unwrap_or(0.0));
                by_half[entry][usize::from(2 * pass >= passes)] += lx;
                rows[entry] += lx;
            }
            walked.fill(0.0);
            let mut first = 0;
            for ((plain_lx, end), (_, entry)) in records.walks.iter().zip(order.entries(0..walks * sites as u64)) {
                let terms = &records.walk_terms[first as usize..*end as usize];
                let told: f64 =
                    terms.iter().map(|term| f64::from(term.factor) * f64::from(cells.value_lx(term.asked))).sum();
                walked[entry] += f64::from(*plain_lx) + told;
                first = *end;
            }
            by_half
        });
        let halves: Vec<Vec<[f64; 2]>> = halves.collect();
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
    /// Rays of one replica; returns those of gathering and those of samples.
    fn ask(
        &self,
        records: &mut Records,
        cells: &mut CellLight,
        most_samples: u16,
        replica: u32,
        entries: impl Iterator<Item = (u64, usize)>,
    ) -> [u64; 2] {
        let stage = self.context.stage;
        let mut stream = Stream::new(self.context.seed, Purpose::CellRays, self.kind.number(), replica);
        // Samples are numbered through all maps.
        let samples = Stream::new(self.context.seed, Purpose::Cells, 0, replica);
        let mut sampler = CellSampler { stage, cells, most_samples, stream: samples, rays: 0 };
        let finds_more = self.finds_more_than_cells();
        let mut cut = Cut::default();
        let mut rays = 0;
        for (pass, entry) in entries {
            let (mut plain_lx, mut term) = (0.0, Term::NONE);
            if let Some(site) = self.site(entry) {
                stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                let start = self.start(&site, &mut stream);
                let found = sampler.gather(&start.receiver(), &mut cut, &mut stream);
                plain_lx = start.weight * found.0;
                term = Term { factor: start.weight as f32 * found.1.factor, ..found.1 };
                rays += found.2;
            }
            records.terms.push(term);
            if finds_more {
                records.plain_lx.push(plain_lx as f32);
            }
        }
        [rays, sampler.rays]
    }

    /// Walks of one replica; returns their rays.
    fn walk(
        &self,
        records: &mut Records,
        cells: &CellLight,
        replica: u32,
        entries: impl Iterator<Item = (u64, usize)>,
    ) -> u64 {
        let stage = self.context.stage;
        let mut stream = Stream::new(self.context.seed, Purpose::Residuals, self.kind.number(), replica);
        let mut cut = Cut::default();
        let mut rays = 0;
        for (pass, entry) in entries {
            let mut plain_lx = 0.0;
            if let Some(site) = self.site(entry) {
                stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                let start = self.start(&site, &mut stream);
                let (receiver, terms) = (start.receiver(), &mut records.walk_terms);
                let add = |term: Term| terms.push(term);
                let walked = residual_walk(stage, cells, &receiver, start.weight, &mut cut, &mut stream, add);
                plain_lx = walked.0;
                rays += walked.1;
            }
            records.walks.push((plain_lx as f32, records.walk_terms.len() as u32));
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
