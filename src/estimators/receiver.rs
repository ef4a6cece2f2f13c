//! Receivers of light.

use glam::DVec3;

use crate::geometry::Origin;

/// A point that receives light.
#[derive(Clone, Copy)]
pub struct Receiver<'a> {
    /// Point in m.
    pub point_m: DVec3,
    /// Unit normal of the receiving side.
    pub normal: DVec3,
    /// The same point for the tracer.
    pub origin: &'a Origin,
}
