//! What receives light.

use glam::DVec3;

use crate::geometry::Origin;

/// A point that receives light.
#[derive(Clone, Copy)]
pub struct Receiver<'a> {
    /// Place in m.
    pub point_m: DVec3,
    /// Unit normal of the receiving side.
    pub normal: DVec3,
    /// The same place for the tracer.
    pub origin: &'a Origin,
}
