//! The elements of a job's map: an empty map of them, their refinement and their values.

use super::super::adapt::{Looked, Refined, Spent, at_least_none};
use super::super::contact::{KnownContact, contact_free_shares};
use super::super::pilot::{DirectShare, direct_cost, indirect_cost};
use super::{Engine, Job};
use crate::maps::{Judgement, MapKind, MapValues, ReplicaMap, Unit, judge};
use crate::scene::Elements;
use crate::solver::context::Context;
use crate::solver::empty_maps::{element_map, element_weights_m2, numbers_per_site};

/// What happened to the elements of a map after a look (error check).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refinement {
    /// They are unchanged.
    None,
    /// Direct light gets finer elements and starts anew. Gathered light is kept.
    OfDirect,
    /// The map starts anew on finer elements.
    Anew,
}

impl Job {
    /// Changes to finer elements if, at the latest look, the present ones cannot show what the target requires.
    /// If the coarse elements are new, gathering must then be started by its plan.
    pub fn refine_elements(&mut self, context: &Context) -> Refinement {
        let refined = self.adapting.adaptive.as_ref().and_then(|adaptive| {
            let direct = self.work.direct_rays as f64;
            let looked = Looked {
                elements: &self.elements,
                map: &self.map,
                coarse: self.adapting.coarse.as_ref(),
                loss: &self.adapting.loss,
                ray_scatters_lx2: &self.ray_scatters_lx2(),
                mean_lx: self.judgement.mean,
                spent: Spent { direct, gathered: self.kept_rays() as f64 - direct },
            };
            adaptive.refined(context, &looked, |error_lx| self.rays_to_chance(error_lx))
        });
        let Some(Refined { elements, coarse }) = refined else {
            return Refinement::None;
        };
        self.adapting.before_cut = self.before_cut(context);
        self.forget_looks();
        let found =
            if coarse.is_some() || self.adapting.coarse.is_none() { Refinement::Anew } else { Refinement::OfDirect };
        if let Some(coarse) = coarse {
            self.adapting.coarse = Some(coarse);
        }
        if let Some((elements, adaptive)) = elements {
            self.work.pilot_rays += adaptive.pilot_rays;
            self.work.direct_rays = 0;
            (self.map, self.weights) = element_map(context, &elements, Some(adaptive.shows()));
            (self.elements, self.adapting.adaptive) = (elements, Some(adaptive));
            let numbers = self.numbers_per_site();
            self.costs.direct =
                direct_cost(context, self.kind, &self.elements, self.adapting.adaptive.as_ref()).0.times(numbers);
            self.costs.indirect = indirect_cost(context, self.kind, &self.elements, None).shared.times(numbers);
        }
        let found = match found {
            Refinement::OfDirect => self.keep_gathered(context),
            found => found,
        };
        if found == Refinement::OfDirect {
            return found;
        }
        self.share = DirectShare::of(self.costs.direct, self.costs.indirect, [self.map.len(); 2]);
        self.samples = 0;
        self.give_up_samples();
        if self.engine == Engine::Gather {
            self.begin_gathering(context);
        }
        found
    }

    /// Whether its elements must still be cut before the run.
    pub fn is_to_be_cut(&self) -> bool {
        self.adapting.cutting.is_some()
    }

    /// Rays until the end of cutting, as far as it is known; approximate.
    pub(super) fn rays_to_cut(&self, context: &Context) -> f64 {
        self.adapting.cutting.as_ref().map_or(0.0, |cutting| cutting.rays_left(context))
    }

    /// Continues cutting for about `rays` rays. Returns whether more cutting remains. At the end of cutting the job starts anew on finer
    /// elements, and its rays so far count as pilot rays.
    pub fn cut_on(&mut self, context: &Context, rays: f64) -> bool {
        let Some(mut cutting) = self.adapting.cutting.take() else {
            return false;
        };
        let before = cutting.rays();
        let has_more = cutting.advance(context, rays);
        self.work.pilot_rays += cutting.rays() - before;
        if has_more {
            self.adapting.cutting = Some(cutting);
            return true;
        }
        let pilot_rays = self.work.pilot_rays - cutting.rays();
        // Two maps at a time may not fit into memory.
        (self.map, self.adapting.coarse) = (ReplicaMap::new(0, Unit::Scores), None);
        let (elements, adaptive) = cutting.end(context);
        let (map, weights) = element_map(context, &elements, Some(adaptive.shows()));
        *self = Job::new(context, self.kind, elements, Some(adaptive), map, weights, self.bound);
        self.work.pilot_rays += pilot_rays;
        false
    }

    /// Finds how much of each given element is free of contact, before walks or rays start from them.
    pub fn find_contact(&mut self, context: &Context) {
        if self.kind == MapKind::Elements && self.adapting.adaptive.is_none() && self.adapting.contact_free.is_empty() {
            let (contact_free, rays) =
                contact_free_shares(context, &self.elements, 0..self.elements.len(), |_| KnownContact::Unknown);
            self.adapting.contact_free = contact_free;
            self.work.pilot_rays += rays;
        }
    }

    /// Rays, approximately, that reduce the random error to `error_lx`.
    fn rays_to_chance(&self, error_lx: f64) -> f64 {
        let counted = || {
            let now_lx = self.judgement.expected_error * self.judgement.mean;
            self.kept_rays() as f64 * ((now_lx / error_lx).powi(2) - 1.0).max(0.0)
        };
        self.gathering_parts().map_or_else(counted, |parts| parts.growth(error_lx).rays)
    }

    /// Keeps what was gathered, on finer elements of direct light. Starts anew if the finer elements see a different contact occlusion.
    fn keep_gathered(&mut self, context: &Context) -> Refinement {
        let (Some(coarse), Some(adaptive)) = (&mut self.adapting.coarse, &mut self.adapting.adaptive) else {
            return Refinement::Anew;
        };
        if !coarse.lay_under(context, &self.elements, &adaptive.contact_free) {
            *coarse = coarse.cut(context, coarse.elements.clone(), &self.elements, &adaptive.contact_free);
            return Refinement::Anew;
        }
        adaptive.stand_on(coarse);
        self.weights = element_weights_m2(context, &self.elements, Some(adaptive.shows()));
        self.map.indirect_unit = Unit::Scores;
        Refinement::OfDirect
    }

    /// Stated relative error of some elements that adapt. It includes the error of all numbers that they show, and what they cannot show.
    pub fn error_of_elements(&self, sites: &[usize]) -> f64 {
        let sites_of_map = self.map.len();
        let numbers = (0..self.map.entries() / sites_of_map)
            .flat_map(|number| sites.iter().map(move |site| number * sites_of_map + site));
        let judgement = judge(&self.map, numbers.map(|entry| (entry, self.weights[entry])));
        let area_m2: f64 = sites.iter().map(|site| self.weights[*site]).sum();
        let lost = sites
            .iter()
            .map(|site| self.weights[*site] * self.adapting.loss.lost_lx2.get(*site).copied().unwrap_or(0.0));
        let lost_lx2 = at_least_none(lost.sum()) / area_m2.max(f64::MIN_POSITIVE);
        let discretisation = if judgement.mean > 0.0 { lost_lx2.sqrt() / judgement.mean } else { 0.0 };
        Judgement { discretisation, ..judgement }.error_of_part()
    }

    /// Takes the element numbering of the scene, which is not stored with the run.
    pub fn take_numbering(&mut self, of_scene: &Elements) {
        if self.kind == MapKind::Elements {
            self.elements.take_numbering(of_scene);
        }
        if let Some(coarse) = &mut self.adapting.coarse {
            coarse.elements.take_numbering(of_scene);
        }
    }

    /// Whether its first elements seem to lose so much that they will be cut, once this is certain.
    pub fn may_be_cut(&self) -> bool {
        let adaptive = self.adapting.adaptive.as_ref();
        adaptive.is_some_and(|adaptive| adaptive.seems_to_lose(&self.adapting.loss, self.judgement.mean))
    }

    /// Whether its elements lose more than the target allows and cannot be cut further.
    pub fn is_finest(&self) -> bool {
        let adaptive = self.adapting.adaptive.as_ref().filter(|_| !self.met && self.looks.judged_samples > 0);
        adaptive.is_some_and(|adaptive| adaptive.loses_over(1.0, &self.adapting.loss, self.judgement.mean))
    }

    /// Numbers that an element of the map shows, as an area-weighted mean: its own value and its slopes.
    pub fn numbers_per_site(&self) -> f64 {
        numbers_per_site(&self.weights, self.map.len())
    }

    /// Area or weight of every element or point.
    pub fn site_weights(&self) -> &[f64] {
        &self.weights[..self.map.len()]
    }

    /// Marks all rays of indirect light so far as no longer part of any sample of the map. Those of direct light stay.
    pub(super) fn give_up_samples(&mut self) {
        self.work.given_up_rays = self.work.rays - self.work.direct_rays;
    }

    /// Rays of the samples that are in the map.
    pub fn kept_rays(&self) -> u64 {
        self.work.rays - self.work.given_up_rays
    }

    /// Root mean square in lx of what every element that adapts does not show.
    pub fn discretisation_lx(&self) -> Vec<f64> {
        self.adapting.loss.lost_lx2.iter().map(|lost_lx2| lost_lx2.max(0.0).sqrt()).collect()
    }

    /// The finished values.
    pub fn values(&self) -> MapValues {
        let mut values = self.map.values();
        if let Some(adaptive) = &self.adapting.adaptive {
            let slopes = adaptive.sloped.iter().enumerate();
            values.slopes_lx =
                slopes.map(|(site, sloped)| if *sloped { self.map.slopes_lx(site) } else { [0.0; 2] }).collect();
            values.in_contact = adaptive.contact_free.iter().map(|contact_free| *contact_free == 0.0).collect();
            for site in (0..values.in_contact.len()).filter(|site| values.in_contact[*site]) {
                values.value[site] = 0.0;
                values.halves[site] = [0.0; 2];
                values.standard_error[site] = 0.0;
                values.direct[site] = 0.0;
                values.indirect[site] = 0.0;
            }
            values.discretisation_lx = self.discretisation_lx();
        }
        values
    }
}
