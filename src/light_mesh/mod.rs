//! Light meshes: the visibility of the luminaires is computed at the points of a regular mesh and averaged near each receiver.
//!
//! After Debelov and Sevastyanov (2001, "An original approach to simulation of soft shadows and diffuse color bleeding in ray tracing") and
//! Debelov and Novikov (2009, "Soft shadow generation via recursive ray tracing").

mod anew;
pub mod classes;
mod complete;
mod entries;
mod error;
pub mod exact;
mod eye;
mod fit;
mod harmonics;
mod indirect;
pub mod judge;
mod lattice;
mod lines_of_sight;
mod mesh;
mod options;
mod plan;
mod plan_indirect;
mod result;
mod samples;
mod solids;
mod sparse;
mod template;
pub mod tracing;
mod walks;

pub use complete::Rounds;
pub use entries::Entries;
pub use error::{NotForLightMesh, check};
pub use indirect::{GatherCounts, GatherRoom, Gathering, IndirectMesh};
pub use lattice::{Index, Lattice};
pub use mesh::{Counts, LightMesh, MeshLight, SetKind, Surroundings, Workroom};
pub use options::{
    Accelerations, IndirectForm, LEAST_RADIUS_PER_STEP, MOST_RADIUS_PER_STEP, NEVER, Options, RADIUS_PER_STEP, Stop,
};
pub use plan::{DirectPlan, IndirectPlan, MapPlan, Planner, Why, Wishes};
pub use result::{MeshFacts, TracedMap};
pub use samples::{SamplePlacing, Samples};
pub use solids::{Solids, Walls};
