//! The proving ground: rooms by rule, and what `auto` comes to in them beside long runs of walks.
//!
//! Every room is made from a kind and a seed (`rooms`), a long run of walks stands for its truth (`reference`), runs with many seeds
//! are held against it (`campaign`, `judgement`), and rules of statistics accept them or not (`acceptance`).

mod acceptance;
mod campaign;
mod cpu;
mod judgement;
mod patient;
mod pictures;
mod reference;
mod report;
mod rival;
mod rival_scene;
pub mod rooms;
mod summary;

use std::path::{Path, PathBuf};

pub use acceptance::failures;
pub use campaign::{MapProof, Proof, ProofSettings, RoomProof, RunProof, prove};
pub use judgement::RoomJudgement;
pub use reference::{Cost, ReferenceSettings};
pub use report::{proof_csv, proof_html, proof_md, proof_pictures, proof_table};
pub use rival::Rival;

use super::error::CaseError;
use crate::check::read_scene;
use crate::scene::Scene;
use rooms::{Room, SCENE_FILE};

/// The scene of a room. The files that its scene names stand in a temporary folder for a moment.
///
/// # Errors
///
/// A room that the reader refuses, a disk that is full.
pub fn scene_of(room: &Room) -> Result<Scene, CaseError> {
    let what = "a room of the proving ground cannot be read";
    let path = PathBuf::from(room.name());
    let refuse = |error: std::io::Error| error_of(&path, what, &error.to_string());
    let folder = tempfile::tempdir().map_err(refuse)?;
    for file in &room.files {
        std::fs::write(folder.path().join(&file.name), &file.text).map_err(refuse)?;
    }
    let scene_path = folder.path().join(SCENE_FILE);
    std::fs::write(&scene_path, &room.scene).map_err(refuse)?;
    read_scene(&scene_path).map_err(|error| error_of(&path, what, &error.to_string()))
}

fn error_of(path: &Path, what: &str, got: &str) -> CaseError {
    let expected = "a folder that can be written, and rooms that can be read";
    CaseError::new(path, what, got, expected, "name another folder, or make room on the disk")
}
