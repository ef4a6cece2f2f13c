//! `luxmc schema`: the JSON Schema of the scene file.

use super::exit::Exit;
use super::{Outcome, console};
fn scene_schema() -> serde_json::Value { todo!() }

/// Prints the schema.
pub fn run() -> Outcome {
    console::result(&format!("{:#}\n", scene_schema()))?;
    Ok(Exit::Done)
}
