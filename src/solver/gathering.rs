//! Gathering: rays from receivers and elements look up what the forward stage left, with checks of what they were told.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::forward::{Forward, Recollection};
use super::job::Context;
use super::sweep::{origin_in_element, stream_index};
use crate::estimators::direct::Receiver;
use crate::estimators::reception::one_plane;
use crate::estimators::walk::gather_indirect_lx;
use crate::geometry::Origin;
use crate::maps::{ENTRIES_PER_BLOCK, HALF, HalfChecks, HalfScores, MapKind, PartScores, ReplicaMap};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Cell, Quantity};

/// What gathering needs besides the map that it fills.
pub struct Gatherer<'a> {
    /// The run.
    pub context: &'a Context<'a>,
    /// What chains left.
    pub forward: &'a Forward,
    /// Elements or a receiver set.
    pub kind: MapKind,
    /// Share of the look-ups that are checked.
    pub checked_share: f64,
}

impl Gatherer<'_> {
    /// Samples of a range of entries in every replica, added to the map; returns the rays traced.
    pub fn gather(&self, map: &mut ReplicaMap, entries: Range<usize>, samples: Range<u64>) -> u64 {
        map.fix_indirect_levels(entries.clone());
        let parts: Vec<(usize, Range<usize>)> =
            parts_of(entries).flat_map(|part| [(0, part.clone()), (1, part)]).collect();
        let before: &ReplicaMap = map;
        let gather =
            |(parity, part): &(usize, Range<usize>)| self.gather_part(before, *parity, part.clone(), samples.clone());
        let gathered: Vec<(Vec<HalfScores>, HalfChecks, u64, PartScores)> = parts.par_iter().map(gather).collect();
        let mut rays = 0;
        for ((parity, part), (scores, checks, part_rays, single)) in parts.into_iter().zip(gathered) {
            let block = part.start / ENTRIES_PER_BLOCK;
            for (entry, scores) in part.clone().zip(&scores) {
                for (row, sum_lx) in scores.rows_lx.iter().enumerate() {
                    map.indirect[2 * row + parity][entry] += sum_lx;
                }
                if let Some(crossing) = &mut map.crossing {
                    crossing.add(parity, entry, scores);
                }
            }
            if let Some(crossing) = &mut map.crossing {
                crossing.correct(parity, block, &checks);
                if parity == 0 {
                    crossing.count(block, part.len() as u64 * (samples.end - samples.start));
                }
            }
            map.scores[1].merge(single);
            rays += part_rays;
        }
        rays
    }

    /// The eight replicas of a half, from entries that lie in one block.
    fn gather_part(
        &self,
        before: &ReplicaMap,
        parity: usize,
        entries: Range<usize>,
        samples: Range<u64>,
    ) -> (Vec<HalfScores>, HalfChecks, u64, PartScores) {
        let number = match self.kind {
            MapKind::Elements => 0,
            MapKind::Receivers(set) => set as u32 + 1,
        };
        let seed = self.context.seed;
        let mut streams: [Stream; HALF] =
            std::array::from_fn(|row| Stream::new(seed, Purpose::Gathering, number, (2 * row + parity) as u32));
        let mut memory = Recollection::new(self.context, self.forward, parity, self.checked_share);
        let mut cut = Cut::default();
        let mut rays = 0;
        let mut single = PartScores::for_task(&before.scores[1]);
        let scores = entries.map(|entry| {
            memory.scores = HalfScores::default();
            let Some(site) = self.site(entry) else {
                return memory.scores;
            };
            for (row, stream) in streams.iter_mut().enumerate() {
                memory.row = row;
                let mut entry_scores = single.of_entry(self.weight(entry), before.levels[1].of(entry));
                for number in samples.clone() {
                    stream.seek_quasi(stream_index(entry, number), entry as u64, number);
                    let (lx, sample_rays) = self.sample(&site, &mut memory, &mut cut, stream);
                    memory.scores.rows_lx[row] += lx;
                    entry_scores.add(lx);
                    rays += sample_rays;
                }
            }
            memory.scores
        });
        let scores = scores.collect();
        (scores, memory.checks, rays, single)
    }

    /// Area of an element side in m², or weight of a receiver.
    fn weight(&self, entry: usize) -> f64 {
        match self.kind {
            MapKind::Elements => {
                let elements = &self.context.stage.elements;
                elements.area_m2(self.context.scene, elements.cell(entry as u32))
            }
            MapKind::Receivers(set) => self.context.scene.receivers[set].points[entry].weight,
        }
    }

    /// Where the rays of an entry start; `None` for a point inside a solid.
    pub fn site(&self, entry: usize) -> Option<Site> {
        let stage = self.context.stage;
        match self.kind {
            MapKind::Elements => {
                let cell = stage.elements.cell(entry as u32);
                let corners = stage.elements.part_corners(cell.triangle, cell.part);
                Some(Site::Element { cell, corners, normal: stage.normal(cell.triangle, cell.side) })
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

    /// One sample of the indirect illuminance at a site in lx, and the rays it took.
    #[inline]
    pub fn sample(&self, site: &Site, memory: &mut Recollection, cut: &mut Cut, stream: &mut Stream) -> (f64, u64) {
        let stage = self.context.stage;
        match site {
            Site::Element { cell, corners, normal } => {
                let origin = origin_in_element(stage, cell, corners, stream);
                let receiver = Receiver { point_m: stage.tracer.position_m(&origin), normal: *normal, origin: &origin };
                gather_indirect_lx(stage, &receiver, memory, cut, stream)
            }
            Site::Point { point_m, normal, origin, quantity } => {
                let receiver = Receiver { point_m: *point_m, normal: *normal, origin };
                let (plane, weight) = one_plane(*quantity, &receiver, stream);
                memory.weight = weight;
                let (lx, rays) = gather_indirect_lx(stage, &plane, memory, cut, stream);
                (weight * lx, rays)
            }
        }
    }
}

/// Where gathering rays start.
pub enum Site {
    /// Anywhere in an element side.
    Element {
        /// The element.
        cell: Cell,
        /// Barycentric coordinates of its corners in its triangle.
        corners: [[f64; 2]; 3],
        /// Unit normal.
        normal: DVec3,
    },
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

/// Cuts a range of entries into parts that lie in one block each.
fn parts_of(entries: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let blocks = entries.start / ENTRIES_PER_BLOCK..entries.end.div_ceil(ENTRIES_PER_BLOCK);
    blocks.map(move |block| {
        (block * ENTRIES_PER_BLOCK).max(entries.start)..((block + 1) * ENTRIES_PER_BLOCK).min(entries.end)
    })
}
