//! The work itself, sixteen replicas in parallel: passes of direct light and of walks over the entries of a map, and chains.
//! A task is one replica (and for receivers a chunk of points). It writes to slabs of its own and uses streams keyed by its work, so that
//! the sums do not depend on threads.

mod walks;

use std::ops::Range;

use rayon::prelude::*;

pub use self::walks::{PointWalks, walks_from_points};
use super::adapt::{Adaptive, add_direct};
use super::allotment::Allotment;
use super::context::Context;
use super::ends::Ends;
use super::streams::{emission_shift, spread_choice, stream_index};
use crate::estimators::basis::{SLOPES, bends_at};
use crate::estimators::control_variate::ControlVariates;
use crate::estimators::direct::DirectPass;
use crate::estimators::element::Element;
use crate::estimators::receiver::Receiver;
use crate::estimators::reception::DirectSampler;
use crate::maps::{MapKind, PartScores, REPLICAS, ReplicaMap, Unit};
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Elements, IntensityTable};
use crate::transport::Traced;

/// Points of a receiver set that a thread takes at a time.
const POINTS_PER_CHUNK: usize = 64;
/// Arrivals of chains that score in the element map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScoredArrivals {
    /// Arrivals after the first reflection; direct light is computed separately.
    IndirectOnly,
    /// All arrivals.
    DirectToo,
}

/// Rays of a replica after which it traces no more chains for the flux balance.
const RAYS_FOR_ENDS: u64 = 20_000;

/// Does passes over the direct light of a range of element sides, each of which takes its samples of a pass. Returns the rays traced.
pub fn direct_over_elements(
    context: &Context,
    (elements, allotment): (&Elements, &Allotment),
    map: &mut ReplicaMap,
    range: Range<usize>,
    passes: Range<u64>,
) -> u64 {
    map.fix_direct_levels(range.clone());
    let (whole, levels) = (&map.scores[0], &map.levels[0]);
    // The samples by which others were shared out must not come again.
    let purpose = if allotment.is_even() { Purpose::Direct } else { Purpose::AllottedDirect };
    let replicas = map.direct.par_iter_mut().with_max_len(1).enumerate();
    let done = replicas.map(|(replica, direct)| {
        let mut rays = 0;
        let mut scores = PartScores::for_task(whole);
        let mut scratch = DirectPass::default();
        let mut stream = Stream::new(context.seed, purpose, MapKind::Elements.number(), replica as u32);
        for index in range.clone() {
            let element = Element::of(context.world, context.scene, elements, index as u32);
            let area_m2 = elements.area_m2(context.scene, elements.element(index as u32));
            let mut entry = scores.of_entry(area_m2, levels.of(index));
            let samples = allotment.of(index);
            for pass in passes.clone() {
                let mut sum = Traced::default();
                for number in pass * samples..(pass + 1) * samples {
                    stream.seek_quasi(stream_index(index, number), index as u64, number);
                    sum += scratch.over_element(context.world, &element, &mut stream);
                }
                let score_lx = sum.value / samples as f64;
                direct[index] += score_lx;
                entry.add(score_lx);
                rays += sum.rays;
            }
        }
        (rays, scores)
    });
    let done = done.collect();
    merged(&mut map.scores[0], done)
}

/// Adds the scores of tasks, in their order. Returns their rays.
pub(super) fn merged(whole: &mut PartScores, tasks: Vec<(u64, PartScores)>) -> u64 {
    let mut rays = 0;
    for (task_rays, scores) in tasks {
        whole.merge(scores);
        rays += task_rays;
    }
    rays
}

/// Does passes over the direct light of a range of elements that adapt. It samples single points, so that slopes and what they leave out
/// are measured too.
pub fn direct_in_elements(
    context: &Context,
    elements: &Elements,
    map: &mut ReplicaMap,
    adaptive: &mut Adaptive,
    range: Range<usize>,
    passes: Range<u64>,
) -> u64 {
    let sites = map.len();
    let number = adaptive.stream_number();
    let Adaptive { detail, references_lx, expected, contact_free, direct_samples, .. } = adaptive;
    let replicas = map.direct.par_iter_mut().with_max_len(1).zip(detail.direct.par_iter_mut()).enumerate();
    let rays = replicas.map(|(replica, (direct, detail))| {
        let mut rays = 0;
        let mut scratch = DirectPass::default();
        let mut stream = Stream::new(context.seed, Purpose::Direct, number, replica as u32);
        for index in range.clone().filter(|index| contact_free[*index] > 0.0) {
            let element =
                Element::of(context.world, context.scene, elements, index as u32).contact_free(contact_free[index]);
            let samples = direct_samples.of(index);
            let share = (samples as f64).recip();
            for sample in passes.start * samples..passes.end * samples {
                stream.seek_quasi(stream_index(index, sample), index as u64, sample);
                let seen = scratch.sample_twice(context.world, &element, &expected[index], &mut stream);
                let scores_lx = add_direct(&mut detail[index], &seen, &references_lx[index][0], share);
                for (number, lx) in scores_lx.into_iter().enumerate() {
                    direct[number * sites + index] += lx;
                }
                rays += seen.rays;
            }
        }
        rays
    });
    rays.collect::<Vec<u64>>().iter().sum()
}

/// Traces chains of every replica. Returns rays and ends of each replica.
pub fn chains(
    context: &Context,
    elements: &Elements,
    map: &mut ReplicaMap,
    adaptive: Option<&mut Adaptive>,
    chains: Range<u64>,
    scored: ScoredArrivals,
) -> Vec<(u64, Ends)> {
    let world = context.world;
    let sites = map.len();
    let number = adaptive.as_deref().map_or(MapKind::Elements.number(), Adaptive::stream_number);
    let mut nothing = vec![Vec::new(); if adaptive.is_some() { 0 } else { REPLICAS }];
    let bends = adaptive.map_or(&mut nothing, |adaptive| &mut adaptive.detail.indirect);
    let Unit::Packets { luminous_flux_lm, area_m2 } = &map.indirect_unit else {
        return Vec::new();
    };
    let replicas = map
        .direct
        .par_iter_mut()
        .with_max_len(1)
        .zip(map.indirect.par_iter_mut())
        .zip(bends.par_iter_mut())
        .enumerate();
    let traced = replicas.map(|(replica, ((direct, indirect), bends))| {
        let mut rays = 0;
        let mut ends = Ends::default();
        let mut stream = Stream::new(context.seed, Purpose::Chains, number, replica as u32);
        let shift = emission_shift(&mut stream);
        for chain in chains.clone() {
            stream.seek(chain);
            let choice = spread_choice(chain, shift);
            let (end, chain_rays) = world.trace_chain(choice, &mut stream, |arrival| {
                let hit = &arrival.hit;
                let Some((site, at)) = elements.place_at(hit.triangle, hit.barycentric, hit.side) else {
                    return;
                };
                let site = site as usize;
                if arrival.bounces > 0 {
                    indirect[site] += 1.0;
                    if let Some(bends) = bends.get_mut(site) {
                        let scores = bends_at(at);
                        bends.iter_mut().zip(scores).for_each(|(sum, score)| *sum += score);
                        (0..SLOPES).for_each(|k| indirect[(1 + k) * sites + site] += scores[k]);
                    }
                } else if scored == ScoredArrivals::DirectToo {
                    direct[site] += luminous_flux_lm / area_m2[site];
                }
            });
            ends.count(end);
            rays += chain_rays;
        }
        (rays, ends)
    });
    traced.collect()
}

/// Traces chains of every replica, of which only the ends are counted. Returns rays and ends of each replica.
pub fn ends_of_chains(context: &Context, chains: u64) -> Vec<(u64, Ends)> {
    let replicas = (0..REPLICAS as u32).into_par_iter().with_max_len(1);
    let traced = replicas.map(|replica| {
        let (mut rays, mut ends) = (0, Ends::default());
        let mut stream = Stream::new(context.seed, Purpose::Chains, MapKind::Elements.number(), replica);
        let shift = emission_shift(&mut stream);
        for chain in 0..chains {
            stream.seek(chain);
            let (end, chain_rays) = context.world.trace_chain(spread_choice(chain, shift), &mut stream, |_| {});
            ends.count(end);
            rays += chain_rays;
            if rays > RAYS_FOR_ENDS {
                break;
            }
        }
        (rays, ends)
    });
    traced.collect()
}

/// Traces chains of every replica, counted by the direction in which they leave the scene after they have been scattered. A packet that
/// leaves into the cell of a direction scores Φ/Ω there, where Ω is the cell's solid angle. Returns rays and ends of each replica.
pub fn leaving_chains(
    context: &Context,
    set: usize,
    table: &IntensityTable,
    map: &mut ReplicaMap,
    chains: Range<u64>,
) -> Vec<(u64, Ends)> {
    let number = MapKind::Receivers(set).number();
    let replicas = map.indirect.par_iter_mut().with_max_len(1).enumerate();
    let traced = replicas.map(|(replica, counts)| {
        let (mut rays, mut ends) = (0, Ends::default());
        let mut stream = Stream::new(context.seed, Purpose::Chains, number, replica as u32);
        let shift = emission_shift(&mut stream);
        for chain in chains.clone() {
            stream.seek(chain);
            let (end, chain_rays, direction) = context.world.trace_out(spread_choice(chain, shift), &mut stream);
            if let Some(direction) = direction {
                counts[table.entry_towards(direction)] += 1.0;
            }
            ends.count(end);
            rays += chain_rays;
        }
        (rays, ends)
    });
    traced.collect()
}

/// Does passes over the direct light of a range of points. Returns the rays traced.
/// A task does all replicas of its points, so that light sampling evaluates the emitters once for each point. The control variate of a
/// point is stored for the next passes.
pub fn direct_at_points(
    context: &Context,
    set: usize,
    map: &mut ReplicaMap,
    control_variates: &mut ControlVariates,
    points: Range<usize>,
    passes: Range<u64>,
) -> u64 {
    let (world, receivers) = (context.world, &context.scene.receivers[set]);
    let firsts: Vec<usize> = points.clone().step_by(POINTS_PER_CHUNK).collect();
    map.fix_direct_levels(points.clone());
    let (whole, levels, kept) = (&map.scores[0], &map.levels[0], &*control_variates);
    let sampled = firsts.par_iter().with_max_len(1).map(|first| {
        let mut rays = 0;
        let mut scores = PartScores::for_task(whole);
        let mut pass = DirectPass::default();
        let mut streams: [Stream; REPLICAS] = std::array::from_fn(|replica| {
            Stream::new(context.seed, Purpose::Direct, MapKind::Receivers(set).number(), replica as u32)
        });
        let chunk = *first..(*first + POINTS_PER_CHUNK).min(points.end);
        let mut made = Vec::new();
        let sums = chunk.map(|entry| {
            let mut sums_of_point = [0.0; REPLICAS];
            let point = &receivers.points[entry];
            if point.inside {
                return sums_of_point;
            }
            let origin = world.tracer.side_origin(point.position_m, point.normal);
            let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
            let control_variate = kept.of(entry).unwrap_or_else(|| {
                let survey_samples = kept.survey_samples;
                let control_variate =
                    DirectSampler::control_variate(world, receivers.quantity, &receiver, &mut pass, survey_samples);
                rays += control_variate.rays;
                made.push((entry, control_variate));
                &made[made.len() - 1].1
            });
            let mut sampler = DirectSampler::new(world, receivers.quantity, &receiver, &mut pass, control_variate);
            for (sum, stream) in sums_of_point.iter_mut().zip(&mut streams) {
                let mut entry_scores = scores.of_entry(point.weight, levels.of(entry));
                for number in passes.clone() {
                    stream.seek_quasi(stream_index(entry, number), entry as u64, number);
                    let sampled = sampler.sample(stream);
                    *sum += sampled.value;
                    entry_scores.add(sampled.value);
                    rays += sampled.rays;
                }
            }
            sums_of_point
        });
        let sums: Vec<[f64; REPLICAS]> = sums.collect();
        (sums, rays, scores, made)
    });
    let mut rays = 0;
    for (first, (sums, chunk_rays, scores, made)) in firsts.iter().zip(sampled.collect::<Vec<_>>()) {
        let points = receivers.points.len();
        made.into_iter().for_each(|(entry, control_variate)| control_variates.keep(entry, points, control_variate));
        for (offset, sums_of_point) in sums.iter().enumerate() {
            for (slab, sum) in map.direct.iter_mut().zip(sums_of_point) {
                slab[first + offset] += sum;
            }
        }
        map.scores[0].merge(scores);
        rays += chunk_rays;
    }
    rays
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::transport::World;

    #[test]
    fn chains_beyond_four_billion_are_chains_of_their_own() {
        // 16 × 4,000 chains from 0, across 2³² and from 2⁴⁰ on, in a closed room of ρ = 0.5 and faces of equal light: Φ/(1−ρ) within 5
        // standard errors of 16 replicas (α = 2e-4; seed 3). Planted fault: 3% more is outside. No run repeats another.
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [ { "name": "r", "type": "box", "min": [0,0,0], "max": [1,1,1], "facing": "inward", "material": "m" } ],
            "luminaires": [ { "name": "a", "type": "point", "position": [0.5,0.5,0.5], "luminous_flux_lm": 100 },
                            { "name": "b", "type": "point", "position": [0.4,0.6,0.5], "luminous_flux_lm": 50 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a valid scene");
        let world = World::new(&scene);
        let context = Context::of_a_test(&scene, &world, 3);
        let counts = |first: u64| -> Vec<f64> {
            let unit = Unit::Packets { luminous_flux_lm: 150.0, area_m2: vec![0.5; 12] };
            let mut map = ReplicaMap::new(12, unit);
            chains(&context, &world.elements, &mut map, None, first..first + 4000, ScoredArrivals::DirectToo);
            map.indirect.iter().map(|slab| slab.iter().sum::<f64>() / 4000.0).collect()
        };
        let runs = [0, (1u64 << 32) - 2000, 1 << 40].map(counts);
        for run in &runs {
            let mean = run.iter().sum::<f64>() / 16.0;
            let squares: f64 = run.iter().map(|value| (value - mean).powi(2)).sum();
            let error = (squares / (16.0 * 15.0)).sqrt();
            // Hits after the first reflection, per packet: ρ/(1 − ρ) = 1.
            assert!((mean - 1.0).abs() < 5.0 * error, "{mean} ± {error}");
            assert!((1.03 * mean - 1.0).abs() > 5.0 * error, "the planted fault passed: {mean} ± {error}");
        }
        assert!(runs[0] != runs[1] && runs[1] != runs[2] && runs[0] != runs[2]);
    }
}
