//! Stated errors and what depends on them: stop rule, forecast, checks, choice of method, shares, verdicts.

#[path = "../cli_support/mod.rs"]
mod cli_support;
#[path = "../common/mod.rs"]
mod common;

mod checkpoints;
mod choice;
mod forecasts;
mod shares;
mod statistical_checks;
mod verdicts;
