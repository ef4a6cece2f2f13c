//! What an eye sees in each direction of a set, and how many rays along gloss that takes.

use rayon::prelude::*;

use super::exact::look_at_all;
use super::eye::{Eye, GlossRays, SeenPlace, Shown};
use super::mesh::Surroundings;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{ReceiverPoint, ReceiverSet};

/// A branch of a line of sight that carries less than this goes on by chance, with a weight that makes up for it.
const FAINT_SHARE: f64 = 0.01;
/// The map number of the streams that thin faint branches.
const SIGHTS: u32 = u32::MAX - 3;
/// The map number of the streams that tell how much chance is in gloss.
const GLOSS_PILOT: u32 = u32::MAX - 5;
/// Directions that tell it, at most, and samples of each.
const PILOT_DIRECTIONS: usize = 256;
const PILOT_SAMPLES: usize = 16;
/// Part of the target that the chance in gloss may take.
const SHARE_OF_GLOSS: f64 = 0.3;
/// Part of it that may be added by the chance in what checks it.
const SHARE_OF_CHECK: f64 = 0.3;
/// Target for which gloss is looked into where there is none.
const NO_TARGET: f64 = 0.02;
/// Rays along the gloss that a direction shows, at least and at most.
const RAYS: [f64; 2] = [16.0, 4096.0];
/// Places that all directions of a set show, at most: some 100 MB.
const MOST_PLACES: f64 = 1_048_576.0;
/// Samples of each half that check a direction, at least and at most.
const CHECKS: [f64; 2] = [32.0, 1024.0];

/// How thoroughly gloss is looked into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlossEffort {
    /// Rays along the gloss of a surface that fills a line of sight.
    pub rays: u32,
    /// Samples of each half that a check of a direction takes.
    pub checks: u64,
}

/// What the directions of a set show.
pub struct Sights {
    /// Places of all directions, one after the other.
    places: Vec<SeenPlace>,
    /// Where the places of each direction begin; one more entry ends the last.
    starts: Vec<usize>,
    luminaires_cd_m2: Vec<f64>,
    /// Places of the direction that has most.
    pub most_places: usize,
    /// Whether a faint branch was decided by chance.
    pub has_chance: bool,
    /// How thoroughly gloss was looked into, if it is seen.
    pub gloss: Option<GlossEffort>,
    /// Rays that it took.
    pub rays: u64,
}

impl Sights {
    /// Follows every direction of a set; `target_error` is what chance in gloss goes by.
    pub fn of(
        around: &Surroundings,
        set: &ReceiverSet,
        seed: u64,
        set_number: u32,
        target_error: Option<f64>,
    ) -> Sights {
        let stage = around.stage;
        let has_gloss = around.scene.surfaces.iter().any(|surface| {
            let material = &around.scene.materials[surface.material as usize];
            material.law.has_lobe()
        });
        let gloss = has_gloss.then(|| effort_of_gloss(around, set, seed, set_number, target_error));
        let rays_of_gloss = gloss.map_or(1, |gloss| gloss.rays);
        let follow = |(number, point): (usize, &ReceiverPoint)| {
            let mut places = Vec::new();
            if point.inside || (around.give_up)() {
                return (places, Shown::default());
            }
            let mut stream = Stream::new(seed, Purpose::LightMesh, SIGHTS, set_number);
            stream.seek(number as u64);
            let from = stage.tracer.side_origin(point.position_m, point.normal);
            let gloss = GlossRays::Even(rays_of_gloss, number as u64);
            let eye = Eye {
                stage,
                small_share: FAINT_SHARE,
                gloss,
                with_luminaires: true,
                looks_for_areas: around.looks_for_areas(),
            };
            let shown = eye.look(&from, point.normal, &mut stream, &mut places);
            (places, shown)
        };
        let followed: Vec<(Vec<SeenPlace>, Shown)> = set.points.par_iter().enumerate().map(follow).collect();
        let most_places = followed.iter().map(|(places, _)| places.len()).max().unwrap_or(0).max(1);
        let shows_gloss = followed.iter().any(|(_, shown)| shown.has_gloss);
        let mut sights = Sights {
            places: Vec::new(),
            starts: vec![0],
            luminaires_cd_m2: followed.iter().map(|(_, shown)| shown.luminaires_cd_m2).collect(),
            most_places,
            has_chance: stage.has_specular() || shows_gloss,
            gloss: gloss.filter(|_| shows_gloss),
            rays: followed.iter().map(|(_, shown)| shown.rays).sum(),
        };
        for (places, _) in followed {
            sights.places.extend(places);
            sights.starts.push(sights.places.len());
        }
        sights
    }

    /// Places of all directions.
    pub fn places(&self) -> usize {
        self.places.len()
    }

    /// All places that are seen.
    pub fn spots(&self) -> impl Iterator<Item = &SeenPlace> {
        self.places.iter()
    }

    /// What a direction shows of surfaces.
    pub fn places_of(&self, direction: usize) -> &[SeenPlace] {
        &self.places[self.starts[direction]..self.starts[direction + 1]]
    }

    /// Luminance of the luminaires that a direction shows.
    pub fn luminaires_cd_m2(&self, direction: usize) -> f64 {
        self.luminaires_cd_m2[direction]
    }
}

/// How thoroughly gloss must be looked into for a target: some directions are looked along a few times, with direct light at the
/// surfaces that they show.
fn effort_of_gloss(
    around: &Surroundings,
    set: &ReceiverSet,
    seed: u64,
    set_number: u32,
    target_error: Option<f64>,
) -> GlossEffort {
    let stage = around.stage;
    let every = set.points.len().div_ceil(PILOT_DIRECTIONS).max(1);
    let chosen: Vec<(usize, &ReceiverPoint)> =
        set.points.iter().enumerate().step_by(every).filter(|(_, point)| !point.inside).collect();
    let eye = Eye {
        stage,
        small_share: FAINT_SHARE,
        gloss: GlossRays::One,
        with_luminaires: true,
        looks_for_areas: around.looks_for_areas(),
    };
    // Mean, variance of a sample, and whether gloss is in it, of a direction.
    let judge = |(number, point): &(usize, &ReceiverPoint)| {
        let mut stream = Stream::new(seed, Purpose::LightMesh, GLOSS_PILOT, set_number);
        let from = stage.tracer.side_origin(point.position_m, point.normal);
        let (mut samples, mut has_gloss) = ([0.0; PILOT_SAMPLES], false);
        for (sample_number, sample) in (0u64..).zip(&mut samples) {
            stream.seek(((*number as u64) << 32) | sample_number);
            let mut places = Vec::new();
            let shown = eye.look(&from, point.normal, &mut stream, &mut places);
            has_gloss |= shown.has_gloss;
            *sample = shown.luminaires_cd_m2;
            for place in places {
                let (lx, _) = look_at_all(stage, &place.receiver(), &mut stream);
                *sample += place.weight_per_sr * lx;
            }
        }
        let mean = samples.iter().sum::<f64>() / PILOT_SAMPLES as f64;
        let squares: f64 = samples.iter().map(|sample| (sample - mean).powi(2)).sum();
        (mean, squares / (PILOT_SAMPLES - 1) as f64, has_gloss)
    };
    let judged: Vec<(f64, f64, bool)> = chosen.par_iter().map(judge).collect();
    let count = judged.len().max(1) as f64;
    let mean = judged.iter().map(|(mean, ..)| mean).sum::<f64>() / count;
    let variance =
        judged.iter().filter(|(.., has_gloss)| *has_gloss).map(|(_, variance, _)| variance).sum::<f64>() / count;
    let fourth = judged.iter().map(|(_, variance, _)| variance * variance).sum::<f64>() / count;
    let target = target_error.unwrap_or(NO_TARGET) * mean.max(f64::MIN_POSITIVE);
    let most = (MOST_PLACES / set.points.len().max(1) as f64).clamp(RAYS[0], RAYS[1]);
    let rays = (variance / (SHARE_OF_GLOSS * target).powi(2)).clamp(RAYS[0], most);
    // Products of two independent estimates of n checks vary by variance/n, their mean over the places by less.
    let checks = fourth.sqrt() / count.sqrt() / (SHARE_OF_CHECK * target).powi(2);
    GlossEffort { rays: rays.ceil() as u32, checks: checks.clamp(CHECKS[0], CHECKS[1]).ceil() as u64 }
}
