//! Which maps a run makes, and on which elements.

use crate::base::memory::limit_bytes;
use crate::maps::MapKind;
use crate::scene::Scene;
use crate::solver::adapt::most_that_adapt;
use crate::solver::context::Context;
use crate::solver::job::Job;
use crate::solver::{ElementChoice, MapSelection, Settings};
use crate::transport::{NearLuminaires, World};

/// Whether elements adapt. They stay means if a luminaire nearly touches a surface, since no slope shows its spot, and if there are very
/// many elements.
pub fn adapts(settings: &Settings, world: &World) -> bool {
    settings.elements == ElementChoice::Adaptive
        && !world.near_luminaires.as_ref().is_some_and(NearLuminaires::touch)
        && world.elements.len() <= most_that_adapt(settings.time_limit_s, limit_bytes())
}

/// The requested maps, elements first, and whether the target binds each.
pub fn map_requests(scene: &Scene, maps: &MapSelection) -> Vec<(MapKind, bool)> {
    let sets = &scene.receivers;
    let wanted = |name: &str, is_elements: bool| match maps {
        MapSelection::Default | MapSelection::All => true,
        MapSelection::Elements => is_elements,
        MapSelection::Receivers => !is_elements,
        MapSelection::Named(names) => names.iter().any(|wanted| wanted == name),
    };
    let bound = *maps != MapSelection::Default || sets.is_empty();
    let elements = wanted("elements", true).then_some((MapKind::Elements, bound));
    let receivers = sets.iter().enumerate().filter(|(_, receivers)| wanted(&receivers.name, false));
    elements.into_iter().chain(receivers.map(|(set, _)| (MapKind::Receivers(set), true))).collect()
}

/// Creates a job for each requested map.
pub fn choose_jobs(context: &Context, maps: &MapSelection) -> Vec<Job> {
    let job = |(kind, bound): (MapKind, bool)| match kind {
        MapKind::Elements => Job::elements(context, bound),
        MapKind::Receivers(set) => Job::receivers(context, set, bound),
    };
    map_requests(context.scene, maps).into_iter().map(job).collect()
}
