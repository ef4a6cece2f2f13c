//! A job that gathers: what it gathers on, how it begins and how it leaves off.

use std::ops::Range;

use super::elements::{element_weights, numbers_per_site};
use super::{Context, Engine, Job, Method, Tally, after_sweep, slice_of_sweep};
use crate::maps::{ReplicaMap, Unit};
use crate::scene::Elements;
use crate::solver::adapt::slope_from_m;
use crate::solver::broad::Broad;
use crate::solver::forward::Forward;
use crate::solver::gathering::Gatherer;
use crate::solver::pilot::{DirectShare, MOST_RAY_SHARE, PartCost};
use crate::solver::plan::GatherCosts;

/// Passes a sample by a look over those by the pilot from which on they are worth a change.
const WORTH_MORE: f64 = 1.25;

impl Job {
    /// Makes ready for gathering: elements that adapt get broader ones for it, with edges of about so many m at first.
    pub fn prepare_gathering(&mut self, context: &Context, edge_m: f64) {
        self.broad = self.adaptive.as_ref().map(|adaptive| {
            let slope_from_m = slope_from_m(context, adaptive.target_error());
            let edges_m = [edge_m, slope_from_m];
            Broad::first(context, &self.elements, &adaptive.exposed, edges_m, self.indirect.mean_lx)
        });
    }

    /// What holds its indirect light: its own map, or that of broader elements.
    pub fn gathered(&self) -> &ReplicaMap {
        self.broad.as_ref().map_or(&self.map, |broad| &broad.map)
    }

    /// The elements that gather, where elements do.
    pub fn gathering_elements(&self) -> &Elements {
        self.broad.as_ref().map_or(&self.elements, |broad| &broad.elements)
    }

    /// Shares of these that are exposed; empty where elements count as they are.
    pub fn gathering_exposed(&self) -> &[f64] {
        self.broad.as_ref().map_or(&[], |broad| &broad.exposed)
    }

    /// Areas or weights of all entries of [`Job::gathered`].
    pub fn gathered_weights(&self) -> &[f64] {
        self.broad.as_ref().map_or(&self.weights, |broad| &broad.weights)
    }

    /// Numbers that an element that gathers shows, in the mean over the area: its own and those of its slopes.
    pub fn numbers_per_gathering_site(&self) -> f64 {
        numbers_per_site(self.gathered_weights(), self.gathered().len())
    }

    /// Starts (again) with gathering, from costs and a plan; direct light stays as far as it is.
    pub fn start_gathering(&mut self, context: &Context, costs: &GatherCosts, samples: f64, checked_share: f64) {
        self.checked_share = if context.stage.paths_not_found.is_empty() { checked_share } else { 0.0 };
        self.planned_samples = (samples.ceil() as u64).max(1);
        self.first_plan = self.planned_samples;
        self.share_out(costs);
        self.map.indirect.iter_mut().for_each(|slab| slab.fill(0.0));
        self.map.indirect_samples = Tally::default();
        let unit = std::mem::replace(&mut self.map.indirect_unit_lx, Unit::Lux);
        if matches!(unit, Unit::Packets { .. }) {
            self.counting_unit = Some(unit);
        }
        match (&mut self.broad, &mut self.adaptive) {
            (Some(broad), Some(adaptive)) => {
                broad.restart();
                adaptive.stand_on(broad);
                self.weights = element_weights(context, &self.elements, Some(adaptive.shows()));
            }
            _ => self.map.cross(&self.weights),
        }
        self.map.forget_indirect_scores();
        self.forget_looks();
        self.samples = 0;
        self.given_up_rays = self.rays;
        self.engine = Engine::Gathering;
    }

    /// Samples that were planned when gathering began, with the chains that there are.
    pub fn first_plan(&self) -> u64 {
        self.first_plan
    }

    /// Shares the rays out between direct light and gathering, which costs so much.
    pub fn share_out(&mut self, costs: &GatherCosts) {
        let rays = costs.rays_per_sample + self.checked_share * costs.rays_per_check;
        let gathered = PartCost { variance: costs.ray_variance, rays, ..PartCost::default() };
        self.share = DirectShare::of(self.direct, gathered, [self.map.len(), self.gathered().len()]);
    }

    /// Gives direct light more passes a sample, where a look shows more chance of it beside that of the rays, both as squared
    /// errors, than the pilot saw: where light falls through gaps it seldom sees any.
    pub fn share_anew(&mut self, of_direct: f64, of_rays: f64) {
        if !(of_direct > 0.0 && of_rays > 0.0) {
            return;
        }
        // The least of a/P + b/Nᵅ for a cost of so many rays, at the samples that are planned.
        let exponent = self.rows.exponent();
        let (samples, passes) = (self.samples as f64, self.map.direct_samples.complete as f64);
        let later = (samples / self.planned_samples.max(self.samples) as f64).powf(exponent - 1.0);
        let (direct, rays) = (of_direct * passes, exponent * of_rays * samples * later);
        let best = (direct * self.share.rays_per_indirect / (rays * self.share.rays_per_pass)).sqrt();
        let most = MOST_RAY_SHARE * self.share.rays_per_indirect / self.share.rays_per_pass;
        if best > WORTH_MORE * self.share.passes_per_sample {
            self.share.passes_per_sample = best.min(most);
            // A map that starts anew shares out by this.
            self.direct.variance = self.direct.variance.max(self.direct_variance * passes);
        }
    }

    /// Goes over to walks or counting; direct light stays as far as it is.
    pub fn stop_gathering(&mut self) {
        self.map.indirect.iter_mut().for_each(|slab| slab.fill(0.0));
        self.map.indirect_samples = Tally::default();
        self.map.crossing = None;
        self.broad = None;
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.detail.restart_indirect();
        }
        self.map.forget_indirect_scores();
        self.forget_looks();
        if let Some(unit) = self.counting_unit.take() {
            self.map.indirect_unit_lx = unit;
        }
        self.engine = Engine::unbiased(self.kind, Method::Auto);
        self.share = DirectShare::of(self.direct, self.indirect, [self.map.len(); 2]);
        self.samples = 0;
    }

    /// Gathers a slice on the way to a number of samples.
    pub(super) fn gather(&mut self, context: &Context, forward: &Forward, goal: u64) {
        let (sites, tally) = (self.gathered().len(), self.gathered().indirect_samples);
        let (entries, times): (Range<usize>, Range<u64>) =
            slice_of_sweep(tally, goal, sites, self.share.rays_per_indirect);
        let (kind, checked_share) = (self.kind, self.checked_share);
        let (elements, exposed, map, shape) = match &mut self.broad {
            Some(broad) => (&broad.elements, &broad.exposed[..], &mut broad.map, Some(&mut broad.shape)),
            None => (&self.elements, &[][..], &mut self.map, None),
        };
        let gatherer = Gatherer { context, forward, kind, elements, exposed, checked_share };
        self.rays += gatherer.gather(map, shape, entries.clone(), times.clone());
        map.indirect_samples = after_sweep(entries, times, sites);
    }

    /// Makes ready what was gathered, to be judged and read.
    pub(super) fn settle(&mut self) {
        let Some(broad) = &mut self.broad else {
            self.map.settle(&self.weights);
            return;
        };
        broad.map.settle(&broad.weights);
        self.map.take_indirect(&broad.map, &broad.sloped, &broad.pieces);
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.detail.take_indirect(&broad.shape.detail, &broad.pieces);
        }
    }
}
