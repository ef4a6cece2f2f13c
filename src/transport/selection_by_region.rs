//! Light selection by region: which luminaires are visible from where.
//!
//! A walk samples one luminaire, chosen by its unshadowed illuminance. Where a strong luminaire is hidden, nearly all light samples go to
//! it. The luminaires that light the point are then hardly ever found: the mean is right, but no run is long enough for its error bar to
//! show this. So before the run a few light samples from every part of the scene show where most of the unshadowed light is hidden. In
//! these parts the choice is shared: half of the samples go to luminaires seen from the region, most others go by unshadowed light, and a
//! few go to any luminaire, so that none is ever impossible.

use glam::DVec3;
use rayon::prelude::*;

use super::World;
use super::sides_by_area::{SidesByArea, TriangleSide};
use super::traced::Traced;
use crate::geometry::Origin;
use crate::sampling::emitter::LightSample;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::uniform_triangle;
use crate::scene::{Scene, Side};

/// Maximum number of parts into which a scene's surfaces are divided.
const MOST_REGIONS: usize = 128;
/// Points of a region from which the first light samples are taken.
const FIRST_POINTS: u64 = 8;
/// Maximum number of luminaires sampled from each of these points.
const FIRST_SAMPLED: u64 = 32;
/// The choice needs help if more than this share of the unshadowed light is hidden from a point. Less costs little.
pub const HIDDEN: f64 = 0.99;
/// Points of a region that is surveyed closely.
const POINTS: u64 = 16;
/// Maximum number of luminaires sampled from each of these points.
const MOST_SAMPLED: u64 = 256;
/// A close survey at a point ends when the luminaires not yet sampled could bring at most this share of what is visible.
const REST: f64 = 1e-3;
/// The survey affects results only through probabilities, so its random numbers are the same for all seeds.
const SEED: u64 = 0x0A11;

/// Visibility of the luminaires from the parts of a scene.
#[derive(Clone, Debug, Default)]
pub struct SelectionByRegion {
    /// Region of every triangle's front and back. Empty if no choice needs help.
    regions: Vec<[u32; 2]>,
    selections: Vec<Option<RegionSelection>>,
    rays: u64,
    hidden_share: f64,
}

/// The luminaires visible from a region where most of the unshadowed light is hidden.
#[derive(Clone, Debug)]
pub(super) struct RegionSelection {
    /// Numbers of the emitters.
    emitters: Vec<u32>,
    /// Cumulative share up to and including each emitter, 1 at the end.
    cumulative: Vec<f64>,
}

impl RegionSelection {
    pub fn choose(&self, variate: f64) -> u32 {
        let place = self.cumulative.partition_point(|sum| *sum <= variate);
        self.emitters[place.min(self.emitters.len() - 1)]
    }

    pub fn probability(&self, emitter: u32) -> f64 {
        self.emitters.binary_search(&emitter).map_or(0.0, |place| {
            let before = if place == 0 { 0.0 } else { self.cumulative[place - 1] };
            self.cumulative[place] - before
        })
    }
}

impl SelectionByRegion {
    /// Surveys a scene. A scene with one emitter, or without reflection, needs no survey.
    pub(super) fn of(scene: &Scene, world: &World) -> SelectionByRegion {
        if world.emitters.list().len() < 2 || !world.reflects() {
            return SelectionByRegion::default();
        }
        let mut spots: Vec<TriangleSide> = (0..scene.triangles.len() as u32)
            .flat_map(|triangle| [(triangle, Side::Front), (triangle, Side::Back)])
            .filter(|(triangle, side)| world.receives(*triangle, *side) && world.bsdf(*triangle).scatters())
            .filter(|spot| !world.is_unlit(*spot))
            .collect();
        let mut parts = Vec::new();
        let most = spots.len().div_ceil(MOST_REGIONS);
        divide(scene, world, &mut spots, most, &mut parts);

        let found: Vec<RegionSurvey> = parts
            .par_iter()
            .with_max_len(1)
            .enumerate()
            .map(|(region, spots)| survey(scene, world, spots, region as u32))
            .collect();
        let rays = found.iter().map(|survey| survey.rays).sum();
        let [seen, hidden] = [0, 1].map(|which| found.iter().map(|survey| survey.light[which]).sum::<f64>());
        let hidden_share = if hidden > 0.0 { hidden / (seen + hidden) } else { 0.0 };
        if found.iter().all(|survey| survey.selection.is_none()) {
            return SelectionByRegion { rays, hidden_share, ..SelectionByRegion::default() };
        }
        let mut regions = vec![[u32::MAX; 2]; scene.triangles.len()];
        for (region, spots) in parts.iter().enumerate() {
            for (triangle, side) in spots.iter() {
                regions[*triangle as usize][*side as usize] = region as u32;
            }
        }
        let selections = found.into_iter().map(|survey| survey.selection).collect();
        SelectionByRegion { regions, selections, rays, hidden_share }
    }

    /// Rays that the survey took.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Approximate mean share of the unshadowed light that is hidden from surfaces.
    pub fn hidden_share(&self) -> f64 {
        self.hidden_share
    }

    #[inline]
    pub(super) fn selection_at(&self, (triangle, side): TriangleSide) -> Option<&RegionSelection> {
        let region = self.regions.get(triangle as usize)?[side as usize];
        self.selections.get(region as usize)?.as_ref()
    }
}

impl World {
    /// Share of the light of a sample that reaches a point: 1, 0, or what panes transmit.
    pub fn seen_share(&self, sample: &LightSample, origin: &Origin) -> f64 {
        sample.place.map_or(0.0, |place| self.transmittance(origin, &self.origin(&place)))
    }

    /// Illuminance in lx that a light sample brings to a point, if there is one, and its ray.
    #[inline]
    pub fn light_found(&self, sample: Option<LightSample>, origin: &Origin) -> Traced {
        let lx = |sample: LightSample| sample.unshadowed_lx * self.seen_share(&sample, origin);
        sample.map_or(Traced::default(), |sample| Traced { value: lx(sample), rays: 1 })
    }

    /// Samples one emitter after the other from a point with a unit normal, roughly in order of strength. Passes each to `show` with its
    /// illuminance in lx, until `enough` returns true.
    pub fn light_samples_around(
        &self,
        origin: &Origin,
        [point_m, normal]: [DVec3; 2],
        stream: &mut Stream,
        show: &mut dyn FnMut(u32, f64),
        enough: &dyn Fn(&LightInSight) -> bool,
    ) -> LightInSight {
        let mut found = LightInSight::default();
        self.emitters.strongest_first(point_m, normal, |index, importance, rest| {
            let sample = self.emitters.list()[index as usize].light_sample(point_m, normal, stream);
            let Traced { value: lx, rays } = self.light_found(sample, origin);
            found.rays += rays;
            found.samples += 1;
            found.rest_lx = rest;
            *(if lx > 0.0 { &mut found.seen_lx } else { &mut found.hidden_lx }) += importance;
            show(index, lx);
            !enough(&found)
        });
        found
    }
}

/// Divides sides of triangles into parts of at most `most` that face and lie alike: first by the axis that they face, then in halves along
/// the longest extent.
fn divide<'a>(
    scene: &Scene,
    world: &World,
    spots: &'a mut [TriangleSide],
    most: usize,
    parts: &mut Vec<&'a [TriangleSide]>,
) {
    let facing = |(triangle, side): &TriangleSide| {
        let normal = world.normal(*triangle, *side);
        let axis = normal.abs().max_position();
        2 * axis + usize::from(normal[axis] < 0.0)
    };
    spots.sort_by_key(facing);
    for alike in spots.chunk_by_mut(|a, b| facing(a) == facing(b)) {
        halve(scene, alike, most, parts);
    }
}

fn halve<'a>(scene: &Scene, spots: &'a mut [TriangleSide], most: usize, parts: &mut Vec<&'a [TriangleSide]>) {
    if spots.len() <= most.max(1) {
        parts.push(spots);
        return;
    }
    let center = |spot: &TriangleSide| scene.corners_m(spot.0).iter().sum::<DVec3>() / 3.0;
    let (low, high) = spots
        .iter()
        .map(center)
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let axis = (high - low).max_position();
    let middle = spots.len() / 2;
    spots.select_nth_unstable_by(middle, |a, b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.0.cmp(&b.0)));
    let (first, second) = spots.split_at_mut(middle);
    halve(scene, first, most, parts);
    halve(scene, second, most, parts);
}

/// Result of the light samples from one point.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightInSight {
    /// Sum of the importance of emitters that were seen, in lx.
    pub seen_lx: f64,
    /// Sum of the importance of emitters that were hidden, in lx.
    pub hidden_lx: f64,
    /// Sum of the importance of emitters that were not sampled, in lx.
    pub rest_lx: f64,
    /// Number of emitters that were sampled.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
}

impl LightInSight {
    /// Whether nearly all importance that was sampled is hidden. A choice by unshadowed light then needs help.
    pub fn is_mostly_hidden(&self) -> bool {
        self.hidden_lx > HIDDEN * (self.hidden_lx + self.seen_lx)
    }

    /// Whether the unsampled rest is negligible beside what is visible.
    pub fn has_little_rest(&self) -> bool {
        self.rest_lx <= REST * self.seen_lx
    }
}

/// Result of the survey of a region.
struct RegionSurvey {
    /// The luminaires visible, if nearly all unshadowed light is hidden from some point of the region.
    selection: Option<RegionSelection>,
    /// Shares of the light that were seen and that were hidden, summed over the first points.
    light: [f64; 2],
    rays: u64,
}

/// Surveys a region.
fn survey(scene: &Scene, world: &World, spots: &[TriangleSide], region: u32) -> RegionSurvey {
    let sides = SidesByArea::of(scene, spots);
    let mut stream = Stream::new(SEED, Purpose::Pilot, region, 0);
    let mut sample_from =
        |index: u64, points: u64, show: &mut dyn FnMut(u32, f64), enough: &dyn Fn(&LightInSight) -> bool| {
            stream.seek(index);
            let aim = (index % points) as f64 + stream.unit();
            let (triangle, side) = sides.at(aim / points as f64);
            let at = uniform_triangle(stream.pair());
            let origin = world.tracer.surface_origin(triangle, at, side);
            let place = [world.tracer.position_m(&origin), world.normal_on(triangle, at, side)];
            world.light_samples_around(&origin, place, &mut stream, show, enough)
        };

    let (mut rays, mut light) = (0, [0.0; 2]);
    let mut most_is_hidden = false;
    for index in 0..FIRST_POINTS {
        let enough = |found: &LightInSight| found.seen_lx >= found.rest_lx || found.samples >= FIRST_SAMPLED;
        let found = sample_from(index, FIRST_POINTS, &mut |_, _| {}, &enough);
        rays += found.rays;
        // In full shadow there is nothing to find.
        let may_find = found.seen_lx + found.rest_lx > 0.0;
        most_is_hidden |= may_find && found.is_mostly_hidden();
        if found.seen_lx > 0.0 {
            light[0] += found.seen_lx / (found.seen_lx + found.hidden_lx);
            light[1] += found.hidden_lx / (found.seen_lx + found.hidden_lx);
        }
    }
    if !most_is_hidden {
        return RegionSurvey { selection: None, light, rays };
    }

    let mut shares: Vec<(u32, f64)> = Vec::new();
    for index in 0..POINTS {
        let first = shares.len();
        let enough = |found: &LightInSight| found.has_little_rest() || found.samples >= MOST_SAMPLED;
        let mut show = |emitter: u32, lx: f64| {
            if lx > 0.0 {
                shares.push((emitter, lx));
            }
        };
        rays += sample_from(FIRST_POINTS + index, POINTS, &mut show, &enough).rays;
        // Every point has one vote, however dark it is.
        let sum: f64 = shares[first..].iter().map(|(_, lx)| lx).sum();
        shares[first..].iter_mut().for_each(|(_, lx)| *lx /= sum);
    }
    shares.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    if total <= 0.0 {
        return RegionSurvey { selection: None, light, rays };
    }
    let mut selection = RegionSelection { emitters: Vec::new(), cumulative: Vec::new() };
    let mut before = 0.0;
    for same in shares.chunk_by(|a, b| a.0 == b.0) {
        before += same.iter().map(|(_, share)| share).sum::<f64>() / total;
        selection.emitters.push(same[0].0);
        selection.cumulative.push(before);
    }
    RegionSurvey { selection: Some(selection), light, rays }
}
