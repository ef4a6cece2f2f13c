//! Glare ratings, from the background illuminance in a map's replicas and the luminaires that the observer sees.

use std::f64::consts::PI;
use std::ops::Range;

use rayon::prelude::*;

use super::context::Context;
use super::glare_rating::GlareRating;
use super::job::Job;
use super::pace::TimeLeft;
use crate::base::glare::unified_glare_rating;
use crate::base::position_index::Outside;
use crate::estimators::glare::{outside_of_table, sample_glare};
use crate::estimators::receiver::Receiver;
use crate::maps::{Estimate, MapKind, REPLICAS, standard_error};
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Background, GlareObserver, Quantity};

/// Approximate upper limit for the rays of all replicas to the luminaires, for all observers of a set together.
const RAYS: f64 = 1e6;
/// Standard error of a rating, from the luminaires' part alone, at which no more passes are made. Ratings are reported to a tenth.
const RATING_ERROR: f64 = 0.01;
/// Change of a rating per change of the natural logarithm of the luminaires' sum. Per decimal logarithm it is 8.
const UGR_PER_LOG_SUM: f64 = 8.0 / std::f64::consts::LN_10;
/// Passes over the luminaires in a replica: fewest for one observer, fewest for a grid of observers, and most.
const FEWEST_PASSES: u64 = 4;
const FEWEST_PASSES_OF_MANY: u64 = 1;
const MOST_PASSES: u64 = 512;
/// Most luminaires that a sentence names.
const MOST_NAMES: usize = 3;

/// Rates the observers of a finished job, without those inside solids. Empty if the job is not about glare.
pub(super) fn rate(context: &Context, job: &Job) -> Vec<GlareRating> {
    let MapKind::Receivers(set) = job.kind else {
        return Vec::new();
    };
    let receivers = &context.scene.receivers[set];
    let Quantity::Glare(background) = receivers.quantity else {
        return Vec::new();
    };
    let seen = receivers.observers.iter().enumerate().filter(|(_, observer)| !observer.inside);
    // Every observer has a site, or all share the sites on the walls.
    let sites = |index: usize| match background {
        Background::Observer => index..index + 1,
        Background::Tabular => 0..job.weights.len(),
    };
    seen.map(|(index, observer)| rate_observer(context, job, [set, index], observer, sites(index))).collect()
}

/// Rates an observer from the luminaires in sight and the illuminance at the sites that give the background.
/// The rating is not a linear function of what the replicas estimate. It is computed from their means, and its error by the jackknife,
/// which leaves out one replica at a time.
fn rate_observer(
    context: &Context,
    job: &Job,
    [set, index]: [usize; 2],
    observer: &GlareObserver,
    sites: Range<usize>,
) -> GlareRating {
    let luminaires = context.scene.luminaires.len();
    let origin = context.world.tracer.side_origin(observer.eye_m, observer.view);
    let eye = Receiver { point_m: observer.eye_m, normal: observer.view, origin: &origin };
    let map = MapKind::Receivers(set).number();
    let mut trial = Stream::new(context.seed, Purpose::Pilot, map, 1);
    trial.seek(index as u64);
    let rays = sample_glare(context.world, &eye, &mut trial, &mut vec![0.0; luminaires]);
    let outside = outside_of_table(context.world, &eye, &mut trial, luminaires);
    let observers = context.scene.receivers[set].observers.len();
    let fewest = if observers > 1 { FEWEST_PASSES_OF_MANY } else { FEWEST_PASSES };
    let rays_of_replica = RAYS / (REPLICAS * observers) as f64;
    let most_passes = ((rays_of_replica / rays.max(1) as f64) as u64).clamp(fewest, MOST_PASSES);
    let mut by_replica = vec![vec![0.0; luminaires]; REPLICAS];
    let mut passes = 0;
    while passes < most_passes {
        let until = if passes == 0 { fewest } else { (2 * passes).min(most_passes) };
        by_replica.par_iter_mut().with_max_len(1).enumerate().for_each(|(replica, sums)| {
            let mut stream = Stream::new(context.seed, Purpose::Direct, map, replica as u32);
            for pass in passes..until {
                stream.seek(index as u64 * MOST_PASSES + pass);
                sample_glare(context.world, &eye, &mut stream, sums);
            }
        });
        passes = until;
        let of_replica = |replica: usize| by_replica[replica].iter().sum::<f64>();
        let mean = (0..REPLICAS).map(of_replica).sum::<f64>() / REPLICAS as f64;
        let rating_error = UGR_PER_LOG_SUM * standard_error(of_replica) / mean;
        // A luminaire that is hardly visible may be in none of the first passes. So all passes are made while nothing is seen.
        if mean > 0.0 && rating_error <= RATING_ERROR || (context.time_left)() == TimeLeft::LongOver {
            break;
        }
    }
    by_replica.iter_mut().flatten().for_each(|sum| *sum /= passes as f64);
    let mut contributions: Vec<(usize, f64)> = (0..luminaires)
        .map(|index| (index, by_replica.iter().map(|sums| sums[index]).sum::<f64>() / REPLICAS as f64))
        .filter(|(_, sum)| *sum > 0.0)
        .collect();
    contributions.sort_by(|one, other| other.1.total_cmp(&one.1));
    let sums: Vec<f64> = by_replica.iter().map(|sums| sums.iter().sum()).collect();
    let all_weights: f64 = job.weights[sites.clone()].iter().sum();
    let backgrounds: Vec<f64> = (0..REPLICAS)
        .map(|replica| {
            let weighed = sites.clone().map(|site| job.weights[site] * job.map.value(replica, site));
            // If all sites are inside solids, the background is unknown.
            if all_weights > 0.0 { weighed.sum::<f64>() / all_weights / PI } else { 0.0 }
        })
        .collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / REPLICAS as f64;
    let without =
        |values: &[f64], replica: usize| (mean(values) * REPLICAS as f64 - values[replica]) / (REPLICAS - 1) as f64;
    let estimate =
        |values: &[f64]| Estimate { value: mean(values), standard_error: standard_error(|replica| values[replica]) };
    let ugr = unified_glare_rating(mean(&backgrounds), mean(&sums)).map(|value| {
        let leaves: Vec<f64> = (0..REPLICAS)
            .map(|replica| {
                unified_glare_rating(without(&backgrounds, replica), without(&sums, replica)).unwrap_or(value)
            })
            .collect();
        // The jackknife's spread is (n − 1) times that of means.
        Estimate { value, standard_error: (REPLICAS - 1) as f64 * standard_error(|replica| leaves[replica]) }
    });
    GlareRating {
        set,
        observer: index,
        ugr,
        background_cd_m2: estimate(&backgrounds),
        glare_sum: estimate(&sums),
        contributions,
        outside: outside.into_iter().enumerate().filter_map(|(index, reason)| Some((index, reason?))).collect(),
    }
}

/// Reports the luminaires that do not count, as a sentence.
pub(super) fn words_on_outside(context: &Context, rating: &GlareRating) -> Option<String> {
    let name = |index: usize| context.scene.luminaires[index].name.as_str();
    let mut reasons: Vec<Outside> = rating.outside.iter().map(|(_, reason)| *reason).collect();
    reasons.sort();
    reasons.dedup();
    let groups: Vec<String> = reasons
        .iter()
        .map(|reason| {
            let members: Vec<&str> =
                rating.outside.iter().filter(|(_, other)| other == reason).map(|(index, _)| name(*index)).collect();
            let more = if members.len() > MOST_NAMES { ", …" } else { "" };
            format!(
                "{} {} ({}{more})",
                members.len(),
                reason.explanation(),
                members[..members.len().min(MOST_NAMES)].join(", ")
            )
        })
        .collect();
    (!groups.is_empty()).then(|| {
        format!(
            "{}: luminaires in sight that have no position index in CIE 117 do not count: {}",
            context.scene.receivers[rating.set].name,
            groups.join("; ")
        )
    })
}
