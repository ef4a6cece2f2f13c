//! Why a scene is not for radiosity.

use thiserror::Error;

/// What of a scene radiosity cannot compute.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("--method radiosity cannot compute {what}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}")]
pub struct NotARoom {
    /// What it cannot compute, in words.
    pub what: String,
    /// What stands there.
    pub got: String,
    /// What it takes.
    pub expected: String,
    /// What to do about it.
    pub remedy: String,
}

/// A refusal; the method of chains computes every scene.
pub(super) fn refuse<T>(what: &str, got: String, expected: &str) -> Result<T, NotARoom> {
    Err(NotARoom {
        what: what.to_owned(),
        got,
        expected: expected.to_owned(),
        remedy: "use --method collision, which computes every scene".to_owned(),
    })
}

/// What is said where time is over before there is anything to show.
pub(super) fn out_of_time() -> NotARoom {
    NotARoom {
        what: "the room in the time given".to_owned(),
        got: "a time limit that passed before the three coarsest meshes were solved".to_owned(),
        expected: "time for these, which grows with the number of luminaires".to_owned(),
        remedy: "grant more time, or use --method collision, which shows something sooner".to_owned(),
    }
}
