//! A survey before the year: where walks meet surfaces, and how large the error of patches of uniform luminance is.

use glam::DVec3;
use rayon::prelude::*;

use super::hours::YearSky;
use super::receiver::at;
use super::sun_cells::side_index;
use crate::base::sky::Sky;
use crate::estimators::coefficients::{CoefficientTally, MetPlace, SkyPath, walk_for_coefficients};
use crate::estimators::direct::DirectPass;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Openings, Scene};
use crate::transport::World;

/// Number of surveyed receivers, and of walks from each.
const SURVEYED: usize = 128;
const WALKS: u64 = 512;
/// Number of occupied hours whose skies are compared.
const HOURS: usize = 48;

/// Result of the survey.
pub(super) struct HourSurvey {
    /// Number of times that walks met each side of a triangle.
    pub meetings: Vec<u32>,
    /// Relative error of the sky's light due to patches of uniform luminance, in the median hour. It is a root mean square over the
    /// surveyed receivers, relative to the light itself; 0 if noise hides it. The median is used because in the first and last
    /// minutes of a day the sky model has its light in a rim at the horizon. A mean over hours would depend on these alone.
    pub patch_error: f64,
    pub rays: u64,
}

/// An hour with both skies: its patches and its exact sky.
struct Compared<'a> {
    patches_cd_m2: &'a [f64],
    sky: Sky,
}

/// Illuminance in lx that walks find under the patches and under the exact sky, for both halves of the walks.
type Both = [[f64; 2]; 2];

/// Results of the walks from one receiver: the sides of triangles that they meet, and the light of each hour.
struct HourTally<'a> {
    of: &'a YearSky,
    hours: &'a [Compared<'a>],
    met: Vec<usize>,
    found: Vec<Both>,
    half: usize,
}

impl CoefficientTally for HourTally<'_> {
    fn add_sky(&mut self, towards: DVec3, lx: f64, _: SkyPath) {
        let column = self.of.column_of(towards);
        for (hour, both) in self.hours.iter().zip(&mut self.found) {
            let even_cd_m2 = hour.patches_cd_m2[column];
            let own_cd_m2 = if towards.z > 0.0 { hour.sky.luminance_cd_m2(towards) } else { even_cd_m2 };
            both[self.half][0] += lx * even_cd_m2;
            both[self.half][1] += lx * own_cd_m2;
        }
    }

    fn met(&mut self, place: &MetPlace) {
        self.met.push(side_index(place.spot));
    }
}

/// Traces walks from receivers spread over the planes.
///
/// Patches and exact sky share the same walks, so the noise in their difference is small. The product of two halves of the walks
/// removes the rest of the noise on average.
pub(super) fn survey(
    (scene, world): (&Scene, &World),
    openings: &Openings,
    sky: &YearSky,
    planes: &[usize],
    seed: u64,
) -> HourSurvey {
    let places: Vec<(usize, usize)> = planes
        .iter()
        .flat_map(|set| (0..scene.receivers[*set].points.len()).map(move |index| (*set, index)))
        .filter(|(set, index)| !scene.receivers[*set].points[*index].inside)
        .collect();
    let step = places.len().div_ceil(SURVEYED).max(1);
    let occupied: Vec<usize> = (0..sky.hours.len()).filter(|hour| sky.hours[*hour].is_occupied).collect();
    let hours: Vec<Compared> = (0..HOURS.min(occupied.len()))
        .map(|number| {
            let hour = occupied[number * occupied.len() / HOURS.min(occupied.len())];
            let outside_lx = sky.hours[hour].outside_lx[0];
            let own = Sky::of_horizontal(sky.patterns[hour], outside_lx, 0.0);
            Compared { patches_cd_m2: sky.luminances_cd_m2(hour), sky: own }
        })
        .collect();
    let surveyed: Vec<(usize, usize)> = places.into_iter().step_by(step).collect();
    let from_place = |(number, (set, index)): (usize, &(usize, usize))| {
        let (mut pass, mut cut) = (DirectPass::default(), Cut::default());
        let mut stream = Stream::new(seed, Purpose::Pilot, u32::MAX, 0);
        let found = vec![Both::default(); hours.len()];
        let mut tally = HourTally { of: sky, hours: &hours, met: Vec::new(), found, half: 0 };
        let mut rays = 0;
        at(world, &scene.receivers[*set].points[*index], |receiver| {
            for walk in 0..WALKS {
                // The two halves of one quasi-random sequence would be correlated. Each half therefore has its own sequence.
                let sequence = 2 * number as u64 + walk % 2;
                stream.seek_quasi((number as u64) * WALKS + walk, sequence, walk / 2);
                tally.half = (walk % 2) as usize;
                rays +=
                    walk_for_coefficients((world, openings), receiver, (&mut pass, &mut cut), &mut tally, &mut stream);
            }
        });
        (tally.met, tally.found, rays)
    };
    let of_places: Vec<(Vec<usize>, Vec<Both>, u64)> = surveyed.par_iter().enumerate().map(from_place).collect();
    let mut meetings = vec![0; 2 * scene.triangles.len()];
    let (mut of_hours, mut rays) = (vec![[0.0f64; 2]; hours.len()], 0);
    for (met, found, rays_of_place) in of_places {
        met.into_iter().for_each(|side| meetings[side] += 1);
        rays += rays_of_place;
        for ([squares, known_lx2], [one, other]) in of_hours.iter_mut().zip(found) {
            *squares += 4.0 * (one[0] - one[1]) * (other[0] - other[1]);
            *known_lx2 += (one[1] + other[1]).powi(2);
        }
    }
    let lit = of_hours.into_iter().filter(|[_, known_lx2]| *known_lx2 > 0.0);
    let mut errors: Vec<f64> = lit.map(|[squares, known_lx2]| (squares / known_lx2).max(0.0).sqrt()).collect();
    errors.sort_by(f64::total_cmp);
    let patch_error = errors.get(errors.len() / 2).copied().unwrap_or(0.0);
    HourSurvey { meetings, patch_error, rays }
}
