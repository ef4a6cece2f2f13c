//! Gathering through cells: rays that look cells up, the samples that cells take, and walks that measure the error of the cells.
//!
//! E_indirect = mean_k ρ_k (D(y_k) + I(y_k)). Ray k meets point y_k. A light sample finds the direct light D there, and a cell gives the
//! indirect illuminance I. Separate rays fill the cells. They start where the other rays do, and the points that they meet are the points
//! of the samples. So samples lie where cells are looked up. No ray whose value counts fills a cell. Otherwise the value that it reads
//! would correlate with what it met, and walks would measure a different bias. The results of a ray or a walk are kept as cell numbers with
//! factors, so they can be summed once the light of the cells is solved for.

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::caches::{CellGrid, CellKey, CellLight, CellSample, Lookup, NO_CELL};
use crate::estimators::cache::{Cache, CacheAnswer, Met};
use crate::estimators::receiver::Receiver;
use crate::estimators::walk::{MOST_RAYS_OF_A_WALK, walk_indirect_lx, walk_parts_lx};
use crate::geometry::Origin;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::guide::{Density, bin_of};
use crate::sampling::random::Stream;
use crate::transport::World;

/// Minimum number of samples that a thread takes at a time.
const SAMPLES_A_TASK: usize = 64;

/// Rays that start in cells look up cells of this many times the edge that rays of entries look up. Many such rays together make the light
/// of one cell, so the errors of the cells that they look up average out.
const EDGES_FROM_CELLS: f64 = 2.0;

/// Factor with which the light of a cell counts.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Term {
    /// The cell, or [`NO_CELL`].
    pub cell: u32,
    /// The factor.
    pub factor: f32,
}

impl Term {
    /// Term without a cell.
    pub const NONE: Term = Term { cell: NO_CELL, factor: 0.0 };
}

/// A diffuse surface point that a ray met.
#[derive(Clone, Copy)]
struct DiffusePlace {
    point_m: DVec3,
    normal: DVec3,
    origin: Origin,
}

impl DiffusePlace {
    fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.point_m, normal: self.normal, origin: &self.origin }
    }
}

/// Records where a ray met the first diffuse surface, and how it looks the cell up there.
struct FirstDiffuse<'a> {
    world: &'a World,
    grid: &'a CellGrid,
    /// Whether a light sample for direct light is also taken there.
    samples: bool,
    /// Edge of the cell, relative to one that a ray of an entry looks up.
    edges: f64,
    found: Option<CellPlace>,
}

/// A surface point whose cell a ray looks up.
#[derive(Clone, Copy)]
pub struct CellPlace {
    place: DiffusePlace,
    key: CellKey,
    reflectance: f64,
    /// Length in m of the ray that met it.
    distance_m: f64,
}

impl Cache for FirstDiffuse<'_> {
    const SUPPLIES: bool = true;

    #[inline]
    fn look_up(&mut self, met: &Met, _: &mut Cut, _: &mut Stream) -> (CacheAnswer, u64) {
        let Receiver { point_m, normal, origin } = met.receiver;
        let tracer = &self.world.tracer;
        let lookup = Lookup { point_m, normal, distance_m: self.edges * met.hit.distance_m };
        let key = self.grid.key(&lookup, |to_m| !tracer.is_occluded(origin, &tracer.free_origin(to_m)));
        let place = DiffusePlace { point_m, normal, origin: *origin };
        self.found = Some(CellPlace { place, key, reflectance: met.reflectance, distance_m: met.hit.distance_m });
        (if self.samples { CacheAnswer::End(0.0) } else { CacheAnswer::Stop }, 1)
    }
}

/// A [`Term`] whose cell is still to be looked up.
///
/// Look-ups are done many at a time. Each waits for memory, and many together wait no longer than one.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct PendingTerm {
    /// The cell.
    pub key: CellKey,
    /// The factor by which its light counts.
    pub factor: f32,
}

impl PendingTerm {
    /// The term, once the cell is known.
    #[inline]
    pub fn of_cell(&self, cell: u32) -> Term {
        Term { cell, factor: self.factor }
    }
}

impl CellPlace {
    #[inline]
    fn pending_term(&self, factor: f64) -> PendingTerm {
        PendingTerm { key: self.key, factor: factor as f32 }
    }
}

/// Result of a gathering ray.
pub struct Gathered {
    /// Light found apart from the cell's light, in lx.
    pub plain_lx: f64,
    /// The cell that the ray looks up.
    pub term: Option<PendingTerm>,
    /// Distance in m to the diffuse surface that it met; infinite if it met none.
    pub distance_m: f64,
    /// Bin of its direction: see [`crate::sampling::guide`].
    pub bin: u8,
    /// Number of rays traced.
    pub rays: u64,
}

/// Sends a ray from a receiver. Its direction follows a density, if there is one.
pub fn gather(
    world: &World,
    grid: &CellGrid,
    receiver: &Receiver,
    density: Option<&Density>,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Gathered {
    let mut first = FirstDiffuse { world, grid, samples: true, edges: 1.0, found: None };
    let (variates, weight) = drawn(density, stream);
    let ([sampled_lx, arriving_lx], rays) = walk_parts_lx(world, receiver, variates, &mut first, cut, stream);
    Gathered {
        plain_lx: sampled_lx + weight * arriving_lx,
        distance_m: first.found.map_or(f64::INFINITY, |met| met.distance_m),
        term: first.found.map(|met| met.pending_term(weight * met.reflectance)),
        bin: bin_of(variates) as u8,
        rays,
    }
}

/// Two variates that follow a density, if there is one, and their weight.
#[inline]
fn drawn(density: Option<&Density>, stream: &mut Stream) -> ([f64; 2], f64) {
    let variates = stream.pair();
    density.map_or((variates, 1.0), |density| density.warp(variates))
}

/// Sends a ray from a point in a cell. Returns the light found apart from the cell's light in lx, the point whose cell it looks up (if it
/// met one), and the number of rays.
fn send(
    world: &World,
    grid: &CellGrid,
    receiver: &Receiver,
    cut: &mut Cut,
    stream: &mut Stream,
) -> (f64, Option<CellPlace>, u64) {
    let mut first = FirstDiffuse { world, grid, samples: true, edges: EDGES_FROM_CELLS, found: None };
    let plain = walk_indirect_lx(world, receiver, &mut first, cut, stream);
    (plain.value, first.found, plain.rays)
}

/// The point that a ray from a receiver meets, if any, and the number of rays. No light sample is taken there. Its direction follows a
/// density, if there is one.
pub fn find_cell_place(
    world: &World,
    grid: &CellGrid,
    receiver: &Receiver,
    density: Option<&Density>,
    cut: &mut Cut,
    stream: &mut Stream,
) -> (Option<CellPlace>, u64) {
    let (variates, _) = drawn(density, stream);
    trace_to_cell(world, grid, receiver, variates, cut, stream)
}

/// The same along the direction given by two variates.
fn trace_to_cell(
    world: &World,
    grid: &CellGrid,
    receiver: &Receiver,
    variates: [f64; 2],
    cut: &mut Cut,
    stream: &mut Stream,
) -> (Option<CellPlace>, u64) {
    let mut first = FirstDiffuse { world, grid, samples: false, edges: 1.0, found: None };
    let (_, rays) = walk_parts_lx(world, receiver, variates, &mut first, cut, stream);
    (first.found, rays)
}

/// A sample that a cell is to take at a point in it.
struct Booked {
    cell: u32,
    /// Its number within the cell.
    number: u16,
    place: DiffusePlace,
}

/// Result of a sample.
struct Taken {
    plain_lx: f32,
    next: Option<CellPlace>,
    /// Whether the cell that it looked up may take another sample there.
    goes_on: bool,
    rays: u64,
}

/// Lets the cells at some points take samples there, as long as they have fewer than `most_samples`. Continues with the cells that these
/// samples look up, in the same way. Returns the number of rays.
///
/// The work proceeds in waves: the samples of a wave are taken in parallel, and cells are booked in order. `stream` creates a stream for
/// samples.
pub fn fill_cells(
    world: &World,
    cells: &mut CellLight,
    most_samples: u16,
    places: impl Iterator<Item = CellPlace>,
    stream: impl Fn() -> Stream + Sync,
) -> u64 {
    let mut wave: Vec<Booked> = Vec::new();
    let book = |cells: &mut CellLight, cell: u32, place: DiffusePlace| Booked { cell, number: cells.book(cell), place };
    for met in places {
        let cell = cells.grid.cell(met.key);
        if cells.count(cell) < most_samples {
            wave.push(book(cells, cell, met.place));
        }
    }
    let mut rays = 0;
    while !wave.is_empty() {
        let first = cells.sample_count();
        let room = || (stream(), Cut::default());
        let grid = &cells.grid;
        let taken: Vec<Taken> = wave
            .par_iter()
            .enumerate()
            .with_min_len(SAMPLES_A_TASK)
            .map_init(room, |(stream, cut), (index, booked)| {
                stream.seek_quasi((first + index) as u64, u64::from(booked.cell), u64::from(booked.number));
                take(world, grid, &booked.place, cut, stream)
            })
            .collect();
        let mut next_wave = Vec::new();
        for (Booked { cell, .. }, Taken { plain_lx, next, goes_on, rays: more_rays }) in wave.iter().zip(taken) {
            rays += more_rays;
            let cell = *cell;
            let Some(met) = next else {
                cells.add(CellSample { cell, plain_lx, reflectance: 0.0, next: NO_CELL });
                continue;
            };
            let next = cells.grid.cell(met.key);
            cells.add(CellSample { cell, plain_lx, reflectance: met.reflectance as f32, next });
            // A cell without any sample needs one. Further samples are worth less if less light is passed on.
            let count = cells.count(next);
            if count == 0 || (count < most_samples && goes_on) {
                next_wave.push(book(cells, next, met.place));
            }
        }
        wave = next_wave;
    }
    rays
}

/// Takes a sample at a point: sends a ray on, and takes a light sample where it arrives.
fn take(world: &World, grid: &CellGrid, place: &DiffusePlace, cut: &mut Cut, stream: &mut Stream) -> Taken {
    let (plain_lx, next, rays) = send(world, grid, &place.receiver(), cut, stream);
    let goes_on = next.is_some_and(|met| stream.happens(met.reflectance));
    Taken { plain_lx: plain_lx as f32, next, goes_on, rays }
}

/// Result of a residual walk.
pub struct Walked {
    /// Light found apart from cells, in lx: by the whole walk, and by its first step.
    pub plain_lx: f64,
    pub plain_of_step_lx: f64,
    /// Bin of its first direction.
    pub bin: u8,
    /// Number of rays traced.
    pub rays: u64,
}

/// A walk that measures the error of the cells. The mean over walks of `plain_lx` plus the sum over all terms is the exact indirect
/// illuminance minus the value from the cells, in lx.
///
/// Each point y of the walk, in cell c, scores δ = P + ρ I_z − I_c by a ray to the next point z. P is the light that the ray finds by
/// itself, including direct light at z. The walk continues at z with probability ρ. Its first direction follows a density, if there is one.
/// Terms are passed to `note` one by one.
pub fn residual_walk(
    world: &World,
    grid: &CellGrid,
    receiver: &Receiver,
    (weight, density): (f64, Option<&Density>),
    cut: &mut Cut,
    stream: &mut Stream,
    mut note: impl FnMut(PendingTerm),
) -> Walked {
    let (variates, weight_of_first) = drawn(density, stream);
    let (met, rays) = trace_to_cell(world, grid, receiver, variates, cut, stream);
    let mut walked = Walked { plain_lx: 0.0, plain_of_step_lx: 0.0, bin: bin_of(variates) as u8, rays };
    let Some(mut here) = met else {
        return walked;
    };
    let weight = weight * weight_of_first * here.reflectance;
    let mut surfaces = 0;
    while walked.rays < MOST_RAYS_OF_A_WALK && !world.patience.is_over(surfaces) {
        surfaces += 1;
        note(here.pending_term(-weight));
        let (beside_lx, met, more_rays) = send(world, grid, &here.place.receiver(), cut, stream);
        walked.plain_lx += weight * beside_lx;
        if surfaces == 1 {
            walked.plain_of_step_lx = walked.plain_lx;
        }
        walked.rays += more_rays;
        let Some(next) = met else {
            return walked;
        };
        note(next.pending_term(weight * next.reflectance));
        if !stream.happens(next.reflectance) {
            return walked;
        }
        here = next;
    }
    world.patience.note_walk_given_up();
    walked
}
