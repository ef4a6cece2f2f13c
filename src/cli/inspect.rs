//! `luxmc inspect`
use super::{Outcome, exit::Exit};
#[derive(Debug, clap::Args)]
pub struct InspectArguments { scene: std::path::PathBuf }
pub fn run(_: &InspectArguments) -> Outcome { Ok(Exit::Done) }
