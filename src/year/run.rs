//! Solves a year for all receivers, in chunks over threads.

use rayon::prelude::*;

use super::count::{ASE_HOURS, ASE_LX, BLINDS_SHARE, Counted, MEASURES, SDA_SHARE, YearMeasure};
use super::hours::YearSky;
use super::receiver::{DirectSuns, ReceiverHours, YearContext, at, year_of};
use super::result::{SetYear, YearPoint, YearSolution};
use super::sun_cells::SunCells;
use super::survey::survey;
use crate::base::half_samples::{PARTINGS, error_of_mean};
use crate::base::sky::{Sky, SkyPattern};
use crate::scene::{BsdfParameters, Emission, Openings, Quantity, ReceiverSet, Scene, Weather, joined};
use crate::transport::World;
use std::sync::Arc;

/// Number of receivers computed before their hours are passed on.
const CHUNK: usize = 64;

/// Settings of a year.
#[derive(Clone, Copy, Debug)]
pub struct YearSettings {
    /// Parts along the sides of Tregenza's patches, 1 to 4.
    pub subdivision: u32,
    /// Occupied hours of every day: from and to, in standard time, h.
    pub occupied_hours: [f64; 2],
    /// Target for the relative error of the hours' illuminances at each point.
    pub target_error: f64,
    /// Seed of all streams.
    pub seed: u64,
    /// Blinds, if there are any.
    pub blinds: Option<Blinds>,
}

impl Default for YearSettings {
    fn default() -> YearSettings {
        YearSettings { subdivision: 2, occupied_hours: [8.0, 18.0], target_error: 0.03, seed: 0, blinds: None }
    }
}

/// Blinds that are closed while direct sunlight gives 1000 lx or more at more than 2 % of a set's points (IES LM-83).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blinds {
    /// Share of skylight and of sunlight reflected by surfaces that closed blinds let pass. They block all direct sunlight.
    pub transmittance: f64,
}

/// Hours of one receiver, as passed to the caller.
pub struct YearHours<'a> {
    /// The receiver set.
    pub receivers: &'a ReceiverSet,
    /// Index of the point in the set.
    pub point: usize,
    /// Illuminance of each hour with light in lx.
    pub lx: &'a [f64],
    /// Standard error of `lx` in lx.
    pub standard_error_lx: &'a [f64],
}

/// Reason why a year cannot be computed for a scene.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[error("{what}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}")]
pub struct NotForYear {
    what: &'static str,
    got: String,
    expected: &'static str,
    remedy: &'static str,
}

/// Returns the scene with a uniform sky of 1 cd/m² as its only luminaire, the ground's reflectance and the factor of maintenance
/// and dimming.
fn under_even_sky(mut scene: Scene) -> Result<(Scene, f64, f64), NotForYear> {
    let sky = scene.luminaires.iter().find(|luminaire| matches!(luminaire.emission, Emission::Sky { .. }));
    let Some(luminaire) = sky else {
        return Err(NotForYear {
            what: "the scene has no sky",
            got: match scene.luminaires.len() {
                1 => "one luminaire, of another type".to_owned(),
                count => format!("{count} luminaires of other types"),
            },
            expected: "a luminaire of type \"sky\", whose brightness comes from the weather",
            remedy: "add { \"name\": \"sky\", \"type\": \"sky\", \"luminance_distribution\": \"overcast\", \
                     \"horizontal_illuminance_lx\": 10000, \"ground_reflectance\": 0.2 }",
        });
    };
    let mut alone = luminaire.clone();
    let (mut ground_reflectance, mut largest) = (0.0, 0.0);
    if let Emission::Sky { sky, openings, .. } = &mut alone.emission {
        ground_reflectance = sky.ground_reflectance();
        *sky = Arc::new(Sky::of_zenith(SkyPattern::Uniform, 1.0, 1.0));
        largest = openings.fluxes_lm(|normal| sky.illuminance_lx(normal)).sum::<f64>()
            + openings.open_flux_lm(sky.total_cd_sr_m2());
    }
    alone.luminous_flux_lm = largest;
    let maintained = luminaire.dimming * luminaire.maintenance_factor;
    scene.luminaires = vec![alone];
    Ok((scene, ground_reflectance, maintained))
}

/// Solves a year of a scene. The solution contains the scene with a uniform sky as its only luminaire. `hand_out` receives the
/// hours of every point that is not inside a solid, in the order of the scene; its error ends the run.
///
/// # Errors
///
/// A scene without a sky, or without receivers on planes, and errors of `hand_out`.
pub fn solve_year<E: From<NotForYear>>(
    scene: Scene,
    weather: &Weather,
    settings: &YearSettings,
    mut hand_out: impl FnMut(&YearSky, &YearHours) -> Result<(), E>,
) -> Result<YearSolution, E> {
    let (scene, ground_reflectance, maintained) = under_even_sky(scene)?;
    let [from, to] = settings.occupied_hours;
    let is_occupied = |middle: f64| from <= middle && middle < to;
    let sky = YearSky::of(weather, settings.subdivision, ground_reflectance, maintained, is_occupied);
    let world = World::new(&scene);
    let none = Openings::default();
    let openings = scene.luminaires[0].emission.openings().unwrap_or(&none);
    let is_plane = |set: &usize| scene.receivers[*set].quantity == Quantity::Perpendicular;
    let (planes, others): (Vec<usize>, Vec<usize>) = (0..scene.receivers.len()).partition(is_plane);
    let survey = survey((&scene, &world), openings, &sky, &planes, settings.seed);
    let tuning = (settings.target_error, settings.seed);
    let cells = SunCells::new((&scene, &world), (&sky.suns, &sky.nodes), openings.if_all(), &survey.meetings, tuning);
    let context = YearContext {
        scene: &scene,
        world: &world,
        sky: &sky,
        cells: &cells,
        openings,
        seed: settings.seed,
        target_error: settings.target_error,
    };
    if planes.is_empty() {
        return Err(E::from(NotForYear {
            what: "the scene has no receivers for which a year can be computed",
            got: format!("{} receiver sets of other quantities", others.len()),
            expected: "a receiver set of illuminance on planes",
            remedy: "add a grid",
        }));
    }
    let mut sets = Vec::with_capacity(planes.len());
    let mut rays = survey.rays;
    for set in planes {
        let (solved, set_rays) = set_year(&context, set, settings.blinds, |hours| hand_out(&sky, hours))?;
        sets.push(solved);
        rays += set_rays;
    }
    rays += cells.rays();
    let left_out = others.iter().map(|set| scene.receivers[*set].name.clone()).collect();
    let walks_given_up = world.patience.walks_given_up();
    Ok(YearSolution {
        sets,
        left_out,
        target_error: settings.target_error,
        patch_error: survey.patch_error,
        rays,
        walks_given_up,
        warnings: warnings(&scene, &sky),
        sky,
        scene,
    })
}

/// Warnings about parts that the year leaves out: sunlight reflected by mirrors.
fn warnings(scene: &Scene, sky: &YearSky) -> Vec<String> {
    let is_mirror = |material: u32| matches!(scene.materials[material as usize].bsdf, BsdfParameters::Mirror { .. });
    let mirrors: Vec<String> = scene
        .surfaces
        .iter()
        .filter(|surface| is_mirror(surface.material))
        .map(|surface| surface.name.clone())
        .collect();
    if mirrors.is_empty() || sky.suns.towards.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "sunlight reflected by mirrors is left out of the year ({}): hours with these reflections are too dark",
        joined(&mirrors)
    )]
}

/// Whether blinds are closed in each hour, and the number of rays traced.
fn closed_hours(context: &YearContext, set: usize) -> (Vec<bool>, u64) {
    let points = &context.scene.receivers[set].points;
    let counted: Vec<usize> = (0..points.len()).filter(|index| !points[*index].inside).collect();
    let suns = context.sky.suns.towards.len();
    let chunks: Vec<(Vec<u32>, u64)> = counted
        .par_chunks(CHUNK)
        .map(|chunk| {
            let (mut lit, mut rays) = (vec![0; suns], 0);
            for index in chunk {
                let direct =
                    at(context.world, &points[*index], |receiver| DirectSuns::of(context, (set, *index), receiver));
                rays += direct.rays;
                for (sun, lit) in lit.iter_mut().enumerate() {
                    let hour = context.sky.hours_of_suns[sun] as usize;
                    *lit += u32::from(context.sky.hours[hour].sun_lx * direct.mean_lx(sun) >= ASE_LX);
                }
            }
            (lit, rays)
        })
        .collect();
    let mut closed = vec![false; context.sky.hours.len()];
    for (sun, hour) in context.sky.hours_of_suns.iter().enumerate() {
        let lit: u32 = chunks.iter().map(|(lit, _)| lit[sun]).sum();
        closed[*hour as usize] = f64::from(lit) > BLINDS_SHARE * counted.len() as f64;
    }
    (closed, chunks.iter().map(|(_, rays)| rays).sum())
}

/// Sums over the points of a set.
struct SetSums {
    weight: f64,
    autonomy: Counted,
    sunlit: Counted,
    averages: [Counted; MEASURES.len()],
    hourly: Vec<(f64, [f64; PARTINGS])>,
    useful: Vec<f64>,
    worst_error: f64,
    squares: f64,
    points: f64,
}

impl SetSums {
    fn new(hours: usize) -> SetSums {
        SetSums {
            weight: 0.0,
            autonomy: Counted::default(),
            sunlit: Counted::default(),
            averages: Default::default(),
            hourly: vec![(0.0, [0.0; PARTINGS]); hours],
            useful: vec![0.0; hours],
            worst_error: 0.0,
            squares: 0.0,
            points: 0.0,
        }
    }

    fn add(&mut self, weight: f64, found: &ReceiverHours, measures: &[Counted; MEASURES.len()]) {
        let one = |is_so: bool| f64::from(u8::from(is_so));
        self.weight += weight;
        self.autonomy.add(&measures[YearMeasure::Autonomy as usize], weight, |share| one(share >= SDA_SHARE));
        self.sunlit.add(&measures[YearMeasure::Sunlit as usize], weight, |hours| one(hours > ASE_HOURS));
        for (average, measure) in self.averages.iter_mut().zip(measures) {
            average.add(measure, weight, |value| value);
        }
        for ((sum, useful), (lx, off)) in self.hourly.iter_mut().zip(&mut self.useful).zip(&found.lx) {
            sum.0 += weight * lx;
            sum.1.iter_mut().zip(off).for_each(|(sum, off)| *sum += weight * off);
            *useful += weight * one((super::UDI_LIMITS_LX[1]..=super::UDI_LIMITS_LX[2]).contains(lx));
        }
        self.worst_error = self.worst_error.max(found.error);
        self.squares += found.error * found.error;
        self.points += 1.0;
    }

    fn finish(self, set: usize, name: &str, points: Vec<YearPoint>, closed: Vec<bool>) -> SetYear {
        // If no point counts, all sums are 0.
        let all = if self.weight > 0.0 { self.weight } else { 1.0 };
        SetYear {
            set,
            name: name.to_owned(),
            points,
            autonomy: self.autonomy.over(all).estimate(),
            sunlit: self.sunlit.over(all).estimate(),
            averages: self.averages.map(|average| average.over(all).estimate()),
            hourly_standard_error_lx: self
                .hourly
                .iter()
                .map(|(_, off)| error_of_mean(&off.map(|off| off / all)))
                .collect(),
            hourly_lx: self.hourly.iter().map(|(lx, _)| lx / all).collect(),
            hourly_useful: self.useful.iter().map(|useful| useful / all).collect(),
            closed,
            worst_error: self.worst_error,
            error: (self.squares / self.points.max(1.0)).sqrt(),
        }
    }
}

/// The year of a set, and the number of rays traced.
fn set_year<E>(
    context: &YearContext,
    set: usize,
    blinds: Option<Blinds>,
    mut hand_out: impl FnMut(&YearHours) -> Result<(), E>,
) -> Result<(SetYear, u64), E> {
    let receivers = &context.scene.receivers[set];
    let (closed, mut rays) = blinds.map_or((Vec::new(), 0), |_| closed_hours(context, set));
    let closing = blinds.map(|blinds| (closed.as_slice(), blinds.transmittance));
    let mut sums = SetSums::new(context.sky.hours.len());
    let mut points = Vec::with_capacity(receivers.points.len());
    let all: Vec<usize> = (0..receivers.points.len()).collect();
    for chunk in all.chunks(CHUNK) {
        let found: Vec<Option<ReceiverHours>> = chunk
            .par_iter()
            .map(|index| {
                let point = &receivers.points[*index];
                (!point.inside)
                    .then(|| at(context.world, point, |receiver| year_of(context, (set, *index), receiver, closing)))
            })
            .collect();
        for (index, found) in chunk.iter().zip(found) {
            let Some(found) = found else {
                points.push(YearPoint::default());
                continue;
            };
            let measures = found.counts.clone().finish(context.sky.occupied as f64);
            if receivers.points[*index].weight > 0.0 {
                sums.add(receivers.points[*index].weight, &found, &measures);
            }
            rays += found.rays;
            let lx: Vec<f64> = found.lx.iter().map(|(lx, _)| *lx).collect();
            let standard_error_lx: Vec<f64> = found.lx.iter().map(|(_, off)| error_of_mean(off)).collect();
            hand_out(&YearHours { receivers, point: *index, lx: &lx, standard_error_lx: &standard_error_lx })?;
            let measures = measures.map(|measure| measure.estimate());
            points.push(YearPoint { measures, error: found.error, walks: found.walks });
        }
    }
    Ok((sums.finish(set, &receivers.name, points, closed), rays))
}
