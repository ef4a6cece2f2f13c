//! `luxmc schema`: the JSON Schema of the scene file.

use super::exit::Exit;
use super::{Outcome, console};
use crate::scene::scene_schema;

/// Prints the schema.
pub fn run() -> Outcome {
    console::result(&format!("{:#}\n", scene_schema()))?;
    Ok(Exit::Done)
}
