//! Speed against error: a method runs with more and more chains, and each run is compared with the truth.

use super::case::{Case, CaseRun};
use super::comparison::Comparison;
use super::error::CaseError;
use super::exact_side::ExactSide;
use super::measure::Stopwatch;
use super::methods::{Climb, ComparedMethod};
use super::statistics::SAME_SUM;
use crate::solver::{ElementChoice, MapSelection, Settings};

/// Chains per map on the lowest rung.
const FIRST_CHAINS: u64 = 1024;
/// Target error on the lowest rung of a method that climbs by targets.
const FIRST_TARGET: f64 = 1.0;
/// Factor from the stated error of a rung to the next target.
const UNDER: f64 = 0.99;
/// Runs with different seeds on a rung while they are cheap. They reduce the noise in the error of a map of few points.
const REPEATS: usize = 4;
/// A rung is repeated while one run takes less than this share of the time budget.
const CHEAP: f64 = 1.0 / 16.0;
/// Rungs that take less than this share of the last rung's time are not fitted. Their time is mostly building and pilots, not
/// convergence.
const FITTED_FROM: f64 = 1.0 / 64.0;

/// Relative errors for which times are reported.
pub const LEVELS: [f64; 3] = [0.03, 0.01, 0.003];

/// The climb of a method on one map of a case.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// Name of the case.
    pub case: String,
    /// Name of the run of the case.
    pub run: String,
    /// Name of the comparison with the truth.
    pub comparison: String,
    /// Name of the method.
    pub method: String,
    /// Name of the estimator that the method used.
    pub estimator: String,
    /// Its rungs, from cheap to expensive.
    pub rungs: Vec<Rung>,
    /// Error against seconds, if there are enough rungs.
    pub by_time: Option<LadderFit>,
    /// Error against rays, if there are enough rungs.
    pub by_rays: Option<LadderFit>,
}

/// One rung: runs with the same number of chains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rung {
    /// Chains of one run.
    pub chains: u64,
    /// Rays of one run.
    pub rays: u64,
    /// Seconds of one run, building included.
    pub seconds: f64,
    /// True relative RMS error: root mean square over the runs.
    pub true_error: f64,
    /// Stated error: root mean square over the runs.
    pub stated_error: f64,
    /// Number of runs.
    pub runs: usize,
}

/// error = scale · cost^slope, fitted to the logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LadderFit {
    /// Error at a cost of 1.
    pub scale: f64,
    /// Exponent; −½ for independent samples.
    pub slope: f64,
    /// Largest and smallest error among the rungs that were fitted.
    pub covers: [f64; 2],
}

impl LadderFit {
    /// Least-squares fit through `(cost, error)`; `None` for fewer than three points or if the error does not fall.
    pub fn through(places: &[(f64, f64)]) -> Option<LadderFit> {
        let logs: Vec<(f64, f64)> = places
            .iter()
            .filter(|(cost, error)| *cost > 0.0 && *error > 0.0)
            .map(|(cost, error)| (cost.ln(), error.ln()))
            .collect();
        if logs.len() < 3 {
            return None;
        }
        let count = logs.len() as f64;
        let (x, y) = (
            logs.iter().map(|place| place.0).sum::<f64>() / count,
            logs.iter().map(|place| place.1).sum::<f64>() / count,
        );
        let squares: f64 = logs.iter().map(|place| (place.0 - x).powi(2)).sum();
        let products: f64 = logs.iter().map(|place| (place.0 - x) * (place.1 - y)).sum();
        let slope = products / squares;
        let errors = || logs.iter().map(|place| place.1.exp());
        let covers = [errors().fold(0.0, f64::max), errors().fold(f64::INFINITY, f64::min)];
        (squares > 0.0 && slope < 0.0).then(|| LadderFit { scale: (y - slope * x).exp(), slope, covers })
    }

    /// Cost at which `error` is reached.
    pub fn cost_at(&self, error: f64) -> f64 {
        (error / self.scale).powf(1.0 / self.slope)
    }

    /// Returns whether the error is outside the range of the fitted rungs.
    pub fn extrapolates(&self, error: f64) -> bool {
        error > self.covers[0] || error < self.covers[1]
    }
}

impl Ladder {
    /// The cheapest rung with only rounding errors, if there is one. The method is then exact at any cost.
    pub fn exact_rung(&self) -> Option<&Rung> {
        self.rungs.iter().find(|rung| rung.true_error < SAME_SUM)
    }

    /// Figure of merit 1/(ε² t) in 1/s: geometric mean over the fitted rungs. Twice the figure means the same error in half the
    /// time.
    pub fn figure_of_merit(&self) -> f64 {
        let fitted = fitted(&self.rungs);
        let logs: f64 = fitted.iter().map(|rung| -(rung.true_error.powi(2) * rung.seconds).ln()).sum();
        (logs / fitted.len().max(1) as f64).exp()
    }
}

/// Climbs with a method on every map of points or elements that a case compares, for `budget_s` seconds each.
///
/// # Errors
///
/// A comparison that the truth or the map cannot answer.
pub fn climb(
    case: &Case,
    method: &ComparedMethod,
    budget_s: f64,
    tell: &mut dyn FnMut(&str),
) -> Result<Vec<Ladder>, CaseError> {
    let run = &case.runs[case.ladder_run];
    let mut ladders: Vec<Ladder> = Vec::new();
    for comparison in run.comparisons.iter().filter(|comparison| !comparison.what.is_one_number()) {
        let ascent = Ascent { case, run, comparison, method, budget_s };
        match ascent.ladder(tell)? {
            Ok(ladder) => ladders.push(ladder),
            Err(reason) => tell(&format!("{}: {}: {reason}", comparison.name, method.name)),
        }
    }
    Ok(ladders)
}

/// The climb of a method on one comparison.
struct Ascent<'a> {
    case: &'a Case,
    run: &'a CaseRun,
    comparison: &'a Comparison,
    method: &'a ComparedMethod,
    budget_s: f64,
}

/// Settings of a rung.
#[derive(Clone, Copy)]
struct RungRequest {
    chains: u64,
    target_error: f64,
    /// Seed of its first run.
    seed: u64,
}

/// Result of the runs of a rung.
struct Reached {
    rung: Rung,
    estimator: String,
    /// Seconds of all its runs together.
    spent_s: f64,
    /// Whether a run missed its target; the method then cannot improve further.
    at_the_end: bool,
    /// Relative error of the truth itself.
    truth_error: f64,
}

impl Ascent<'_> {
    /// Climbs from the lowest rung to the last one within the time budget, or returns why the method cannot.
    fn ladder(&self, tell: &mut dyn FnMut(&str)) -> Result<Result<Ladder, String>, CaseError> {
        let (comparison, method) = (self.comparison, self.method);
        let mut request = RungRequest { chains: FIRST_CHAINS, target_error: FIRST_TARGET, seed: self.run.seed };
        if let Err(reason) = (method.applies)(&self.run.scene, &self.settings(request)) {
            return Ok(Err(reason));
        }
        tell(&format!("{}: {}", comparison.name, method.name));
        let exact = ExactSide::new(self.case, self.run, comparison)?;
        let mut rungs: Vec<Rung> = Vec::new();
        let mut estimator = String::new();
        let mut spent_s = 0.0;
        let mut at_the_end = false;
        loop {
            request.seed = self.run.seed + 1 + (rungs.len() * REPEATS) as u64;
            let reached = match self.rung(&exact, request)? {
                Ok(reached) => reached,
                Err(reason) => return Ok(Err(reason)),
            };
            let rung = reached.rung;
            spent_s += reached.spent_s;
            at_the_end |= reached.at_the_end;
            if !reached.estimator.is_empty() {
                estimator = reached.estimator;
            }
            // Below the truth's own error nothing more can be measured.
            if rung.true_error < reached.truth_error {
                tell(&format!("{}: {}: as exact as the truth", comparison.name, method.name));
                break;
            }
            // A map without random error has only one rung. A rung is also new only if it has more chains, since the number is
            // rounded up to fill the replicas.
            let without_chance = rung.true_error == 0.0 || rung.stated_error == 0.0;
            let further = |last: &Rung| match method.climbs {
                Climb::Chains => last.chains < rung.chains,
                Climb::Targets => rung.stated_error < last.stated_error,
            };
            if rungs.last().is_none_or(further) || without_chance {
                rungs.push(rung);
            }
            request.chains = (2 * request.chains).max(2 * rung.chains);
            request.target_error = UNDER * rung.stated_error;
            if without_chance || at_the_end || spent_s + 2.0 * rung.seconds > self.budget_s {
                break;
            }
        }
        let fitted = fitted(&rungs);
        let places = |cost: fn(&Rung) -> f64| -> Vec<(f64, f64)> {
            fitted.iter().map(|rung| (cost(rung), rung.true_error)).collect()
        };
        Ok(Ok(Ladder {
            case: self.case.name.clone(),
            run: self.run.name.clone(),
            comparison: comparison.name.clone(),
            method: method.name.to_owned(),
            estimator,
            by_time: LadderFit::through(&places(|rung| rung.seconds)),
            by_rays: LadderFit::through(&places(|rung| rung.rays as f64)),
            rungs,
        }))
    }

    fn settings(&self, request: RungRequest) -> Settings {
        let climbs = self.method.climbs;
        Settings {
            method: crate::solver::Method::Collision,
            elements: ElementChoice::Given,
            seed: request.seed,
            target_error: (climbs == Climb::Targets).then_some(request.target_error),
            chains: (climbs == Climb::Chains).then_some(request.chains),
            time_limit_s: None,
            maps: MapSelection::Named(vec![self.comparison.map.clone()]),
            threads: None,
        }
    }

    /// Computes the runs of one rung, several while they are cheap, and compares each with the truth. Or returns why the method
    /// cannot.
    fn rung(&self, exact: &ExactSide, request: RungRequest) -> Result<Result<Reached, String>, CaseError> {
        let mut rung = Rung { chains: 0, rays: 0, seconds: 0.0, true_error: 0.0, stated_error: 0.0, runs: 0 };
        let (mut estimator, mut at_the_end) = (String::new(), false);
        let (mut truth_error, mut truth_variance) = (0.0, 0.0);
        while rung.runs < REPEATS {
            let settings = self.settings(RungRequest { seed: request.seed + rung.runs as u64, ..request });
            let solution = match (self.method.solve)(&self.run.scene, &settings, &Stopwatch::starting_now()) {
                Ok(solution) => solution,
                Err(reason) => return Ok(Err(reason)),
            };
            at_the_end |= solution.target_met == Some(false);
            let set = exact.beside(&solution)?;
            let statistics = set.statistics();
            truth_error = statistics.truth;
            let is_random = set.truth_average_error.is_some();
            truth_variance = if is_random { truth_error * truth_error } else { 0.0 };
            let seconds = solution.build_s + solution.compute_s;
            rung.runs += 1;
            rung.chains = solution.chains;
            rung.rays += solution.rays;
            rung.seconds += seconds;
            rung.true_error += statistics.rms * statistics.rms;
            rung.stated_error += solution.estimated_error.powi(2);
            if let Some(map) = solution.maps.first() {
                estimator.clone_from(&map.method);
            }
            if seconds > CHEAP * self.budget_s || !self.method.takes_chains {
                break;
            }
        }
        let (runs, spent_s) = (rung.runs as f64, rung.seconds);
        rung.rays = (rung.rays as f64 / runs) as u64;
        rung.seconds /= runs;
        // A stored run adds its own random error to every deviation. Its mean square is subtracted.
        rung.true_error = (rung.true_error / runs - truth_variance).max(0.0).sqrt();
        rung.stated_error = (rung.stated_error / runs).sqrt();
        Ok(Ok(Reached { rung, estimator, spent_s, at_the_end, truth_error }))
    }
}

/// The rungs that show how a method converges: those near the expensive end. Rungs that took more rays than a later one are excluded,
/// since with few chains a method may do other work instead.
fn fitted(rungs: &[Rung]) -> Vec<&Rung> {
    let last_s = rungs.last().map_or(0.0, |rung| rung.seconds);
    let does_other_work = |place: usize| rungs[place + 1..].iter().any(|later| later.rays < rungs[place].rays);
    let expensive = rungs.iter().enumerate().filter(|(_, rung)| rung.seconds >= FITTED_FROM * last_s);
    expensive.filter(|(place, _)| !does_other_work(*place)).map(|(_, rung)| rung).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_finds_the_law_that_made_the_places() {
        let places: Vec<(f64, f64)> = (0..8).map(|k| (2f64.powi(k), 0.05 * 2f64.powi(k).powf(-0.5))).collect();
        let fit = LadderFit::through(&places).expect("eight places on a line");
        assert!((fit.slope + 0.5).abs() < 1e-12 && (fit.scale - 0.05).abs() < 1e-12);
        assert!((fit.cost_at(0.005) - 100.0).abs() < 1e-9);
        assert!(fit.extrapolates(0.003) && !fit.extrapolates(0.03));
        assert_eq!(LadderFit::through(&places[..2]), None);
    }
}
