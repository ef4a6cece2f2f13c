//! Chains that leave the scene, counted by their direction: the far-field intensity of light that has met something on its way.
//!
//! A packet that leaves into the cell of a direction scores Φ/Ω there, Ω the cell's solid angle, as one that an element counts scores
//! Φ/A. Light that has met nothing, or panes alone, is computed ([`crate::estimators::far_field`]).

use std::ops::Range;

use rayon::prelude::*;

use super::job::{Context, Ends};
use super::pilot::{ENOUGH_RAYS, FEWEST_SITES, PartCost, is_over, scattered};
use super::sweep::{emission_shift, spread_choice};
use crate::maps::{MapKind, ReplicaMap, Unit};
use crate::sampling::random::{Purpose, Stream};
use crate::scene::IntensityTable;

/// Chains of a pilot.
const CHAINS: usize = 4096;

/// An empty map of a receiver set, and its weights.
pub fn receiver_map(context: &Context, set: usize) -> (ReplicaMap, Vec<f64>) {
    let receivers = &context.scene.receivers[set];
    let weights: Vec<f64> =
        receivers.points.iter().map(|point| if point.inside { 0.0 } else { point.weight }).collect();
    let unit = match receivers.is_far_field() {
        // Solid angles stand where areas do.
        true => Unit::Packets { luminous_flux_lm: context.stage.emitters.luminous_flux_lm(), area_m2: weights.clone() },
        false => Unit::Lux,
    };
    (ReplicaMap::new(weights.len(), unit), weights)
}

/// Chains of every replica, counted by where they leave to; returns rays and ends, replica by replica.
pub fn leaving_chains(
    context: &Context,
    set: usize,
    table: &IntensityTable,
    map: &mut ReplicaMap,
    chains: Range<u64>,
) -> Vec<(u64, Ends)> {
    let number = MapKind::Receivers(set).number();
    let replicas = map.indirect.par_iter_mut().with_max_len(1).enumerate();
    let traced = replicas.map(|(replica, counts)| {
        let (mut rays, mut ends) = (0, Ends::default());
        let mut stream = Stream::new(context.seed, Purpose::Chains, number, replica as u32);
        let shift = emission_shift(&mut stream);
        for chain in chains.clone() {
            stream.seek(chain);
            let (end, chain_rays, direction) = context.stage.trace_out(spread_choice(chain, shift), &mut stream);
            if let Some(direction) = direction {
                counts[table.entry_towards(direction)] += 1.0;
            }
            ends.count(end);
            rays += chain_rays;
        }
        (rays, ends)
    });
    traced.collect()
}

/// Measures what a chain costs and how its scores scatter: Σ Ω·var I is Φ² times the mean of 1/Ω where it leaves.
pub fn leaving_cost(context: &Context, set: usize, table: &IntensityTable) -> PartCost {
    let stage = context.stage;
    let points = &context.scene.receivers[set].points;
    let all_sr: f64 = points.iter().map(|point| point.weight).sum();
    let flux_lm = stage.emitters.luminous_flux_lm();
    let mut stream = Stream::new(context.seed, Purpose::Pilot, MapKind::Receivers(set).number(), 1);
    let (mut variance, mut left, mut chains, mut rays) = (0.0, 0.0, 0, 0);
    for chain in scattered(CHAINS) {
        stream.seek(chain as u64);
        let choice = (chain as f64 + stream.fine_unit()) / CHAINS as f64;
        let (_, chain_rays, direction) = stage.trace_out(choice, &mut stream);
        if let Some(direction) = direction {
            variance += flux_lm * flux_lm / (points[table.entry_towards(direction)].weight * all_sr);
            left += 1.0;
        }
        rays += chain_rays;
        chains += 1;
        if chains >= FEWEST_SITES && (rays > ENOUGH_RAYS || is_over(context)) {
            break;
        }
    }
    let chains = chains as f64;
    PartCost {
        variance: variance / chains,
        rays: rays as f64 / chains / points.len() as f64,
        choosing: 0.0,
        mean_lx: flux_lm * left / chains / all_sr,
        pilot_rays: rays,
    }
}
