//! What a map is known to be off by, and what it is still to take.

use super::{Context, Engine, Job};
use crate::control::{Forecast, deviation_of_work, needed_work};
use crate::maps::judge;
use crate::solver::ErrorParts;

/// An entry is judged in the time of this many rays, about, and glances may take this share of a run.
const RAYS_OF_AN_ENTRY: f64 = 1.0;
const SHARE_OF_GLANCES: f64 = 0.01;
/// Share of the squared target that is left to chance where elements are to be cut before they can meet it.
const SHARE_OF_CHANCE: f64 = 0.75;
/// Standard deviations of the logarithm of the work, by a pilot and where elements are to be cut.
const DEVIATION_BY_PILOT: f64 = 0.5;
const DEVIATION_BY_CUTTING: f64 = 0.7;

impl Job {
    /// Whether anything of the error of its present samples is known but what its pilot lets expect.
    pub fn is_judged(&self) -> bool {
        self.seen.is_some()
    }

    /// The error so far: by the latest look, or what as many rays of walks or counts would leave by the pilot. None where
    /// the pilot found no light.
    pub fn error_so_far(&self, context: &Context) -> Option<ErrorParts> {
        match &self.seen {
            Some((judgement, _)) if judgement.mean_lx > 0.0 => Some(ErrorParts::of(judgement)),
            _ => self.error_by_pilot(context),
        }
    }

    fn error_by_pilot(&self, context: &Context) -> Option<ErrorParts> {
        let mean_lx = self.mean_without_gathering_lx();
        let indirect = self.indirect.variance * self.indirect.rays * self.map.len() as f64;
        let direct = self.direct.variance * self.direct.rays * self.map.len() as f64;
        let rays = self.all_rays() + context.stage.outlook_rays();
        let error = (direct.sqrt() + indirect.sqrt()) / (rays as f64).sqrt() / mean_lx;
        (mean_lx > 0.0 && rays > 0).then_some(ErrorParts::random(error))
    }

    /// Looks at the error, to tell it and not to decide by it, where that takes little beside so many rays.
    pub fn glance(&mut self, rays: f64) {
        let is_cheap = RAYS_OF_AN_ENTRY * self.map.entries() as f64 <= SHARE_OF_GLANCES * rays;
        let is_whole = self.map.direct_samples.ahead == 0 && self.map.indirect_samples.ahead == 0;
        let is_new = self.seen.as_ref().is_none_or(|(_, samples)| self.samples > *samples);
        let counts = !self.black && self.engine != Engine::Gathering && self.samples > 0 && !self.met;
        if !(is_cheap && is_whole && is_new && counts && self.has_started()) {
            return;
        }
        let mut judgement = judge(&self.map, self.weights.iter().copied().enumerate());
        if judgement.mean_lx > 0.0 && !judgement.unseen {
            // What elements cannot show is what it was.
            judgement.discretisation = self.seen.map_or(0.0, |(seen, _)| seen.discretisation);
            if self.adaptive.is_none() || self.seen.is_some() {
                self.seen = Some((judgement, self.samples));
            }
        }
    }

    /// Rays that it still takes to a target: by its plan, its latest look, or before these by its pilot; none where the pilot found
    /// no light.
    pub fn rays_left(&self, context: &Context, target: f64) -> Option<Forecast> {
        match (&self.seen, self.rays_to_ask()) {
            (_, Some(rays)) => Some(Forecast::spread(rays + self.rays as f64, 0.2).less(self.rays as f64)),
            (Some((judgement, samples)), None) if judgement.mean_lx > 0.0 && *samples > 0 => {
                Some(self.left_by_look(target))
            }
            _ => self.left_by_pilot(context, target),
        }
    }

    fn left_by_pilot(&self, context: &Context, target: f64) -> Option<Forecast> {
        let error_lx = target * self.mean_without_gathering_lx();
        if error_lx <= 0.0 {
            return None;
        }
        let rays = match (&self.local, self.engine) {
            (_, Engine::Gathering) => self.work_by_cells(context, target),
            (Some(plan), Engine::Connecting(_)) => self.rays_by_connecting(plan, error_lx),
            _ => self.rays_without_gathering(context, error_lx),
        };
        Some(Forecast::spread(rays, DEVIATION_BY_PILOT).less(self.kept_rays() as f64))
    }

    /// By its samples so far and the error that they left.
    fn left_by_look(&self, target: f64) -> Forecast {
        let Some((judgement, seen_at)) = &self.seen else {
            return Forecast::default();
        };
        let done = self.kept_rays() as f64;
        let rays_per_sample = done / self.samples.max(1) as f64;
        if self.refused {
            return Forecast::known(rays_per_sample * self.next_judgement.saturating_sub(self.samples) as f64);
        }
        let exponent = self.error_exponent();
        let needed = needed_work(target, judgement, exponent);
        if !needed.is_finite() {
            let chance = SHARE_OF_CHANCE * target * target;
            let anew = judgement.expected_error.powi(2) / chance * *seen_at as f64 * rays_per_sample;
            return Forecast::spread(anew, DEVIATION_BY_CUTTING);
        }
        let all = needed * *seen_at as f64 * rays_per_sample;
        let of_chance = deviation_of_work(judgement.degrees_of_freedom, 1.0 / needed, exponent);
        let of_law = self.deviation_of_exponent() * needed.ln() / exponent;
        Forecast::spread(all, of_chance.hypot(of_law)).less(done)
    }

    /// Standard deviation of the power of the work with which its error falls.
    fn deviation_of_exponent(&self) -> f64 {
        if self.engine == Engine::Counting { 0.0 } else { self.pace.deviation() }
    }
}
