//! Maps before any sample, and the weights of their entries.

use super::context::Context;
use crate::maps::{ReplicaMap, Unit};
use crate::scene::Elements;

/// Numbers that an element or point shows, as a weighted mean: the sum of all weights over that of the means' weights.
pub fn numbers_per_site(weights: &[f64], sites: usize) -> f64 {
    weights.iter().sum::<f64>() / weights[..sites].iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Whether elements that adapt show slopes, and the contact-free share of each.
pub type Shows<'a> = (&'a [bool], &'a [f64]);

/// An empty map of elements, and its weights. They depend on what elements that adapt show.
pub fn element_map(context: &Context, elements: &Elements, shows: Option<Shows>) -> (ReplicaMap, Vec<f64>) {
    let luminous_flux_lm = context.world.emitters.luminous_flux_lm();
    let weights = element_weights_m2(context, elements, shows);
    let whole_m2 = |index: usize| elements.area_m2(context.scene, elements.element(index as u32));
    // A packet that meets an element that seems hidden by contact counts in all of it.
    let area_m2 = |(index, weight): (usize, &f64)| if *weight > 0.0 { *weight } else { whole_m2(index) };
    let area_m2: Vec<f64> = weights[..elements.len()].iter().enumerate().map(area_m2).collect();
    let unit = Unit::Packets { luminous_flux_lm, area_m2 };
    let mut map = match shows {
        Some(_) => ReplicaMap::linear(elements.len(), unit),
        None => ReplicaMap::new(elements.len(), unit),
    };
    map.may_be_in_contact = true;
    (map, weights)
}

/// Weights of all entries of a map of elements: areas in m². Elements that adapt have their contact-free area, and slopes that are not shown
/// have 0.
pub fn element_weights_m2(context: &Context, elements: &Elements, shows: Option<Shows>) -> Vec<f64> {
    let numbers = 0..elements.len() as u32;
    let area_m2: Vec<f64> = numbers.map(|index| elements.area_m2(context.scene, elements.element(index))).collect();
    let Some((sloped, contact_free)) = shows else {
        return area_m2;
    };
    let area_m2: Vec<f64> =
        area_m2.iter().zip(contact_free).map(|(area_m2, contact_free)| area_m2 * contact_free).collect();
    let of_slopes = area_m2.iter().zip(sloped).map(|(area_m2, sloped)| if *sloped { *area_m2 } else { 0.0 });
    let of_slopes: Vec<f64> = of_slopes.collect();
    [area_m2, of_slopes.clone(), of_slopes].concat()
}

/// An empty map of a receiver set, and its weights.
pub fn receiver_map(context: &Context, set: usize) -> (ReplicaMap, Vec<f64>) {
    let receivers = &context.scene.receivers[set];
    let weights: Vec<f64> =
        receivers.points.iter().map(|point| if point.inside { 0.0 } else { point.weight }).collect();
    let unit = match receivers.is_far_field() {
        // Solid angles take the place of areas.
        true => Unit::Packets { luminous_flux_lm: context.world.emitters.luminous_flux_lm(), area_m2: weights.clone() },
        false => Unit::Scores,
    };
    (ReplicaMap::new(weights.len(), unit), weights)
}
