//! A pilot of gathering: how many chains and gathering rays a map will need, and how many look-ups to check.
//!
//! The first guess of a run need not be fine: as it goes on, the spread of rows and columns tells which of both holds up
//! the error, and that one gets more. No sample of the pilot enters a result.

use rayon::prelude::*;

use super::forward::{Forward, Recollection};
use super::gathering::Gatherer;
use super::job::{Context, Job};
use super::pilot::{ENOUGH_RAYS, WEIGHED_PER_RAY};
use super::sweep::stream_index;
use crate::maps::{HALF, HalfChecks, HalfScores, REPLICAS};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};

/// Coefficients that a patch holds: its mean and two slopes.
const COEFFICIENTS: f64 = 3.0;
/// Chains that a run starts with, over those with which deposits alone would be right: the patches' own gathering takes
/// most of their chance, and a look soon tells whether more are needed.
pub const CHAINS_SHARE: f64 = 0.5;
/// Rays of the forward stage over those of its chains: the patches' own gathering takes as many again.
pub const RAYS_OF_FORWARD: f64 = 2.0;
/// Share of the squared error that chains and gathering rays have together, and steps in which it is shared out.
const SHARED_ERROR: f64 = 2.0 / 3.0;
const SHARES: u32 = 40;
/// Chains of each replica in the pilot, at most.
const CHAINS: u64 = 256;
/// Entries that the pilot looks at, at most, and at least rays from all of them together.
const MOST_SITES: usize = 128;
const LEAST_RAYS: usize = 32;
/// Share of the pilot's look-ups that are checked.
const CHECKED_SHARE: f64 = 0.25;
/// A run checks at least this share of its look-ups.
const LEAST_CHECKED: f64 = 1.0 / 128.0;
/// Squared error over that of the pooled checks.
const CHECK_PRECISION: f64 = 16.0;
/// Rays of the checks over those of gathering, at most.
const CHECK_RAYS: f64 = 0.4;
/// Variance by the chance of deposits over that by the chance of rays, at least: where rays met none they say nothing of it.
const LEAST_NOISE: f64 = 1e-3;
/// Patches of the pilot.
const PATCHES_OF_PILOT: f64 = 96.0;
/// Patches for an error of 1%; at least and at most.
const PATCHES_AT_ONE_PERCENT: f64 = 50.0;
const FEWEST_PATCHES: f64 = 32.0;
/// Edges of patches for an error of 1%, at most, over the median way of light between surfaces: what lies about a place must not
/// be shared with what it does not see. In rooms that are not full of things patches are smaller by their number alone.
const FREE_PATHS: f64 = 1.0;
/// Share of the looks for luminaires that gathering rays make themselves although patches tell direct light, about.
const OWN_LOOKS: f64 = 0.5;
const MOST_PATCHES: f64 = 400_000.0;

/// What the pilot found out of one map; variances are those of one sample in one replica, weighted means over the entries.
#[derive(Clone, Copy, Debug)]
pub struct GatherCosts {
    /// Variance of one gathering ray in lx², were patches free of chance.
    pub ray_variance: f64,
    /// Variance in lx² of what a single deposit on a patch says of it: D deposits divide it by D, as N deposits in all
    /// divide that of a whole hemisphere.
    pub deposit_variance: f64,
    /// Variance of one check in lx².
    pub check_variance: f64,
    /// Rays of one sample without its check.
    pub rays_per_sample: f64,
    /// What it takes beside them to choose among luminaires, in rays.
    pub choosing_per_sample: f64,
    /// Looks for luminaires where patches are looked up, in one sample.
    pub looks_per_sample: f64,
    /// Rays of one check.
    pub rays_per_check: f64,
    /// Weighted mean of what was gathered, in lx.
    pub mean_lx: f64,
    /// Entries of the map that count.
    pub entries: f64,
    /// Rays that it took to find that out.
    pub pilot_rays: u64,
}

/// What a chain costs and brings.
#[derive(Clone, Copy, Debug)]
pub struct ChainCosts {
    /// Rays.
    pub rays: f64,
    /// Deposits on patches.
    pub deposits: f64,
}

/// How much of what a map should get.
#[derive(Clone, Copy, Debug)]
pub struct GatherPlan {
    /// Chains of each replica.
    pub chains: f64,
    /// Gathering rays of each entry in each replica.
    pub samples: f64,
    /// Share of the look-ups that are checked.
    pub checked_share: f64,
    /// Rays of all that, all replicas.
    pub rays: f64,
}

/// The forward stage of the pilot.
pub fn pilot_chains(context: &Context) -> Forward {
    let mut forward = Forward::new(context, patch_edge_m(context, PATCHES_OF_PILOT, f64::INFINITY));
    forward.trace_pilot(context, CHAINS, ENOUGH_RAYS);
    forward.settle(context, f64::INFINITY);
    forward
}

/// Edge in m of so many patches of the scene, or shorter where light goes but short ways between surfaces.
pub fn patch_edge_m(context: &Context, patches: f64, free_path_m: f64) -> f64 {
    // The parts of a right-angled isosceles triangle have half the square of their short edges.
    let even_m = (2.0 * context.scene.area_m2() / patches).sqrt();
    even_m.min(FREE_PATHS * free_path_m * (PATCHES_AT_ONE_PERCENT / patches).sqrt())
}

/// Patches that a target error asks for: the look-up's bias falls as their area.
pub fn patches_for(error: f64) -> f64 {
    (PATCHES_AT_ONE_PERCENT * 0.01 / error).clamp(FEWEST_PATCHES, MOST_PATCHES)
}

/// Measures a map's variances and costs with the pilot's chains.
pub fn gather_costs(context: &Context, forward: &Forward, job: &Job) -> GatherCosts {
    let (sites, weights) = (job.gathered().len(), job.gathered_weights());
    let entries: Vec<usize> = (0..sites).filter(|entry| weights[*entry] > 0.0).collect();
    let stride = entries.len().div_ceil(MOST_SITES).max(1);
    let sites: Vec<usize> = entries.iter().step_by(stride).copied().collect();
    let pairs = LEAST_RAYS.div_ceil(sites.len().max(1)).max(1);
    let samples = (2 * sites.len() * HALF * 2 * pairs) as f64;
    // A check is a walk, about as long as a chain.
    let checked_share = CHECKED_SHARE.min(ENOUGH_RAYS as f64 / (samples * forward.rays_per_chain()));
    let (elements, exposed) = (job.gathering_elements(), job.gathering_exposed());
    let gatherer = Gatherer { context, forward, elements, kind: job.kind, exposed, checked_share };
    let number = job.kind.number();
    let halves: Vec<(Vec<SiteSample>, u64)> = (0..2)
        .into_par_iter()
        .with_max_len(1)
        .map(|parity| {
            let mut stream = Stream::new(context.seed, Purpose::Pilot, number, 2 + parity as u32);
            let mut memory = Recollection::new(context, forward, parity, checked_share);
            memory.is_pilot = true;
            let mut cut = Cut::default();
            let sample = |entry: &usize| sample_site(&gatherer, *entry, pairs, &mut memory, &mut cut, &mut stream);
            (sites.iter().map(sample).collect(), cut.weighed)
        })
        .collect();
    let weighed = halves.iter().map(|(_, weighed)| *weighed as f64).sum::<f64>();
    let halves: Vec<Vec<SiteSample>> = halves.into_iter().map(|(sites, _)| sites).collect();

    let weights: Vec<f64> = sites.iter().map(|entry| weights[*entry]).collect();
    let weight_sum = 2.0 * weights.iter().sum::<f64>();
    let mean = |of: &dyn Fn(&SiteSample) -> f64| {
        let at_sites =
            |half: &Vec<SiteSample>| half.iter().zip(&weights).map(|(site, weight)| weight * of(site)).sum::<f64>();
        halves.iter().map(at_sites).sum::<f64>() / weight_sum
    };
    let total = |of: &dyn Fn(&SiteSample) -> f64| halves.iter().flatten().map(of).sum::<f64>();
    let ray_variance = mean(&|site| site.variance);
    let noise = mean(&|site| site.noise).max(LEAST_NOISE * ray_variance);
    let mean_lx = mean(&|site| site.mean_lx);
    GatherCosts {
        // Chance can make the rays' own part vanish; a tenth is always left.
        ray_variance: (ray_variance - noise).max(0.1 * ray_variance) * job.numbers_per_gathering_site(),
        deposit_variance: noise * forward.deposits_per_chain() * (forward.chains as usize * HALF) as f64
            / forward.patch_count() as f64,
        check_variance: mean(&|site| site.check_squared),
        rays_per_sample: ((total(&|site| site.rays) - total(&|site| site.check_rays)) / samples).max(1.0),
        choosing_per_sample: weighed / WEIGHED_PER_RAY / samples,
        looks_per_sample: total(&|site| site.look_ups) / samples,
        rays_per_check: (total(&|site| site.check_rays) / total(&|site| site.checks).max(1.0)).max(1.0),
        mean_lx,
        entries: entries.len() as f64,
        pilot_rays: total(&|site| site.rays) as u64,
    }
}

/// What one half found at one site.
#[derive(Clone, Copy, Debug, Default)]
struct SiteSample {
    mean_lx: f64,
    /// Variance of one sample by chance of the rays.
    variance: f64,
    /// Variance of one sample by the chance of the patch that it looked up.
    noise: f64,
    /// Mean square of what one look-up's check said.
    check_squared: f64,
    rays: f64,
    look_ups: f64,
    checks: f64,
    check_rays: f64,
}

fn sample_site(
    gatherer: &Gatherer,
    entry: usize,
    pairs: usize,
    memory: &mut Recollection,
    cut: &mut Cut,
    stream: &mut Stream,
) -> SiteSample {
    let mut found = SiteSample::default();
    let Some(site) = gatherer.site(entry) else {
        return found;
    };
    let pairs = pairs * HALF;
    let count = (2 * pairs) as f64;
    memory.scores = HalfScores::default();
    memory.noise = 0.0;
    memory.look_ups = 0;
    memory.check_count = [0; 2];
    for pair in 0..pairs as u64 {
        let both = [0, 1].map(|second| {
            stream.seek(stream_index(entry, 2 * pair + second));
            memory.checks = HalfChecks::default();
            let (lx, rays) = gatherer.sample(&site, memory, cut, stream).1;
            found.rays += rays as f64;
            // A check is drawn with the share p and counts 1/p: its mean square is p times what a sum shows.
            found.check_squared += memory.checks.rows_lx[0].powi(2) * gatherer.checked_share / count;
            lx
        });
        found.mean_lx += (both[0] + both[1]) / count;
        found.variance += (both[0] - both[1]).powi(2) / count;
    }
    found.noise = memory.noise / count;
    found.look_ups = memory.look_ups as f64;
    (found.checks, found.check_rays) = (memory.check_count[0] as f64, memory.check_count[1] as f64);
    found
}

impl GatherCosts {
    /// The same where patches tell direct light to so large a share of the rays that ask for it.
    pub fn knowing_direct(&self, told_share: f64) -> GatherCosts {
        let rays_per_sample = (self.rays_per_sample - told_share * self.looks_per_sample).max(1.0);
        GatherCosts { rays_per_sample, ..*self }
    }

    /// The same in work, where rays that look themselves choose among luminaires.
    pub fn with_choosing(&self) -> GatherCosts {
        GatherCosts { rays_per_sample: self.rays_per_sample + OWN_LOOKS * self.choosing_per_sample, ..*self }
    }

    /// Share of look-ups that is checked by a run to an error in lx: as many as bring the chance of the pooled checks down
    /// to a fourth of it, if they take no more than a share of the rays.
    pub fn checked_share(&self, samples: f64, error_lx: f64) -> f64 {
        let wanted =
            self.check_variance * CHECK_PRECISION / (samples * self.entries * REPLICAS as f64 * error_lx * error_lx);
        let most = CHECK_RAYS * self.rays_per_sample / self.rays_per_check;
        wanted.clamp(LEAST_CHECKED, most.max(LEAST_CHECKED))
    }

    /// About the least work that brings the random error to `error_lx`.
    ///
    /// Chains and gathering rays have two thirds of the squared error between them, shared so that both together take the
    /// fewest rays; the chance of the rays, whose points are quasi-random, falls about as n^(−3/2).
    pub fn plan(&self, chain: ChainCosts, error_lx: f64) -> GatherPlan {
        // All sixteen replicas together have a sixteenth of a replica's variance.
        let squared = error_lx * error_lx * REPLICAS as f64;
        let plan = |share: f64| {
            let chains = self.deposits_needed(squared * share) / chain.deposits;
            let samples = (self.ray_variance / (squared * (SHARED_ERROR - share))).powf(2.0 / 3.0).max(1.0);
            let checked_share = self.checked_share(samples, error_lx);
            let rays_per_sample = self.rays_per_sample + checked_share * self.rays_per_check;
            let rays = chains * chain.rays * RAYS_OF_FORWARD + samples * self.entries * rays_per_sample;
            GatherPlan { chains, samples, checked_share, rays: REPLICAS as f64 * rays }
        };
        let shares = (1..SHARES).map(|step| SHARED_ERROR * f64::from(step) / f64::from(SHARES));
        shares
            .map(plan)
            .min_by(|one, other| one.rays.total_cmp(&other.rays))
            .unwrap_or_else(|| plan(0.5 * SHARED_ERROR))
    }

    /// Deposits with which the chance of chains comes down to a squared error in lx².
    fn deposits_needed(&self, squared_lx2: f64) -> f64 {
        CHAINS_SHARE * COEFFICIENTS * self.deposit_variance / squared_lx2
    }

    /// The plan in which so many chains are right.
    pub fn plan_for_chains(&self, chain: ChainCosts, chains: f64) -> GatherPlan {
        // The larger the error, the fewer chains.
        let (mut low_lx, mut high_lx) = (1e-12 * self.mean_lx, 1e6 * self.mean_lx);
        for _ in 0..80 {
            let middle_lx = (low_lx * high_lx).sqrt();
            *(if self.plan(chain, middle_lx).chains > chains { &mut low_lx } else { &mut high_lx }) = middle_lx;
        }
        self.plan(chain, high_lx)
    }
}
