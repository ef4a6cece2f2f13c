//! Elements that adapt: cut and sloped until what they cannot show is as small as a target asks.
//!
//! Direct light has edges, but little chance: its variation in every element is measured before the run, by a pilot whose
//! samples enter no result. Indirect light is smooth, but noisy: its variation shows only in the run, for whole sides of
//! surfaces together; if it is too large there, the map starts anew on finer elements. Where indirect light is gathered, it
//! has elements of its own ([`super::coarse`]), which are cut by what they lose and not by the edges of direct light.

mod first;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::first::Cutting;
use super::coarse::{CoarseElements, CoarseLoss};
use super::context::Context;
use super::empty_maps::Shows;
use super::exposure::{Exposure, exposed_shares};
use super::finer::{corners_within, cuts_of, parent_of, reference_on};
use super::side_losses::SideLosses;
use super::streams::stream_number;
use crate::estimators::direct::SamplePair;
use crate::maps::basis::{Linear, SLOPES, bends_at};
use crate::maps::{Detail, DirectDetail, ReplicaMap, Variation};
use crate::scene::Elements;

/// Share of the squared target that the whole discretisation may take in the run, and that it is brought down to where
/// it takes more and starting anew takes fewer rays than going on.
const MOST_SHARE: f64 = 0.5;
const AIM_SHARE: f64 = 0.25;
/// The part of that which indirect light may have, where it is gathered on elements of its own.
const AIM_OF_COARSE: f64 = 0.15;
/// Relative slope of illuminance over a scene's size that a constant element is taken to stand for.
const USUAL_SLOPE: f64 = 2.0;
/// Rounds of cutting in the run at most.
const RUN_ROUNDS: u32 = 12;
/// Elements of an adaptive map, at most.
const MOST_ELEMENTS: usize = 400_000;
/// Element sides that adapt in a second of a time limit: each takes some 8 µs whatever is computed, and has a tenth of the limit.
const SIDES_A_SECOND: f64 = 12_500.0;
/// Bytes of a side that adapts and gathers at the peak of a run: sums of 16 replicas with slopes, the same on the coarser elements, and what
/// tells how light varies within both (`docs/performance.md`). They may take half of the memory.
pub const BYTES_OF_A_SIDE: u64 = 6700;
/// The loss must be known this many standard errors above what is allowed to start anew.
const CERTAINTY: f64 = 2.0;

/// What a job keeps of elements that adapt, beside its sums.
#[derive(Serialize, Deserialize)]
pub struct Adaptive {
    /// Share of each element that is exposed: where something stands on it nobody sees it, and nothing is shown.
    pub exposed: Vec<f64>,
    /// Whether each element shows slopes; one that is covered in part shows none.
    pub sloped: Vec<bool>,
    /// Direct and indirect illuminance in lx that samples are compared with: the nearer they are, the less chance what
    /// the elements show has. They bias nothing.
    pub references_lx: Vec<[Linear; 2]>,
    /// How light varies within the elements, from the run's own samples.
    pub detail: Detail,
    /// How often the map started anew.
    pub rounds: u32,
    /// Rays that the pilot took.
    pub pilot_rays: u64,
    target_error: f64,
}

/// What elements cannot show.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Loss {
    /// Estimate of each element's mean square over its area in lx²; may be below 0 by chance.
    pub lost_lx2: Vec<f64>,
    /// The same less one standard error of the direct part, which is all that a single element's samples tell.
    sure_lx2: Vec<f64>,
    /// Of the whole map, weighted by area, in lx².
    pub mean_lx2: f64,
    /// Standard error of that.
    pub standard_error_lx2: f64,
    /// Of it what the elements lose that indirect light is gathered on.
    coarse: CoarseLoss,
}

/// Rays of the samples that a map has.
#[derive(Clone, Copy, Debug)]
pub struct Spent {
    /// Of direct light.
    pub direct: f64,
    /// Of indirect light.
    pub gathered: f64,
}

/// A map as a look has shown it.
pub struct Looked<'a> {
    pub elements: &'a Elements,
    pub map: &'a ReplicaMap,
    /// What indirect light is gathered on, where that is coarser.
    pub coarse: Option<&'a CoarseElements>,
    pub loss: &'a Loss,
    pub mean_lx: f64,
    pub spent: Spent,
}

/// Elements that lose less.
pub struct Refined {
    /// Those of the map with what is kept of them, where these are others than before.
    pub elements: Option<(Elements, Adaptive)>,
    /// Those that indirect light is gathered on, where these are others.
    pub coarse: Option<CoarseElements>,
}

/// Elements of a scene up to which they adapt, under a time limit and in so much memory; more stay as the scene gives them.
pub fn most_that_adapt(time_limit_s: Option<f64>, memory_bytes: u64) -> usize {
    let in_time = time_limit_s.map_or(f64::INFINITY, |limit_s| SIDES_A_SECOND * limit_s);
    let in_memory = (memory_bytes / 2 / BYTES_OF_A_SIDE) as f64;
    (MOST_ELEMENTS as f64).min(in_time).min(in_memory) as usize
}

/// Adds two looks at the direct light of a point; returns the scores of the mean and of the slopes in lx.
#[inline]
pub fn add_direct(detail: &mut DirectDetail, seen: &SamplePair, reference: &Linear) -> [f64; 1 + SLOPES] {
    let known_lx = reference.at(seen.at);
    let [one_lx, other_lx] = seen.samples_lx.map(|lx| lx - known_lx);
    let beyond_lx = 0.5 * (one_lx + other_lx);
    let bends = bends_at(seen.at);
    for (sum, bend) in detail.bends_lx.iter_mut().zip(bends) {
        *sum += beyond_lx * bend;
    }
    detail.sum_lx += beyond_lx;
    detail.product_lx2 += one_lx * other_lx;
    let [mean, first, second] = reference.0;
    [mean + beyond_lx, first + beyond_lx * bends[0], second + beyond_lx * bends[1]]
}

/// Edge in m over which elements show slopes in any case: over a smaller one light changes less than the target asks to show.
pub fn slope_from_m(context: &Context, target_error: f64) -> f64 {
    USUAL_SLOPE * target_error * (context.stage.area_m2 / 6.0).sqrt()
}

impl Adaptive {
    fn variation(&self, map: &ReplicaMap, index: usize, apart: bool) -> Variation {
        let [Linear(direct), Linear(indirect)] = self.references_lx[index];
        // Counted packets are compared with nothing.
        let known = f64::from(u8::from(apart));
        let slopes_lx = [[direct[1], direct[2]], [known * indirect[1], known * indirect[2]]];
        let whole = self.exposed[index] == 1.0;
        self.detail.variation(index, map.scales(index), slopes_lx, [apart, whole])
    }

    /// What the elements, of these areas, cannot show, by the run's samples.
    pub fn loss(
        &self,
        context: &Context,
        elements: &Elements,
        areas_m2: &[f64],
        map: &ReplicaMap,
        coarse: Option<&CoarseElements>,
    ) -> Loss {
        let variations: Vec<Variation> =
            (0..elements.len()).into_par_iter().map(|index| self.variation(map, index, coarse.is_some())).collect();
        let sides = SideLosses::of(context, elements, areas_m2, self.shows(), &variations);
        let mut loss =
            Loss { coarse: coarse.map(|coarse| coarse.loss(context)).unwrap_or_default(), ..Loss::default() };
        let (mut sum_lx2_m2, mut variance) = (loss.coarse.sum_lx2_m2, loss.coarse.variance);
        for (index, (variation, area_m2)) in variations.iter().zip(areas_m2).enumerate() {
            // Of one that is covered in part only the coarse element above it can tell, where there is one.
            let smooth_lx2 = match coarse {
                Some(_) if self.exposed[index] < 1.0 => 0.0,
                _ => sides.lx2(context, elements, index, *area_m2, self.shows()),
            };
            let parent = coarse.map(|coarse| coarse.children[index].parent as usize);
            let of_coarse_lx2 = parent.map_or(0.0, |parent| loss.coarse.lost_lx2[parent]);
            loss.lost_lx2.push(variation.direct_lx2 + smooth_lx2 + of_coarse_lx2);
            loss.sure_lx2.push((variation.direct_lx2 - variation.direct_noise.sqrt()).max(0.0) + smooth_lx2.max(0.0));
            sum_lx2_m2 += area_m2 * (variation.direct_lx2 + smooth_lx2);
            variance += area_m2 * area_m2 * noise_of(variation, self.sloped[index]);
        }
        let area_m2: f64 = areas_m2.iter().sum();
        (loss.mean_lx2, loss.standard_error_lx2) = (sum_lx2_m2 / area_m2, variance.sqrt() / area_m2);
        loss
    }

    /// Whether the elements surely lose more than this share of the squared target.
    pub fn loses_over(&self, share: f64, loss: &Loss, mean_lx: f64) -> bool {
        let target_lx2 = (self.target_error * mean_lx).powi(2);
        loss.mean_lx2 - CERTAINTY * loss.standard_error_lx2 > share * target_lx2
    }

    /// Finer elements, where these lose too much for the target by all that a look has shown; `None` where they do not, where
    /// going on with them takes fewer rays all the same, or where nothing finer is allowed.
    ///
    /// `rays_to` tells how many rays more bring chance down to an error in lx.
    pub fn refined(&self, context: &Context, looked: &Looked, rays_to: impl Fn(f64) -> f64) -> Option<Refined> {
        let Looked { elements, map, coarse, loss, mean_lx, spent } = *looked;
        let target_lx2 = (self.target_error * mean_lx).powi(2);
        let rounds = self.rounds.max(coarse.map_or(0, |coarse| coarse.shape.rounds));
        if rounds >= RUN_ROUNDS || !self.loses_over(MOST_SHARE, loss, mean_lx) {
            return None;
        }
        let of_coarse = if coarse.is_some() { AIM_OF_COARSE } else { 0.0 };
        let goal_lx2 = (AIM_SHARE - of_coarse) * target_lx2;
        let cuts = cuts_of(context, elements, loss.sure_lx2.iter().copied(), goal_lx2, MOST_ELEMENTS);
        let coarse_cuts =
            coarse.map(|coarse| coarse.cuts(context, &loss.coarse, of_coarse * target_lx2, MOST_ELEMENTS));
        let mut finer = elements.cut(|element| cuts[element as usize]);
        let finer_coarse =
            coarse.zip(coarse_cuts).map(|(coarse, cuts)| coarse.elements.cut(|element| cuts[element as usize]));
        if let Some(finer_coarse) = &finer_coarse {
            finer = finer.cut_like(finer_coarse);
        }
        let finer_coarse =
            finer_coarse.filter(|finer| coarse.is_some_and(|coarse| coarse.elements.len() < finer.len()));
        // Going on as they are, what chance may have is less; starting anew, what was done is lost.
        let share = (loss.mean_lx2 + loss.standard_error_lx2) / target_lx2;
        let chance_lx = |share: f64| (target_lx2 * (1.0 - share)).sqrt();
        let times = |finer: usize, before: usize| finer as f64 / before.max(1) as f64;
        let lost_rays = match (coarse, &finer_coarse) {
            (Some(coarse), Some(finer)) => spent.gathered * times(finer.len(), coarse.elements.len()),
            (Some(_), None) => 0.0,
            (None, _) => spent.gathered * times(finer.len(), elements.len()),
        };
        let anew = spent.direct * times(finer.len(), elements.len()) + lost_rays + rays_to(chance_lx(AIM_SHARE));
        if share < 1.0 && rays_to(chance_lx(share)) <= anew {
            return None;
        }
        let adaptive = (finer.len() > elements.len()).then(|| self.on_finer(context, elements, &finer, map));
        let refined = Refined {
            coarse: coarse.zip(finer_coarse).map(|(coarse, finer_coarse)| {
                let exposed = adaptive.as_ref().map_or(&self.exposed, |adaptive| &adaptive.exposed);
                coarse.cut(context, finer_coarse, &finer, exposed)
            }),
            elements: adaptive.map(|adaptive| (finer, adaptive)),
        };
        (refined.elements.is_some() || refined.coarse.is_some()).then_some(refined)
    }

    /// What is kept of finer elements, from what these have shown.
    fn on_finer(&self, context: &Context, elements: &Elements, finer: &Elements, map: &ReplicaMap) -> Adaptive {
        let parents: Vec<u32> = (0..finer.len() as u32).map(|index| parent_of(elements, finer, index)).collect();
        let was_cut = |index: usize| finer.element(index as u32).cuts() > elements.element(parents[index]).cuts();
        let (exposed, pilot_rays) = exposed_shares(context, finer, 0..finer.len(), |index| {
            let before = self.exposed[parents[index as usize] as usize];
            if before == 0.0 || !was_cut(index as usize) { Exposure::Known(before) } else { Exposure::Unknown }
        });
        let is_sloped = |(index, parent): (usize, &u32)| {
            // Constant elements that were cut lost too much by their slopes.
            exposed[index] == 1.0 && (self.sloped[*parent as usize] || was_cut(index))
        };
        let references = |(index, parent): (usize, &u32)| {
            let corners = corners_within(elements, finer, index as u32, *parent);
            map.parts_lx(*parent as usize).map(|part| reference_on(Linear(part), corners, exposed[index]))
        };
        Adaptive {
            sloped: parents.iter().enumerate().map(is_sloped).collect(),
            references_lx: parents.iter().enumerate().map(references).collect(),
            exposed: exposed.clone(),
            detail: Detail::new(finer.len()),
            rounds: self.rounds + 1,
            pilot_rays,
            target_error: self.target_error,
        }
    }

    /// Shows slopes wherever the coarse elements do that indirect light is gathered on, and compares with what these do.
    pub fn stand_on(&mut self, coarse: &CoarseElements) {
        for (site, child) in coarse.children.iter().enumerate() {
            let whole = self.exposed[site] == 1.0;
            self.sloped[site] |= whole && coarse.shows_slopes(site);
            let Linear([mean, first, second]) = child.on(&coarse.shape.references_lx[child.parent as usize]);
            self.references_lx[site][1] = Linear(if whole { [mean, first, second] } else { [mean, 0.0, 0.0] });
        }
    }

    /// What of the elements is shown.
    pub fn shows(&self) -> Shows<'_> {
        (&self.sloped, &self.exposed)
    }

    /// Target that the elements adapt to.
    pub fn target_error(&self) -> f64 {
        self.target_error
    }

    /// Adapts to another target from now on.
    pub fn aim_at(&mut self, target_error: f64) {
        self.target_error = target_error;
    }

    /// Number of the element map's streams in this round: a map that starts anew draws anew.
    pub fn stream_number(&self) -> u32 {
        stream_number(self.rounds)
    }
}

fn noise_of(variation: &Variation, sloped: bool) -> f64 {
    let slopes = if sloped { 0.0 } else { variation.slope_noise };
    variation.direct_noise + variation.indirect_noise + slopes
}
