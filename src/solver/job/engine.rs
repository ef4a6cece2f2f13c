//! Estimators of the indirect light of a map, and all that differs between them: what a sample is, when its error is judged first, a slice of
//! its work, and how its error falls. For a new variant the compiler reports every missing arm here, and none elsewhere.

use serde::{Deserialize, Serialize};

use super::{Job, RAYS_PER_SLICE};
use crate::control::EXPONENT_OF_INDEPENDENT_SAMPLES;
use crate::maps::{MapKind, REPLICAS};
use crate::scene::Scene;
use crate::solver::Method;
use crate::solver::context::Context;
use crate::solver::ends::Ends;
use crate::solver::local::Kernel;
use crate::solver::passes::ScoredArrivals;
use crate::solver::spending::Activity;

/// Errors fall with the work to these powers: for walks and connections from quasi-random points, and for gathering (up to a look, where
/// cells grow with the rays).
const EXPONENT_OF_WALKS: f64 = 0.55;
const EXPONENT_OF_GATHERING: f64 = 0.44;

/// Chains per replica at which local estimation is judged for the first time.
const FIRST_LOCAL_CHAINS: u64 = 64;

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

    /// The engine of this name; if shares had several engines, the unbiased one of the map.
    pub fn named(name: Option<&str>, scene: &Scene, kind: MapKind, method: Method) -> Engine {
        let unbiased = Engine::unbiased(scene, kind, method);
        let all = [Engine::Gather, Engine::Walk, Engine::Local(Kernel::Bounded), Engine::Local(Kernel::Naive)];
        all.into_iter().find(|engine| Some(engine.name()) == name).unwrap_or(unbiased)
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

impl Job {
    /// Chains that the samples so far stand for, over all replicas; 0 in a black scene.
    pub fn chains(&self) -> u64 {
        let of_a_replica = match self.engine {
            Engine::Collision => self.samples,
            Engine::Walk => self.walks_of_a_replica(),
            Engine::Gather => return self.ends.iter().map(Ends::packets).sum(),
            Engine::Local(_) => self.samples * self.chains_per_round(),
        };
        if self.black { 0 } else { of_a_replica * REPLICAS as u64 }
    }

    /// Samples per replica that need at least `chains` chains in all.
    pub fn samples_for(&self, chains: u64) -> u64 {
        let per_sample = match self.engine {
            Engine::Collision => REPLICAS as u64,
            Engine::Walk => (REPLICAS * self.map.len().max(1)) as u64,
            Engine::Gather => return self.gathering.goal.rays,
            Engine::Local(_) => REPLICAS as u64 * self.chains_per_round(),
        };
        if self.black { 1 } else { chains.div_ceil(per_sample).max(1) }
    }

    /// Samples at which the error is judged for the first time.
    pub fn first_samples(&self) -> u64 {
        match self.engine {
            _ if self.black => 1,
            Engine::Collision | Engine::Walk => self.first_look(self.engine),
            Engine::Gather => self.gathering.goal.rays,
            Engine::Local(_) => first_rounds(self.chains_per_round(), self.share.rays_per_indirect),
        }
    }

    /// Does one slice of chains, rounds or walks towards `goal` samples. Gathering has slices of its own (`Job::gather_a_slice`).
    pub(super) fn advance_indirect(&mut self, context: &Context, goal: u64) {
        let done = self.map.indirect_samples.complete;
        let rays_per_sample = self.share.rays_per_indirect.max(1.0) * REPLICAS as f64;
        let until = goal.min(done + (context.pace.rays_per_slice() / rays_per_sample).ceil() as u64);
        match (self.engine, self.kind) {
            (Engine::Collision, MapKind::Elements) => self.chains_until(context, until, ScoredArrivals::IndirectOnly),
            (Engine::Collision, MapKind::Receivers(set)) => self.chains_out_until(context, set, until),
            (Engine::Walk, MapKind::Receivers(set)) => self.walk_from_points(context, set, goal),
            (Engine::Local(_), MapKind::Receivers(set)) => self.connect_until(context, set, until),
            (Engine::Gather, _) | (Engine::Walk | Engine::Local(_), MapKind::Elements) => {
                unreachable!("gathering has slices of its own, and only receivers walk or connect")
            }
        }
    }

    /// The power of the work with which its error falls: docs/methods.md, "The forecast".
    pub fn error_exponent(&self) -> f64 {
        match self.engine {
            Engine::Collision => EXPONENT_OF_INDEPENDENT_SAMPLES,
            Engine::Walk | Engine::Local(_) => EXPONENT_OF_WALKS,
            Engine::Gather => EXPONENT_OF_GATHERING,
        }
    }
}

/// Rounds per replica after which local estimation is judged for the first time.
pub fn first_rounds(chains_per_round: u64, rays_per_round: f64) -> u64 {
    let affordable = RAYS_PER_SLICE / (rays_per_round.max(1.0) * REPLICAS as f64);
    (FIRST_LOCAL_CHAINS / chains_per_round).min(affordable as u64).max(1)
}
