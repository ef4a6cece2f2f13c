//! The split of daylight at the points of a map: straight from the sky, by way of something outside, and by way of something inside.
//! The map itself separates direct light from reflected light. Separate walks estimate the share of the ground in direct light, and the
//! share of reflected light that has met something outside before. They are like those of a year of daylight (docs/methods.md, section 27).
//! So the three components add up to the map's value, whatever the error of the shares.

use rayon::prelude::*;

use super::context::Context;
use super::job::Job;
use crate::base::half_samples::{PARTED, mean_and_halves, standard_error};
use crate::estimators::coefficients::{CoefficientTally, MetPlace, SKY_WAYS, SkyPath, walk_for_coefficients};
use crate::estimators::direct::DirectPass;
use crate::estimators::receiver::Receiver;
use crate::maps::{Estimate, MapKind, MapValues};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Openings, Quantity, ReceiverPoint};
use glam::DVec3;

/// Most rays of the walks, as a share of the rays of the map.
const SHARE_OF_RAYS: f64 = 0.2;
/// Walks of a point in each replica: fewest and most.
const FIRST_WALKS: u64 = 8;
const MOST_WALKS: u64 = 4096;
/// Estimate of a share on which no walk gives information.
const UNKNOWN: Estimate = Estimate { value: 0.5, standard_error: 0.5 };

/// Light found by the walks of a replica, in lx: straight from the sky, straight from the ground, by way of something outside, and by way
/// of something inside.
type LightBySkyWay = [f64; SKY_WAYS + 1];

/// Sums of a point.
#[derive(Clone, Default)]
struct PointSums {
    found: [LightBySkyWay; PARTED],
    rays: u64,
}

struct SkyWayTally<'a>(&'a mut LightBySkyWay);

impl CoefficientTally for SkyWayTally<'_> {
    #[inline]
    fn add_sky(&mut self, towards: DVec3, lx: f64, way: SkyPath) {
        let place = match way {
            SkyPath::Straight if way.component(towards) == SkyPath::Straight => 0,
            SkyPath::Straight => 1,
            SkyPath::FromOutside => 2,
            SkyPath::FromInside => 3,
        };
        self.0[place] += lx;
    }

    fn met(&mut self, _: &MetPlace) {}
}

/// The components of a map's points in lx, and the rays that they took. There are none if the scene has light other than that of the sky,
/// for quantities other than those on planes, or without time. The clock is read before each point. If a limit ends the run during the
/// first walks, no point has components. Later, points with more walks keep them.
pub(super) fn sky_components_lx(context: &Context, job: &Job, values: &MapValues) -> (Vec<[Estimate; SKY_WAYS]>, u64) {
    let MapKind::Receivers(set) = job.kind else { return (Vec::new(), 0) };
    let receivers = &context.scene.receivers[set];
    let is_daylit = context.scene.daylight().is_some_and(|(outside_lx, _)| outside_lx > 0.0);
    if !is_daylit || receivers.quantity != Quantity::Perpendicular || context.is_over() {
        return (Vec::new(), 0);
    }
    let none = Openings::default();
    let openings = context.scene.luminaires.iter().find_map(|luminaire| luminaire.emission.openings());
    let openings = openings.unwrap_or(&none);
    let mut points = vec![PointSums::default(); receivers.points.len()];
    let walk = |points: &mut [PointSums], walks: std::ops::Range<u64>| {
        points.par_iter_mut().zip(&receivers.points).enumerate().for_each(|(index, (found, point))| {
            if !point.inside && !context.is_over() {
                walk_from(context, (set, index), openings, point, found, walks.clone());
            }
        });
    };
    walk(&mut points, 0..FIRST_WALKS);
    let first_rays: u64 = points.iter().map(|point| point.rays).sum();
    if context.is_over() {
        return (Vec::new(), first_rays);
    }
    let affordable = SHARE_OF_RAYS * job.all_rays() as f64 * FIRST_WALKS as f64 / first_rays.max(1) as f64;
    walk(&mut points, FIRST_WALKS..(affordable as u64).clamp(FIRST_WALKS, MOST_WALKS));
    let components = points.iter().enumerate().map(|(index, point)| split(values, index, point)).collect();
    (components, points.iter().map(|point| point.rays).sum())
}

fn walk_from(
    context: &Context,
    (set, index): (usize, usize),
    openings: &Openings,
    point: &ReceiverPoint,
    into: &mut PointSums,
    walks: std::ops::Range<u64>,
) {
    let world = context.world;
    let origin = world.tracer.side_origin(point.position_m, point.normal);
    let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
    let (mut pass, mut cut) = (DirectPass::default(), Cut::default());
    for (replica, found) in into.found.iter_mut().enumerate() {
        let mut stream = Stream::new(context.seed, Purpose::DaylightWalks, set as u32 + 1, replica as u32);
        for number in walks.clone() {
            stream.seek_quasi(((index as u64) << 24) | number, index as u64, number);
            let tally = &mut SkyWayTally(found);
            into.rays += walk_for_coefficients((world, openings), &receiver, (&mut pass, &mut cut), tally, &mut stream);
        }
    }
}

/// The map's direct and reflected light at a point, in parts.
fn split(values: &MapValues, index: usize, point: &PointSums) -> [Estimate; SKY_WAYS] {
    let across = |place: usize| std::array::from_fn(|replica| point.found[replica][place]);
    let [from_sky, outside] = [share_of(&across(0), &across(1)), share_of(&across(2), &across(3))];
    let all_error_lx = values.standard_error[index];
    let direct = Estimate {
        value: values.direct[index],
        standard_error: values.direct_standard_error.get(index).copied().unwrap_or(all_error_lx),
    };
    let reflected_error_lx = (all_error_lx.powi(2) - direct.standard_error.powi(2)).max(0.0).sqrt();
    let reflected = Estimate { value: values.indirect[index], standard_error: reflected_error_lx };
    let rest = |share: Estimate| Estimate { value: 1.0 - share.value, ..share };
    let (ground, past) = (part(direct, rest(from_sky)), part(reflected, outside));
    let from_outside =
        Estimate { value: ground.value + past.value, standard_error: ground.standard_error.hypot(past.standard_error) };
    [part(direct, from_sky), from_outside, part(reflected, rest(outside))]
}

/// A share of an illuminance, with the errors of both.
fn part(all: Estimate, share: Estimate) -> Estimate {
    let standard_error = (share.value * all.standard_error).hypot(all.value * share.standard_error);
    Estimate { value: share.value * all.value, standard_error }
}

/// The ratio of `one` to the sum of both, with its error from halves of the replicas.
fn share_of(one: &[f64; PARTED], other: &[f64; PARTED]) -> Estimate {
    let ((one, one_off), (other, other_off)) = (mean_and_halves(one), mean_and_halves(other));
    let share = |one: f64, other: f64| if one + other > 0.0 { one / (one + other) } else { UNKNOWN.value };
    if one + other <= 0.0 {
        return UNKNOWN;
    }
    let halves = one_off.iter().zip(&other_off);
    let of_halves = halves.map(|(a, b)| [share(one + a, other + b), share(one - a, other - b)]);
    Estimate { value: share(one, other), standard_error: standard_error(of_halves) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Components add up to the map's value whatever the shares are, and errors combine both. Without walks a share is unknown.
    #[test]
    fn components_add_up() {
        let values = MapValues {
            value: vec![100.0],
            standard_error: vec![5.0],
            direct: vec![60.0],
            indirect: vec![40.0],
            direct_standard_error: vec![3.0],
            ..MapValues::default()
        };
        let mut point = PointSums::default();
        for (replica, found) in point.found.iter_mut().enumerate() {
            let odd = (replica % 2) as f64;
            *found = [9.0, 1.0, 1.0 + odd, 5.0 - odd];
        }
        let [sky, outside, inside] = split(&values, 0, &point);
        let near = |found: f64, exact: f64| assert!((found - exact).abs() < 1e-9, "{found}, {exact}");
        near(sky.value + outside.value + inside.value, 100.0);
        near(sky.value, 54.0);
        near(sky.standard_error, 2.7);
        near(outside.value, 6.0 + 10.0);
        // Shares of 1/6 and 2/6 in the two halves of the replicas: 1/12/√15 around their mean.
        let share_error = 1.0 / 12.0 / 15f64.sqrt();
        near(inside.standard_error, (0.75 * 4.0f64).hypot(40.0 * share_error));
        let [sky, outside, inside] = split(&values, 0, &PointSums::default());
        near(sky.value + outside.value + inside.value, 100.0);
        assert!(sky.standard_error >= 30.0 && inside.standard_error >= 20.0);
    }
}
