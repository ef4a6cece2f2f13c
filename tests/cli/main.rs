//! The program as its users see it.

#[path = "../cli_support/mod.rs"]
mod cli_support;

mod budgets;
mod checkpoints;
mod commands;
mod convert;
mod hostile_shares;
mod kills;
mod limits;
mod pages;
mod result_directory;
mod shares;
mod solve;
