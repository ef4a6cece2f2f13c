//! Light sources: luminaires, their files, skies and the sun, against closed forms and numbers calculated by hand.

#[path = "../common/mod.rs"]
mod common;

mod all_kinds;
mod box_openings;
mod daylight;
mod hidden_lamps;
mod intensity;
mod near_field;
mod near_luminaires;
mod photometric_files;
mod selection_by_cell;
mod sun;
mod year;
