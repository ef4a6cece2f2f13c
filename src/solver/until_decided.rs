//! Runs to ever smaller errors until every requirement of a scene is decided.

use super::spending::Spending;
use super::verdicts::{Finding, Verdict, verdicts};
use super::{Settings, Solution, StopReason, map_requests};
use crate::control::{Forecast, Ruling, is_decided_at_look};
use crate::maps::MapKind;
use crate::scene::Scene;

/// The errors to which runs go.
#[derive(Clone, Copy, Debug)]
pub struct VerdictLadder {
    /// Stated error of the first run.
    pub first_error: f64,
    /// Smallest error of a run. Requirements that close to their limits stay undecided.
    pub least_error: f64,
}

/// Default error of the first run, and default smallest error.
const USUAL_ERRORS: [f64; 2] = [0.03, 0.001];

impl VerdictLadder {
    /// A ladder from the default first error down to the requested smallest error.
    pub fn down_to(least_error: Option<f64>) -> VerdictLadder {
        let [first_error, usual] = USUAL_ERRORS;
        let least_error = least_error.unwrap_or(usual);
        VerdictLadder { first_error: first_error.max(least_error), least_error }
    }
}

/// A run goes to the error at which undecided values would be this many standard errors away from their limits.
const ERRORS_OFF: f64 = 4.0;
/// Smallest and largest ratio of the error of the next run to the present one.
const STEP: [f64; 2] = [0.125, 0.6];

/// Total work of all runs so far.
#[derive(Default)]
struct TakenTogether {
    errors: Vec<String>,
    rays: u64,
    chains: u64,
    compute_s: f64,
    spending: Spending,
}

/// Solves a scene until each requirement of the requested maps is decided, or a limit comes.
/// Every run is a look. At each look, a requirement counts as decided only beyond the tail of that look. So the wrong verdicts of many
/// looks do not add up to more than is allowed: docs/methods.md, section 22. `solve` makes one run. The solution is that of the last run.
/// If a limit cut the last run short and left it with the larger error, it is that of the run before. Its work is that of all runs.
/// # Errors
/// Errors of a run.
///
/// Those of a run.
pub fn solve_to_verdicts<E>(
    scene: &Scene,
    settings: &Settings,
    ladder: VerdictLadder,
    solve: impl Fn(&Settings) -> Result<Solution, E>,
) -> Result<Solution, E> {
    let requested: Vec<MapKind> = map_requests(scene, &settings.maps).into_iter().map(|(kind, _)| kind).collect();
    let mut error = ladder.first_error;
    let mut taken = TakenTogether::default();
    let mut best: Option<Solution> = None;
    loop {
        let mut solution = solve(&Settings { target_error: Some(error), chains: None, ..settings.clone() })?;
        taken.add(&mut solution, error);
        let is_cut_short = matches!(solution.stop_reason, StopReason::TimeLimit | StopReason::Interrupted);
        if is_cut_short && let Some(before) = best.take_if(|before| before.estimated_error < solution.estimated_error) {
            solution = Solution { stop_reason: solution.stop_reason, ..before };
        }
        let mut found = verdicts(scene, &solution);
        found.retain(|verdict| requested.contains(&MapKind::Receivers(verdict.set)));
        let look = taken.errors.len() as u32;
        let open: Vec<&Verdict> = found.iter().filter(|verdict| is_open(verdict, look)).collect();
        let ends = is_cut_short || matches!(solution.stop_reason, StopReason::Exact | StopReason::FinestMesh);
        if open.is_empty() || ends || error <= ladder.least_error {
            let is_decided = found.iter().all(|verdict| verdict.ruling() != Ruling::Undecided);
            if !ends {
                let [yes, no] = [StopReason::VerdictsDecided, StopReason::Undecided];
                solution.stop_reason = if is_decided { yes } else { no };
            }
            solution.target_met = Some(is_decided);
            taken.tell(&mut solution);
            return Ok(solution);
        }
        let step = open.iter().map(|verdict| step_of(verdict)).fold(STEP[1], f64::min);
        error = (step.max(STEP[0]) * error).max(ladder.least_error);
        best = Some(solution);
    }
}

impl TakenTogether {
    /// Adds a run. The counts in its convergence rows continue from the runs before.
    fn add(&mut self, solution: &mut Solution, error: f64) {
        for row in &mut solution.convergence {
            row.rays += self.rays;
            row.chains += self.chains;
            row.forecast_rays = row.forecast_rays.plus_alike(Forecast::known(self.rays as f64));
        }
        self.errors.push(format!("{:.2} %", 100.0 * error));
        self.rays += solution.rays;
        self.chains += solution.chains;
        self.compute_s += solution.compute_s;
        self.spending += solution.spending;
    }

    /// Writes the totals of all runs into the last solution.
    fn tell(self, solution: &mut Solution) {
        let runs = match self.errors.len() {
            1 => "a run".to_owned(),
            count => format!("{count} runs"),
        };
        solution
            .notes
            .push(format!("{runs} to stated errors of {} tried to decide the verdicts", self.errors.join(", ")));
        (solution.rays, solution.chains) = (self.rays, self.chains);
        (solution.compute_s, solution.spending) = (self.compute_s, self.spending);
    }
}

/// Whether a longer run may decide what this look does not.
fn is_open(verdict: &Verdict, look: u32) -> bool {
    match &verdict.finding {
        Finding::Value { certainty, is_reliable, .. } => !is_reliable || !is_decided_at_look(certainty, look),
        Finding::BelowScale | Finding::Nothing(_) => false,
    }
}

/// Ratio of the error at which a value would be far enough from its limit to the present error.
fn step_of(verdict: &Verdict) -> f64 {
    match &verdict.finding {
        Finding::Value { estimate, .. } if estimate.standard_error > 0.0 => {
            (estimate.value - verdict.requirement.limit).abs() / (ERRORS_OFF * estimate.standard_error)
        }
        _ => STEP[1],
    }
}
