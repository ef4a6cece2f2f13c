//! A perfectly flat mirror.

use super::{LobeKind, Reflection, Scattered, mirrored};
use crate::sampling::random::Stream;
use glam::DVec3;

/// Reflects only into the mirror direction, with the same reflectance at every angle.
#[derive(Clone, Copy, Debug)]
pub struct Mirror {
    /// Reflectance, 0 to 1.
    pub reflectance: f64,
}

impl Reflection for Mirror {
    fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        stream
            .happens(self.reflectance)
            .then(|| Scattered { direction: mirrored(direction, normal), lobe: LobeKind::Mirrored })
    }

    fn total(&self, _: f64) -> f64 {
        self.reflectance
    }

    fn is_specular(&self) -> bool {
        true
    }

    fn mirror_share(&self, _: f64) -> f64 {
        self.reflectance
    }

    fn is_mirror(&self) -> bool {
        self.reflectance > 0.0
    }
}
