//! Whole runs in rooms whose light is known: maps of elements and receivers against exact truths.

#[path = "../cli_support/mod.rs"]
mod cli_support;
#[path = "../common/mod.rs"]
mod common;

mod adaptive;
mod gather;
mod hard_cases;
mod harmonics;
mod images;
mod leaks;
mod maps_of_known_rooms;
mod materials;
mod radiosity;
mod surface_tables;
mod uneven_sets;
