//! What an eye sees in each direction of a set, and the number of rays along gloss that this requires.

use rayon::prelude::*;

use super::exact::sample_all_emitters;
use super::eye::{Eye, GlossRays, SeenPlace, Shown};
use super::mesh::Surroundings;
use super::options::{DIRECT_PLACES, SHARE_OF_DIRECT};
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{ReceiverPoint, ReceiverSet};

/// Share below which a branch of a line of sight continues only with a probability (roulette). Its weight compensates for this.
const FAINT_SHARE: f64 = 0.01;
/// Map number of the random streams for roulette of faint branches.
const LINES_OF_SIGHT: u32 = u32::MAX - 3;
/// Map number of the random streams that estimate the random error in gloss.
const GLOSS_PILOT: u32 = u32::MAX - 5;
/// Largest number of directions for this estimate, and number of samples for each.
const PILOT_DIRECTIONS: usize = 256;
const PILOT_SAMPLES: usize = 16;
/// Part of the target that the random error of gloss may take.
const SHARE_OF_GLOSS: f64 = 0.3;
/// Part of the target that the random error of its check may add.
const SHARE_OF_CHECK: f64 = 0.3;
/// Target for gloss where no target is set.
const NO_TARGET: f64 = 0.02;
/// Least and largest number of rays along the gloss that a direction shows.
const RAYS: [f64; 2] = [16.0, 4096.0];
/// Largest number of surface points seen in all directions of a set: about 100 MB.
const MOST_PLACES: f64 = 1_048_576.0;
/// Least and largest number of samples in each half for checking a direction.
const CHECKS: [f64; 2] = [32.0, 1024.0];

/// Least number of checks of direct light for finding a mesh and stating its error: two meshes, and the last check.
const LEAST_CHECKS: f64 = 3.0;

/// Numbers of samples for gloss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlossEffort {
    /// Rays along the gloss of a surface that fills a line of sight.
    pub rays: u32,
    /// Samples of each half for a check of a direction.
    pub checks: u64,
    /// Whether samples with their own lines of sight take fewer rays than this.
    pub is_dear: bool,
}

/// What the directions of a set show.
pub struct LinesOfSight {
    /// Surface points of all directions, one direction after the other.
    places: Vec<SeenPlace>,
    /// Index of the first surface point of each direction. One more entry ends the last.
    starts: Vec<usize>,
    shown: Vec<Shown>,
    /// Number of surface points of the direction that has most.
    pub most_places: usize,
    /// Whether random decisions can affect what is seen: at specular branches or in gloss.
    pub has_chance: bool,
    /// Numbers of samples for gloss, if gloss is seen.
    pub gloss: Option<GlossEffort>,
    /// Whether every sample of light traces new lines of sight. The stored ones then only show where surfaces are.
    pub are_drawn: bool,
    /// Rays used.
    pub rays: u64,
}

impl LinesOfSight {
    /// Follows every direction of a set, with random streams from the seed and the set's number. `target_error` is the target for the
    /// random error of gloss. `may_draw` allows samples to trace new lines of sight where gloss takes too many rays.
    pub fn of(
        around: &Surroundings,
        set: &ReceiverSet,
        [seed, set_number]: [u64; 2],
        target_error: Option<f64>,
        may_draw: bool,
    ) -> LinesOfSight {
        let set_number = set_number as u32;
        let world = around.world;
        let has_gloss = around.scene.surfaces.iter().any(|surface| {
            let material = &around.scene.materials[surface.material as usize];
            material.bsdf.has_lobe()
        });
        let gloss = has_gloss.then(|| effort_of_gloss(around, set, seed, set_number, target_error));
        let are_drawn = may_draw && gloss.is_some_and(|gloss| gloss.is_dear);
        let rays_of_gloss = gloss.filter(|_| !are_drawn).map_or(1, |gloss| gloss.rays);
        let follow = |(number, point): (usize, &ReceiverPoint)| {
            let mut places = Vec::new();
            if point.inside || (around.give_up)() {
                return (places, Shown::default());
            }
            let mut stream = Stream::new(seed, Purpose::LightMesh, LINES_OF_SIGHT, set_number);
            stream.seek(number as u64);
            let from = world.tracer.side_origin(point.position_m, point.normal);
            let gloss = GlossRays::Even(rays_of_gloss, number as u64);
            let eye = Eye {
                world,
                small_share: FAINT_SHARE,
                gloss,
                with_luminaires: true,
                samples_area_images: around.samples_area_images(),
            };
            let shown = eye.trace(&from, point.normal, &mut stream, &mut places);
            (places, shown)
        };
        let followed: Vec<(Vec<SeenPlace>, Shown)> = set.points.par_iter().enumerate().map(follow).collect();
        let most_places = followed.iter().map(|(places, _)| places.len()).max().unwrap_or(0).max(1);
        let shows_gloss = followed.iter().any(|(_, shown)| shown.has_gloss);
        let mut lines = LinesOfSight {
            places: Vec::new(),
            starts: vec![0],
            shown: followed.iter().map(|(_, shown)| *shown).collect(),
            most_places,
            has_chance: world.has_specular() || shows_gloss,
            gloss: gloss.filter(|_| shows_gloss),
            are_drawn,
            rays: followed.iter().map(|(_, shown)| shown.rays).sum(),
        };
        for (places, _) in followed {
            lines.places.extend(places);
            lines.starts.push(lines.places.len());
        }
        lines
    }

    /// Returns the number of surface points of all directions.
    pub fn places(&self) -> usize {
        self.places.len()
    }

    /// Returns all surface points that are seen.
    pub fn spots(&self) -> impl Iterator<Item = &SeenPlace> {
        self.places.iter()
    }

    /// Returns the surface points that a direction shows.
    pub fn places_of(&self, direction: usize) -> &[SeenPlace] {
        &self.places[self.starts[direction]..self.starts[direction + 1]]
    }

    /// Returns the luminance of the luminaires that a direction shows, in cd/m².
    pub fn luminaires_cd_m2(&self, direction: usize) -> f64 {
        self.shown[direction].luminaires_cd_m2
    }

    /// Whether a direction shows gloss.
    pub fn shows_gloss(&self, direction: usize) -> bool {
        self.shown[direction].has_gloss
    }
}

/// Returns the numbers of samples for gloss that a target requires. It traces some directions a few times and computes direct light at the
/// surfaces that they show.
fn effort_of_gloss(
    around: &Surroundings,
    set: &ReceiverSet,
    seed: u64,
    set_number: u32,
    target_error: Option<f64>,
) -> GlossEffort {
    let world = around.world;
    let every = set.points.len().div_ceil(PILOT_DIRECTIONS).max(1);
    let chosen: Vec<(usize, &ReceiverPoint)> =
        set.points.iter().enumerate().step_by(every).filter(|(_, point)| !point.inside).collect();
    let eye = Eye {
        world,
        small_share: FAINT_SHARE,
        gloss: GlossRays::One,
        with_luminaires: true,
        samples_area_images: around.samples_area_images(),
    };
    let judge = |(number, point): &(usize, &ReceiverPoint)| {
        let mut stream = Stream::new(seed, Purpose::LightMesh, GLOSS_PILOT, set_number);
        let from = world.tracer.side_origin(point.position_m, point.normal);
        let (mut samples, mut has_gloss) = ([0.0; PILOT_SAMPLES], false);
        let (mut sight_rays, mut rays) = (0, 0);
        for (sample_number, sample) in (0u64..).zip(&mut samples) {
            stream.seek(((*number as u64) << 32) | sample_number);
            let mut places = Vec::new();
            let shown = eye.trace(&from, point.normal, &mut stream, &mut places);
            has_gloss |= shown.has_gloss;
            *sample = shown.luminaires_cd_m2;
            sight_rays += shown.rays;
            for place in places {
                let sampled = sample_all_emitters(world, &place.receiver(), &mut stream);
                *sample += place.weight_per_sr * sampled.value;
                rays += sampled.rays;
            }
        }
        let mean = samples.iter().sum::<f64>() / PILOT_SAMPLES as f64;
        let squares: f64 = samples.iter().map(|sample| (sample - mean).powi(2)).sum();
        let per_sample = |rays: u64| rays as f64 / PILOT_SAMPLES as f64;
        JudgedDirection {
            mean,
            variance: squares / (PILOT_SAMPLES - 1) as f64,
            has_gloss,
            sight_rays: per_sample(sight_rays),
            rays: per_sample(sight_rays + rays),
        }
    };
    let judged: Vec<JudgedDirection> = chosen.par_iter().map(judge).collect();
    let mean_of = |of: fn(&JudgedDirection) -> f64| judged.iter().map(of).sum::<f64>() / judged.len().max(1) as f64;
    let mean = mean_of(|direction| direction.mean);
    let variance = mean_of(|direction| direction.variance);
    let variance_of_gloss = mean_of(|direction| if direction.has_gloss { direction.variance } else { 0.0 });
    let fourth = mean_of(|direction| direction.variance * direction.variance);
    let target = target_error.unwrap_or(NO_TARGET) * mean.max(f64::MIN_POSITIVE);
    let most = (MOST_PLACES / set.points.len().max(1) as f64).clamp(RAYS[0], RAYS[1]);
    let rays = (variance_of_gloss / (SHARE_OF_GLOSS * target).powi(2)).clamp(RAYS[0], most).ceil();
    // The product of two independent estimates, each from n checks, has a standard deviation of variance/n. That of the mean over the
    // points is smaller.
    let checked = set.points.len().min(DIRECT_PLACES) as f64;
    let checks = fourth.sqrt() / checked.sqrt() / (SHARE_OF_CHECK * target).powi(2);
    let checks = checks.clamp(CHECKS[0], CHECKS[1]).ceil();
    // A mesh saves light samples at surface points. It requires more rays along gloss, and checks.
    let rays_of_sample = mean_of(|direction| direction.rays);
    let directions = set.points.len() as f64;
    let by_samples = directions * variance / (SHARE_OF_DIRECT * target).powi(2) * rays_of_sample;
    let by_mesh = directions * rays * mean_of(|direction| if direction.has_gloss { direction.sight_rays } else { 0.0 });
    let by_checks = LEAST_CHECKS * 2.0 * checked * checks * rays_of_sample;
    GlossEffort { rays: rays as u32, checks: checks as u64, is_dear: by_mesh + by_checks > by_samples }
}

/// Statistics of a few samples of a direction.
struct JudgedDirection {
    mean: f64,
    variance: f64,
    has_gloss: bool,
    /// Rays per sample: for the line of sight and along gloss.
    sight_rays: f64,
    /// All rays per sample.
    rays: f64,
}
