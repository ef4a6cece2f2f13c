//! `luxmc sobolev`
use super::{Outcome, exit::Exit};
#[derive(Debug, clap::Args)]
pub struct SobolevArguments { #[arg(long, value_parser=super::values::distances)] r: super::values::Distances }
pub fn run(_: &SobolevArguments) -> Outcome { Ok(Exit::Done) }
