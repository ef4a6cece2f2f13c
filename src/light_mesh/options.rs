//! What a light mesh is made with, and by how much it is checked.

/// Places at which direct light is computed again.
pub const DIRECT_PLACES: usize = 1024;
/// Part of the target that direct light may use where there is indirect light too, which gets what is left; squares add up.
pub(super) const SHARE_OF_DIRECT: f64 = 0.6;
/// Part of the target that all light may use: the last check has its own chance.
pub(super) const SHARE_OF_ALL: f64 = 0.9;
/// Walks from a checked place in each half, for the first mesh.
pub(super) const FIRST_CHECK_WALKS: u64 = 256;
/// Walks from a place in the only round, after the run has been ended.
pub(super) const HURRIED_PLACE_WALKS: u32 = 4;

/// Whether a limit or the user has ended the run.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// Where nothing ends a run.
pub const NEVER: Stop<'static> = &|| false;

/// What saves time; each can be switched off, and then changes what is stated beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accelerations {
    /// A tree over the triangles (MU1). Changes nothing.
    pub tree: bool,
    /// Templates of points within the radius of each sub-cell (MU2). Changes nothing.
    pub templates: bool,
    /// Where all outer points of a set are seen, its inner ones are taken to be (MU3). Lets in an inner point that a
    /// thing smaller than the radius hides.
    pub outer_first: bool,
    /// Points inside of solids are told by the parity of a ray's crossings (MU4), and local visibility is tested only near
    /// open surfaces and walls thinner than the radius. Lets in points round the corner of a thicker solid.
    pub inside_flags: bool,
}

impl Accelerations {
    /// All of them.
    pub const ALL: Accelerations = Accelerations { tree: true, templates: true, outer_first: true, inside_flags: true };
    /// The tree alone, which the papers' comparisons start from.
    pub const TREE_ALONE: Accelerations =
        Accelerations { tree: true, templates: false, outer_first: false, inside_flags: false };
}

/// What a mesh point keeps of indirect light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndirectForm {
    /// One number, the light from all sides: a surface gets a quarter of it, whichever way it faces (Debelov and
    /// Sevastyanov).
    Scalar,
    /// Spherical harmonics of low order, which know directions.
    Directional,
}

/// How a light mesh is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Distance of neighbouring points in m.
    pub step_m: f64,
    /// Radius of the sets that are averaged, in m.
    pub radius_m: f64,
    /// What saves time.
    pub accelerations: Accelerations,
}

/// Radius over step where nothing else is asked for: over an upright or level plane no set is empty from √1.5 on, and
/// wider sets blur shadows for the same number of points (the papers use 2.1 and 3.1 for smooth pictures).
pub const RADIUS_PER_STEP: f64 = 1.25;
/// Radius over step at most: sets of some 4,000 points.
pub const MOST_RADIUS_PER_STEP: f64 = 10.0;
/// Radius over step at least: every cell's middle is within √3/2 of a corner in front of any plane through it.
pub const LEAST_RADIUS_PER_STEP: f64 = 0.9;
