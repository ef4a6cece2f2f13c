//! Which patches the gathering rays of a run will ask, found out by a few of them: where many rays ask a patch for its direct
//! light, looks that they share are worth more than looks of their own.
//!
//! Let entry r ask patch p in A_rp of its rays, and let n looks tell the patch's light. Looks of their own would leave the sum
//! over the entries a variance of σ² Σ_r A_rp for as many rays; shared ones leave σ² Q_p/n, Q_p = Σ_r A_rp². What both cost
//! and leave, together with the variance κσ² of where a ray goes, is least for n = √(Q_p/κ). An entry asks by chance, so that Q_p has
//! the variance of its asks in it too, which are about Σ_r A_rp.

use rayon::prelude::*;

use super::forward::{FEWEST_SAMPLES, Forward};
use super::gathering::Gatherer;
use super::job::{Context, Job};
use super::sweep::stream_index;
use crate::estimators::walk::{Memory, Met, Recall, gather_indirect_lx};
use crate::maps::REPLICAS;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::patches::Spot;

/// Share of the planned rays that a survey takes, rays at least of a planned run for it to be worth while, and most rays for each
/// patch: more where patches tell of the places that it meets, since what is told of too few hangs on which these are.
const SHARE: f64 = 0.05;
const LEAST_PLANNED: f64 = 20_000.0;
const MOST_PER_PATCH: f64 = 40.0;
const MOST_PER_JOINED: f64 = 1000.0;
/// Rays from a place, at least: pairs of them tell how much of a patch's asking is by one entry.
const RAYS_PER_SITE: f64 = 16.0;
/// Variance of where a ray goes over that of a look, κ.
const GOING_OVER_LOOKING: f64 = 0.3;
/// A patch whose looks would be more than this share of what asks it is left to those.
const MOST_LOOKS: f64 = 0.6;
/// Asks of a patch, over the samples that slopes take, from which on it gets these.
const ASKS_FOR_SLOPES: f64 = 4.0;
/// Share of the asking that must be worth telling for any to be told.
const LEAST_TOLD: f64 = 0.1;
/// Its streams among those of a map's pilots.
const RAYS: u32 = 5;
const SITES: u32 = 6;
/// Places of a map are taken by one thread so many at a time.
const SITES_PER_TASK: usize = 64;

/// What the rays of a run ask.
pub struct Demand {
    /// For every job what its rays ask, where that is worth knowing.
    surveys: Vec<Option<MapSurvey>>,
    /// Samples of patches over what pays by the survey alone: looks at the error tell whether more do.
    pub times: f64,
}

/// What rays of one map ask.
struct MapSurvey {
    /// Asks of every patch, and pairs of asks by rays of one entry.
    patches: Vec<[f64; 2]>,
    /// Places in patches of joined triangles that rays met.
    joined: Vec<Spot>,
    /// Rays from each entry that was looked at, and how many entries each of these stands for.
    rays_per_site: f64,
    entries_per_site: f64,
    rays: u64,
}

/// Samples that patches take for all rays that ask them.
pub struct Sharing {
    of_patch: Vec<u32>,
    /// Share of the rays' asking that these patches answer.
    pub told_share: f64,
}

/// Rays that note which patches they met.
struct Asking<'a> {
    forward: &'a Forward,
    patches: Vec<u32>,
    /// Places in patches of joined triangles.
    joined: Vec<Spot>,
}

impl Memory for Asking<'_> {
    fn recall(&mut self, met: &Met, _: &mut Cut, _: &mut Stream) -> (Recall, u64) {
        let hit = met.hit;
        match self.forward.asked(hit) {
            Some((patch, is_joined)) => {
                self.patches.push(patch);
                if is_joined {
                    self.joined.push((hit.triangle, hit.barycentric, hit.side));
                }
                (Recall::Whole(0.0), 0)
            }
            None => (Recall::Guide(0.0), 0),
        }
    }
}

impl Default for Demand {
    fn default() -> Demand {
        Demand { surveys: Vec::new(), times: 1.0 }
    }
}

impl Demand {
    /// A survey of the maps that a target binds, which are planned to take so many samples of every entry in each replica.
    ///
    /// Patches of joined triangles tell of the places that it met.
    pub fn of(context: &Context, forward: &mut Forward, jobs: &mut [Job], samples: &[f64], times: f64) -> Demand {
        let survey = |(job, samples): (&mut Job, &f64)| {
            let survey = job.bound.then(|| MapSurvey::of(context, forward, job, *samples))??;
            job.pilot_rays += survey.rays;
            Some(survey)
        };
        let surveys: Vec<Option<MapSurvey>> = jobs.iter_mut().zip(samples).map(survey).collect();
        let places = surveys.iter().flatten().flat_map(|survey| &survey.joined);
        if places.clone().next().is_some() {
            forward.tell_of(context, places);
        }
        Demand { surveys, times }
    }

    /// Samples of patches that pay, where maps take so many of every entry in each replica; `None` where hardly any do.
    pub fn sharing(&self, samples: &[f64]) -> Option<Sharing> {
        let surveyed = self.surveys.iter().zip(samples);
        let surveys = surveyed.filter_map(|(survey, samples)| Some((survey.as_ref()?, *samples)));
        Sharing::of(&surveys.collect::<Vec<_>>(), self.times)
    }
}

impl MapSurvey {
    /// A few rays of a map that is planned to take so many samples of every entry in each replica; `None` where that is too
    /// little for patches to be worth looks.
    fn of(context: &Context, forward: &Forward, job: &Job, samples: f64) -> Option<MapSurvey> {
        let weights = job.gathered_weights();
        let entries: Vec<usize> = (0..job.gathered().len()).filter(|entry| weights[*entry] > 0.0).collect();
        let planned = samples * REPLICAS as f64 * entries.len() as f64;
        if planned < LEAST_PLANNED {
            return None;
        }
        let joined = forward.joined_count() as f64;
        let most = MOST_PER_PATCH * (forward.patch_count() as f64 - joined) + MOST_PER_JOINED * joined;
        let rays = (SHARE * planned).min(most);
        let stride = (entries.len() as f64 * RAYS_PER_SITE / rays).ceil().max(1.0) as usize;
        // Equal steps through a grid would meet few of its columns.
        let mut stream = Stream::new(context.seed, Purpose::Pilot, job.kind.number(), SITES);
        let one_of = |(number, some): (usize, &[usize])| {
            stream.seek(number as u64);
            some[(stream.fine_unit() * some.len() as f64) as usize]
        };
        let sites: Vec<usize> = entries.chunks(stride).enumerate().map(one_of).collect();
        let rays_per_site = (rays / sites.len() as f64).ceil().max(2.0);
        let (elements, exposed) = (job.gathering_elements(), job.gathering_exposed());
        let gatherer = Gatherer { context, forward, kind: job.kind, elements, exposed, checked_share: 0.0 };
        let asked_from = |sites: &[usize]| {
            let mut stream = Stream::new(context.seed, Purpose::Pilot, job.kind.number(), RAYS);
            let mut asking = Asking { forward, patches: Vec::new(), joined: Vec::new() };
            let mut cut = Cut::default();
            let (mut asked, mut rays) = (Vec::new(), 0);
            for entry in sites {
                let Some(site) = gatherer.site(*entry) else {
                    continue;
                };
                if context.is_over() {
                    break;
                }
                for number in 0..rays_per_site as u64 {
                    // Points that fill evenly would seldom meet a patch twice.
                    stream.seek(stream_index(*entry, number));
                    let start = gatherer.start(&site, &mut stream);
                    let (_, ray_rays) =
                        gather_indirect_lx(context.stage, &start.receiver(), &mut asking, &mut cut, &mut stream);
                    rays += start.rays + ray_rays;
                }
                asking.patches.sort_unstable();
                let times = asking.patches.chunk_by(|one, other| one == other);
                asked.extend(times.map(|same| (same[0], same.len() as f64)));
                asking.patches.clear();
            }
            (asked, asking.joined, rays)
        };
        let found: Vec<_> = sites.par_chunks(SITES_PER_TASK).with_max_len(1).map(asked_from).collect();
        let mut patches = vec![[0.0; 2]; forward.patch_count()];
        let mut rays = 0;
        let mut joined = Vec::new();
        for (asked, places, task_rays) in found {
            joined.extend(places);
            for (patch, times) in asked {
                let [asks, pairs] = &mut patches[patch as usize];
                *asks += times;
                *pairs += times * (times - 1.0);
            }
            rays += task_rays;
        }
        Some(MapSurvey { patches, joined, rays_per_site, entries_per_site: stride as f64, rays })
    }
}

impl Sharing {
    fn of(surveys: &[(&MapSurvey, f64)], times: f64) -> Option<Sharing> {
        let patches = surveys.first()?.0.patches.len();
        let asked_of = |patch: usize| {
            surveys.iter().fold([0.0; 2], |[asks, squares], (survey, samples)| {
                let rays = samples * REPLICAS as f64 / survey.rays_per_site;
                let [found, pairs] = survey.patches[patch];
                let asked = survey.entries_per_site * rays * found;
                // Of m rays m(m − 1) pairs are of two; and an entry asks by chance, with the variance of its mean.
                let of_pairs = rays * rays * survey.rays_per_site / (survey.rays_per_site - 1.0);
                [asks + asked, squares + asked + survey.entries_per_site * of_pairs * pairs]
            })
        };
        let (mut told, mut all) = (0.0, 0.0);
        let looks_from = |patch| {
            let [asks, squares] = asked_of(patch);
            let looks = samples_worth(asks, squares, times);
            all += asks;
            told += if looks > 0 { asks } else { 0.0 };
            looks
        };
        let of_patch = (0..patches).map(looks_from).collect();
        let told_share = told / f64::max(all, f64::MIN_POSITIVE);
        (told_share >= LEAST_TOLD).then_some(Sharing { of_patch, told_share })
    }

    /// Samples of each replica from a patch; 0 where rays are told no direct light, and deposits tell the rest.
    pub fn of_patch(&self, patch: u32) -> u64 {
        u64::from(self.of_patch[patch as usize])
    }

    /// Samples of all replicas.
    pub fn sum(&self) -> f64 {
        self.of_patch.iter().map(|looks| f64::from(*looks)).sum::<f64>() * REPLICAS as f64
    }
}

/// Samples of each replica from a patch that is asked so often, with so many squared asks of single entries, so many times as usual.
fn samples_worth(asks: f64, squares: f64, times: f64) -> u32 {
    let replicas = REPLICAS as f64;
    let most = MOST_LOOKS * asks / replicas;
    let best = times * (squares / GOING_OVER_LOOKING).sqrt() / replicas;
    let with_slopes = FEWEST_SAMPLES as f64;
    let least = if asks >= ASKS_FOR_SLOPES * with_slopes * replicas { with_slopes } else { 1.0 };
    if most >= 1.0 { best.round().clamp(least, most.floor()) as u32 } else { 0 }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::chain::Stage;
    use crate::scene::scene_from_json;
    use crate::solver::Method;
    use crate::solver::job::TimeLeft;

    /// 16 receivers side by side within a millimetre ask each patch alike: of A asks each has A/16 in the mean and by chance that as
    /// variance, so that Q = A²/16 + A, where A² is told by pairs of all rays. κ n² of all patches together is Σ Q within 4% (512,000
    /// rays are planned, of which 7,680 are looked at and meet patches in some 8,000 pairs of one receiver: 1.5 standard errors of 1.1%
    /// for each of both sums; seed 2). Samples a tenth more (planted) are not, nor are those without pairs.
    #[test]
    fn samples_of_patches_follow_how_many_share_them() {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [ { "name": "cube", "type": "box", "min": [0,0,0], "max": [1,1,1], "facing": "inward", "material": "m" } ],
            "luminaires": [ { "name": "lamp", "type": "point", "position": [0.4,0.6,0.7], "luminous_flux_lm": 1000 } ],
            "receivers": [ { "name": "spot", "type": "grid", "origin": [0.5,0.5,0.3], "u": [0.001,0,0], "v": [0,0.001,0],
                "columns": 4, "rows": 4 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a valid scene");
        let stage = Stage::new(&scene);
        let (method, time_left) = (Method::Gather, &|| TimeLeft::Enough);
        let context =
            Context { scene: &scene, stage: &stage, seed: 2, method, target_error: 0.01, adapt_to: None, time_left };
        let mut forward = Forward::new(&context, 0.5);
        let mut jobs = [Job::receivers(&context, 0, true)];
        let samples = [2000.0];
        let mut demand = Demand::of(&context, &mut forward, &mut jobs, &samples, 1.0);
        let rays = samples[0] * 16.0 * REPLICAS as f64;
        let surveys = demand.surveys.iter().flatten().flat_map(|survey| &survey.patches);
        let found: Vec<f64> = surveys.map(|[found, _]| *found).collect();
        let all = found.iter().sum::<f64>();
        let pairs: f64 = found.iter().map(|found| found * (found - 1.0)).sum();
        let expected = rays * rays * pairs / (all * (all - 1.0)) / 16.0 + rays;
        let off = |demand: &Demand| {
            let sharing = demand.sharing(&samples).expect("patches are worth samples");
            assert!(sharing.told_share > 0.99, "{}", sharing.told_share);
            let squares = sharing.of_patch.iter().map(|samples| (f64::from(*samples) * REPLICAS as f64).powi(2));
            GOING_OVER_LOOKING * squares.sum::<f64>() / expected - 1.0
        };
        assert!(off(&demand).abs() < 0.04, "{}", off(&demand));
        demand.times = 1.1;
        assert!(off(&demand) > 0.04, "the planted fault passed: {}", off(&demand));
        demand.times = 1.0;
        for survey in demand.surveys.iter_mut().flatten() {
            survey.patches.iter_mut().for_each(|[_, pairs]| *pairs = 0.0);
        }
        assert!(off(&demand) < -0.04, "pairs were not asked");
    }

    /// Where nobody else asks, a patch is left alone: 16 looks for 20 rays are not worth it, nor are as many looks as rays.
    #[test]
    fn patches_that_few_rays_ask_take_no_samples() {
        assert_eq!(samples_worth(20.0, 20.0, 1.0), 0);
        assert_eq!(samples_worth(40.0, 40.0, 1.0), 1);
        // A single receiver asks it: no more samples than the share of its rays that they may be.
        let of_one = samples_worth(1000.0, 1e6, 1.0);
        assert_eq!(f64::from(of_one), (MOST_LOOKS * 1000.0 / 16.0).floor());
    }
}
