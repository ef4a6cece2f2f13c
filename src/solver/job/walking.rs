//! A job whose points walk.

use super::{Context, Engine, Job, Method, after_sweep, slice_of_sweep};
use crate::solver::cells::regions_of;
use crate::solver::guide::Guide;
use crate::solver::sweep;

impl Job {
    /// A slice of walks from the points of a receiver set, towards a number of them from every point.
    pub(super) fn walk_from_points(&mut self, context: &Context, set: usize, goal: u64) {
        let receivers = &context.scene.receivers[set];
        let has_guide = context.method == Method::Auto && receivers.quantity.has_one_hemisphere();
        if has_guide && self.guide.is_none() {
            let places: Vec<_> = receivers.points.iter().map(|point| (point.position_m, point.normal)).collect();
            self.guide = Some(Guide::new(regions_of(&places)));
        }
        let rays = self.share.rays_per_indirect;
        let (entries, times) = slice_of_sweep(context, self.map.indirect_samples, goal, self.map.len(), rays);
        let (guide, part) = (self.guide.as_mut(), (entries.clone(), times.clone()));
        self.rays += sweep::walks_from_points(context, set, &mut self.map, guide, part.0, part.1);
        self.map.indirect_samples = after_sweep(entries, times, self.map.len());
    }

    /// Lets the walks to come go where light has come from.
    pub(super) fn learn_directions(&mut self) {
        if let Some(guide) = self.guide.as_mut().filter(|_| self.engine == Engine::Walk) {
            guide.learn();
        }
    }
}
