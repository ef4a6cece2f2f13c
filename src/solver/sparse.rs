//! Elements that chains seldom meet take their indirect light from walks instead.
//! A small element is met by few packets, and a mean of few counts gives neither its value nor its error. Walks start from the element
//! itself, so its size does not matter to them. The choice of elements follows from their areas and the mean of the whole map; for the
//! replicas of one half it also follows from the counts of the other half. A choice by their own low counts would bias them. So rooms far
//! from the light, which few packets reach, get their light by walks.

use std::time::Instant;

use rayon::prelude::*;

use super::context::Context;
use super::job::{Engine, Job};
use super::pace::TimeLeft;
use super::spending::Activity;
use crate::estimators::element::Element;
use crate::estimators::receiver::Receiver;
use crate::estimators::walk::sample_indirect_lx;
use crate::maps::{MapKind, REPLICAS, Unit};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::transport::Traced;

/// Expected scores of an element, in all replicas together, below which walks are used.
const FEWEST_SCORES: f64 = 30.0;
/// Most walks of a replica from one element.
const MOST_WALKS: u64 = 32;
/// Rays that the walks may take, relative to those of the map so far, and in any case.
const RAY_SHARE: f64 = 0.25;
const RAYS_IN_ANY_CASE: f64 = 2e6;
/// Walks that measure the rays per walk.
const PROBES: usize = 64;
/// Elements whose areas a forecast samples.
const SAMPLED_AREAS: usize = 512;

/// Flux in lm, and areas in m² of the elements, of a map whose counts walks may replace. Chains find every path; walks must not replace
/// them if walks miss some paths. Elements that adapt are excluded: they are as large as the target allows, and their slopes must not be
/// separated from their means.
fn counted_areas<'a>(context: &Context, job: &'a Job) -> Option<(f64, &'a [f64])> {
    let Unit::Packets { luminous_flux_lm, area_m2 } = &job.map.indirect_unit else { return None };
    let is_fixed = job.kind == MapKind::Elements && job.adapting.adaptive.is_none();
    (is_fixed && context.world.paths_not_found.is_empty()).then_some((*luminous_flux_lm, area_m2))
}

/// Walks from each of `elements` elements in each replica, from the map's rays before and the rays of one walk. 0 if the walks would take
/// too much of the run; then the counts must do.
fn walks_from_each(rays_before: f64, elements: f64, rays_per_walk: f64) -> u64 {
    let budget = (RAY_SHARE * rays_before).max(RAYS_IN_ANY_CASE);
    ((budget / (rays_per_walk * elements * REPLICAS as f64)) as u64).min(MOST_WALKS)
}

/// Approximate rays for filling the elements of a counted map, if the map has taken `rays_before` rays. It is estimated from the areas of
/// some elements, one score per ray, and at least as many scores as a first look brings.
pub fn rays_to_fill(context: &Context, job: &Job, rays_before: f64) -> f64 {
    let counts = job.engine == Engine::Collision && !job.is_black();
    let Some((_, area_m2)) = counted_areas(context, job).filter(|_| counts) else { return 0.0 };
    let every = area_m2.len().div_ceil(SAMPLED_AREAS).max(1);
    let areas: Vec<f64> = area_m2.iter().step_by(every).copied().collect();
    let scores = (rays_before - job.work.direct_rays as f64).max(job.rays_of_chains(job.first_samples()));
    let mean_m2 = areas.iter().sum::<f64>() / areas.len().max(1) as f64;
    let is_small = |area_m2: &&f64| scores * **area_m2 < FEWEST_SCORES * mean_m2 * job.map.len() as f64;
    let count = (areas.iter().filter(is_small).count() * every) as f64;
    let rays_per_walk = job.rays_of_a_walk().max(1.0);
    count * rays_per_walk * (walks_from_each(rays_before, count.max(1.0), rays_per_walk) * REPLICAS as u64) as f64
}

/// Replaces the indirect light of elements with too few expected scores.
pub fn fill_sparse_elements(context: &Context, job: &mut Job) {
    let started = Instant::now();
    let Some((flux_lm, areas)) = counted_areas(context, job) else { return };
    if job.map.indirect_samples.complete == 0 {
        return;
    }
    let areas = areas.to_vec();
    let total_area_m2: f64 = areas.iter().sum();
    let scores: f64 = (0..job.map.len()).map(|element| job.map.indirect_sum(element)).sum();
    let small = |element: u32| scores * areas[element as usize] / total_area_m2 < FEWEST_SCORES;
    let count_of_half = |parity: usize, element: u32| -> f64 {
        job.map.indirect.iter().skip(parity).step_by(2).map(|slab| slab[element as usize]).sum()
    };
    let sparse: [Vec<u32>; 2] = [0, 1].map(|parity| {
        let is_sparse = |element: &u32| small(*element) || 2.0 * count_of_half(1 - parity, *element) < FEWEST_SCORES;
        (0..areas.len() as u32).filter(is_sparse).collect()
    });
    let longer = if sparse[0].len() >= sparse[1].len() { &sparse[0] } else { &sparse[1] };
    let count = longer.len();
    if count == 0 || scores == 0.0 {
        return;
    }
    job.find_contact(context);
    let contact_free = &job.adapting.contact_free[..];
    let probes: Vec<u32> = longer.iter().step_by(count.div_ceil(PROBES)).copied().collect();
    let mut cut = Cut::default();
    let mut stream = Stream::new(context.seed, Purpose::Pilot, 0, 1);
    let is_long_over = || (context.time_left)() == TimeLeft::LongOver;
    let mut probe_rays = 0;
    for element in probes.iter().take_while(|_| !is_long_over()) {
        probe_rays +=
            walk_from_element(context, (*element, contact_free[*element as usize]), 0, &mut cut, &mut stream).rays;
    }
    let rays_per_walk = (probe_rays as f64 / probes.len() as f64).max(1.0);
    job.work.rays += probe_rays;
    job.work.spending.add(Activity::Walks, probe_rays, started.elapsed());
    let started = Instant::now();
    let walks = walks_from_each(job.work.rays as f64, count as f64, rays_per_walk);
    if walks == 0 {
        return;
    }
    let walked: Vec<(Vec<f64>, u64)> = (0..REPLICAS)
        .into_par_iter()
        .with_max_len(1)
        .map(|replica| {
            let mut cut = Cut::default();
            let mut stream = Stream::new(context.seed, Purpose::Walks, 0, replica as u32);
            let (mut means_lx, mut rays) = (Vec::new(), 0);
            for element in sparse[replica % 2].iter().take_while(|_| !is_long_over()) {
                let mut sum_lx = 0.0;
                for walk in 0..walks {
                    let walked = walk_from_element(
                        context,
                        (*element, contact_free[*element as usize]),
                        walk,
                        &mut cut,
                        &mut stream,
                    );
                    sum_lx += walked.value;
                    rays += walked.rays;
                }
                means_lx.push(sum_lx / walks as f64);
            }
            (means_lx, rays)
        })
        .collect();
    let rays = walked.iter().map(|(_, rays)| rays).sum::<u64>();
    job.work.rays += rays;
    job.work.spending.add(Activity::Walks, rays, started.elapsed());
    // If a limit passed long ago, some elements have no walks. Then the counts of all elements are kept, so that replicas do not differ.
    if walked.iter().enumerate().any(|(replica, (means_lx, _))| means_lx.len() < sparse[replica % 2].len()) {
        return;
    }
    let samples = job.map.indirect_samples.complete as f64;
    for (replica, (means_lx, _)) in walked.iter().enumerate() {
        for (element, mean_lx) in sparse[replica % 2].iter().zip(means_lx) {
            // The number of packets that would have brought the same light.
            job.map.indirect[replica][*element as usize] = mean_lx * areas[*element as usize] / flux_lm * samples;
        }
    }
}

/// Traces one walk from a random point of an element side with this contact-free share. Returns the indirect illuminance in lx, 0 if the point
/// is hidden by contact, and the rays traced.
fn walk_from_element(
    context: &Context,
    (index, contact_free): (u32, f64),
    walk: u64,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let world = context.world;
    if contact_free == 0.0 {
        return Traced::default();
    }
    stream.seek((u64::from(index) << 32) | walk);
    let element = Element::of(world, context.scene, &world.elements, index).contact_free(contact_free);
    let (at, tested_rays) = element.draw_of_whole(world, stream);
    let Some(at) = at else {
        return Traced { value: 0.0, rays: tested_rays };
    };
    let origin = element.origin(world, at);
    let receiver =
        Receiver { point_m: world.tracer.position_m(&origin), normal: element.normal_at(world, at), origin: &origin };
    let walked = sample_indirect_lx(world, &receiver, cut, stream);
    Traced { rays: tested_rays + walked.rays, ..walked }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::solver::contact::{KnownContact, contact_free_shares};
    use crate::transport::World;

    /// The top of a beam lies on the ceiling. No packet comes there, so no walk from there finds light. Planted fault: walks that assume
    /// the top is free of contact and start near its edge find light. Seed 2, 400 walks from each element; those that start in the hidden area are
    /// counted.
    #[test]
    fn walks_from_what_is_covered_find_nothing_up_to_its_edge() {
        const WALKS: u64 = 400;
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [
                { "name": "room", "type": "box", "min": [0,0,0], "max": [4.1,3.3,2.7], "facing": "inward", "material": "m",
                  "max_element_edge": 0.5 },
                { "name": "beam", "type": "box", "min": [1.01,1.03,2.3], "max": [1.17,2.51,2.7], "facing": "outward", "material": "m",
                  "max_element_edge": 0.1 } ],
            "luminaires": [ { "name": "a", "type": "point", "position": [3,2,1.5], "luminous_flux_lm": 10000 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a valid scene");
        let world = World::new(&scene);
        let context = Context::of_a_test(&scene, &world, 2);
        let contact_free =
            contact_free_shares(&context, &world.elements, 0..world.elements.len(), |_| KnownContact::Unknown).0;
        // Elements of the beam's top, and those of the ceiling whose walks start below the beam.
        let elements_of = |name: &str| {
            let surface = scene.surfaces.iter().position(|surface| surface.name == name).expect("a surface");
            world.elements.of_surface(&scene, surface as u32)
        };
        let mut stream = Stream::new(context.seed, Purpose::Walks, 0, 0);
        let is_below = |index: u32, walk: u64, stream: &mut Stream| {
            stream.seek((u64::from(index) << 32) | walk);
            let element = Element::of(&world, &scene, &world.elements, index);
            let at_m = element.point_m(&world, element.draw(&world, stream));
            (1.01..1.17).contains(&at_m.x) && (1.03..2.51).contains(&at_m.y)
        };
        let mut found_lx = |name: &str, share: &dyn Fn(u32) -> f64| {
            let (mut sum_lx, mut starts) = (0.0, 0);
            for (element, walk) in elements_of(name).flat_map(|element| (0..WALKS).map(move |walk| (element, walk))) {
                if is_below(element, walk, &mut stream) {
                    starts += 1;
                    sum_lx +=
                        walk_from_element(&context, (element, share(element)), walk, &mut Cut::default(), &mut stream)
                            .value;
                }
            }
            assert!(starts > 1000, "{starts}");
            sum_lx
        };
        for name in ["beam/ceiling", "room/ceiling"] {
            let known_lx = found_lx(name, &|element| contact_free[element as usize].min(0.5));
            let faulty_lx = found_lx(name, &|_| 1.0);
            assert!(known_lx == 0.0 && faulty_lx > 0.0, "{name}: {known_lx} {faulty_lx}");
        }
    }
}
