//! What estimates the indirect light of a map.

use serde::{Deserialize, Serialize};

use crate::maps::MapKind;
use crate::scene::Scene;
use crate::solver::Method;
use crate::solver::local::Kernel;

/// What estimates the indirect light of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Engine {
    /// Packets of chains are counted on elements.
    Counting,
    /// Walks from receivers.
    Walking,
    /// Gathering rays that ask cells, and walks that measure what these have wrong.
    Gathering,
    /// Vertices of chains score at all receivers.
    Connecting(Kernel),
}

impl Engine {
    /// The unbiased one of a map.
    pub(super) fn unbiased(scene: &Scene, kind: MapKind, method: Method) -> Engine {
        match (kind, method) {
            (MapKind::Elements, _) => Engine::Counting,
            // What leaves the scene is counted, too.
            (MapKind::Receivers(set), _) if scene.receivers[set].is_far_field() => Engine::Counting,
            (MapKind::Receivers(_), Method::Local) => Engine::Connecting(Kernel::Bounded),
            (MapKind::Receivers(_), Method::LocalNaive) => Engine::Connecting(Kernel::Naive),
            (MapKind::Receivers(_), _) => Engine::Walking,
        }
    }

    /// Name as results tell it.
    pub fn name(self) -> &'static str {
        match self {
            Engine::Counting => "collision",
            Engine::Walking => "walk",
            Engine::Gathering => "gather",
            Engine::Connecting(Kernel::Bounded) => "local",
            Engine::Connecting(Kernel::Naive) => "local-naive",
        }
    }
}
