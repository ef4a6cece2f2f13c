//! The year of one receiver: coefficients from walks, hours from sums.

use super::count::{Counted, HourCounts, YearMeasure};
use super::hours::YearSky;
use super::sun_cells::SunCells;
use crate::base::half_samples::{PARTED, PARTINGS, mean_and_halves};
use crate::estimators::coefficients::{CoefficientTally, MetPlace, SKY_WAYS, SkyPath, walk_for_coefficients};
use crate::estimators::direct::DirectPass;
use crate::estimators::receiver::Receiver;
use crate::estimators::sunlight::Suns;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Openings, ReceiverPoint, Scene};
use crate::transport::World;
use glam::DVec3;

/// Walks of a replica before the first check of the error, and at most.
const FIRST_WALKS: u64 = 64;
const MOST_WALKS: u64 = 1 << 15;
/// Factor on the number of walks that the error requires, because the error is an estimate.
const RESERVE: f64 = 1.15;
/// Share of the target that partly hidden suns may leave, and the maximum of shadow rays per replica for each of these suns.
const HALF_HIDDEN_SHARE: f64 = 0.5;
const MOST_SUN_SAMPLES: u64 = 64;
/// An hour's error is relative to its illuminance, or to this share of the mean over all occupied hours if that is larger. At dusk
/// there is almost no light, and a relative error of a hundredth is not needed there.
const DIM_SHARE: f64 = 0.01;

/// Data shared by all receivers.
pub(super) struct YearContext<'a> {
    pub scene: &'a Scene,
    pub world: &'a World,
    pub sky: &'a YearSky,
    pub cells: &'a SunCells<'a>,
    /// Openings through which daylight enters.
    pub openings: &'a Openings,
    pub seed: u64,
    pub target_error: f64,
}

/// The hours of a receiver.
pub(super) struct ReceiverHours {
    /// Illuminance of each hour with light in lx, and the differences of the halves from it.
    pub lx: Vec<(f64, [f64; PARTINGS])>,
    pub counts: HourCounts,
    pub error: f64,
    /// Part of the error that shadow rays to partly hidden suns leave. More walks do not lower it.
    sun_error: f64,
    pub walks: u64,
    pub rays: u64,
}

/// Results of sixteen replicas, stored replica by replica.
struct Replicas {
    width: usize,
    values: Vec<f64>,
}

impl Replicas {
    fn new(width: usize) -> Replicas {
        Replicas { width, values: vec![0.0; PARTED * width] }
    }

    fn of(&mut self, replica: usize) -> &mut [f64] {
        &mut self.values[replica * self.width..(replica + 1) * self.width]
    }

    fn across(&self, place: usize) -> [f64; PARTED] {
        std::array::from_fn(|replica| self.values[replica * self.width + place])
    }
}

/// Adds the contributions that a walk of a replica finds.
struct RowTally<'a> {
    sky: &'a YearSky,
    cells: &'a SunCells<'a>,
    replica: usize,
    columns: &'a mut [f64],
    /// Contributions by reflecting surfaces: of the nodes, and of the hours' own suns beyond the value interpolated from the nodes.
    suns: &'a mut [f64],
    own_suns: &'a mut [f64],
    ways: &'a mut [f64],
}

impl CoefficientTally for RowTally<'_> {
    #[inline]
    fn add_sky(&mut self, towards: DVec3, lx: f64, way: SkyPath) {
        self.columns[self.sky.column_of(towards)] += lx;
        self.ways[way.component(towards) as usize] += lx * self.sky.overcast_percent(towards);
    }

    #[inline]
    fn met(&mut self, place: &MetPlace) {
        let seen = self.cells.suns_on(self.replica, place.spot, place.barycentric);
        let nodes = &self.sky.nodes;
        if let Some(share) = place.brings_evenly() {
            seen.nodes().for_each(|(node, lx)| self.suns[node] += share * lx);
            seen.own.iter().for_each(|own| self.own_suns[usize::from(own.sun)] += share * own.off_lx());
            return;
        }
        let of_node = |node: usize, lx: f64| lx * place.brings(nodes.suns.towards[node]);
        seen.nodes().for_each(|(node, lx)| self.suns[node] += of_node(node, lx));
        for own in &seen.own {
            let sun = usize::from(own.sun);
            let lx = own.lx() * place.brings(self.sky.suns.towards[sun]);
            let off_lx = lx - nodes.between(sun, |node| of_node(node, seen.of_node_lx(node)));
            self.own_suns[sun] += f64::from(own.times) * off_lx;
        }
    }
}

/// Direct contributions of the suns to a receiver in all replicas. Each sun gives 1 lx perpendicular to its rays.
pub(super) struct DirectSuns {
    lx: Replicas,
    /// Shadow rays of each replica to a sun that some replicas see and others do not.
    samples: u64,
    pub rays: u64,
}

impl DirectSuns {
    pub fn of(context: &YearContext, (set, index): (usize, usize), receiver: &Receiver) -> DirectSuns {
        let mut found = DirectSuns { lx: Replicas::new(context.sky.suns.towards.len()), samples: 1, rays: 0 };
        for replica in 0..PARTED {
            let mut stream = Stream::new(context.seed, Purpose::SunPlaces, set as u32 + 1, replica as u32);
            stream.seek(index as u64);
            let slab = found.lx.of(replica);
            let around = (context.scene, context.world);
            let show = |sun: usize, lx| slab[sun] = lx;
            found.rays += context.sky.suns.find_all(around, receiver, context.openings.if_all(), &mut stream, show);
        }
        found
    }

    /// Repeats shadow rays to the suns that some replicas saw and others did not, up to `samples` per replica.
    fn sample_again(&mut self, context: &YearContext, (set, index): (usize, usize), receiver: &Receiver, samples: u64) {
        let all = &context.sky.suns;
        let is_half_hidden = |sun: &usize| {
            let seen = self.lx.across(*sun);
            seen.iter().any(|lx| *lx > 0.0) && seen.contains(&0.0)
        };
        let half_hidden: Vec<usize> = (0..all.towards.len()).filter(is_half_hidden).collect();
        let suns = Suns { towards: half_hidden.iter().map(|sun| all.towards[*sun]).collect(), disk: all.disk };
        let around = (context.scene, context.world);
        for replica in 0..PARTED {
            let mut stream = Stream::new(context.seed, Purpose::SunPlaces, set as u32 + 1, replica as u32);
            let mut sums = vec![0.0; half_hidden.len()];
            for sample in self.samples..samples {
                stream.seek((sample << 32) | index as u64);
                let add = |sun: usize, lx| sums[sun] += lx;
                self.rays += suns.find_all(around, receiver, context.openings.if_all(), &mut stream, add);
            }
            let slab = self.lx.of(replica);
            for (sun, sum) in half_hidden.iter().zip(sums) {
                slab[*sun] = (self.samples as f64 * slab[*sun] + sum) / samples as f64;
            }
        }
        self.samples = samples;
    }

    /// Mean direct illuminance in lx by a sun of 1 lx perpendicular to its rays.
    pub fn mean_lx(&self, sun: usize) -> f64 {
        self.lx.across(sun).iter().sum::<f64>() / PARTED as f64
    }
}

/// Calls a closure with the receiver of a point.
pub(super) fn at<R>(world: &World, point: &ReceiverPoint, then: impl FnOnce(&Receiver) -> R) -> R {
    let origin = world.tracer.side_origin(point.position_m, point.normal);
    then(&Receiver { point_m: point.position_m, normal: point.normal, origin: &origin })
}

/// Gathers a receiver's coefficients until its target error is met, and computes its hours. `closed` has the hours with closed
/// blinds and the share of light that these let pass; they block all direct sunlight.
pub(super) fn year_of(
    context: &YearContext,
    (set, index): (usize, usize),
    receiver: &Receiver,
    closed: Option<(&[bool], f64)>,
) -> ReceiverHours {
    let sky = context.sky;
    let mut direct = DirectSuns::of(context, (set, index), receiver);
    let mut rays = 0;
    let mut columns = Replicas::new(sky.columns());
    let mut suns = Replicas::new(sky.nodes.suns.towards.len());
    let mut own_suns = Replicas::new(sky.suns.towards.len());
    let mut ways = Replicas::new(SKY_WAYS);
    let (mut pass, mut cut) = (DirectPass::default(), Cut::default());
    let mut walked = 0;
    let mut wanted = FIRST_WALKS;
    loop {
        for replica in 0..PARTED {
            let mut stream = Stream::new(context.seed, Purpose::DaylightWalks, set as u32 + 1, replica as u32);
            let mut tally = RowTally {
                sky,
                cells: context.cells,
                replica,
                columns: columns.of(replica),
                suns: suns.of(replica),
                own_suns: own_suns.of(replica),
                ways: ways.of(replica),
            };
            for number in walked..wanted {
                stream.seek_quasi(((index as u64) << 24) | number, index as u64, number);
                rays += walk_for_coefficients(
                    (context.world, context.openings),
                    receiver,
                    (&mut pass, &mut cut),
                    &mut tally,
                    &mut stream,
                );
            }
        }
        walked = wanted;
        let mut found = hours_of(sky, (&columns, [&suns, &own_suns], &direct), walked, closed);
        let target_square = context.target_error.powi(2);
        let sun_square = (HALF_HIDDEN_SHARE * context.target_error).powi(2);
        if found.sun_error.powi(2) > sun_square && direct.samples < MOST_SUN_SAMPLES {
            let needed = direct.samples as f64 * RESERVE * found.sun_error.powi(2) / sun_square;
            let samples = (needed.min(MOST_SUN_SAMPLES as f64) as u64).clamp(direct.samples + 1, MOST_SUN_SAMPLES);
            direct.sample_again(context, (set, index), receiver, samples);
            found = hours_of(sky, (&columns, [&suns, &own_suns], &direct), walked, closed);
        }
        // Squared error that walks may leave. If suns alone exceed the target, walks may leave as much as partly hidden suns may.
        let of_walks = found.error.powi(2) - found.sun_error.powi(2);
        let allowed = (target_square - found.sun_error.powi(2)).max(sun_square);
        if found.error <= context.target_error || of_walks <= allowed || walked >= MOST_WALKS {
            for way in 0..SKY_WAYS {
                let percents = ways.across(way).map(|sum| sum / walked as f64);
                found.counts.of[YearMeasure::SkyComponent as usize + way] = Counted::of(&percents);
            }
            return ReceiverHours { walks: walked * PARTED as u64, rays: rays + direct.rays, ..found };
        }
        let needed = walked as f64 * RESERVE * of_walks / allowed;
        wanted = (needed.min(MOST_WALKS as f64) as u64).max(walked + walked / 4).min(MOST_WALKS);
    }
}

/// Computes the hours from coefficients gathered by `walks` walks per replica.
fn hours_of(
    sky: &YearSky,
    (columns, [suns, own_suns], direct): (&Replicas, [&Replicas; 2], &DirectSuns),
    walks: u64,
    closed: Option<(&[bool], f64)>,
) -> ReceiverHours {
    let share = 1.0 / walks as f64;
    // Only the patches from which light comes, with all replicas side by side.
    let lit: Vec<(usize, [f64; PARTED])> = (0..columns.width)
        .map(|column| (column, columns.across(column).map(|sum| share * sum)))
        .filter(|(_, coefficients)| coefficients.iter().any(|coefficient| *coefficient > 0.0))
        .collect();
    let mut counts = HourCounts::default();
    let mut lx = Vec::with_capacity(sky.hours.len());
    let mut occupied: Vec<OccupiedHour> = Vec::with_capacity(sky.occupied);
    let mut sun = 0;
    for (number, hour) in sky.hours.iter().enumerate() {
        let luminances = sky.luminances_cd_m2(number);
        let mut all = [0.0; PARTED];
        for (column, coefficients) in &lit {
            let luminance = luminances[*column];
            for (sum, coefficient) in all.iter_mut().zip(coefficients) {
                *sum += luminance * coefficient;
            }
        }
        let mut of_sun = [0.0; PARTED];
        if sky.hours_of_suns.get(sun) == Some(&(number as u32)) {
            of_sun = direct.lx.across(sun).map(|lx| hour.sun_lx * lx);
            let by_suns = hour.sun_lx * share;
            all.iter_mut().zip(own_suns.across(sun)).for_each(|(sum, more)| *sum += by_suns * more);
            for (node, weight) in sky.nodes.around(sun) {
                all.iter_mut().zip(suns.across(node)).for_each(|(sum, reflected)| *sum += weight * by_suns * reflected);
            }
            sun += 1;
        }
        let is_open = closed.is_none_or(|(closed, _)| !closed[number]);
        match closed {
            Some((_, passed)) if !is_open => all.iter_mut().for_each(|sum| *sum *= passed),
            _ => all.iter_mut().zip(of_sun).for_each(|(sum, lx)| *sum += lx),
        }
        let (mean_lx, off_lx) = mean_and_halves(&all);
        let sunlit = of_sun.iter().any(|lx| *lx > 0.0).then(|| mean_and_halves(&of_sun));
        let sunlit = sunlit.as_ref().map(|(lx, off)| (*lx, off));
        let square_of = |off: &[f64; PARTINGS]| off.iter().map(|off| off * off).sum::<f64>() / PARTINGS as f64;
        counts.add_hour(hour.is_occupied, (mean_lx, &off_lx), sunlit);
        if hour.is_occupied {
            let of_sun = sunlit.filter(|_| is_open).map_or(0.0, |(_, off)| square_of(off));
            occupied.push(OccupiedHour { lx: mean_lx, squared_error_lx2: square_of(&off_lx), of_sun_lx2: of_sun });
        }
        lx.push((mean_lx, off_lx));
    }
    counts.add_dark((sky.occupied - occupied.len()) as f64);
    let error_of = |square: fn(&OccupiedHour) -> f64| relative_error(&occupied, square);
    let (error, sun_error) = (error_of(|hour| hour.squared_error_lx2), error_of(|hour| hour.of_sun_lx2));
    ReceiverHours { lx, counts, error, sun_error, walks: 0, rays: 0 }
}

/// Illuminance of an occupied hour with light, its squared error, and the part of this from shadow rays to the sun.
struct OccupiedHour {
    lx: f64,
    squared_error_lx2: f64,
    of_sun_lx2: f64,
}

/// Root mean square of the relative errors of occupied hours; see [`DIM_SHARE`].
fn relative_error(hours: &[OccupiedHour], square_lx2: impl Fn(&OccupiedHour) -> f64) -> f64 {
    let mean_lx = hours.iter().map(|hour| hour.lx).sum::<f64>() / hours.len().max(1) as f64;
    let lit = || hours.iter().filter(|hour| hour.lx > 0.0);
    let squares = lit().map(|hour| square_lx2(hour) / hour.lx.max(DIM_SHARE * mean_lx).powi(2));
    (squares.sum::<f64>() / lit().count().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks a hundred hours of 1000 lx with an error of 3 %, and one at dusk of 0.01 lx with an error of 0.1 lx: the result is 3
    /// %. Planted fault: with each error relative to its own illuminance the result would be about 100 %.
    #[test]
    fn an_hour_without_light_to_speak_of_does_not_rule_the_year() {
        let mut hours: Vec<OccupiedHour> =
            (0..100).map(|_| OccupiedHour { lx: 1000.0, squared_error_lx2: 900.0, of_sun_lx2: 400.0 }).collect();
        hours.push(OccupiedHour { lx: 0.01, squared_error_lx2: 0.01, of_sun_lx2: 0.0 });
        let error = relative_error(&hours, |hour| hour.squared_error_lx2);
        assert!((error - 0.03).abs() < 3e-4, "{error}");
        assert!((relative_error(&hours, |hour| hour.of_sun_lx2) - 0.02).abs() < 2e-4);
        let each_by_itself: f64 = hours.iter().map(|hour| hour.squared_error_lx2 / hour.lx.powi(2)).sum();
        assert!((each_by_itself / 101.0).sqrt() > 0.9);
        assert_eq!(relative_error(&[], |hour| hour.squared_error_lx2), 0.0);
    }
}
