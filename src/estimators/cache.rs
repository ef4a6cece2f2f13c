//! A cache that walks ask on their way, and what they tell it.

use glam::DVec3;

use crate::chain::LookBack;
use crate::estimators::receiver::Receiver;
use crate::geometry::SurfaceHit;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;

/// What the cache answers where a walk meets a diffuse surface, and what the walk does then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CacheAnswer {
    /// Nothing is known: the walk goes on by itself.
    Nothing,
    /// The walk ends: this indirect illuminance in lx stands for the rest of it.
    End(f64),
    /// The walk ends without a look: who asked wants the place alone.
    Stop,
}

/// A diffuse surface that a walk met.
pub struct Met<'a> {
    /// Where.
    pub hit: &'a SurfaceHit,
    /// The place on the side that the walk came from.
    pub receiver: Receiver<'a>,
    /// Unit direction of the walk's ray.
    pub direction: DVec3,
    /// Reflectance.
    pub reflectance: f64,
    /// Whether the walk's first ray led straight here, without a pane on its way.
    pub is_first: bool,
}

/// A cache that walks ask, as in final gathering: it may know the indirect light of a diffuse surface, and the direct light too.
pub trait Cache {
    /// What is known at a diffuse surface, and the rays that asking took.
    fn look_up(&mut self, met: &Met, cut: &mut Cut, stream: &mut Stream) -> (CacheAnswer, u64);

    /// Hears what the walk does, where that is of use.
    #[inline]
    fn told(&mut self, _: &WalkEvent) {}
}

/// What a walk tells of its way.
pub enum WalkEvent<'a> {
    /// It goes on from a diffuse surface: with this weight, after what it has summed up and the rays it has taken.
    GoesOn {
        /// What the rest of the walk is multiplied by.
        weight: f64,
        /// What it has found, in lm/m².
        sum_lm_m2: f64,
        /// Its rays.
        rays: u64,
    },
    /// A look from the first surface that it met found a near luminaire.
    FoundNear {
        /// Which emitter.
        emitter: u32,
        /// What leaves the surface of its light, in lm/m².
        lm_m2: f64,
        /// The part of it that counts, in lm/m², since looking back finds the rest.
        counted_lm_m2: f64,
    },
    /// It looked back from a packet of a near luminaire.
    LookedBack {
        /// What that is multiplied by.
        weight: f64,
        /// What it found.
        found: &'a LookBack,
    },
}
