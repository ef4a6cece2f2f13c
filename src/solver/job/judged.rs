//! What becomes of a job's judgement, whether it made its samples itself or shares did.

use super::{Engine, Job, PACKETS_OF_A_BOUND};
use crate::control::statistical_checks;
use crate::maps::{MapKind, PastJudgement, ScoreEvidence};
use crate::solver::context::Context;
use crate::solver::local::Kernel;

impl Job {
    /// Direct light is known but nothing has bounced yet: what N chains have not found is below 3/N.
    pub(super) fn bound_unseen(&mut self, context: &Context, chains: u64) {
        if !self.judgement.unseen || self.judgement.dark || self.engine == Engine::Gather {
            return;
        }
        let bound = PACKETS_OF_A_BOUND / chains as f64 * self.flux_over_map(context);
        self.judgement.halves_error = self.judgement.halves_error.max(bound);
        self.judgement.expected_error = self.judgement.expected_error.max(bound);
        self.judgement.unseen = false;
    }

    /// Adds the judgement to the history that the statistical checks compare it with.
    pub(super) fn note_judgement(&mut self) {
        self.looks.history.add(PastJudgement {
            samples: self.samples,
            rays: self.work.rays,
            squared_error: (self.judgement.expected_error * self.judgement.mean_lx).powi(2),
            degrees_of_freedom: self.judgement.degrees_of_freedom,
            means_lx: self.judgement.means_lx,
        });
    }

    /// What single scores say of direct light and of indirect.
    pub(super) fn score_parts(&self) -> [ScoreEvidence; 2] {
        let [mut direct, _] = self.map.score_evidence();
        let [_, mut indirect] = self.gathered().score_evidence();
        // Laws that have an end look like a tail where entries of many sizes are pooled: what cells answer, the bounded kernel, and direct
        // light at points, which differs from what is expected by no more than an emitter brings unshadowed over its share of the looks.
        if matches!(self.engine, Engine::Gather | Engine::Local(Kernel::Bounded)) {
            indirect.shape = None;
        }
        if matches!(self.kind, MapKind::Receivers(_)) {
            direct.shape = None;
        }
        [direct, indirect]
    }

    /// Runs the statistical checks on what has been judged; whether all pass. Keeps what they found, and the samples at which one
    /// first refused.
    pub fn run_checks(&mut self, target_error: Option<f64>) -> bool {
        let parts = self.score_parts();
        self.looks.checks =
            statistical_checks(&self.looks.history, parts, &self.judgement, self.looks.held_since, target_error);
        let all_pass = self.looks.checks.iter().all(|check| check.passed);
        if !all_pass {
            self.looks.held_since.get_or_insert(self.samples);
        }
        all_pass
    }
}
