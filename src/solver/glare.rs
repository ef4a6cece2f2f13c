//! Glare ratings, from the background that a map's replicas know and the luminaires that the observer sees.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::job::{Context, Job};
use crate::base::glare::unified_glare_rating;
use crate::estimators::direct::Receiver;
use crate::estimators::glare::sample_glare;
use crate::maps::{Estimate, MapKind, REPLICAS, standard_error};
use crate::sampling::random::{Purpose, Stream};
use crate::scene::Quantity;

/// Rays of all replicas for the luminaires of one observer, about; a rating stays within some thousandths.
const RAYS: f64 = 1e6;
/// Passes over the luminaires in a replica.
const FEWEST_PASSES: u64 = 4;
const MOST_PASSES: u64 = 512;

/// The rating of one observer.
#[derive(Clone, Debug)]
pub struct GlareRating {
    /// The receiver's place among the scene's receiver sets.
    pub set: usize,
    /// UGR with its standard error; `None` where no luminaire is in view or nothing lights the background.
    pub ugr: Option<Estimate>,
    /// Background luminance in cd/m²: the indirect illuminance of the eye over π.
    pub background_cd_m2: Estimate,
    /// Σ L²ω/p² of the luminaires in view in cd²·sr/m⁴.
    pub glare_sum: Estimate,
}

/// Rates a finished job; `None` if it is not about glare.
///
/// The rating is no linear function of what the replicas estimate: it is taken of their means, and its error by the
/// jackknife, which leaves out one replica at a time.
pub(super) fn rate(context: &Context, job: &Job) -> Option<GlareRating> {
    let MapKind::Receivers(set) = job.kind else {
        return None;
    };
    let receivers = &context.scene.receivers[set];
    let point = receivers.points.first().filter(|_| receivers.quantity == Quantity::Glare)?;
    let origin = context.stage.tracer.side_origin(point.position_m, point.normal);
    let eye = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
    let mut trial = Stream::new(context.seed, Purpose::Pilot, MapKind::Receivers(set).number(), 1);
    let (_, rays) = sample_glare(context.stage, &eye, &mut trial);
    let passes = ((RAYS / (REPLICAS as f64 * rays.max(1) as f64)) as u64).clamp(FEWEST_PASSES, MOST_PASSES);
    let sums: Vec<f64> = (0..REPLICAS as u32)
        .into_par_iter()
        .with_max_len(1)
        .map(|replica| {
            let mut stream = Stream::new(context.seed, Purpose::Direct, MapKind::Receivers(set).number(), replica);
            let mut sum = 0.0;
            for pass in 0..passes {
                stream.seek(pass);
                sum += sample_glare(context.stage, &eye, &mut stream).0;
            }
            sum / passes as f64
        })
        .collect();
    let backgrounds: Vec<f64> = (0..REPLICAS).map(|replica| job.map.illuminance_lx(replica, 0) / PI).collect();
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
    Some(GlareRating { set, ugr, background_cd_m2: estimate(&backgrounds), glare_sum: estimate(&sums) })
}
