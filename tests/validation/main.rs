//! Validation cases, stored runs, the proving ground and UGR tables.

#[path = "../cli_support/mod.rs"]
mod cli_support;

mod cases;
mod faults;
mod proving_ground;
mod stored_run;
mod ugr_table;
