//! The pilot of walks from the points of a set. It measures their cost and scatter, alone and if neighbours share what their walks meet.

use rayon::prelude::*;

use super::{
    ENOUGH_RAYS, FEWEST_SITES, IndirectCost, PartCost, Sites, WALKS, WORTH_ANOTHER, over_receivers, samples_of_a_site,
    sites_of,
};
use crate::base::scattered::scattered;
use crate::estimators::neighbours::{Neighbour, SharedWalks, Sharing};
use crate::estimators::receiver::Receiver;
use crate::estimators::reception::sample_reflected;
use crate::maps::MapKind;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Quantity, ReceiverPoint};
use crate::solver::allotment::Allotment;
use crate::solver::context::Context;
use crate::solver::pace::TimeLeft;
use crate::solver::regions::{Groups, POINTS_OF_A_BLOCK, halved};
use crate::transport::World;

/// Approximate number of points in groups that the pilot samples; walks of all of them together; and fewest walks at each. The most walks
/// at each is `WALKS`, unless points are few.
const SITES_IN_GROUPS: usize = 512;
const WALKS_IN_GROUPS: u64 = 1024;
const FEWEST_WALKS: u64 = 2;
/// Most points that share what their walks meet. (Five rooms to 1 %, two seeds: 8 take 1.04 and 32 take 1.06 of the time.)
const MOST_NEIGHBOURS: usize = 16;
/// Traces and stores everything that any form of sharing needs.
const ALL: Sharing = Sharing { neighbours: MOST_NEIGHBOURS, is_levelled: true, shares_spots: true };
/// Groups that walk in parallel before their rays are counted.
const GROUPS_AT_A_TIME: usize = 2;
/// Points share if that takes less than this part of the work.
const WORTH_SHARING: f64 = 0.9;
/// First number of the parts of a pilot's stream that its walks use.
const WALK_PARTS: u32 = 32;
/// Share of the work to the target that walks of a pilot take, if that is more. If few walks carry most of the light, hundreds of walks may
/// underestimate the variance a few times. The walks grow by at most the second factor from one try to the next.
const SHARE_OF_WORK: f64 = 0.005;
const MOST_GROWTH_OF_WALKS: f64 = 8.0;
/// Most rays of a walk that count for that share: where walks are long, gathering takes this many instead.
const MOST_RAYS_THAT_COUNT: f64 = 5.0;

/// The ways in which points can share. Each point counts for itself, or 2, 4, 8 or 16 points share, with a level or without. If luminaires
/// are near surfaces, points may share their spots as well.
fn ways(world: &World) -> Vec<Sharing> {
    let mut ways = vec![Sharing::default()];
    let mut neighbours = 2;
    while neighbours <= MOST_NEIGHBOURS {
        for shares_spots in [false, true].into_iter().filter(|shares| !shares || world.near_luminaires.is_some()) {
            ways.extend([false, true].map(|is_levelled| Sharing { neighbours, is_levelled, shares_spots }));
        }
        neighbours *= 2;
    }
    ways
}

/// Measures walks from a set's points.
/// `direct_mean` is the mean of its direct light if the target binds the map. Then walks take their share of the work.
pub(super) fn cost(context: &Context, set: usize, direct_mean: Option<f64>) -> IndirectCost {
    let receivers = &context.scene.receivers[set];
    let shares = receivers.points.len() > 1 && receivers.quantity != Quantity::Luminance;
    let walks = if shares {
        let sites = receivers.points.len().min(SITES_IN_GROUPS) as u64;
        samples_of_a_site(context, sites, (WALKS_IN_GROUPS / sites).clamp(FEWEST_WALKS, WALKS))
    } else {
        samples_of_a_site(context, sites_of(context, set), WALKS)
    };
    let measure = |walks: u64, part: u32| {
        if shares { cost_in_groups(context, set, walks, part) } else { cost_alone(context, set, walks, part) }
    };
    let first = measure(walks, WALK_PARTS);
    match direct_mean {
        Some(direct_mean) => by_more_walks(context, set, first, walks, direct_mean, measure),
        None => first,
    }
}

/// Repeats the measurement with more walks until these took their share of the work to the target.
fn by_more_walks(
    context: &Context,
    set: usize,
    first: IndirectCost,
    mut walks: u64,
    direct_mean: f64,
    measure: impl Fn(u64, u32) -> IndirectCost,
) -> IndirectCost {
    let entries = context.scene.receivers[set].points.len() as f64;
    let (mut found, mut all_rays) = (first, first.shared.pilot_rays);
    for part in WALK_PARTS + 1.. {
        let cost = &found.shared;
        let absolute_error = context.target_error * (direct_mean + cost.mean);
        let work = cost.variance * cost.rays.min(MOST_RAYS_THAT_COUNT) * entries / (absolute_error * absolute_error);
        let growth = (SHARE_OF_WORK * work).min(ENOUGH_RAYS as f64) / cost.pilot_rays as f64;
        if growth.is_nan() || growth <= WORTH_ANOTHER || (context.time_left)() <= TimeLeft::Little {
            break;
        }
        walks = (walks as f64 * growth.min(MOST_GROWTH_OF_WALKS)) as u64;
        found = measure(walks, part);
        all_rays += found.shared.pilot_rays;
    }
    found.shared.pilot_rays = all_rays;
    found
}

/// Measures `walks` walks from each of some points, with the random numbers of part `part`.
fn cost_alone(context: &Context, set: usize, walks: u64, part: u32) -> IndirectCost {
    let (world, quantity) = (context.world, context.scene.receivers[set].quantity);
    let walk_from = |receiver: &Receiver, weight: f64, stream: &mut Stream| {
        let mut cut = Cut::default();
        let mut site = Sites::default();
        site.add(context, weight, walks, || sample_reflected(world, quantity, receiver, &mut cut, stream));
        site.weighed = cut.weighed as f64;
        site
    };
    let mut sites = Sites::default();
    over_receivers(context, set, part, walk_from, |_, site| {
        sites.merge(&site);
        sites.rays < ENOUGH_RAYS as f64
    });
    IndirectCost::alone(sites.cost())
}

/// Groups of neighbours in scattered order over a set. So if many rays end the pilot early, the groups left out lie anywhere.
fn groups_of(points: &[ReceiverPoint]) -> Vec<Vec<u32>> {
    let wanted = SITES_IN_GROUPS / MOST_NEIGHBOURS;
    let blocks = points.len().div_ceil(POINTS_OF_A_BLOCK);
    let some_blocks = (0..blocks).step_by(blocks.div_ceil(wanted).max(1));
    let of_a_block = wanted.div_ceil(some_blocks.len().max(1));
    let of_block = |block: usize| {
        let first = block * POINTS_OF_A_BLOCK;
        let groups = Groups::of(points, first..(first + POINTS_OF_A_BLOCK).min(points.len()), MOST_NEIGHBOURS);
        let stride = groups.iter().len().div_ceil(of_a_block).max(1);
        groups.iter().step_by(stride).map(<[u32]>::to_vec).collect::<Vec<_>>()
    };
    let found: Vec<Vec<u32>> = some_blocks.flat_map(of_block).collect();
    scattered(found.len()).map(|group| found[group].clone()).collect()
}

/// Measures `walks` walks from each point of some groups of neighbours. The same walks give the cost for each point alone and for groups of
/// fewer or more neighbours that share them.
fn cost_in_groups(context: &Context, set: usize, walks: u64, part: u32) -> IndirectCost {
    let (world, receivers) = (context.world, &context.scene.receivers[set]);
    let number = MapKind::Receivers(set).number();
    let ways = ways(world);
    let walk_from = |group: &Vec<u32>| {
        let neighbours = Neighbour::group(world, receivers, group);
        let mut stream = Stream::new(context.seed, Purpose::Pilot, number, part);
        let (mut cut, mut passes, mut rays) = (Cut::default(), Vec::new(), 0);
        while (passes.len() as u64) < walks {
            let pass = passes.len() as u64;
            let seek = |stream: &mut Stream, neighbour: usize, _: u64| {
                stream.seek(u64::from(group[neighbour]) << 32 | pass);
            };
            let mut shared = SharedWalks::default();
            rays += shared.sample(world, &neighbours, (1, ALL), (&mut cut, &mut stream), seek);
            passes.push(shared);
            if passes.len() as u64 >= FEWEST_WALKS && (rays > ENOUGH_RAYS || context.is_over()) {
                break;
            }
        }
        let levels = passes.iter().map(SharedWalks::level_lm_m2);
        let (sum, met) = levels.fold((0.0, 0.0), |(sum, all), (mean, count)| (sum + mean * count, all + count));
        let level_lm_m2 = sum / f64::max(met, 1.0);
        let site = Sites { weighed: cut.weighed as f64, ..Sites::default() };
        let mut found = vec![(site, <[Sites; 2]>::default()); ways.len()];
        let mut scores_lx = Vec::new();
        for ((found, halves), sharing) in found.iter_mut().zip(&ways) {
            // Moments of the scores of every point, of the even and the odd passes.
            let mut moments = vec![[[0.0; 2]; 2]; group.len()];
            for (pass, shared) in passes.iter().enumerate() {
                for part in halved(group.len(), sharing.neighbours) {
                    shared.scores_lx(world, (part.clone(), *sharing), level_lm_m2, &mut scores_lx);
                    for (moments, lx) in moments[part.clone()].iter_mut().zip(&scores_lx) {
                        let [sum, squares] = &mut moments[pass % 2];
                        *sum += lx;
                        *squares += lx * lx;
                    }
                    let [of_walks, of_sharing] = shared.rays(part, *sharing);
                    found.rays += (of_walks + of_sharing) as f64;
                    found.sharing_rays += of_sharing as f64;
                }
            }
            let counts = [passes.len().div_ceil(2), passes.len() / 2];
            for ([even, odd], entry) in moments.into_iter().zip(group) {
                let weight = receivers.points[*entry as usize].weight;
                found.add_moments(weight, passes.len() as f64, [even[0] + odd[0], even[1] + odd[1]]);
                // A single pass has no variance.
                for (half, moments) in [even, odd].into_iter().enumerate().filter(|(half, _)| counts[*half] > 1) {
                    halves[half].add_moments(weight, counts[half] as f64, moments);
                }
            }
        }
        (found, rays)
    };
    let mut all = vec![Sites::default(); ways.len()];
    // For each way, the variances of the groups by the even and the odd passes.
    let mut variances = vec![Vec::new(); ways.len()];
    let (mut rays, mut sites) = (0, 0);
    for some in groups_of(&receivers.points).chunks(GROUPS_AT_A_TIME) {
        let walk_in_time = |(place, group)| (place == 0 || !context.is_over()).then(|| walk_from(group));
        let found: Vec<_> = some.par_iter().with_max_len(1).enumerate().map(walk_in_time).collect();
        for (found, of_group) in found.into_iter().flatten() {
            for (way, (of_way, halves)) in found.iter().enumerate() {
                all[way].merge(of_way);
                variances[way].extend((halves[1].samples > 0.0).then(|| [halves[0].variance, halves[1].variance]));
            }
            rays += of_group;
        }
        sites += some.iter().map(Vec::len).sum::<usize>();
        if sites >= FEWEST_SITES && rays > ENOUGH_RAYS || context.is_over() {
            break;
        }
    }
    let cost = |way: usize| PartCost { pilot_rays: rays, ..all[way].cost() };
    let work = |way: usize| cost(way).variance * (cost(way).work() + cost(way).choosing);
    let best = (0..ways.len()).min_by(|one, other| work(*one).total_cmp(&work(*other)));
    let best = best.filter(|best| work(*best) < WORTH_SHARING * work(0)).unwrap_or(0);
    let gain_to_come = Allotment::default().gain_to_come(&variances[best]);
    IndirectCost { alone: cost(0), shared: cost(best), sharing: ways[best], gain_to_come }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::tests::room_with;
    use super::*;
    use crate::check::scene_from_json;
    use crate::scene::Elements;
    use crate::solver::pilot::indirect_cost;

    /// Walks of a pilot take their share of the work to the target, which grows with its inverse square. All tries together take up to
    /// twice that. For an unbound map, or if little time is left, they take no more than the minimum.
    #[test]
    fn a_pilot_takes_its_share_of_the_work() {
        let scene = room_with(r#""origin": [1,1,1], "u": [2,0,0], "v": [0,1,0], "columns": 8, "rows": 4"#);
        let world = World::new(&scene);
        let cost = |target_error: f64, time_left: TimeLeft, direct_mean: Option<f64>| {
            let time_left = &move || time_left;
            let context = Context { time_left, target_error, ..Context::of_a_test(&scene, &world, 3) };
            indirect_cost(&context, MapKind::Receivers(0), &Elements::default(), direct_mean).shared
        };
        let anyway = cost(0.01, TimeLeft::Enough, None).pilot_rays;
        for target_error in [0.0005, 0.00025] {
            let found = cost(target_error, TimeLeft::Enough, Some(0.0));
            let absolute_error = target_error * found.mean;
            let work = found.variance * found.rays.min(MOST_RAYS_THAT_COUNT) * 32.0 / (absolute_error * absolute_error);
            let share = found.pilot_rays as f64 / work;
            assert!(found.pilot_rays > 4 * anyway, "{} beside {anyway}", found.pilot_rays);
            assert!((0.5 * SHARE_OF_WORK..2.0 * SHARE_OF_WORK).contains(&share), "{share} to {target_error}");
        }
        assert_eq!(cost(0.00025, TimeLeft::Enough, None).pilot_rays, anyway);
        assert_eq!(cost(0.00025, TimeLeft::Little, Some(0.0)).pilot_rays, anyway);
    }

    /// 64 points, half of them behind a black wall, where no light comes. By Neyman's allotment they take half as many walks, and 0.6 of
    /// them with whole numbers and caution: the pilot says a factor of 1.4 to 1.8. Without the wall it says less than 1.15.
    #[test]
    fn a_pilot_shows_what_sharing_walks_out_will_gain() {
        let gain = |wall: &str| {
            let text = format!(
                r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }},
                    "black": {{ "type": "diffuse", "reflectance": 0 }} }},
                "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" }}
                    {wall} ],
                "luminaires": [ {{ "name": "a", "type": "point", "position": [1,1.5,1], "luminous_flux_lm": 100 }},
                    {{ "name": "b", "type": "point", "position": [{}], "luminous_flux_lm": 100 }} ],
                "receivers": [ {{ "name": "p", "type": "grid", "origin": [0.1,0.2,0.8], "u": [3.8,0,0], "v": [0,2.6,0],
                    "columns": 16, "rows": 4 }} ] }}"#,
                if wall.is_empty() { "3,1.5,1" } else { "1,1.4,1" }
            );
            let scene = scene_from_json(&text, None, Path::new(".")).expect("a valid scene");
            let world = World::new(&scene);
            let context = Context::of_a_test(&scene, &world, 3);
            indirect_cost(&context, MapKind::Receivers(0), &Elements::default(), None).gain_to_come
        };
        let wall = r#", { "name": "wall", "type": "box", "min": [1.95,0,0], "max": [2.05,3,2], "material": "black" }"#;
        let [behind_a_wall, open] = [gain(wall), gain("")];
        assert!((1.4..1.8).contains(&behind_a_wall) && open < 1.15, "{behind_a_wall} {open}");
    }
}
