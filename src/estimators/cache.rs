//! A cache that walks query on their path, and the events that walks report to it.

use glam::DVec3;

use crate::estimators::receiver::Receiver;
use crate::geometry::SurfaceHit;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::transport::{PacketConnection, Traced};

/// Answer of the cache at a diffuse surface that a walk met. It determines what the walk does next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CacheAnswer {
    /// Nothing is known: the walk continues by itself.
    Nothing,
    /// The walk ends. This indirect illuminance in lx replaces the rest of it.
    End(f64),
    /// The walk ends without a light sample: the caller needs only the surface point.
    Stop,
}

/// A diffuse surface that a walk met.
pub struct Met<'a> {
    /// The hit point.
    pub hit: &'a SurfaceHit,
    /// The point on the side from which the walk came.
    pub receiver: Receiver<'a>,
    /// Unit direction of the walk's ray.
    pub direction: DVec3,
    /// Reflectance.
    pub reflectance: f64,
    /// Whether the walk's first ray led straight here, without a pane on its way.
    pub is_first: bool,
}

/// A cache that walks query, as in final gathering. It may supply the indirect light of a diffuse surface, and the direct light too.
pub trait Cache {
    /// Whether it supplies light, so that walks end at the first diffuse surface. Sheets before it then make no connections to packets of
    /// near luminaires, whose light the cache contains.
    const SUPPLIES: bool = false;

    /// What is known at a diffuse surface, and the number of rays that the query took.
    fn look_up(&mut self, met: &Met, cut: &mut Cut, stream: &mut Stream) -> (CacheAnswer, u64);

    /// Receives an event of the walk. The default ignores it.
    #[inline]
    fn observe(&mut self, _: &WalkEvent) {}
}

/// An event that a walk reports.
pub enum WalkEvent<'a> {
    /// The walk continues from a diffuse surface.
    GoesOn {
        /// Factor on the rest of the walk.
        weight: f64,
        /// Light found before in lm/m², and rays traced before.
        before: Traced,
    },
    /// A light sample from the first surface that the walk met found a near luminaire.
    FoundNear {
        /// Number of the emitter.
        emitter: u32,
        /// Its light that leaves the surface, in lm/m².
        lm_m2: f64,
        /// The part of that light that counts, in lm/m². The light-path connection finds the rest.
        counted_lm_m2: f64,
    },
    /// The walk made a light-path connection to a packet of a near luminaire.
    Connected {
        /// Factor on the result.
        weight: f64,
        /// Result of the connection.
        found: &'a PacketConnection,
    },
}
