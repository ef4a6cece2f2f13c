//! Walks from the points of a receiver set: separate for each point, or shared among neighbours.

use std::ops::Range;

use rayon::prelude::*;

use super::{POINTS_PER_CHUNK, merged};
use crate::estimators::neighbours::{Neighbour, SharedWalks, Sharing};
use crate::estimators::receiver::Receiver;
use crate::estimators::reception::sample_reflected;
use crate::maps::{MapKind, PartScores, REPLICAS, ReplicaMap, Tally};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::solver::allotment::{Allotment, Carried};
use crate::solver::context::Context;
use crate::solver::regions::Groups;
use crate::solver::streams::stream_index;
use crate::transport::Traced;

/// Groups of neighbours that a thread takes at a time.
const GROUPS_PER_CHUNK: usize = 8;

/// Walks that start from the points of a set.
pub struct PointWalks<'a> {
    /// The receiver set.
    pub set: usize,
    /// How many walks a point takes in a pass.
    pub allotment: &'a Allotment,
    /// Walks with other allotments.
    pub carried: &'a Carried,
    /// How neighbours share what their walks meet, and the groups of those that do.
    pub sharing: Sharing,
    pub groups: Option<&'a Groups>,
    /// Approximate indirect light of the points, in the unit of the set.
    pub expected: f64,
}

/// Indirect illuminance of a group in lx from all scores so far, the same for all slices of work up to rounding. It approximates the
/// exitance of the surfaces that the group sees.
struct GroupLevel {
    sum_lx: f64,
    scores: f64,
}

impl GroupLevel {
    /// The level of a group in a replica. `expected_lx` counts as one score.
    fn of(expected_lx: f64, (slab, samples): (&[f64], Tally), group: &[u32]) -> GroupLevel {
        let mut level = GroupLevel { sum_lx: expected_lx, scores: 1.0 };
        for entry in group.iter().map(|entry| *entry as usize) {
            level.sum_lx += slab[entry];
            level.scores += samples.of(entry) as f64;
        }
        level
    }

    fn mean_lx(&self) -> f64 {
        self.sum_lx / self.scores
    }

    fn add(&mut self, scores_lx: &[f64]) {
        self.sum_lx += scores_lx.iter().sum::<f64>();
        self.scores += scores_lx.len() as f64;
    }
}

/// Does passes of walks from a range of points. Returns the rays traced. A pass scores the mean of a point's walks.
pub fn walks_from_points(
    context: &Context,
    walks: PointWalks,
    map: &mut ReplicaMap,
    points: Range<usize>,
    passes: Range<u64>,
) -> u64 {
    if let Some(groups) = walks.groups {
        return shared_walks(context, &walks, groups, map, (points, passes));
    }
    let PointWalks { set, allotment, carried, .. } = walks;
    let (world, quantity) = (context.world, context.scene.receivers[set].quantity);
    let receivers = &context.scene.receivers[set].points;
    map.fix_indirect_levels(points.clone());
    let (whole, levels) = (&map.scores[1], &map.levels[1]);
    let chunks: Vec<(usize, usize, &mut [f64])> = map
        .indirect
        .iter_mut()
        .enumerate()
        .flat_map(|(replica, slab)| {
            let first = points.start;
            let chunks = slab[points.clone()].chunks_mut(POINTS_PER_CHUNK).enumerate();
            chunks.map(move |(chunk, sums)| (replica, first + chunk * POINTS_PER_CHUNK, sums))
        })
        .collect();
    let walked = chunks.into_par_iter().with_max_len(1).map(|(replica, first, sums)| {
        let mut rays = 0;
        let mut scores = PartScores::for_task(whole);
        let mut cut = Cut::default();
        let mut stream = Stream::new(context.seed, Purpose::Walks, MapKind::Receivers(set).number(), replica as u32);
        for (offset, sum) in sums.iter_mut().enumerate() {
            let (entry, point) = (first + offset, &receivers[first + offset]);
            if point.inside {
                continue;
            }
            let origin = world.tracer.side_origin(point.position_m, point.normal);
            let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
            let mut entry_scores = scores.of_entry(point.weight, levels.of(entry));
            let walks = allotment.of(entry);
            for pass in passes.clone() {
                let mut found = Traced::default();
                let first_walk = carried.first_walk(entry, pass, walks);
                for walk in first_walk..first_walk + walks {
                    stream.seek_quasi(stream_index(entry, walk), entry as u64, walk);
                    found += sample_reflected(world, quantity, &receiver, &mut cut, &mut stream);
                }
                rays += found.rays;
                let score = found.value / walks as f64;
                *sum += score;
                entry_scores.add(score);
            }
        }
        (rays, scores)
    });
    let done = walked.collect();
    merged(&mut map.scores[1], done)
}

/// Does passes of walks where neighbours share what their walks meet first. Only points of illuminance do. The points of a group take equally
/// many walks.
fn shared_walks(
    context: &Context,
    walks: &PointWalks,
    groups: &Groups,
    map: &mut ReplicaMap,
    (points, passes): (Range<usize>, Range<u64>),
) -> u64 {
    let PointWalks { set, allotment, carried, sharing, expected: expected_lx, .. } = *walks;
    let (world, receivers) = (context.world, &context.scene.receivers[set]);
    map.fix_indirect_levels(points.clone());
    let (whole, levels) = (&map.scores[1], &map.levels[1]);
    let groups = groups.within(points);
    let tasks: Vec<(usize, &[&[u32]])> =
        (0..REPLICAS).flat_map(|replica| groups.chunks(GROUPS_PER_CHUNK).map(move |some| (replica, some))).collect();
    let (slabs, samples) = (&map.indirect, map.indirect_samples);
    let walked = tasks.par_iter().with_max_len(1).map(|(replica, groups)| {
        let mut rays = 0;
        let mut scores = PartScores::for_task(whole);
        let (mut cut, mut shared) = (Cut::default(), SharedWalks::default());
        let mut stream = Stream::new(context.seed, Purpose::Walks, MapKind::Receivers(set).number(), *replica as u32);
        let (mut sums_lx, mut found_lx) = (Vec::new(), Vec::new());
        for group in *groups {
            let neighbours = Neighbour::group(world, receivers, group);
            let weights = group.iter().map(|entry| *entry as usize);
            let mut group_scores =
                scores.of_group(weights.map(|entry| (receivers.points[entry].weight, levels.of(entry))));
            let first = sums_lx.len();
            sums_lx.resize(first + group.len(), 0.0);
            let walks = allotment.of(group[0] as usize);
            let mut level = GroupLevel::of(expected_lx, (&slabs[*replica], samples), group);
            for pass in passes.clone() {
                let seek = |stream: &mut Stream, neighbour: usize, walk: u64| {
                    let entry = group[neighbour] as usize;
                    let walk = carried.first_walk(entry, pass, walks) + walk;
                    stream.seek_quasi(stream_index(entry, walk), entry as u64, walk);
                };
                rays += shared.sample(world, &neighbours, (walks, sharing), (&mut cut, &mut stream), seek);
                shared.scores_lx(world, (0..group.len(), sharing), level.mean_lx(), &mut found_lx);
                level.add(&found_lx);
                sums_lx[first..].iter_mut().zip(&found_lx).for_each(|(sum_lx, lx)| *sum_lx += lx);
                group_scores.add(&found_lx);
            }
        }
        ((rays, scores), sums_lx)
    });
    let mut done = Vec::new();
    for ((replica, groups), (found, sums_lx)) in tasks.iter().zip(walked.collect::<Vec<_>>()) {
        let slab = &mut map.indirect[*replica];
        groups.iter().copied().flatten().zip(sums_lx).for_each(|(entry, lx)| slab[*entry as usize] += lx);
        done.push(found);
    }
    merged(&mut map.scores[1], done)
}
