//! Options of a light mesh, and numbers for its check.

/// Number of points at which direct light is computed again.
pub const DIRECT_PLACES: usize = 1024;
/// Part of the target that direct light may use if there is indirect light, which gets the rest. The squares add up to that of the whole.
pub(super) const SHARE_OF_DIRECT: f64 = 0.6;
/// Part of the target that all light may use. The last check has its own random error.
pub(super) const SHARE_OF_ALL: f64 = 0.9;
/// Walks in each half from a checked point, for the first mesh.
pub(super) const FIRST_CHECK_WALKS: u64 = 256;
/// Walks from a receiver point in the only round, after the run has been ended.
pub(super) const HURRIED_PLACE_WALKS: u32 = 4;

/// Whether a limit or the user has ended the run.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// A stop condition that never ends a run.
pub const NEVER: Stop<'static> = &|| false;

/// Accelerations. Each can be switched off; its comment states how this changes the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accelerations {
    /// A tree over the triangles (MU1). It does not change the result.
    pub tree: bool,
    /// Templates of mesh points within the radius of each sub-cell (MU2). They do not change the result.
    pub templates: bool,
    /// If all outer points of a set are visible, its inner points are assumed to be visible (MU3). This includes inner points hidden by an
    /// object smaller than the radius.
    pub outer_first: bool,
    /// The parity of a ray's crossings marks mesh points inside solids (MU4). Local visibility is tested only near open surfaces and walls
    /// thinner than the radius. This includes points around the corner of a thicker solid.
    pub inside_flags: bool,
}

impl Accelerations {
    /// All accelerations.
    pub const ALL: Accelerations = Accelerations { tree: true, templates: true, outer_first: true, inside_flags: true };
    /// The tree alone, the starting point of the papers' comparisons.
    pub const TREE_ALONE: Accelerations =
        Accelerations { tree: true, templates: false, outer_first: false, inside_flags: false };
}

/// Form in which a mesh point stores indirect light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndirectForm {
    /// One number, the light from all sides. A surface gets a quarter of it, whatever its orientation (Debelov and Sevastyanov).
    Scalar,
    /// Spherical harmonics of low order, which depend on direction.
    Directional,
}

/// Settings of a light mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Distance between neighbouring mesh points in m.
    pub step_m: f64,
    /// Radius of the averaged sets, in m.
    pub radius_m: f64,
    /// Accelerations to use.
    pub accelerations: Accelerations,
}

/// Default ratio of radius to step. Over a vertical or horizontal plane no set is empty from √1.5 on. Wider sets blur shadows for the same
/// number of mesh points (the papers use 2.1 and 3.1 for smooth pictures).
pub const RADIUS_PER_STEP: f64 = 1.25;
/// Largest ratio of radius to step: sets of about 4,000 points.
pub const MOST_RADIUS_PER_STEP: f64 = 10.0;
/// Least ratio of radius to step: every cell's centre is within √3/2 of a corner in front of any plane through it.
pub const LEAST_RADIUS_PER_STEP: f64 = 0.9;
