//! Checks of a mesh or a whole scene, and advice. The checks examine the whole scene, also along straight lines.
//!
//! Every part of the program gets a [`crate::Scene`] from [`read_scene`]. `scene` reads what is written, value by value. This room refuses
//! what cannot be computed, marks points inside of solids, finds the openings to the sky, and warns. It works in f64 on triangles within a
//! budget of steps. It does not depend on light transport or results.

mod advice;
mod advice_openings;
mod box_tree;
mod by_number;
mod coplanar;
mod faults;
mod fitted_openings;
mod harmonic_fit;
mod insides;
mod inspect;
mod inspect_bodies;
mod mesh_faults;
mod open_rooms;
mod overlaps;
mod proportions;
mod read;
mod rooms_outward;
mod shells;
mod skipped;
mod sky_openings;
mod straight;
mod t_junctions;
mod walls;
mod warnings;
mod whiteness;
mod winding;
#[cfg(test)]
mod work_tests;

pub use advice::BURIED;
pub(crate) use advice::luminaires_aimed_at_backs;
pub(crate) use advice_openings::luminaires_behind_surfaces;
pub use faults::{Faults, Hole, KindOfFault, MeshFaults};
pub use harmonic_fit::{HarmonicFit, NoFit, fit_harmonics};
pub use insides::all_luminaires_are_shut_in;
pub use inspect::{
    InspectedLuminaire, InspectedReceivers, InspectedShell, InspectedSurface, InspectedTotals, InspectedUnits,
    Inspection, inspect, inspect_surfaces,
};
pub use inspect_bodies::InspectedBody;
pub use proportions::{Proportions, Trust};
pub use read::{read_and_inspect, read_scene, scene_from_json};
pub use shells::{Shell, closed_shells_of_geometries, shells_of_scene};
pub use skipped::{MeshCheck, skip_checks};
