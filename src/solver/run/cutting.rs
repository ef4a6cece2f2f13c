//! Elements are cut before a run: that takes long itself, so that a first forecast comes before it, and more on the way.

use super::{Method, Run};
use crate::solver::job::RAYS_PER_SLICE;

/// Share of the forecast run that is cut between two looks at how it stands, and rays of one in any case.
const SHARE_OF_A_STEP: f64 = 0.01;
const LEAST_RAYS: f64 = 20_000.0;

impl Run<'_> {
    /// Cuts the elements of the map that adapts, if there is one, and tells meanwhile how the run stands.
    pub(super) fn cut_elements(&mut self) {
        let Some(index) = self.jobs.iter().position(|job| job.is_to_be_cut()) else {
            return;
        };
        let gathers = matches!(self.settings.method, Method::Auto | Method::Gather) && self.context.stage.reflects();
        let error = self.error_to_plan_for();
        let job = &mut self.jobs[index];
        if gathers && job.can_ask_cells(self.context) && job.mean_without_gathering_lx() > 0.0 {
            job.prepare_asking(self.context, error);
        }
        loop {
            self.record(false);
            self.tell();
            let forecast_rays = self.convergence.last().map_or(0.0, |row| row.forecast_rays.expected);
            let rays = (SHARE_OF_A_STEP * forecast_rays).clamp(LEAST_RAYS, RAYS_PER_SLICE);
            if !self.jobs[index].cut_on(self.context, rays) {
                return;
            }
        }
    }
}
