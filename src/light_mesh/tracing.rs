//! Maps by light meshes: computes the direct and indirect light of every receiver point of a map.

use rayon::prelude::*;

use super::anew::{sample_direct, walks_of_entry};
use super::entries::Entries;
use super::exact::{light_samples_are_exact, sample_all_emitters};
use super::indirect::{GatherCounts, GatherRoom, IndirectMesh};
use super::mesh::{Counts, LightMesh, SetKind, Surroundings, Workroom};
use super::samples::Samples;
use super::walks::walks_at_place_lx;
use crate::sampling::random::{Purpose, SAMPLE_BITS, Stream};
use crate::transport::Traced;

/// Entries that a thread takes at a time.
const ENTRIES_PER_CHUNK: usize = 128;

/// Method for computing direct light.
pub enum DirectBy<'m, 'a> {
    /// By a mesh.
    Mesh(&'m LightMesh<'a>),
    /// By shadow rays from every receiver point, with a number of passes over the luminaires in each half.
    Rays {
        /// Number of the first pass.
        first: u64,
        /// Number of passes in each half.
        passes: u64,
    },
    /// By a shadow ray to every one of these sample points, each as a point source.
    Points(&'m Samples),
}

/// Method for computing indirect light.
pub enum IndirectBy<'m, 'a> {
    /// No surface reflects.
    Nothing,
    /// Light is gathered at the points of a mesh.
    Mesh(&'m IndirectMesh<'a>),
    /// By walks from every receiver point: number of the first walk, and count.
    Walks([u32; 2]),
}

/// Light that one entry of a map receives or shows, in the unit of the map's quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EntryLight {
    /// Direct light from each half.
    pub direct: [f64; 2],
    /// Indirect light from each half.
    pub indirect: [f64; 2],
    /// Kind of its sets of mesh points for direct light: that of the least certain of its points.
    pub set: SetKind,
    /// Amount of its direct light on which its sets disagreed.
    pub disputed: f64,
    /// Kind of its sets of mesh points for indirect light.
    pub indirect_set: SetKind,
    /// Whether no surface is in the entry: it shows luminaires or nothing.
    pub is_known: bool,
}

impl EntryLight {
    /// Returns the direct light, averaged over the halves.
    pub fn direct_mean(&self) -> f64 {
        0.5 * (self.direct[0] + self.direct[1])
    }

    /// Returns the indirect light, averaged over the halves.
    pub fn indirect_mean(&self) -> f64 {
        0.5 * (self.indirect[0] + self.indirect[1])
    }

    /// Returns the sum of both parts in each half.
    pub fn halves(&self) -> [f64; 2] {
        [0, 1].map(|half| self.direct[half] + self.indirect[half])
    }
}

/// Work for computing entries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Counts of the mesh.
    pub mesh: Counts,
    /// Counts of gathering indirect light.
    pub gather: GatherCounts,
    /// Shadow rays from receiver points without a mesh.
    pub exact_rays: u64,
    /// Rays of lines of sight.
    pub sight_rays: u64,
}

impl Effort {
    /// Returns the rays of all kinds.
    pub fn rays(&self) -> u64 {
        self.mesh.rays() + self.gather.rays() + self.exact_rays + self.sight_rays
    }
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Effort) {
        self.mesh += other.mesh;
        self.gather += other.gather;
        self.exact_rays += other.exact_rays;
        self.sight_rays += other.sight_rays;
    }
}

/// Computes some entries of a map in parallel. The values depend neither on threads nor on order.
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
                let mut light = EntryLight { is_known: !entries.has_places(*entry), ..EntryLight::default() };
                if entries.weights[*entry] <= 0.0 || (around.give_up)() {
                    return light;
                }
                if let DirectBy::Rays { first, passes } = direct {
                    let (halves, rays) = by_rays(around, entries, *entry, [*first, *passes], seed, map);
                    light.direct = halves;
                    exact_rays += rays;
                }
                if entries.draw_lines_of_sight() {
                    if let IndirectBy::Walks(walks) = indirect {
                        let (halves, rays) = walks_of_entry(around, entries, *entry, *walks, seed, &mut gather.cut);
                        light.indirect = halves;
                        gather.counts.walk_rays += rays;
                    }
                    return light;
                }
                light.direct = light.direct.map(|sum| sum + entries.own_light_cd_m2(*entry));
                let mut number = 0;
                entries.each_spot(around, *entry, |spot, weight| {
                    spot.with_receiver(around.world, |receiver| {
                        match direct {
                            DirectBy::Mesh(mesh) => {
                                let here = mesh.direct(receiver, &mut room);
                                light.direct = light.direct.map(|sum| sum + weight * here.illuminance_lx);
                                light.set = light.set.max(here.set);
                                light.disputed += weight * here.disputed_lx;
                            }
                            DirectBy::Points(points) => {
                                let here = points.as_point_sources_lx(around.world, receiver);
                                light.direct = light.direct.map(|sum| sum + weight * here.value);
                                exact_rays += here.rays;
                            }
                            DirectBy::Rays { .. } => {}
                        }
                        let place = entries.place_number(*entry, number);
                        let here = match indirect {
                            IndirectBy::Nothing => [0.0; 2],
                            IndirectBy::Mesh(mesh) => {
                                let (lx, set) = mesh.indirect_lx(receiver, place, &mut gather);
                                light.indirect_set = light.indirect_set.max(set);
                                lx
                            }
                            IndirectBy::Walks(walks) => {
                                let (lx, rays) =
                                    walks_at_place_lx(around, receiver, place, *walks, seed, &mut gather.cut);
                                gather.counts.walk_rays += rays;
                                lx
                            }
                        };
                        light.indirect = [0, 1].map(|half| light.indirect[half] + weight * here[half]);
                        number += 1;
                    });
                });
                light
            });
            let lights = lights.collect();
            (lights, Effort { mesh: room.counts, gather: gather.counts, exact_rays, sight_rays: 0 })
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

/// Returns the direct light by shadow rays in two independent halves, and the number of rays.
fn by_rays(
    around: &Surroundings,
    entries: &Entries,
    entry: usize,
    [first, passes]: [u64; 2],
    seed: u64,
    map: u32,
) -> ([f64; 2], u64) {
    let mut rays = 0;
    let one_half = light_samples_are_exact(around.world) && !entries.are_means() && !entries.draw_lines_of_sight();
    let mut half_of = |half: u64| {
        let mut stream = Stream::new(seed, Purpose::Direct, map, half as u32);
        let mut sum = Traced::default();
        for pass in first..first + passes {
            stream.seek_quasi(((entry as u64) << SAMPLE_BITS) | pass, entry as u64, pass);
            if entries.draw_lines_of_sight() {
                sum += sample_direct(around, entries, entry, &mut stream);
                continue;
            }
            entries.each_drawn_spot(around, entry, &mut stream, |spot, weight, stream| {
                let world = around.world;
                sum += weight * spot.with_receiver(world, |receiver| sample_all_emitters(world, receiver, stream));
            });
        }
        rays += sum.rays;
        sum.value / passes.max(1) as f64
    };
    let first_half = half_of(0);
    let second_half = if one_half { first_half } else { half_of(1) };
    ([first_half, second_half], rays)
}

fn weighted(entries: &Entries, lights: &[EntryLight], of: impl Fn(&EntryLight) -> f64) -> f64 {
    let weight: f64 = entries.weights.iter().sum();
    let sum: f64 = entries.weights.iter().zip(lights).map(|(weight, light)| weight * of(light)).sum();
    if weight > 0.0 { sum / weight } else { 0.0 }
}

/// Returns the weighted mean over the entries, in the unit of the map's values.
pub(super) fn mean_value(entries: &Entries, lights: &[EntryLight]) -> f64 {
    weighted(entries, lights, |light| light.direct_mean() + light.indirect_mean())
}

/// Returns the random error in the unit of the map's values, from the difference of the two halves.
pub(super) fn random_error(entries: &Entries, lights: &[EntryLight], halves: impl Fn(&EntryLight) -> [f64; 2]) -> f64 {
    let square = |light: &EntryLight| {
        let [even, odd] = halves(light);
        (even - odd).powi(2)
    };
    0.5 * weighted(entries, lights, square).sqrt()
}
