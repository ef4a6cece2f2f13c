//! Estimators of the indirect light of a map.

use serde::{Deserialize, Serialize};

use crate::maps::MapKind;
use crate::scene::Scene;
use crate::solver::Method;
use crate::solver::local::Kernel;
use crate::solver::spending::Activity;

/// Estimator of the indirect light of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Engine {
    /// Packets of chains are counted on elements.
    Collision,
    /// Walks from receivers.
    Walk,
    /// Gathering: rays look cells up, and residual walks measure the error of the cells.
    Gather,
    /// Local estimation: vertices of chains score at all receivers.
    Local(Kernel),
}

impl Engine {
    /// The unbiased engine for a map.
    pub(super) fn unbiased(scene: &Scene, kind: MapKind, method: Method) -> Engine {
        match (kind, method) {
            (MapKind::Elements, _) => Engine::Collision,
            // Light that leaves the scene is counted, too.
            (MapKind::Receivers(set), _) if scene.receivers[set].is_far_field() => Engine::Collision,
            (MapKind::Receivers(_), Method::Local) => Engine::Local(Kernel::Bounded),
            (MapKind::Receivers(_), Method::LocalNaive) => Engine::Local(Kernel::Naive),
            (MapKind::Receivers(_), _) => Engine::Walk,
        }
    }

    /// Kind of its work on indirect light; `None` for gathering, which has several kinds.
    pub(super) fn activity(self) -> Option<Activity> {
        match self {
            Engine::Gather => None,
            Engine::Walk => Some(Activity::Walks),
            Engine::Collision | Engine::Local(_) => Some(Activity::Chains),
        }
    }

    /// Name of the engine in results.
    pub fn name(self) -> &'static str {
        match self {
            Engine::Collision => "collision",
            Engine::Walk => "walk",
            Engine::Gather => "gather",
            Engine::Local(Kernel::Bounded) => "local",
            Engine::Local(Kernel::Naive) => "local-naive",
        }
    }
}
