//! What a job does with the elements of its map: an empty map of them, their refinement, their values.

use super::super::pilot::{DirectShare, direct_cost, indirect_cost};
use super::{Adaptive, Context, Job};
use crate::maps::{MapValues, ReplicaMap, Unit, judge};
use crate::scene::Elements;

impl Job {
    /// Starts anew on finer elements, where those at hand cannot show what the target asks for by the latest look;
    /// whether it did.
    ///
    /// What gathers is to be started by its plan then.
    pub fn refine_elements(&mut self, context: &Context) -> bool {
        let refined = self
            .adaptive
            .as_ref()
            .and_then(|adaptive| adaptive.refined(context, &self.elements, &self.map, &self.loss, &self.judgement));
        let Some((elements, adaptive)) = refined else {
            return false;
        };
        (self.map, self.weights) = element_map(context, &elements, Some(&adaptive));
        self.forget_looks();
        (self.elements, self.adaptive) = (elements, Some(adaptive));
        let numbers = self.numbers_per_site();
        self.direct = direct_cost(context, self.kind, &self.elements, self.adaptive.as_ref()).0.times(numbers);
        self.indirect = indirect_cost(context, self.kind, &self.elements).times(numbers);
        self.share = DirectShare::of(self.direct, self.indirect, self.map.len());
        self.counting_unit = None;
        self.samples = 0;
        self.given_up_rays = self.rays;
        true
    }

    /// Stated relative error of some of the elements that adapt: that of all they show, and what they cannot show.
    pub fn error_of_elements(&self, sites: &[usize]) -> f64 {
        let sites_of_map = self.map.len();
        let numbers = (0..self.map.entries() / sites_of_map)
            .flat_map(|number| sites.iter().map(move |site| number * sites_of_map + site));
        let judgement = judge(&self.map, numbers.map(|entry| (entry, self.weights[entry])));
        let area_m2: f64 = sites.iter().map(|site| self.weights[*site]).sum();
        let lost = sites.iter().map(|site| self.weights[*site] * self.loss.lost_lx2.get(*site).copied().unwrap_or(0.0));
        let lost_lx2 = lost.sum::<f64>().max(0.0) / area_m2.max(f64::MIN_POSITIVE);
        let discretisation = if judgement.mean_lx > 0.0 { lost_lx2.sqrt() / judgement.mean_lx } else { 0.0 };
        judgement.halves_error.hypot(discretisation)
    }

    /// Whether its elements lose more than the target allows and can be cut no further.
    pub fn is_finest(&self) -> bool {
        let adaptive = self.adaptive.as_ref().filter(|_| !self.met && self.judged_samples > 0);
        adaptive.is_some_and(|adaptive| adaptive.loses_over(1.0, &self.loss, self.judgement.mean_lx))
    }

    /// Numbers that an element of the map shows, in the mean over the area: its own and those of its slopes.
    pub fn numbers_per_site(&self) -> f64 {
        numbers_per_site(&self.weights, self.map.len())
    }

    /// Area or weight of every element or point.
    pub fn site_weights(&self) -> &[f64] {
        &self.weights[..self.map.len()]
    }

    /// Share of the look-ups that are checked.
    pub fn checked_share(&self) -> f64 {
        self.checked_share
    }

    /// Rays of the samples that are in the map.
    pub fn kept_rays(&self) -> u64 {
        self.rays - self.given_up_rays
    }

    /// The finished values.
    pub fn values(&self) -> MapValues {
        let mut values = self.map.values();
        if let Some(adaptive) = &self.adaptive {
            let slopes = adaptive.sloped.iter().enumerate();
            values.slopes_lx =
                slopes.map(|(site, sloped)| if *sloped { self.map.slopes_lx(site) } else { [0.0; 2] }).collect();
            values.discretisation_lx = self.loss.lost_lx2.iter().map(|lost_lx2| lost_lx2.max(0.0).sqrt()).collect();
        }
        values
    }
}

/// Numbers that one of so many elements or points shows, weighted: all weights over those of the means.
pub(super) fn numbers_per_site(weights: &[f64], sites: usize) -> f64 {
    weights.iter().sum::<f64>() / weights[..sites].iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

/// An empty map of elements, and its weights.
pub(super) fn element_map(
    context: &Context,
    elements: &Elements,
    adaptive: Option<&Adaptive>,
) -> (ReplicaMap, Vec<f64>) {
    let area_m2: Vec<f64> =
        (0..elements.len() as u32).map(|cell| elements.area_m2(context.scene, elements.cell(cell))).collect();
    let luminous_flux_lm = context.stage.emitters.luminous_flux_lm();
    let unit = Unit::Packets { luminous_flux_lm, area_m2: area_m2.clone() };
    let Some(adaptive) = adaptive else {
        return (ReplicaMap::new(elements.len(), unit), area_m2);
    };
    let of_slopes = area_m2.iter().zip(&adaptive.sloped).map(|(area_m2, sloped)| if *sloped { *area_m2 } else { 0.0 });
    let of_slopes: Vec<f64> = of_slopes.collect();
    (ReplicaMap::linear(elements.len(), unit), [area_m2, of_slopes.clone(), of_slopes].concat())
}
