//! Limits of what the few bytes of a scene file may request, where the number costs memory and time.
//!
//! Fuzz targets (`cfg(fuzzing)`) have their own limits. With the limits of a run most of an execution would make points and triangles
//! instead of reading. `tests/fights_back.rs` checks the limits of runs.

/// Picks one of two limits, for a normal build or for fuzzing.
const fn either(run: u64, fuzzing: u64) -> u64 {
    if cfg!(fuzzing) { fuzzing } else { run }
}

/// Points of all grids, fans and views of a scene together. The sums of a run take some hundred bytes per point.
pub(super) const MOST_POINTS: u64 = either(4_000_000, 400);
/// Luminaires of a scene, including arrays.
pub(super) const MOST_LUMINAIRES: u64 = either(1_000_000, 400);
/// Triangles of all spheres of a scene together.
pub(super) const MOST_SPHERE_TRIANGLES: f64 = either(2_000_000, 1_000) as f64;
/// Default number of divisions of an icosahedron's edge: 5120 triangles.
pub(super) const SPHERE_FREQUENCY: u32 = either(16, 2) as u32;
/// Divisions for the finest sphere: some 2 million triangles.
pub(super) const MOST_SPHERE_FREQUENCY: u32 = either(316, 6) as u32;
/// Triangles, or distinct vertices, of a mesh file. Such a file may request many with few bytes.
pub(super) const MOST_MESH_TRIANGLES: usize = either(33_554_432, 10_000) as usize;
/// Vertices and corners that a mesh file may make the reader read. Each instance reads its own again.
pub(super) const MOST_MESH_READS: usize = either(1 << 28, 100_000) as usize;
/// Most corners of a face. The time to cut it into triangles grows with the cube of their number.
pub(super) const MOST_CORNERS: usize = 1024;
