//! What gathers, and its rays: those that fill cells, those whose values count, and residual walks.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::records::{Records, look_up};
use crate::caches::{CellGrid, CellLight};
use crate::estimators::direct::Receiver;
use crate::estimators::element::Element;
use crate::estimators::gathering::{CellPlace, PendingTerm, fill_cells, gather, look_for_place, residual_walk};
use crate::estimators::reception::one_plane;
use crate::geometry::Origin;
use crate::maps::MapKind;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Elements, Quantity};
use crate::solver::guide::Guide;
use crate::solver::job::Context;
use crate::solver::order::{Order, WalkOrder};
use crate::solver::sweep::stream_index;

/// Rays, or walks, whose cells are looked up together.
const BLOCK: u64 = 64;

/// What gathers: elements or receivers.
pub struct Gatherer<'a> {
    /// The run.
    pub context: &'a Context<'a>,
    /// Elements or a receiver set.
    pub kind: MapKind,
    /// The elements, where they are what gathers.
    pub elements: &'a Elements,
    /// Share of every element that is exposed.
    pub exposed: &'a [f64],
    /// Whether elements count as a whole, with what of them is covered.
    pub as_wholes: bool,
    /// Number of the streams: a map that starts anew draws anew.
    pub number: u32,
    /// Whether elements show slopes.
    pub slopes: bool,
}

impl Gatherer<'_> {
    /// Rays that fill the cells of a half, as gathering rays go; returns the rays, those of samples too.
    pub fn fill(
        &self,
        cells: &mut CellLight,
        (half, most_samples): (u32, u16),
        (order, guide): (Order, &Guide),
        range: Range<u64>,
    ) -> u64 {
        let stage = self.context.stage;
        let room = || (Stream::new(self.context.seed, Purpose::CellFills, self.number, half), Cut::default());
        let numbers = (0..(range.end - range.start) as usize).into_par_iter().with_min_len(BLOCK as usize);
        let found: Vec<(Option<CellPlace>, u64)> = numbers
            .map_init(room, |(stream, cut), number| {
                let (pass, entry) = order.at(range.start + number as u64);
                let Some(site) = self.site(entry) else {
                    return (None, 0);
                };
                stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                let start = self.start(&site, stream);
                if start.weight == 0.0 {
                    return (None, start.rays);
                }
                let (met, rays) = look_for_place(stage, &start.receiver(), guide.density_at(entry), cut, stream);
                (met, start.rays + rays)
            })
            .collect();
        let rays = found.iter().map(|(_, rays)| rays).sum::<u64>();
        let places = found.into_iter().filter_map(|(met, _)| met);
        // Samples are numbered through all maps.
        let stream = || Stream::new(self.context.seed, Purpose::Cells, 0, half);
        rays + fill_cells(stage, cells, most_samples, places, stream)
    }

    /// Rays of one replica whose values count; returns the rays.
    pub fn gather(
        &self,
        records: &mut Records,
        (replica, grid): (u32, &CellGrid),
        (order, guide): (Order, &Guide),
        range: Range<u64>,
    ) -> u64 {
        let stage = self.context.stage;
        let mut stream = Stream::new(self.context.seed, Purpose::CellRays, self.number, replica);
        let mut cut = Cut::default();
        let mut rays = 0;
        let mut pending: Vec<Option<PendingTerm>> = Vec::with_capacity(BLOCK as usize);
        for block in blocks(range) {
            for (pass, entry) in order.entries(block) {
                let (mut plain_lx, mut term, mut bin, mut at) = (0.0, None, 0, [0.0; 2]);
                if let Some(site) = self.site(entry) {
                    stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                    let start = self.start(&site, &mut stream);
                    (at, rays) = (start.at, rays + start.rays);
                    if start.weight > 0.0 {
                        let density = guide.density_at(entry);
                        let found = gather(stage, grid, &start.receiver(), density, &mut cut, &mut stream);
                        plain_lx = start.weight * found.plain_lx;
                        let weighted =
                            |term: PendingTerm| PendingTerm { factor: start.weight as f32 * term.factor, ..term };
                        term = found.term.map(weighted);
                        (bin, rays) = (found.bin, rays + found.rays);
                    }
                }
                if self.slopes {
                    records.starts.push(at.map(|weight| weight as f32));
                }
                pending.push(term);
                records.bins.push(bin);
                records.plain_lx.push(plain_lx as f32);
            }
            let found = pending.drain(..);
            found.for_each(|term| look_up(grid, term, &mut records.terms, &mut records.new));
        }
        rays
    }

    /// Walks of one replica; returns their rays.
    pub fn walk(
        &self,
        records: &mut Records,
        (replica, grid): (u32, &CellGrid),
        (order, guide): (&WalkOrder, &Guide),
        range: Range<u64>,
    ) -> u64 {
        let stage = self.context.stage;
        let mut stream = Stream::new(self.context.seed, Purpose::Residuals, self.number, replica);
        let mut cut = Cut::default();
        let mut rays = 0;
        let mut pending: Vec<PendingTerm> = Vec::new();
        for block in blocks(range) {
            for (pass, entry) in order.entries(block) {
                let (mut plain_lx, mut bin, mut at) = (0.0, 0, [0.0; 2]);
                if let Some(site) = self.site(entry) {
                    stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                    let start = self.start(&site, &mut stream);
                    (at, rays) = (start.at, rays + start.rays);
                    if start.weight > 0.0 {
                        let note = |term: PendingTerm| pending.push(term);
                        let drawn = (start.weight, guide.density_at(entry));
                        let walked = residual_walk(stage, grid, &start.receiver(), drawn, &mut cut, &mut stream, note);
                        (plain_lx, bin, rays) = (walked.plain_lx, walked.bin, rays + walked.rays);
                    }
                }
                if self.slopes {
                    records.walk_starts.push(at.map(|weight| weight as f32));
                }
                records.walk_bins.push(bin);
                records.walks.push((plain_lx as f32, (records.walk_terms.len() + pending.len()) as u32));
            }
            let found = pending.drain(..).map(Some);
            found.for_each(|term| look_up(grid, term, &mut records.walk_terms, &mut records.new_of_walks));
        }
        rays
    }

    /// Whether all rays of an entry have one hemisphere, whose directions can be learned.
    pub fn has_one_hemisphere(&self) -> bool {
        match self.kind {
            MapKind::Elements => true,
            MapKind::Receivers(set) => self.context.scene.receivers[set].quantity.has_one_hemisphere(),
        }
    }

    /// Middle of an entry in m, and its unit normal.
    pub fn middle(&self, entry: usize) -> (DVec3, DVec3) {
        let stage = self.context.stage;
        match self.kind {
            MapKind::Elements => {
                let element = Element::of(stage, self.context.scene, self.elements, entry as u32);
                element.middle(stage)
            }
            MapKind::Receivers(set) => {
                let point = &self.context.scene.receivers[set].points[entry];
                (point.position_m, point.normal)
            }
        }
    }

    /// Where the rays of an entry start; `None` for a point inside a solid, and for an element that is covered.
    pub fn site(&self, entry: usize) -> Option<Site> {
        let stage = self.context.stage;
        match self.kind {
            MapKind::Elements => {
                let element = Element::of(stage, self.context.scene, self.elements, entry as u32);
                let share = self.exposed.get(entry).copied().unwrap_or(1.0);
                (share > 0.0).then(|| Site::Element(element.exposed(share)))
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
    fn start(&self, site: &Site, stream: &mut Stream) -> GatheringStart {
        let stage = self.context.stage;
        match site {
            Site::Element(element) => {
                let (at, rays) = if self.as_wholes {
                    element.draw_of_whole(stage, stream)
                } else {
                    let (at, rays) = element.draw_exposed(stage, stream);
                    (Some(at), rays)
                };
                let (at, weight) = at.map_or(([0.0; 2], 0.0), |at| (at, 1.0));
                let origin = element.origin(stage, at);
                let point_m = stage.tracer.position_m(&origin);
                GatheringStart { at, point_m, normal: element.normal_at(stage, at), origin, weight, rays }
            }
            Site::Point { point_m, normal, origin, quantity } => {
                let receiver = Receiver { point_m: *point_m, normal: *normal, origin };
                let (plane, weight) = one_plane(*quantity, &receiver, stream);
                GatheringStart {
                    at: [0.0; 2],
                    point_m: *point_m,
                    normal: plane.normal,
                    origin: *origin,
                    weight,
                    rays: 0,
                }
            }
        }
    }
}

/// Where one gathering ray starts.
struct GatheringStart {
    /// Place in its element: the weights of the second and third corner.
    at: [f64; 2],
    point_m: DVec3,
    /// Unit normal of the plane that it is for.
    normal: DVec3,
    origin: Origin,
    /// Weight of what it brings; 0 where the place is covered, and no ray starts.
    weight: f64,
    /// Rays that it took to find the place.
    rays: u64,
}

impl GatheringStart {
    /// The plane that the ray is for.
    #[inline]
    fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.point_m, normal: self.normal, origin: &self.origin }
    }
}

/// Where gathering rays start.
pub enum Site {
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

/// A range in blocks.
fn blocks(range: Range<u64>) -> impl Iterator<Item = Range<u64>> {
    let end = range.end;
    range.step_by(BLOCK as usize).map(move |first| first..(first + BLOCK).min(end))
}
