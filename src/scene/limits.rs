//! Most that the few bytes of a scene file may ask for, of what takes memory and time by its number.
//!
//! Fuzz targets (`cfg(fuzzing)`) have limits of their own: with those of a run most of an execution would go into making
//! points and triangles, and none of it into reading. `tests/fights_back.rs` holds the limits of runs.

/// One of two limits, by what is built.
const fn either(run: u64, fuzzing: u64) -> u64 {
    if cfg!(fuzzing) { fuzzing } else { run }
}

/// Points of all grids, fans and views of a scene together: the sums of a run take some hundred bytes for each.
pub(super) const MOST_POINTS: u64 = either(4_000_000, 400);
/// Luminaires of a scene with arrays.
pub(super) const MOST_LUMINAIRES: u64 = either(1_000_000, 400);
/// Triangles of all spheres of a scene together.
pub(super) const MOST_SPHERE_TRIANGLES: f64 = either(2_000_000, 1_000) as f64;
/// Divisions of an icosahedron's edge, where nothing asks for finer ones: 5120 triangles.
pub(super) const SPHERE_FREQUENCY: u32 = either(16, 2) as u32;
/// Divisions of the finest sphere: some 2 million triangles.
pub(super) const MOST_SPHERE_FREQUENCY: u32 = either(316, 6) as u32;
/// Triangles, and vertices apart from each other, of a mesh file that may ask for many with few bytes.
pub(super) const MOST_MESH_TRIANGLES: usize = either(33_554_432, 10_000) as usize;
/// Vertices and corners that are looked at for them: instances look at theirs again.
pub(super) const MOST_MESH_READS: usize = either(1 << 28, 100_000) as usize;
/// Most corners of a face: the time to cut it into triangles grows with the cube of their number.
pub(super) const MOST_CORNERS: usize = 1024;
