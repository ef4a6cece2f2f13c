//! A perfectly flat mirror.

use super::{Scattered, Way, mirrored};
use crate::sampling::random::Stream;
use glam::DVec3;

/// Reflects into the mirror direction alone, alike at every angle.
#[derive(Clone, Copy, Debug)]
pub struct Mirror {
    /// Reflectance, 0 to 1.
    pub reflectance: f64,
}

impl Mirror {
    /// See [`super::Law::sample`].
    pub fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        stream
            .happens(self.reflectance)
            .then(|| Scattered { direction: mirrored(direction, normal), way: Way::Mirrored })
    }

    /// See [`super::Law::total`].
    pub fn total(&self) -> f64 {
        self.reflectance
    }
}
