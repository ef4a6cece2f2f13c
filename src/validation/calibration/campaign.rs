//! Runs of one map with many seeds, and their statistics.

use super::bias::Biases;
use super::{COVERAGE_ALLOWANCE, NOMINAL, fewest_met, most_cost, student_within};
use crate::solver::{ElementChoice, MapSelection, Method, Settings, Solution, solve};
use crate::validation::case::{Case, CaseRun};
use crate::validation::comparison::Comparison;
use crate::validation::error::CaseError;
use crate::validation::exact::LightPart;
use crate::validation::exact_side::ExactSide;
use crate::validation::forecasts::{JudgedForecast, judged_forecasts, median};
use crate::validation::measure::Stopwatch;
use crate::validation::statistics::EntrySet;

/// Probability levels at which error bars are compared with the truth.
pub(super) const LEVELS: [f64; 9] = [0.1, 0.25, 0.5, 0.683, 0.8, 0.9, NOMINAL, 0.99, 0.999];
/// Index of [`NOMINAL`] in `LEVELS`.
pub(super) const AT_NOMINAL: usize = 6;
/// Share of the work at which early forecasts are compared with the result, as in the paper that is the source of the method.
const EARLY: f64 = 0.024;

/// A campaign of expensive runs has fewer seeds. It may use this many rays per requested seed, but has at least `FEWEST_SEEDS`
/// seeds.
const RAYS_PER_SEED: f64 = 8e5;
const FEWEST_SEEDS: u64 = 20;

/// Settings of a campaign.
#[derive(Clone, Copy, Debug)]
pub struct CampaignSettings {
    /// Number of runs, with seeds from 0.
    pub seeds: u64,
    /// Target of every run, as a fraction.
    pub target_error: f64,
    /// Whether maps by `auto` are run in addition to those by `collision`.
    pub with_auto: bool,
    /// Number of runs at the same time.
    pub threads: usize,
}

/// One run compared with the truth.
#[derive(Clone, Debug)]
pub struct SeedRun {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Estimator of the map.
    pub estimator: String,
    /// Whether the run reported "target met".
    pub target_met: bool,
    /// True relative RMS error.
    pub true_error: f64,
    /// Stated error.
    pub stated_error: f64,
    /// Effective degrees of freedom that the run states.
    pub degrees_of_freedom: f64,
    /// Number of rays.
    pub rays: u64,
    /// Number of chains.
    pub chains: u64,
    /// Seconds for building and computing.
    pub seconds: f64,
    /// Number of error checks at which the error met the target but a statistical check refused it.
    pub refusals: u64,
    /// Number of entries with error bars. `within` counts those within the quantiles of `LEVELS`.
    pub noisy: usize,
    /// Number of entries within the quantile of each level.
    pub within: [usize; LEVELS.len()],
    /// Weighted mean deviation over the mean exact value.
    pub bias: f64,
    /// Forecasts compared with the result.
    pub forecasts: Vec<JudgedForecast>,
}

/// Runs of one map of one case by one method.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// Name of the case.
    pub case: String,
    /// Name of the comparison.
    pub comparison: String,
    /// Name of the method.
    pub method: &'static str,
    /// Number of values compared in every run.
    pub values: usize,
    /// Target error of every run.
    pub target_error: f64,
    /// The runs in the order of their seeds.
    pub runs: Vec<SeedRun>,
    /// Deviations that are the same in all runs.
    pub biases: Biases,
}

/// Runs all campaigns of a case. `tell` receives the name of every campaign that begins.
///
/// # Errors
///
/// A comparison that the truth or the map cannot answer.
pub fn calibrate(
    case: &Case,
    settings: &CampaignSettings,
    tell: &mut dyn FnMut(&str),
) -> Result<Vec<Campaign>, CaseError> {
    let run = &case.runs[case.ladder_run];
    let mut campaigns = Vec::new();
    let counts = |comparison: &&Comparison| !comparison.what.is_one_number() && comparison.light == LightPart::Total;
    for comparison in run.comparisons.iter().filter(counts) {
        let truth = ExactSide::new(case, run, comparison)?;
        let methods = [("collision", Method::Collision), ("auto", Method::Auto)];
        for (name, method) in methods.into_iter().take(if settings.with_auto { 2 } else { 1 }) {
            tell(&format!("{}, {name}", comparison.name));
            let solutions = solve_all(run, comparison, method, settings);
            let (mut runs, mut biases) = (Vec::new(), Biases::default());
            for (seed, solution) in solutions.iter().enumerate() {
                let set = truth.beside(solution)?;
                biases.add(&set.entries);
                runs.push(seed_run(seed as u64, solution, comparison, &set));
            }
            campaigns.push(Campaign {
                case: case.name.clone(),
                comparison: comparison.name.clone(),
                method: name,
                values: runs.first().map_or(0, |run| run.noisy),
                target_error: settings.target_error,
                runs,
                biases,
            });
        }
    }
    Ok(campaigns)
}

/// Each thread computes one run at a time: runs are short, and results do not depend on the number of threads.
fn solve_all(run: &CaseRun, comparison: &Comparison, method: Method, settings: &CampaignSettings) -> Vec<Solution> {
    let solve_one = |seed: u64| {
        let settings = Settings {
            method,
            seed,
            target_error: Some(settings.target_error),
            maps: MapSelection::Named(vec![comparison.map.clone()]),
            elements: ElementChoice::Given,
            ..Settings::default()
        };
        solve(&run.scene, &settings, &Stopwatch::starting_now())
    };
    // The first run shows the cost of the others.
    let first = solve_one(0);
    let affordable = RAYS_PER_SEED * settings.seeds as f64 / first.rays.max(1) as f64;
    let seeds = settings.seeds.min((affordable as u64).max(FEWEST_SEEDS));
    let threads = settings.threads.max(1) as u64;
    let worker = |first: u64| -> Vec<(u64, Solution)> {
        let seeds = (1 + first..seeds).step_by(threads as usize);
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        match &one_thread {
            Ok(pool) => pool.install(|| seeds.map(|seed| (seed, solve_one(seed))).collect()),
            Err(_) => seeds.map(|seed| (seed, solve_one(seed))).collect(),
        }
    };
    let mut solved: Vec<(u64, Solution)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|first| scope.spawn(move || worker(first))).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("a run that ends")).collect()
    });
    solved.push((0, first));
    solved.sort_by_key(|(seed, _)| *seed);
    solved.into_iter().map(|(_, solution)| solution).collect()
}

fn seed_run(seed: u64, solution: &Solution, comparison: &Comparison, set: &EntrySet) -> SeedRun {
    let statistics = set.statistics();
    let map = solution.maps.iter().find(|map| map.name == comparison.map);
    let scores: Vec<f64> = set.entries.iter().filter_map(|entry| entry.z()).collect();
    let degrees = set.degrees_of_freedom;
    let within = LEVELS.map(|level| {
        let most = student_within(level, degrees);
        scores.iter().filter(|z| z.abs() <= most).count()
    });
    SeedRun {
        seed,
        estimator: map.map_or(String::new(), |map| map.method.clone()),
        target_met: solution.target_met == Some(true),
        true_error: statistics.rms,
        stated_error: solution.estimated_error,
        degrees_of_freedom: map.map_or(1.0, |map| map.error.degrees_of_freedom),
        rays: solution.rays,
        chains: solution.chains,
        seconds: solution.build_s + solution.compute_s,
        refusals: map.map_or(0, |map| map.refusals),
        noisy: scores.len(),
        within,
        bias: statistics.bias,
        forecasts: judged_forecasts(&solution.convergence),
    }
}

impl Campaign {
    /// Estimators of the map, the most frequent first.
    pub fn estimators(&self) -> String {
        let mut counts: Vec<(String, usize)> = Vec::new();
        for run in &self.runs {
            match counts.iter_mut().find(|(name, _)| *name == run.estimator) {
                Some((_, count)) => *count += 1,
                None => counts.push((run.estimator.clone(), 1)),
            }
        }
        counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        counts.into_iter().map(|(name, _)| name).collect::<Vec<_>>().join(", ")
    }

    fn mean(&self, of: impl Fn(&SeedRun) -> f64) -> f64 {
        self.runs.iter().map(of).sum::<f64>() / self.runs.len().max(1) as f64
    }

    /// Median of the degrees of freedom that the runs state.
    pub fn degrees_of_freedom(&self) -> f64 {
        median(self.runs.iter().map(|run| run.degrees_of_freedom).collect())
    }

    /// Share of all values within the quantile of a level.
    pub fn coverage(&self, level: usize) -> f64 {
        let noisy: usize = self.runs.iter().map(|run| run.noisy).sum();
        self.runs.iter().map(|run| run.within[level]).sum::<usize>() as f64 / noisy.max(1) as f64
    }

    /// Standard error of the coverage at the nominal level. It is computed from the spread between runs, because values of one run
    /// are correlated.
    pub fn coverage_error(&self) -> f64 {
        let share = |run: &SeedRun| run.within[AT_NOMINAL] as f64 / run.noisy.max(1) as f64;
        let mean = self.mean(share);
        let count = self.runs.len().max(2) as f64;
        (self.runs.iter().map(|run| (share(run) - mean).powi(2)).sum::<f64>() / (count * (count - 1.0))).sqrt()
    }

    /// Number of runs that reported "target met" and truly meet it, and number of runs that reported so.
    pub fn met(&self) -> (usize, usize) {
        let said: Vec<&SeedRun> = self.runs.iter().filter(|run| run.target_met).collect();
        (said.iter().filter(|run| run.true_error <= self.target_error).count(), said.len())
    }

    /// Root mean square of the true error over the target.
    pub fn true_over_target(&self) -> f64 {
        self.mean(|run| run.true_error.powi(2)).sqrt() / self.target_error
    }

    /// Mean rays over those of an oracle that stops where the expected squared error is the target's square. A run's squared error
    /// falls as one over its rays, so the product of both gives the oracle's rays.
    pub fn cost(&self) -> f64 {
        let oracle = self.mean(|run| run.true_error.powi(2) * run.rays as f64) / self.target_error.powi(2);
        self.mean(|run| run.rays as f64) / oracle
    }

    /// Number of error checks refused by a statistical check in all runs, and number of runs with a refusal.
    pub fn refusals(&self) -> (u64, usize) {
        let refused = self.runs.iter().filter(|run| run.refusals > 0).count();
        (self.runs.iter().map(|run| run.refusals).sum(), refused)
    }

    /// Mean deviation over the runs, in its own standard errors.
    pub fn bias_z(&self) -> f64 {
        let mean = self.mean(|run| run.bias);
        let count = self.runs.len().max(2) as f64;
        let squares: f64 = self.runs.iter().map(|run| (run.bias - mean).powi(2)).sum();
        mean / (squares / (count * (count - 1.0))).sqrt()
    }

    /// Median and largest relative error of forecasts made between two shares of the work.
    pub fn forecast_error(&self, low: f64, high: f64) -> Option<(f64, f64)> {
        let between = |forecast: &&JudgedForecast| (low..high).contains(&forecast.share);
        let errors: Vec<f64> = self
            .runs
            .iter()
            .flat_map(|run| run.forecasts.iter().filter(between))
            .map(|forecast| (forecast.ratio - 1.0).abs())
            .collect();
        let largest = errors.iter().copied().reduce(f64::max)?;
        Some((median(errors), largest))
    }

    /// Median and largest error of forecasts around the share of work at which the source of the method reports a forecast with an
    /// error of 2.2%.
    pub fn early_forecast_error(&self) -> Option<(f64, f64)> {
        self.forecast_error(EARLY / 3.0, EARLY * 3.0)
    }

    /// Returns whether the error bars have the nominal coverage.
    pub fn covers(&self) -> bool {
        let allowance = COVERAGE_ALLOWANCE + 3.0 * self.coverage_error();
        (self.coverage(AT_NOMINAL) - NOMINAL).abs() <= allowance
    }

    /// Returns whether "target met" is true often enough.
    pub fn keeps_targets(&self) -> bool {
        let (met, said) = self.met();
        met >= fewest_met(said) && said == self.runs.len()
    }

    /// Returns whether the runs stop soon enough.
    pub fn is_thrifty(&self) -> bool {
        self.cost() <= most_cost(self.degrees_of_freedom())
    }

    /// Returns whether error bars have the nominal coverage, targets are met and no bias is large. The work is reported but not
    /// judged.
    pub fn passes(&self) -> bool {
        self.covers() && self.keeps_targets() && self.biases.is_small()
    }
}
