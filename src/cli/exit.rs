//! Exit codes and the failures that cause them.

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
    /// 0: done; the target, if one was set, is met.
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

    /// The same number as the standard library's type.
    pub fn code(self) -> ExitCode {
        ExitCode::from(self.number())
    }
}

/// The reason why a command could not do its work.
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
    /// An exact solution has no answer to the question.
    #[error(transparent)]
    Analytic(#[from] AnalyticError),
    /// Radiosity cannot compute the scene.
    #[error(transparent)]
    NotARoom(#[from] NotARoom),
    /// Light meshes cannot compute the scene.
    #[error(transparent)]
    NotForLightMesh(#[from] NotForLightMesh),
    /// A year cannot be computed for the scene.
    #[error(transparent)]
    NotForYear(#[from] NotForYear),
    /// Shares cannot be merged, or no run can resume from the checkpoint.
    #[error(transparent)]
    Sealed(#[from] SealedError),
    /// Options contradict each other or the scene.
    #[error("{what}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}")]
    Usage {
        /// What is wrong.
        what: String,
        /// What was given.
        got: String,
        /// What was expected.
        expected: String,
        /// The remedy.
        remedy: String,
    },
    /// A study lacks one of its cases, a scene, or room for its files.
    #[error(
        "the study \"{name}\" cannot be run: {why}\n  needs:    luxmc's folder as the working directory, and space \
         in the temporary folder (TMPDIR names another)"
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
    /// The results could not be written to the standard output.
    #[error("cannot write to the standard output: {0}\n  remedy:   check where it is redirected to")]
    StandardOutput(std::io::Error),
}

impl Failure {
    /// The way in which the program ends on this failure.
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
