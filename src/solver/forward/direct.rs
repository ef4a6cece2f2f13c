//! Direct light of patches, by looks that all gathering rays share.

use rayon::prelude::*;

use super::{Context, FEWEST_SAMPLES, FORWARD, Forward, Sampled, point_of_patch};
use crate::estimators::direct::{Care, Receiver, one_look};
use crate::maps::REPLICAS;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::Law;
use crate::scene::Side;

/// A patch tells direct light to all rays if what coarser ones say of it is not surely off by more than so many roots of the error
/// asked for, over all light there: a fourteenth for 1%. Otherwise it tells those from farther away: what it has wrong within itself
/// matters with about the square of its edge over their length.
const MOST_MISFIT: f64 = 0.7;
const MISFIT_POINTS: u64 = 8;
/// Lengths of rays, over those of the others, from which on patches tell that are off by that much.
const FAR: f64 = 8.0;
/// Squares of standard errors by which chance may make them differ.
const SURE: f64 = 4.0;

impl Forward {
    /// Direct light by looks from points of every patch that is asked often.
    pub(super) fn look_at_direct(&mut self, context: &Context, samples_of: impl Fn(u32) -> u64 + Sync, error: f64) {
        let stage = context.stage;
        let look = |_: usize, spot: (u32, Side), receiver: &Receiver, cut: &mut Cut, stream: &mut Stream| {
            if !matches!(stage.law(spot.0), Law::Diffuse(law) if law.reflectance > 0.0) {
                return (0.0, 0);
            }
            let sight = one_look(stage, spot, receiver, Care::Glance, cut, stream);
            sight.map_or((0.0, 0), |sight| (sight.direct_lx(), 1))
        };
        let found = self.sampled(context, Purpose::Direct, samples_of, look);
        let is_told = |layer: usize, patch: usize| {
            found.iter().all(|found| match layer {
                0 => self.fine.is_told(patch, &found.means[0][patch]),
                _ => self.coarse.is_told(patch, &found.means[1][patch]),
            })
        };
        let is_known: Vec<bool> = (0..self.fine.patches.len()).map(|patch| is_told(0, patch)).collect();
        let coarse_knows = (0..self.coarse.patches.len()).map(|patch| is_told(1, patch)).collect();
        let dark = [self.fine.patches.len(), self.coarse.patches.len()].map(|patches| vec![[0.0; 3]; patches]);
        let of_fine = |found: &Sampled| self.fine.means_lx(&found.means[0], FEWEST_SAMPLES, &dark[0]);
        let of_coarse = |found: &Sampled| self.coarse.means_lx(&found.means[1], FEWEST_SAMPLES, &dark[1]);
        let (fine_lx, coarse_lx) = (found.iter().map(of_fine).collect(), found.iter().map(of_coarse).collect());
        let rays = found.iter().map(|found| found.rays).sum::<u64>();
        self.rays += rays;
        self.fine.direct_lx = fine_lx;
        self.coarse.direct_lx = coarse_lx;
        self.coarse_knows_direct = coarse_knows;
        let from_m = |(patch, is_known): (usize, &bool)| {
            if !is_known || context.is_over() {
                return f64::INFINITY;
            }
            let most_lx = MOST_MISFIT * error.sqrt() * self.fine.mean_lx(patch as u32);
            match self.misfit_lx2(context, patch as u32) {
                Some(misfit_lx2) if misfit_lx2.sqrt() <= most_lx => self.near_m,
                Some(misfit_lx2) => self.near_m * FAR * (misfit_lx2.sqrt() / most_lx).sqrt(),
                None => self.near_m * FAR,
            }
        };
        self.tells_direct_from_m = is_known.par_iter().enumerate().map(from_m).collect();
    }

    /// Mean square over a patch, in lx², of what coarser patches say of its direct light beyond it, what chance may have of
    /// that taken off: near luminaires and at the edges of shadows a linear function does not show it. `None` where coarser
    /// patches know nothing of it.
    fn misfit_lx2(&self, context: &Context, patch: u32) -> Option<f64> {
        let mut stream = Stream::new(context.seed, Purpose::Pilot, FORWARD, REPLICAS as u32 + 1);
        let (mut squares, mut chance_lx2, mut compared) = (0.0, 0.0, 0);
        for number in 0..MISFIT_POINTS {
            stream.seek_quasi((u64::from(patch) << 32) | number, u64::from(patch), number);
            let (point, ..) = point_of_patch(context, &self.fine.patches, patch, &mut stream);
            let fine = self.fine.patches.place(point.0, point.1, point.2);
            let coarse = self.coarse.patches.place(point.0, point.1, point.2);
            if let (Some(fine), Some(coarse)) = (fine, coarse)
                && self.coarse_knows_direct[coarse.patch as usize]
            {
                let (fine_lx, fine_lx2) = self.fine.mean_direct_lx(&fine);
                let (coarse_lx, coarse_lx2) = self.coarse.mean_direct_lx(&coarse);
                squares += (coarse_lx - fine_lx).powi(2);
                chance_lx2 += SURE * (fine_lx2 + coarse_lx2);
                compared += 1;
            }
        }
        (compared > 0).then(|| ((squares - chance_lx2) / f64::from(compared)).max(0.0))
    }
}
