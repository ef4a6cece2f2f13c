//! Maps by light meshes: every place of a map asked for its direct and indirect light.

use glam::DVec3;
use rayon::prelude::*;

use super::exact::{Spot, look_at_all, looks_are_exact};
use super::indirect::{GatherCounts, GatherRoom, IndirectMesh, walks_at_place_lx};
use super::mesh::{Counts, LightMesh, Surroundings, Workroom};
use super::samples::Samples;
use crate::maps::MapKind;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::ReceiverLayout;

/// Places of an element at which a mesh is asked: their mean is exact for what varies quadratically.
const PLACES_OF_ELEMENT: [[f64; 2]; 3] = [[1.0 / 6.0, 1.0 / 6.0], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0]];
/// Entries that a thread takes at a time.
const ENTRIES_PER_CHUNK: usize = 128;
/// Bits of a stream's index that count samples.
const SAMPLE_BITS: u32 = 32;

/// The entries of a map: points of a receiver set, or element sides.
pub struct Entries {
    /// Which map.
    pub kind: MapKind,
    /// Weight of each entry in the map's error; 0 leaves it out.
    pub weights: Vec<f64>,
    /// Area in m² that the map stands for; `None` for loose points.
    pub area_m2: Option<f64>,
    /// Box around all places.
    pub bounds_m: [DVec3; 2],
}

impl Entries {
    /// The entries of a map.
    pub fn of(around: &Surroundings, kind: MapKind) -> Entries {
        let mut bounds_m = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut include = |place_m: DVec3| bounds_m = [bounds_m[0].min(place_m), bounds_m[1].max(place_m)];
        let (weights, area_m2) = match kind {
            MapKind::Receivers(set) => {
                let set = &around.scene.receivers[set];
                set.points.iter().filter(|point| !point.inside).for_each(|point| include(point.position_m));
                let weights = set.points.iter().map(|point| if point.inside { 0.0 } else { point.weight });
                let area_m2 = match set.layout {
                    ReceiverLayout::Grid { area_m2, .. } => Some(area_m2),
                    _ => None,
                };
                (weights.collect(), area_m2)
            }
            MapKind::Elements => {
                around.scene.vertices_m.iter().for_each(|vertex_m| include(*vertex_m));
                let elements = &around.stage.elements;
                let weights: Vec<f64> = (0..elements.len() as u32)
                    .map(|cell| elements.area_m2(around.scene, elements.cell(cell)))
                    .collect();
                let area_m2 = weights.iter().sum();
                (weights, Some(area_m2))
            }
        };
        Entries { kind, weights, area_m2, bounds_m }
    }

    /// Whether an entry is a mean over an area.
    pub fn are_means(&self) -> bool {
        self.kind == MapKind::Elements
    }

    /// Places at which the mesh is asked, over all entries.
    pub fn places(&self) -> usize {
        self.weights.len() * if self.are_means() { PLACES_OF_ELEMENT.len() } else { 1 }
    }

    /// A place of an entry: the receiver, or a random point of the element.
    pub fn drawn_spot(&self, around: &Surroundings, entry: usize, stream: &mut Stream) -> Spot {
        match self.kind {
            MapKind::Receivers(set) => Spot::of_point(&around.scene.receivers[set].points[entry]),
            MapKind::Elements => Spot::drawn_in_cell(around, around.stage.elements.cell(entry as u32), stream),
        }
    }

    /// Hands the places at which the mesh is asked to `ask`.
    fn each_spot(&self, around: &Surroundings, entry: usize, mut ask: impl FnMut(Spot)) -> f64 {
        match self.kind {
            MapKind::Receivers(set) => {
                ask(Spot::of_point(&around.scene.receivers[set].points[entry]));
                1.0
            }
            MapKind::Elements => {
                let cell = around.stage.elements.cell(entry as u32);
                PLACES_OF_ELEMENT.iter().for_each(|place| ask(Spot::of_cell(around, cell, *place)));
                PLACES_OF_ELEMENT.len() as f64
            }
        }
    }
}

/// How direct light is computed.
pub enum DirectBy<'m, 'a> {
    /// By a mesh.
    Mesh(&'m LightMesh<'a>),
    /// By shadow rays from every place, with so many passes over the luminaires in each half.
    Rays {
        /// Passes of each half.
        passes: u64,
    },
    /// By a shadow ray to every one of these points, each a point source of its own.
    Points(&'m Samples),
}

/// How indirect light is computed.
pub enum IndirectBy<'m, 'a> {
    /// Nothing reflects.
    Nothing,
    /// Gathered at the points of a mesh.
    Mesh(&'m IndirectMesh<'a>),
    /// By so many walks from every place.
    Walks(u32),
}

/// What one entry of a map receives, in lx.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EntryLight {
    /// Direct light by each half.
    pub direct_lx: [f64; 2],
    /// Indirect light by each half.
    pub indirect_lx: [f64; 2],
    /// The points of its set disagreed about some luminaire.
    pub mixed: bool,
}

impl EntryLight {
    /// Direct light.
    pub fn direct_mean_lx(&self) -> f64 {
        0.5 * (self.direct_lx[0] + self.direct_lx[1])
    }

    /// Indirect light.
    pub fn indirect_mean_lx(&self) -> f64 {
        0.5 * (self.indirect_lx[0] + self.indirect_lx[1])
    }

    /// Both parts by each half.
    pub fn halves_lx(&self) -> [f64; 2] {
        [0, 1].map(|half| self.direct_lx[half] + self.indirect_lx[half])
    }
}

/// What computing entries took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// By the mesh.
    pub mesh: Counts,
    /// By gathering indirect light.
    pub gather: GatherCounts,
    /// Shadow rays from places that no mesh served.
    pub exact_rays: u64,
}

impl Effort {
    /// Rays of all kinds.
    pub fn rays(&self) -> u64 {
        self.mesh.rays() + self.gather.rays() + self.exact_rays
    }
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Effort) {
        self.mesh += other.mesh;
        self.gather += other.gather;
        self.exact_rays += other.exact_rays;
    }
}

/// Computes some entries of a map, over threads; the values depend on neither threads nor order.
pub fn light_of(
    around: &Surroundings,
    entries: &Entries,
    asked: &[usize],
    direct: &DirectBy,
    indirect: &IndirectBy,
    seed: u64,
    map: u32,
) -> (Vec<EntryLight>, Effort) {
    let chunks: Vec<(Vec<EntryLight>, Effort)> = asked
        .par_chunks(ENTRIES_PER_CHUNK)
        .map(|chunk| {
            let (mut room, mut gather) = (Workroom::default(), GatherRoom::default());
            let mut exact_rays = 0;
            let lights = chunk.iter().map(|entry| {
                let mut light = EntryLight::default();
                if entries.weights[*entry] <= 0.0 {
                    return light;
                }
                if let DirectBy::Rays { passes } = direct {
                    let (halves_lx, rays) = by_rays(around, entries, *entry, *passes, seed, map);
                    light.direct_lx = halves_lx;
                    exact_rays += rays;
                }
                let mut number = 0;
                let places = entries.each_spot(around, *entry, |spot| {
                    spot.ask(around.stage, |receiver| {
                        match direct {
                            DirectBy::Mesh(mesh) => {
                                let here = mesh.direct(receiver, &mut room);
                                light.direct_lx = light.direct_lx.map(|lx| lx + here.illuminance_lx);
                                light.mixed |= here.mixed;
                            }
                            DirectBy::Points(points) => {
                                let (here_lx, rays) = points.as_point_sources_lx(around.stage, receiver);
                                light.direct_lx = light.direct_lx.map(|lx| lx + here_lx);
                                exact_rays += rays;
                            }
                            DirectBy::Rays { .. } => {}
                        }
                        let place = (*entry * PLACES_OF_ELEMENT.len() + number) as u64;
                        let here_lx = match indirect {
                            IndirectBy::Nothing => [0.0; 2],
                            IndirectBy::Mesh(mesh) => mesh.indirect_lx(receiver, place, &mut gather),
                            IndirectBy::Walks(walks) => {
                                let (lx, rays) =
                                    walks_at_place_lx(around.stage, receiver, place, *walks, seed, &mut gather.cut);
                                gather.counts.walk_rays += rays;
                                lx
                            }
                        };
                        light.indirect_lx = [0, 1].map(|half| light.indirect_lx[half] + here_lx[half]);
                        number += 1;
                    });
                });
                if !matches!(direct, DirectBy::Rays { .. }) {
                    light.direct_lx = light.direct_lx.map(|lx| lx / places);
                    // Between its places an element may hold a shadow's edge that none of them is near.
                    light.mixed |= entries.are_means();
                }
                light.indirect_lx = light.indirect_lx.map(|lx| lx / places);
                light
            });
            let lights = lights.collect();
            (lights, Effort { mesh: room.counts, gather: gather.counts, exact_rays })
        })
        .collect();
    let mut lights = Vec::with_capacity(asked.len());
    let mut effort = Effort::default();
    for (chunk, of_chunk) in chunks {
        lights.extend(chunk);
        effort += of_chunk;
    }
    (lights, effort)
}

/// Direct light by shadow rays in two independent halves.
fn by_rays(
    around: &Surroundings,
    entries: &Entries,
    entry: usize,
    passes: u64,
    seed: u64,
    map: u32,
) -> ([f64; 2], u64) {
    let mut rays = 0;
    let one_half = looks_are_exact(around.stage) && !entries.are_means();
    let mut half_lx = |half: u64| {
        let mut stream = Stream::new(seed, Purpose::Direct, map, half as u32);
        let mut sum_lx = 0.0;
        for pass in 0..passes {
            stream.seek(((entry as u64) << SAMPLE_BITS) | pass);
            let spot = entries.drawn_spot(around, entry, &mut stream);
            let (lx, pass_rays) = spot.ask(around.stage, |receiver| look_at_all(around.stage, receiver, &mut stream));
            sum_lx += lx;
            rays += pass_rays;
        }
        sum_lx / passes.max(1) as f64
    };
    let first_lx = half_lx(0);
    let second_lx = if one_half { first_lx } else { half_lx(1) };
    ([first_lx, second_lx], rays)
}
