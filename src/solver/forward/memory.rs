//! What gathering rays are told where they meet a patch, and checks of what they are told.

use super::layer::{Light, mean_of};
use super::{Context, Forward};
use crate::estimators::direct::{Care, one_look};
use crate::estimators::walk::{Memory, Met, Recall, gather_indirect_lx};
use crate::geometry::SurfaceHit;
use crate::maps::{HalfChecks, HalfScores};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::scene::patches::PatchPlace;

/// What one replica's chains and looks left, for its own patches to gather.
pub struct Deposits<'a> {
    pub forward: &'a Forward,
    pub replica: usize,
}

impl Memory for Deposits<'_> {
    #[inline]
    fn recall(&mut self, met: &Met, _: &mut Cut, _: &mut Stream) -> (Recall, u64) {
        let hit = met.hit;
        let Some(place) = self.forward.fine.place(hit) else {
            return (Recall::Nothing, 0);
        };
        let (indirect_lx, direct_lx) = self.forward.fine.of_replica(self.replica, &place);
        match (self.forward.light_at(hit, &place), direct_lx) {
            (Light::Whole, Some(direct_lx)) => (Recall::Whole(indirect_lx + direct_lx), 0),
            _ => (Recall::End(indirect_lx), 0),
        }
    }
}

impl Forward {
    /// What a ray is told that met a patch there.
    #[inline]
    fn light_at(&self, hit: &SurfaceHit, place: &PatchPlace) -> Light {
        let tells_from_m = self.tells_direct_from_m.get(place.patch as usize);
        if tells_from_m.is_some_and(|from_m| hit.distance_m >= *from_m) { Light::Whole } else { Light::Indirect }
    }

    /// What a coarse patch says of a place in lx beyond what the fine one says, which is so much; of indirect light alone where the
    /// coarse one knows too little of the direct.
    #[inline]
    fn beyond_fine_lx(&self, light: Light, parity: usize, [fine, coarse]: [&PatchPlace; 2], fine_lx: f64) -> f64 {
        if light == Light::Whole && !self.coarse_knows_direct[coarse.patch as usize] {
            let [coarse_lx] = self.coarse.at(Light::Indirect, parity, coarse);
            return coarse_lx - mean_of(&self.fine.at(Light::Indirect, parity, fine));
        }
        let [coarse_lx] = self.coarse.at(light, parity, coarse);
        coarse_lx - fine_lx
    }
}

/// The memory of a half, which now and then checks what it says by a walk.
pub struct Recollection<'a> {
    forward: &'a Forward,
    context: &'a Context<'a>,
    parity: usize,
    /// Share of the look-ups that are checked.
    checked_share: f64,
    /// Replica of the half whose rays ask.
    pub row: usize,
    /// Weight of the present sample.
    pub weight: f64,
    /// What the present entry's rays found; the rows are for the asker to fill.
    pub scores: HalfScores,
    /// What the checks found: (what walks brought − what was remembered) times what of it was reflected, each divided by the share.
    pub checks: HalfChecks,
    /// Sum of the variances of what was remembered, weighted as it was, in lx²; only a pilot asks for it.
    pub noise: f64,
    /// Whether the noise is summed up.
    pub is_pilot: bool,
    /// Number of look-ups; only a pilot asks for it.
    pub look_ups: u64,
    /// Number of checks, and their rays.
    pub check_count: [u64; 2],
}

impl<'a> Recollection<'a> {
    /// The memory of the even (0) or the odd half (1).
    pub fn new(context: &'a Context<'a>, forward: &'a Forward, parity: usize, checked_share: f64) -> Recollection<'a> {
        Recollection {
            forward,
            context,
            parity,
            checked_share,
            row: 0,
            weight: 1.0,
            scores: HalfScores::default(),
            checks: HalfChecks::default(),
            noise: 0.0,
            is_pilot: false,
            look_ups: 0,
            check_count: [0; 2],
        }
    }
}

impl Memory for Recollection<'_> {
    #[inline]
    fn recall(&mut self, met: &Met, cut: &mut Cut, stream: &mut Stream) -> (Recall, u64) {
        let Met { hit, receiver: vertex, reflectance, .. } = met;
        let forward = self.forward;
        let Some(place) = forward.fine.place(hit) else {
            return (Recall::Nothing, 0);
        };
        if hit.distance_m < forward.near_m {
            return (Recall::Guide(mean_of(&forward.fine.at(Light::Indirect, self.parity, &place))), 0);
        }
        let light = forward.light_at(hit, &place);
        let known_lx = forward.fine.at(light, self.parity, &place);
        let mean_lx = mean_of(&known_lx);
        let weight = self.weight * reflectance;
        self.scores.columns_lx.iter_mut().zip(&known_lx).for_each(|(sum, lx)| *sum += weight * lx);
        if let Some(coarse) = forward.coarse.place(hit) {
            self.scores.coarser_lx += weight * forward.beyond_fine_lx(light, self.parity, [&place, &coarse], mean_lx);
        }
        if self.is_pilot {
            self.noise += weight * weight * forward.variance(self.parity, &place);
            self.look_ups += 1;
        }
        let mut rays = 0;
        if stream.happens(self.checked_share) {
            let mut guide = Guide { forward, parity: self.parity };
            let stage = self.context.stage;
            let (mut walked_lx, mut walk_rays) = gather_indirect_lx(stage, vertex, &mut guide, cut, stream);
            if light == Light::Whole
                && let Some(sight) = one_look(stage, (hit.triangle, hit.side), vertex, Care::Glance, cut, stream)
            {
                walked_lx += sight.direct_lx();
                walk_rays += 1;
            }
            let weight = weight / self.checked_share;
            self.checks.rows_lx[self.row] += weight * (walked_lx - mean_lx);
            let columns_lx = self.checks.columns_lx.iter_mut().zip(&known_lx);
            columns_lx.for_each(|(sum, lx)| *sum += weight * (walked_lx - lx));
            self.check_count[0] += 1;
            self.check_count[1] += walk_rays;
            rays = walk_rays;
        }
        let recall = match light {
            Light::Indirect => Recall::End(mean_lx),
            Light::Whole => Recall::Whole(mean_lx),
        };
        (recall, rays)
    }
}

/// A half's memory as the guide of a walk, which it cannot bias.
struct Guide<'a> {
    forward: &'a Forward,
    parity: usize,
}

impl Memory for Guide<'_> {
    #[inline]
    fn recall(&mut self, met: &Met, _: &mut Cut, _: &mut Stream) -> (Recall, u64) {
        let hit = met.hit;
        let fine = &self.forward.fine;
        let known_lx = fine.place(hit).map(|place| fine.at(Light::Indirect, self.parity, &place));
        (known_lx.map_or(Recall::Nothing, |lx| Recall::Guide(mean_of(&lx))), 0)
    }
}
