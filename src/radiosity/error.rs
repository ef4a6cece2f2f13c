//! Reasons why radiosity refuses a scene.

use thiserror::Error;

/// The part of a scene that radiosity cannot compute.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("--method radiosity cannot compute {what}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}")]
pub struct NotARoom {
    /// What radiosity cannot compute, in words.
    pub what: String,
    /// What the scene contains.
    pub got: String,
    /// What radiosity accepts.
    pub expected: String,
    /// What the user can do about it.
    pub remedy: String,
}

/// Returns a refusal that points to the method of chains, which computes every scene.
pub(super) fn refuse<T>(what: &str, got: String, expected: &str) -> Result<T, NotARoom> {
    Err(NotARoom {
        what: what.to_owned(),
        got,
        expected: expected.to_owned(),
        remedy: "use --method collision, which computes every scene".to_owned(),
    })
}

/// The refusal when the time is over before there is any result.
pub(super) fn out_of_time() -> NotARoom {
    NotARoom {
        what: "the room within the time limit".to_owned(),
        got: "a time limit that passed before the three coarsest meshes were solved".to_owned(),
        expected: "time for these meshes; it grows with the number of luminaires".to_owned(),
        remedy: "allow more time, or use --method collision, which gives first results sooner".to_owned(),
    }
}
