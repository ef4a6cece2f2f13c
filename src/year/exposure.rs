//! Exposure to sunlight of EN 17037: how long the centre of the sun is visible from a point on a day.
//!
//! The sun is sampled every minute of the day. Where it appears or disappears between two samples, bisection finds the moment.
//! Obstacles or gaps that last less than a minute may be missed.

use glam::DVec3;
use rayon::prelude::*;

use super::hours::YEAR;
use crate::base::solar_position::{Moment, direction_of, solar_position_deg};
use crate::estimators::sunlight::way_out;
use crate::geometry::Origin;
use crate::scene::{ReceiverPoint, Scene};
use crate::transport::World;

/// Samples of the sun in a day.
const SUNS_OF_A_DAY: u32 = 24 * 60;
/// Bisections of a minute: to a hundredth of a second.
const HALVINGS: u32 = 13;
/// Hours of sunlight on a day for the minimum, medium and high level of EN 17037.
pub const EXPOSURE_HOURS: [f64; 3] = [1.5, 3.0, 4.0];

/// Location of a scene on the earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunSite {
    /// Latitude in degrees, positive north of the equator.
    pub latitude_deg: f64,
    /// Longitude in degrees, positive east of Greenwich.
    pub longitude_deg: f64,
    /// Offset in hours of the results' time from universal time.
    pub time_zone_hours: f64,
    /// Minimum elevation of the sun in degrees from which it counts.
    pub least_elevation_deg: f64,
}

/// Periods of a day in which the sun is visible, each from and to, in hours.
pub type SunlitHours = Vec<[f64; 2]>;

/// Sunlight of a receiver set on some days.
#[derive(Clone, Debug)]
pub struct SetSunlight {
    /// Index among the scene's receiver sets.
    pub set: usize,
    /// Sunlit hours by point and day; empty for points inside solids.
    pub points: Vec<Vec<SunlitHours>>,
}

/// Computes when the points of all receiver sets with positions see the sun, on days given by month and day.
pub fn sunlight(scene: &Scene, site: &SunSite, days: &[(u32, u32)]) -> Vec<SetSunlight> {
    let world = World::new(scene);
    // The sun's directions are the same for all points.
    let days: Vec<SunDay> = days.iter().map(|day| SunDay::of(*site, *day)).collect();
    let of_point = |point: &ReceiverPoint| {
        if point.inside {
            return vec![Vec::new(); days.len()];
        }
        let origin = world.tracer.side_origin(point.position_m, point.normal);
        days.iter().map(|day| sunlit(&world, point, &origin, day)).collect()
    };
    let sets = scene.receivers.iter().enumerate().filter(|(_, set)| !set.placed_points().is_empty());
    sets.map(|(set, receivers)| SetSunlight { set, points: receivers.points.par_iter().map(of_point).collect() })
        .collect()
}

/// Sum of the hours.
pub fn sum_of_hours(sunlit: &SunlitHours) -> f64 {
    sunlit.iter().fold(0.0, |sum, [from, to]| sum + to - from)
}

/// The sun on a day.
struct SunDay {
    site: SunSite,
    date: (u32, u32),
    /// Direction to the sun at each sample.
    towards: Vec<Option<DVec3>>,
}

impl SunDay {
    fn of(site: SunSite, date: (u32, u32)) -> SunDay {
        let day = SunDay { site, date, towards: Vec::new() };
        SunDay { towards: (0..=SUNS_OF_A_DAY).map(|minute| day.towards(hour_of(minute))).collect(), ..day }
    }

    /// Direction to the sun at an hour, or `None` if the sun is too low.
    fn towards(&self, hour: f64) -> Option<DVec3> {
        let (month, day) = self.date;
        let moment = Moment::of_date(YEAR, month, day, hour - self.site.time_zone_hours);
        let [elevation_deg, azimuth_deg] = solar_position_deg(self.site.latitude_deg, self.site.longitude_deg, moment);
        let is_high = elevation_deg > self.site.least_elevation_deg.max(0.0);
        is_high.then(|| direction_of(elevation_deg, azimuth_deg))
    }
}

fn hour_of(minute: u32) -> f64 {
    24.0 * f64::from(minute) / f64::from(SUNS_OF_A_DAY)
}

fn sunlit(world: &World, point: &ReceiverPoint, origin: &Origin, day: &SunDay) -> SunlitHours {
    let sees = |towards: Option<DVec3>| {
        towards.is_some_and(|towards| point.normal.dot(towards) > 0.0 && way_out(world, origin, towards).0 > 0.0)
    };
    // The moment at which the sun appears or disappears.
    let change = |mut before: f64, mut after: f64, was_seen: bool| {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + after);
            *(if sees(day.towards(middle)) == was_seen { &mut before } else { &mut after }) = middle;
        }
        0.5 * (before + after)
    };
    let mut found = Vec::new();
    let (mut was_seen, mut from) = (sees(day.towards[0]), 0.0);
    for (minute, towards) in (0..).zip(&day.towards).skip(1) {
        let is_seen = sees(*towards);
        if is_seen != was_seen {
            let moment = change(hour_of(minute - 1), hour_of(minute), was_seen);
            if was_seen {
                found.push([from, moment]);
            }
            from = moment;
        }
        was_seen = is_seen;
    }
    if was_seen {
        found.push([from, 24.0]);
    }
    found
}
