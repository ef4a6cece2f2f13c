//! How a gathering goes on: more rays, or more chains and the rays anew.

use super::stop::about_margin;
use crate::maps::Judgement;

/// Squared errors of gathering rays fall with this power of their number where all is smooth: their points are
/// quasi-random. Edges of shadows leave less; no less than random points would.
const RAY_EXPONENT: f64 = 1.5;
const LEAST_RAY_EXPONENT: f64 = 1.0;
/// How far it is from that, about, before anything was seen.
const EXPONENT_SPREAD: f64 = 0.3;
/// What even and odd share may take of the target, in a plan.
const MOST_SHARED: f64 = 0.7;
/// Steps in which the margin of the end is found.
const MARGIN_STEPS: usize = 4;
/// Rays that more chains and all samples anew may take, over those of more samples alone: what looks tell is unsure.
const WORTH_ANEW: f64 = 0.8;
/// More chains are tried in steps of this factor, up to so many steps.
const STEP: f64 = 1.1;
const STEPS: i32 = 60;
/// Where chains have this share of the squared error, rays that were planned too few time and again are no longer believed to be what
/// is missing.
const BY_CHAINS: f64 = 0.5;
/// Chains then grow by so many steps at least.
const LEAST_STEPS: i32 = 5;

/// How a map that is gathered stands, all variances those of the map's mean over all replicas, as fractions of its mean
/// squared.
#[derive(Clone, Copy, Debug)]
pub struct GatherState {
    /// By chance of the gathering rays.
    pub rows: f64,
    /// By chance of the chains.
    pub columns: f64,
    /// By chance of which rays asked which chains.
    pub cells: f64,
    /// By chance of direct light.
    pub direct: f64,
    /// Degrees of freedom of the part by chance of the chains.
    pub degrees_of_columns: f64,
    /// Power of their number with which the rays' part falls.
    pub ray_exponent: f64,
    /// Rays spent on gathering.
    pub gather_rays: f64,
    /// Of these, rays beyond those that were planned when it began.
    pub unplanned_rays: f64,
    /// Rays of direct light that go with as many samples.
    pub direct_rays: f64,
    /// Rays spent on direct light, which stays where gathering begins anew.
    pub direct_done: f64,
    /// Passes over direct light so far, over those that go with as many samples.
    pub direct_ahead: f64,
    /// Rays spent on chains.
    pub chain_rays: f64,
    /// Rays of the patches' samples, which are taken anew with more chains, and more of them.
    pub patch_rays: f64,
}

impl GatherState {
    /// Rays that it still takes to a multiple of the samples, of which so many rays of gathering are there.
    fn rays_to(&self, samples: f64, gathered_rays: f64) -> f64 {
        (self.gather_rays * samples - gathered_rays).max(0.0) + (self.direct_rays * samples - self.direct_done).max(0.0)
    }
}

/// Looks at least this factor of samples apart tell how the variance of rows falls.
const APART: f64 = 1.5;

/// How the variance of rows falls from look to look, as a power of the samples.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rows {
    first: Option<(f64, f64)>,
    exponent: Option<f64>,
}

impl Rows {
    /// Notes the variance by a look after so many samples, known with so many degrees of freedom.
    pub fn note(&mut self, samples: u64, variance: f64, degrees_of_freedom: f64) {
        let samples = samples as f64;
        let (first_samples, first) = *self.first.get_or_insert((samples, variance));
        if samples < APART * first_samples || variance <= 0.0 {
            return;
        }
        let span = (samples / first_samples).ln();
        let measured = (first / variance).ln() / span;
        // Each of the two logarithms has the variance 2/f.
        let (chance, spread) = (4.0 / degrees_of_freedom.max(1.0) / (span * span), EXPONENT_SPREAD * EXPONENT_SPREAD);
        let exponent = (measured * spread + RAY_EXPONENT * chance) / (spread + chance);
        self.exponent = Some(exponent.clamp(LEAST_RAY_EXPONENT, RAY_EXPONENT));
    }

    /// The power by what was seen so far.
    pub fn exponent(&self) -> f64 {
        self.exponent.unwrap_or(RAY_EXPONENT)
    }
}

/// What a gathering needs still, in multiples of what it has had.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherNeed {
    /// Chains: 1 for no more.
    pub chains: f64,
    /// Samples in all; anew where there are more chains.
    pub samples: f64,
    /// Rays that it still takes.
    pub rays: f64,
}

/// The cheapest way on to a target error.
pub fn gather_need(target_error: f64, judgement: &Judgement, state: &GatherState) -> GatherNeed {
    // Against a bias above its share neither rays nor chains help: finer patches and elements do, which come before.
    let shared = judgement.shared_error().min(target_error * MOST_SHARED);
    let room = target_error.powi(2) - shared.powi(2);
    let rest = (judgement.expected_error.powi(2) - state.rows - state.columns - state.cells).max(0.0);
    let samples = |chains: f64| {
        let left = allowed(room, judgement, state, rest, chains) - state.columns / chains;
        (left > 0.0).then(|| samples_for(left, state, (rest - state.direct).max(0.0) + state.cells / chains))
    };
    let as_it_is = samples(1.0).map(|samples| GatherNeed {
        chains: 1.0,
        samples: samples.max(1.0),
        rays: state.rays_to(samples.max(1.0), state.gather_rays),
    });
    let with_more = |step: i32| {
        let chains = STEP.powi(step);
        let samples = samples(chains)?;
        let rays = state.chain_rays * (chains - 1.0) + state.patch_rays * chains + state.rays_to(samples, 0.0);
        Some(GatherNeed { chains, samples, rays })
    };
    let cheapest = |least_steps: i32| {
        (least_steps..=STEPS).filter_map(with_more).min_by(|one, other| one.rays.total_cmp(&other.rays))
    };
    // What was gathered so far is given up for more chains only where that surely pays,
    let worth = |need: &GatherNeed| as_it_is.is_none_or(|as_it_is| need.rays <= WORTH_ANEW * as_it_is.rays);
    // or where it has taken as much more than was planned already.
    let is_stuck = |need: &GatherNeed| {
        state.columns > BY_CHAINS * judgement.expected_error.powi(2) && need.rays <= state.unplanned_rays
    };
    let best = cheapest(1).filter(worth).or_else(|| cheapest(LEAST_STEPS).filter(is_stuck)).or(as_it_is);
    best.unwrap_or_else(|| {
        let chains = STEP.powi(STEPS);
        let rays = (state.chain_rays + state.patch_rays) * chains + state.rays_to(1.0, 0.0);
        GatherNeed { chains, samples: 1.0, rays }
    })
}

/// Squared error by chance at which the map is accepted with so many times the chains: the target leaves it so much room beside
/// what even and odd share. `rest` is what neither rays nor chains have of it.
///
/// The margin is that of the end: what is common to many entries by chance of the chains has few degrees of freedom, and more
/// samples leave more and more of the error to it.
fn allowed(room: f64, judgement: &Judgement, state: &GatherState, rest: f64, chains: f64) -> f64 {
    // What is left beside direct light is taken for pooled corrections.
    let pooled = (rest - state.direct).max(0.0);
    let others = state.rows + state.cells + rest - pooled;
    let degrees = Degrees::of(state.columns, others, pooled, judgement, state);
    let (columns, share) = (state.columns / chains, pooled / (others + pooled).max(f64::MIN_POSITIVE));
    let (mut allowed, mut at_end) = (room, judgement.degrees_of_freedom);
    for _ in 0..MARGIN_STEPS {
        allowed = room / about_margin(at_end).powi(2);
        let left = (allowed - columns).max(0.0);
        let spread = degrees.spread(columns, (1.0 - share) * left, share * left);
        at_end = allowed * allowed / spread.max(f64::MIN_POSITIVE);
    }
    // Halves that happen to differ by more than they should are accepted without a margin. New chains draw anew.
    let unlucky = (judgement.halves_error / judgement.expected_error.max(f64::MIN_POSITIVE)).powi(2) - 1.0;
    allowed.min(room / (1.0 + unlucky.max(0.0) / chains))
}

/// Degrees of freedom of the parts of a squared error.
///
/// Of V = C + O + P, by the chains, by what is independent from entry to entry and by pooled corrections, which all entries have in
/// common, with f degrees in all: V²/f = C²/f_C + (O² + 2 O (C + P))/f_O + (P² + 2 P C)/f_P. Kept are 1/f_C, 1/f_O and 1/f_P.
struct Degrees {
    of_columns: f64,
    of_others: f64,
    of_pooled: f64,
}

impl Degrees {
    /// Those with which the parts have the degrees of the whole at most: O has no fewer than that, P has one at least, and what these do not
    /// explain is by the columns, whatever they were found to have.
    fn of(columns: f64, others: f64, pooled: f64, judgement: &Judgement, state: &GatherState) -> Degrees {
        let of_all = 1.0 / judgement.degrees_of_freedom.max(1.0);
        let whole = (columns + others + pooled).powi(2) * of_all;
        let by_columns = columns * columns / state.degrees_of_columns.max(1.0);
        let inverse = |spread: f64, part: f64| spread.max(0.0) / part.max(f64::MIN_POSITIVE);
        let [by_others, by_pooled] = beside(columns, others, pooled);
        let of_others = inverse(whole - by_columns, by_others + by_pooled).min(of_all);
        let of_pooled = inverse(whole - by_columns - by_others * of_others, by_pooled).min(1.0);
        let by_columns = by_columns.max(whole - by_others * of_others - by_pooled * of_pooled);
        Degrees { of_columns: inverse(by_columns, columns * columns), of_others, of_pooled }
    }

    /// V²/f of other parts.
    fn spread(&self, columns: f64, others: f64, pooled: f64) -> f64 {
        let [by_others, by_pooled] = beside(columns, others, pooled);
        columns * columns * self.of_columns + by_others * self.of_others + by_pooled * self.of_pooled
    }
}

/// O² + 2 O (C + P) and P² + 2 P C.
fn beside(columns: f64, others: f64, pooled: f64) -> [f64; 2] {
    [others * (others + 2.0 * (columns + pooled)), pooled * (pooled + 2.0 * columns)]
}

/// Factor f on the samples for which rows/fᵅ + others/f + direct·min(ahead/f, 1) comes down to `left`.
fn samples_for(left: f64, state: &GatherState, others: f64) -> f64 {
    let (mut low, mut high) = (1e-6f64, 1e9f64);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        let of_direct = state.direct * (state.direct_ahead / middle).min(1.0);
        let error = state.rows / middle.powf(state.ray_exponent) + others / middle + of_direct;
        *(if error > left { &mut low } else { &mut high }) = middle;
    }
    high
}

#[cfg(test)]
mod tests {
    use super::super::stop::accepts;
    use super::*;

    fn judged(expected_error: f64) -> Judgement {
        Judgement { mean_lx: 1.0, expected_error, degrees_of_freedom: 1e6, ..Judgement::default() }
    }

    #[test]
    fn the_power_of_rays_is_learnt_as_far_as_looks_tell() {
        let mut rows = Rows::default();
        assert_eq!(rows.exponent(), RAY_EXPONENT);
        rows.note(4, 1.0, 1e6);
        rows.note(16, 1.0 / 4.0f64.powf(1.1), 1e6);
        assert!((rows.exponent() - 1.1).abs() < 1e-3, "{rows:?}");
        let mut unsure = Rows::default();
        unsure.note(4, 1.0, 4.0);
        unsure.note(8, 0.5, 4.0);
        assert!(unsure.exponent() > 1.4, "{unsure:?}");
    }

    #[test]
    fn chance_of_rays_asks_for_rays_and_chance_of_chains_for_chains() {
        let state = GatherState {
            rows: 4e-4,
            columns: 1e-6,
            cells: 0.0,
            direct: 0.0,
            degrees_of_columns: 1e6,
            ray_exponent: RAY_EXPONENT,
            gather_rays: 1e6,
            unplanned_rays: 0.0,
            direct_rays: 0.0,
            direct_done: 0.0,
            direct_ahead: 1.0,
            chain_rays: 1e6,
            patch_rays: 0.0,
        };
        let need = gather_need(0.01, &judged(0.02), &state);
        assert!(need.chains == 1.0 && (2.4..2.7).contains(&need.samples), "{need:?}");
        let state = GatherState { rows: 1e-6, columns: 4e-4, ..state };
        let need = gather_need(0.01, &judged(0.02), &state);
        assert!(need.chains > 4.0 && need.samples < 1.0, "{need:?}");
    }

    #[test]
    fn chains_of_few_degrees_are_bought_before_the_margin_asks_for_them() {
        // The map at a look has 200 degrees, since rays have most of its error; what chains have has five. As the rays' part falls the
        // margin grows: samples planned with that of the look do not reach the target.
        let state = GatherState {
            rows: 1.5e-5,
            columns: 2.9e-6,
            cells: 5.7e-6,
            direct: 0.0,
            degrees_of_columns: 5.0,
            ray_exponent: 1.25,
            gather_rays: 2.9e5,
            unplanned_rays: 0.0,
            direct_rays: 3.5e4,
            direct_done: 7e4,
            direct_ahead: 1.0,
            chain_rays: 2.4e5,
            patch_rays: 0.0,
        };
        let judgement = Judgement { degrees_of_freedom: 200.0, ..judged(5.2e-3) };
        let need = gather_need(0.003, &judgement, &state);
        let reached = |need: &GatherNeed, state: &GatherState| {
            let columns = state.columns / need.chains;
            let others = state.rows / need.samples.powf(state.ray_exponent)
                + (5.2e-3f64.powi(2) - state.rows - state.columns - state.cells + state.cells / need.chains)
                    / need.samples;
            let spread = columns * columns / 5.0 + others * others * 200f64.recip();
            let squared = columns + others;
            squared.sqrt() * about_margin(squared * squared / spread)
        };
        let blind = gather_need(0.003, &judgement, &GatherState { degrees_of_columns: 1e6, ..state });
        assert!((reached(&need, &state) / 0.003 - 1.0).abs() < 0.03, "{need:?} {}", reached(&need, &state));
        assert!(reached(&blind, &state) > 1.05 * 0.003, "{blind:?} {}", reached(&blind, &state));
    }

    #[test]
    fn chains_are_bought_where_rays_alone_would_never_do() {
        // Corrections leave columns of 4.8 degrees with 2, and hardly anything but columns is left: samples alone would go on for ever.
        let state = GatherState {
            rows: 2.6e-7,
            columns: 3e-5,
            cells: 3.4e-8,
            direct: 0.0,
            degrees_of_columns: 4.8,
            ray_exponent: 1.5,
            gather_rays: 1e6,
            unplanned_rays: 0.0,
            direct_rays: 0.0,
            direct_done: 0.0,
            direct_ahead: 1.0,
            chain_rays: 1e4,
            patch_rays: 1e4,
        };
        let refused = Judgement { degrees_of_freedom: 2.0, ..judged(5.5e-3) };
        assert!(!accepts(0.01, &refused));
        let need = gather_need(0.01, &refused, &state);
        assert!(need.chains > 1.2, "{need:?}");
        // Few more samples would do by what is known; but as many were said to do before, and again.
        let more = GatherState { columns: 2e-5, rows: 7e-6, degrees_of_columns: 100.0, gather_rays: 2e6, ..state };
        let creeping = Judgement { degrees_of_freedom: 2.5, ..judged(5.8e-3) };
        assert!(!accepts(0.01, &creeping));
        assert_eq!(gather_need(0.01, &creeping, &more).chains, 1.0);
        let need = gather_need(0.01, &creeping, &GatherState { unplanned_rays: 1.5e6, ..more });
        assert!(need.chains > 1.6, "{need:?}");
        // The same where only the halves are too far apart.
        let unlucky = Judgement { halves_error: 0.0105, degrees_of_freedom: 100.0, ..judged(5.5e-3) };
        assert!(!accepts(0.01, &unlucky) && accepts(0.01, &Judgement { halves_error: 0.0095, ..unlucky }));
        let need = gather_need(0.01, &unlucky, &GatherState { degrees_of_columns: 100.0, ..state });
        assert!(need.chains > 1.0, "{need:?}");
    }

    #[test]
    fn chance_that_makes_columns_of_more_than_all_asks_for_no_more_margin_than_they_do() {
        // Both are estimates: columns of 1.02 times the whole, or 0.99 times it with the degrees of either as good as alike.
        let state = |columns: f64| GatherState {
            rows: 2.7e-7,
            columns,
            cells: 0.0,
            direct: 0.0,
            degrees_of_columns: 60.0,
            ray_exponent: 1.25,
            gather_rays: 3e5,
            unplanned_rays: 0.0,
            direct_rays: 0.0,
            direct_done: 0.0,
            direct_ahead: 1.0,
            chain_rays: 2e5,
            patch_rays: 0.0,
        };
        let judgement = Judgement { degrees_of_freedom: 50.0, ..judged(5.2e-3) };
        let now = judgement.expected_error.powi(2);
        for columns in [0.99 * now, 1.02 * now] {
            let allowed = allowed(1.0, &judgement, &state(columns), 0.0, 2.0);
            assert!((allowed.sqrt() * about_margin(50.0) - 1.0).abs() < 0.1, "{columns}: {allowed}");
        }
    }

    #[test]
    fn direct_light_that_is_done_does_not_make_more_chains_worth_it() {
        // Gathering anew costs what gathering cost; direct light of ten times the rays stays. Were it to be done again, many
        // more chains would be bought to save samples.
        let state = GatherState {
            rows: 8e-4,
            columns: 3e-4,
            cells: 1e-3,
            direct: 0.0,
            degrees_of_columns: 1e6,
            ray_exponent: LEAST_RAY_EXPONENT,
            gather_rays: 2e5,
            unplanned_rays: 0.0,
            direct_rays: 1e5,
            direct_done: 2e6,
            direct_ahead: 1.0,
            chain_rays: 2.5e4,
            patch_rays: 0.0,
        };
        let need = gather_need(0.01, &judged(0.047), &state);
        let as_if_again =
            gather_need(0.01, &judged(0.047), &GatherState { gather_rays: 2.2e6, direct_done: 0.0, ..state });
        assert!(need.chains > 5.0 && 1.5 * need.chains < as_if_again.chains, "{need:?} {as_if_again:?}");
        let direct_rays = (state.direct_rays * need.samples - state.direct_done).max(0.0);
        let rays = state.chain_rays * (need.chains - 1.0) + state.gather_rays * need.samples + direct_rays;
        assert!((need.rays / rays - 1.0).abs() < 1e-9, "{need:?}");
    }
}
