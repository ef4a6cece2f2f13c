//! What gathers, and its rays: those that fill cells, those whose values count, and residual walks.

use std::ops::Range;

use rayon::prelude::*;

use super::records::{Flight, Records, WalkRecord, look_up};
use crate::caches::{CellGrid, CellLight};
use crate::estimators::gathering::{CellPlace, PendingTerm, fill_cells, find_cell_place, gather, residual_walk};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::solver::guide::Guide;
use crate::solver::order::{Order, RayOrder, WalkOrder};
use crate::solver::starts::Starts;
use crate::solver::streams::stream_index;

/// Rays, or walks, whose cells are looked up together.
const BLOCK: u64 = 64;

/// What gathers: elements or receivers.
pub struct Gatherer<'a> {
    /// Where its rays start.
    pub starts: Starts<'a>,
    /// Whether elements show slopes.
    pub slopes: bool,
}

impl Gatherer<'_> {
    /// Fills the cells of a half with rays that go like gathering rays. Returns the rays, including those of samples.
    pub fn fill(
        &self,
        cells: &mut CellLight,
        (half, most_samples): (u32, u16),
        (order, guide): (Order, &Guide),
        range: Range<u64>,
    ) -> u64 {
        let Starts { context, number: map, .. } = self.starts;
        let world = context.world;
        let room = || (Stream::new(context.seed, Purpose::CellFills, map, half), Cut::default());
        let numbers = (0..(range.end - range.start) as usize).into_par_iter().with_min_len(BLOCK as usize);
        let found: Vec<(Option<CellPlace>, u64)> = numbers
            .map_init(room, |(stream, cut), number| {
                let (pass, entry) = order.at(range.start + number as u64);
                let Some(site) = self.starts.site(entry) else {
                    return (None, 0);
                };
                stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                let start = self.starts.draw(&site, stream);
                if start.weight == 0.0 {
                    return (None, start.rays);
                }
                let (met, rays) =
                    find_cell_place(world, &cells.grid, &start.receiver(), guide.density_at(entry), cut, stream);
                (met, start.rays + rays)
            })
            .collect();
        let rays = found.iter().map(|(_, rays)| rays).sum::<u64>();
        let places = found.into_iter().filter_map(|(met, _)| met);
        // Samples are numbered across all maps.
        let stream = || Stream::new(context.seed, Purpose::Cells, 0, half);
        rays + fill_cells(world, cells, most_samples, places, stream)
    }

    /// Traces the gathering rays of one replica, whose values count. Returns the rays.
    pub fn gather(
        &self,
        records: &mut Records,
        (replica, grid): (u32, &CellGrid),
        (order, guide): (&RayOrder, &Guide),
        range: Range<u64>,
    ) -> u64 {
        let Starts { context, number: map, .. } = self.starts;
        let world = context.world;
        // The rays by which others were shared out must not come again.
        let purpose = if order.allotment.is_even() { Purpose::CellRays } else { Purpose::AllottedRays };
        let mut stream = Stream::new(context.seed, purpose, map, replica);
        let mut cut = Cut::default();
        let mut rays = 0;
        let mut pending: Vec<Option<PendingTerm>> = Vec::with_capacity(BLOCK as usize);
        for block in blocks(range) {
            for (number, entry) in order.entries(block) {
                let (mut plain_lx, mut term, mut bin) = (0.0, None, 0);
                let mut flight = Flight { at: [0.0; 2], length_m: f32::INFINITY };
                if let Some(site) = self.starts.site(entry) {
                    stream.seek_quasi(stream_index(entry, number), entry as u64, number);
                    let start = self.starts.draw(&site, &mut stream);
                    (flight.at, rays) = (start.at.map(|weight| weight as f32), rays + start.rays);
                    if start.weight > 0.0 {
                        let density = guide.density_at(entry);
                        let found = gather(world, grid, &start.receiver(), density, &mut cut, &mut stream);
                        plain_lx = start.weight * found.plain_lx;
                        let weighted =
                            |term: PendingTerm| PendingTerm { factor: start.weight as f32 * term.factor, ..term };
                        term = found.term.map(weighted);
                        (bin, rays, flight.length_m) = (found.bin, rays + found.rays, found.distance_m as f32);
                    }
                }
                if self.slopes {
                    records.flights.push(flight);
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

    /// Traces the residual walks of one replica. Returns the rays.
    pub fn walk(
        &self,
        records: &mut Records,
        (replica, grid): (u32, &CellGrid),
        (order, guide): (&WalkOrder, &Guide),
        range: Range<u64>,
    ) -> u64 {
        let Starts { context, number: map, .. } = self.starts;
        let world = context.world;
        let mut stream = Stream::new(context.seed, Purpose::Residuals, map, replica);
        let mut cut = Cut::default();
        let mut rays = 0;
        let mut pending: Vec<PendingTerm> = Vec::new();
        for block in blocks(range) {
            for (pass, entry) in order.entries(block) {
                let (mut plain_lx, mut plain_of_step_lx, mut bin, mut at) = (0.0, 0.0, 0, [0.0; 2]);
                if let Some(site) = self.starts.site(entry) {
                    stream.seek_quasi(stream_index(entry, pass), entry as u64, pass);
                    let start = self.starts.draw(&site, &mut stream);
                    (at, rays) = (start.at, rays + start.rays);
                    if start.weight > 0.0 {
                        let note = |term: PendingTerm| pending.push(term);
                        let drawn = (start.weight, guide.density_at(entry));
                        let walked = residual_walk(world, grid, &start.receiver(), drawn, &mut cut, &mut stream, note);
                        (plain_lx, plain_of_step_lx) = (walked.plain_lx, walked.plain_of_step_lx);
                        (bin, rays) = (walked.bin, rays + walked.rays);
                    }
                }
                if self.slopes {
                    records.walk_starts.push(at.map(|weight| weight as f32));
                }
                records.walk_bins.push(bin);
                records.walks.push(WalkRecord {
                    plain_lx: plain_lx as f32,
                    plain_of_step_lx: plain_of_step_lx as f32,
                    end: (records.walk_terms.len() + pending.len()) as u32,
                });
            }
            let found = pending.drain(..).map(Some);
            found.for_each(|term| look_up(grid, term, &mut records.walk_terms, &mut records.new_of_walks));
        }
        rays
    }
}

/// Splits a range into blocks.
fn blocks(range: Range<u64>) -> impl Iterator<Item = Range<u64>> {
    let end = range.end;
    range.step_by(BLOCK as usize).map(move |first| first..(first + BLOCK).min(end))
}
