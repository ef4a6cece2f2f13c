//! Exit codes and what stands behind them.

use std::process::ExitCode;

use crate::analytic::AnalyticError;
use crate::light_mesh::NotForLightMesh;
use crate::output::{OutputError, SealedError};
use crate::radiosity::NotARoom;
use crate::scene::SceneError;
use crate::scene::photometry::PhotometricError;
use crate::validation::CaseError;
use crate::year::NotForYear;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// 0: done; the target is met where one was set.
    Done,
    /// 1: a validation case failed; the report was written.
    CaseFailed,
    /// 2: bad usage or bad input; nothing was written.
    Refused,
    /// 3: a limit ended the run before the target was met; results were written.
    TargetMissed,
    /// 4: results could not be written.
    Unwritten,
    /// 130: interrupted; results were written.
    Interrupted,
}

impl Exit {
    /// The process's exit code.
    pub fn number(self) -> u8 {
        match self {
            Exit::Done => 0,
            Exit::CaseFailed => 1,
            Exit::Refused => 2,
            Exit::TargetMissed => 3,
            Exit::Unwritten => 4,
            Exit::Interrupted => 130,
        }
    }

    /// The same as the standard library wants it.
    pub fn code(self) -> ExitCode {
        ExitCode::from(self.number())
    }
}

/// Why a command could not do what it was asked to.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A scene file, or a file that it names, was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A validation case was refused.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// A photometric file was refused.
    #[error(transparent)]
    Photometric(#[from] PhotometricError),
    /// A question that an exact solution has no answer for.
    #[error(transparent)]
    Analytic(#[from] AnalyticError),
    /// A scene that radiosity cannot compute.
    #[error(transparent)]
    NotARoom(#[from] NotARoom),
    /// A scene that light meshes cannot compute.
    #[error(transparent)]
    NotForLightMesh(#[from] NotForLightMesh),
    /// A scene that has no year.
    #[error(transparent)]
    NotForYear(#[from] NotForYear),
    /// Shares that cannot be merged, or a checkpoint that no run can go on from.
    #[error(transparent)]
    Sealed(#[from] SealedError),
    /// Options that do not go together, or not with the scene.
    #[error("{what}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}")]
    Usage {
        /// What is wrong.
        what: String,
        /// What was given.
        got: String,
        /// What could have been given.
        expected: String,
        /// What to do.
        remedy: String,
    },
    /// A study that found no case, scene or room for them.
    #[error(
        "the study \"{name}\" cannot be run: {why}\n  needs:    luxmc's folder to be run in, and room in the temporary folder (TMPDIR names another)"
    )]
    Study {
        /// The study.
        name: &'static str,
        /// What went wrong.
        why: String,
    },
    /// Results could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The standard output did not take what was asked for.
    #[error("cannot write to the standard output: {0}\n  remedy:   look where it is redirected to")]
    StandardOutput(std::io::Error),
}

impl Failure {
    /// How the program ends on it.
    pub fn exit(&self) -> Exit {
        match self {
            Failure::Scene(_)
            | Failure::Case(_)
            | Failure::Photometric(_)
            | Failure::Analytic(_)
            | Failure::NotARoom(_)
            | Failure::NotForLightMesh(_)
            | Failure::NotForYear(_)
            | Failure::Sealed(_)
            | Failure::Usage { .. }
            | Failure::Study { .. } => Exit::Refused,
            Failure::Output(_) | Failure::StandardOutput(_) => Exit::Unwritten,
        }
    }
}
