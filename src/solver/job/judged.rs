//! What follows from the judgement of a job, whether the job made its samples itself or shares of a run made them.

use super::{Engine, Job};
use crate::control::statistical_checks;
use crate::maps::{MapKind, PACKETS_OF_A_BOUND, PastJudgement, ScoreEvidence};
use crate::solver::context::Context;
use crate::solver::local::Kernel;

impl Job {
    /// Sets an upper bound on the error where direct light is known but no light has been reflected yet: what N chains have not found is
    /// below 3/N.
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
            squared_error: (self.judgement.expected_error * self.judgement.mean).powi(2),
            degrees_of_freedom: self.judgement.degrees_of_freedom,
            means: self.judgement.means,
        });
    }

    /// Evidence from single scores, of direct light and of indirect light.
    pub(super) fn score_parts(&self) -> [ScoreEvidence; 2] {
        let [mut direct, _] = self.map.score_evidence();
        let [_, mut indirect] = self.gathered().score_evidence();
        // Distributions with an upper bound look like a heavy tail where entries of many sizes are pooled. This holds for answers of cells,
        // for the bounded kernel, and for direct light at points. There the difference to the expectation is limited: to the unshadowed
        // light of an emitter over its share of the light samples.
        if matches!(self.engine, Engine::Gather | Engine::Local(Kernel::Bounded)) {
            indirect.shape = None;
        }
        if matches!(self.kind, MapKind::Receivers(_)) {
            direct.shape = None;
        }
        [direct, indirect]
    }

    /// Runs the statistical checks on the present judgement. Returns whether all pass. Keeps their findings, and the samples at which a
    /// check first refused.
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
