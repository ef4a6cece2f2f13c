//! Gathering through cells: rays that ask cells, the samples that cells take, and walks that measure what cells have wrong.
//!
//! E_indirect = mean_k ρ_k H(y_k): ray k meets place y_k, whose illuminance H a cell tells. Rays of their own fill the cells: they
//! start where the others do, and what they meet are the places of the samples, so that samples lie where they are asked for. No
//! ray whose value counts fills a cell: what it reads would hang together with what it met, and walks would measure another bias
//! than its own. All that a ray or a walk found is kept as numbers of cells with their factors, so that it can be summed up once
//! the light of the cells is solved for.

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::caches::{CellGrid, CellKey, CellLight, CellRef, CellSample, Lookup};
use crate::chain::{Spot, Stage};
use crate::estimators::direct::{Care, Receiver, one_look};
use crate::estimators::walk::{MOST_RAYS_OF_A_WALK, Memory, Met, Recall, gather_along_lx, gather_indirect_lx};
use crate::geometry::Origin;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;

/// Samples that a thread takes at a time, at least.
const SAMPLES_A_TASK: usize = 64;

/// A factor by which the light of a cell counts.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Term {
    /// What is asked.
    pub asked: CellRef,
    /// The factor.
    pub factor: f32,
}

impl Term {
    /// Nothing was asked.
    pub const NONE: Term = Term { asked: CellRef::NONE, factor: 0.0 };
}

/// A diffuse place that a ray met.
#[derive(Clone, Copy)]
struct Place {
    spot: Spot,
    point_m: DVec3,
    normal: DVec3,
    origin: Origin,
}

impl Place {
    fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.point_m, normal: self.normal, origin: &self.origin }
    }
}

/// Notes where a ray met the first diffuse surface, and how it asks the cell there.
#[derive(Default)]
struct Asking {
    found: Option<Asked>,
}

/// A place that a ray asks about.
#[derive(Clone, Copy)]
pub struct Asked {
    place: Place,
    lookup: Lookup,
    reflectance: f64,
    /// Whether the ray has looked for luminaires itself, and asks for indirect light alone.
    indirect_alone: bool,
}

impl Memory for Asking {
    #[inline]
    fn recall(&mut self, met: &Met, _: &mut Cut, _: &mut Stream) -> (Recall, u64) {
        let Receiver { point_m, normal, origin } = met.receiver;
        let indirect_alone = met.looked_back;
        let distance_m = met.hit.distance_m;
        self.found = Some(Asked {
            place: Place { spot: (met.hit.triangle, met.hit.side), point_m, normal, origin: *origin },
            lookup: Lookup { point_m, normal, direction: met.direction, distance_m },
            reflectance: met.reflectance,
            indirect_alone,
        });
        (if indirect_alone { Recall::End(0.0) } else { Recall::Whole(0.0) }, 0)
    }
}

/// What a ray or a walk asks, before its cell is looked up.
///
/// Look-ups are done many at a time: each waits for memory, and many wait no longer than one.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Question {
    /// The cell.
    pub key: CellKey,
    /// Whether only its indirect light is asked for.
    pub indirect_alone: bool,
    /// The factor by which its light counts.
    pub factor: f32,
}

impl Question {
    /// The term, once the cell is known.
    #[inline]
    pub fn term(&self, cell: u32) -> Term {
        Term { asked: CellRef::new(cell, self.indirect_alone), factor: self.factor }
    }
}

impl Asked {
    #[inline]
    fn question(&self, grid: &CellGrid, factor: f64) -> Question {
        Question { key: grid.key(&self.lookup), indirect_alone: self.indirect_alone, factor: factor as f32 }
    }
}

/// Sends a ray from a receiver along the direction that two variates make; returns what it found beside the cell's light in lx,
/// what it asks, and the rays.
pub fn gather(
    stage: &Stage,
    grid: &CellGrid,
    receiver: &Receiver,
    variates: [f64; 2],
    cut: &mut Cut,
    stream: &mut Stream,
) -> (f64, Option<Question>, u64) {
    let mut asking = Asking::default();
    let (plain_lx, rays) = gather_along_lx(stage, receiver, variates, &mut asking, cut, stream);
    (plain_lx, asking.found.map(|asked| asked.question(grid, asked.reflectance)), rays)
}

/// Sends a ray from a receiver; returns what it found beside the light of the place that it asks about in lx, that place, if it met
/// one, and the rays.
pub fn look_for_place(
    stage: &Stage,
    receiver: &Receiver,
    cut: &mut Cut,
    stream: &mut Stream,
) -> (f64, Option<Asked>, u64) {
    let mut asking = Asking::default();
    let (plain_lx, rays) = gather_indirect_lx(stage, receiver, &mut asking, cut, stream);
    (plain_lx, asking.found, rays)
}

/// A sample that a cell is to take at a place in it.
struct Booked {
    cell: u32,
    /// Its number within the cell.
    number: u16,
    place: Place,
}

/// What a sample found.
struct Taken {
    direct_lx: f32,
    plain_lx: f32,
    next: Option<Asked>,
    /// Whether the cell that it asked may take a further sample there.
    goes_on: bool,
    rays: u64,
}

/// Lets the cells at some places take samples there if they want more, and goes on to the cells that these ask, as long as they
/// want samples; returns the rays.
///
/// Wave after wave: samples of a wave are taken side by side, cells are booked in order. `stream` makes one for samples.
pub fn fill_cells(
    stage: &Stage,
    cells: &mut CellLight,
    most_samples: u16,
    places: impl Iterator<Item = Asked>,
    stream: impl Fn() -> Stream + Sync,
) -> u64 {
    let mut wave: Vec<Booked> = Vec::new();
    let book = |cells: &mut CellLight, cell: u32, place: Place| Booked { cell, number: cells.book(cell), place };
    for asked in places {
        let cell = cells.grid.ask(&asked.lookup);
        if cells.count(cell) < most_samples {
            wave.push(book(cells, cell, asked.place));
        }
    }
    let mut rays = 0;
    while !wave.is_empty() {
        let first = cells.sample_count();
        let room = || (stream(), Cut::default());
        let taken: Vec<Taken> = wave
            .par_iter()
            .enumerate()
            .with_min_len(SAMPLES_A_TASK)
            .map_init(room, |(stream, cut), (index, booked)| {
                stream.seek_quasi((first + index) as u64, u64::from(booked.cell), u64::from(booked.number));
                take(stage, &booked.place, cut, stream)
            })
            .collect();
        let mut next_wave = Vec::new();
        for (Booked { cell, .. }, Taken { direct_lx, plain_lx, next, goes_on, rays: more_rays }) in
            wave.iter().zip(taken)
        {
            rays += more_rays;
            let cell = *cell;
            let Some(asked) = next else {
                cells.add(CellSample { cell, direct_lx, plain_lx, reflectance: 0.0, next: CellRef::NONE });
                continue;
            };
            let next_cell = cells.grid.ask(&asked.lookup);
            let next = CellRef::new(next_cell, asked.indirect_alone);
            cells.add(CellSample { cell, direct_lx, plain_lx, reflectance: asked.reflectance as f32, next });
            // A cell without any sample needs one; further ones are worth the less, the less light goes on.
            let count = cells.count(next_cell);
            if count == 0 || (count < most_samples && goes_on) {
                next_wave.push(book(cells, next_cell, asked.place));
            }
        }
        wave = next_wave;
    }
    rays
}

/// Takes a sample at a place: a light sample, and a ray on.
fn take(stage: &Stage, place: &Place, cut: &mut Cut, stream: &mut Stream) -> Taken {
    let receiver = place.receiver();
    let sight = one_look(stage, place.spot, &receiver, Care::Glance, cut, stream);
    let direct_lx = sight.as_ref().map_or(0.0, |sight| sight.direct_lx());
    let (plain_lx, next, rays) = look_for_place(stage, &receiver, cut, stream);
    let goes_on = next.is_some_and(|asked| stream.happens(asked.reflectance));
    Taken {
        direct_lx: direct_lx as f32,
        plain_lx: plain_lx as f32,
        next,
        goes_on,
        rays: rays + u64::from(sight.is_some()),
    }
}

/// A walk that measures how far the cells are off: the mean over walks of `plain_lx` and of the sum over all terms is the exact
/// indirect illuminance less what cells tell of it, in lx.
///
/// Each place y of the walk, in cell c, scores δ = D + P + ρ H_z − H_c by a light sample and a ray to the next place z, and the walk
/// goes on there with probability ρ. Returns `plain_lx` and the rays; questions are shown one by one.
pub fn residual_walk(
    stage: &Stage,
    grid: &CellGrid,
    receiver: &Receiver,
    weight: f64,
    cut: &mut Cut,
    stream: &mut Stream,
    mut ask: impl FnMut(Question),
) -> (f64, u64) {
    let (_, met, mut rays) = look_for_place(stage, receiver, cut, stream);
    let mut plain_lx = 0.0;
    let Some(mut here) = met else {
        return (0.0, rays);
    };
    let weight = weight * here.reflectance;
    while rays < MOST_RAYS_OF_A_WALK {
        ask(here.question(grid, -weight));
        let receiver = here.place.receiver();
        if !here.indirect_alone
            && let Some(sight) = one_look(stage, here.place.spot, &receiver, Care::Glance, cut, stream)
        {
            plain_lx += weight * sight.direct_lx();
            rays += 1;
        }
        let (beside_lx, met, more_rays) = look_for_place(stage, &receiver, cut, stream);
        plain_lx += weight * beside_lx;
        rays += more_rays;
        let Some(next) = met else {
            return (plain_lx, rays);
        };
        ask(next.question(grid, weight * next.reflectance));
        if !stream.happens(next.reflectance) {
            return (plain_lx, rays);
        }
        here = next;
    }
    (plain_lx, rays)
}
