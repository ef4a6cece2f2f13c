//! Elements that adapt: they are cut and given slopes until what they cannot show is as small as a target requires.
//! Direct light has edges but little random error. A pilot, whose samples enter no result, measures its variation in every element before
//! the run. Indirect light is smooth but noisy. Its variation shows only in the run, for whole sides of surfaces together. If it is too
//! large there, the map starts anew on finer elements. If indirect light is gathered, it has elements of its own ([`super::coarse`]). They
//! are cut by what they lose and not by the edges of direct light.

mod first;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::first::Cutting;
use super::coarse::{CoarseElements, CoarseLoss};
use super::contact::{KnownContact, contact_free_shares};
use super::context::Context;
use super::empty_maps::Shows;
use super::finer::{corners_within, cuts_of, parent_of, reference_on};
use super::side_losses::SideLosses;
use super::streams::stream_number;
use crate::estimators::direct::SamplePair;
use crate::maps::basis::{Linear, SLOPES, bends_at};
use crate::maps::{Detail, DirectDetail, ReplicaMap, Variation};
use crate::scene::Elements;

/// Largest share of the squared target that the whole discretisation may take in the run. Above it, if starting anew takes fewer rays than
/// going on, the discretisation is reduced to the second share.
const MOST_SHARE: f64 = 0.5;
const AIM_SHARE: f64 = 0.25;
/// The part of the second share for indirect light, if it is gathered on elements of its own.
const AIM_OF_COARSE: f64 = 0.15;
/// Relative slope of illuminance over the size of a scene that is assumed for a constant element.
const USUAL_SLOPE: f64 = 2.0;
/// Most rounds of cutting in the run.
const RUN_ROUNDS: u32 = 12;
/// Most elements of an adaptive map.
const MOST_ELEMENTS: usize = 400_000;
/// Element sides that adapt per second of a time limit. Each takes some 8 µs whatever is computed, and all may take a tenth of the limit.
const SIDES_A_SECOND: f64 = 12_500.0;
/// Peak memory in bytes of an element side that adapts and gathers: sums of 16 replicas with slopes, the same on the coarse elements, and
/// the variation of light within both (`docs/performance.md`). They may take half of the memory.
pub const BYTES_OF_A_SIDE: u64 = 6700;
/// To start anew, the loss must be this many standard errors above the allowed loss.
const CERTAINTY: f64 = 2.0;

/// What a job stores for elements that adapt, in addition to its sums.
#[derive(Serialize, Deserialize)]
pub struct Adaptive {
    /// Share of each element that is free of contact. The rest is hidden by contact: nobody sees it and nothing is shown there.
    pub contact_free: Vec<f64>,
    /// Whether each element shows slopes. An element partly hidden by contact shows none.
    pub sloped: Vec<bool>,
    /// Direct and indirect illuminance in lx that samples are compared with. The closer they are, the less random error have the values
    /// that the elements show. They cause no bias.
    pub references_lx: Vec<[Linear; 2]>,
    /// Variation of light within the elements, from the run's own samples.
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
    /// Estimate of each element's mean square over its area in lx². It may be below 0 by random error.
    pub lost_lx2: Vec<f64>,
    /// The same less one standard error of the direct part. The samples of a single element show no more than this.
    sure_lx2: Vec<f64>,
    /// Mean over the whole map, weighted by area, in lx².
    pub mean_lx2: f64,
    /// Standard error of that mean.
    pub standard_error_lx2: f64,
    /// The part of it lost by the elements on which indirect light is gathered.
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

/// A map as found at a look.
pub struct Looked<'a> {
    pub elements: &'a Elements,
    pub map: &'a ReplicaMap,
    /// The elements on which indirect light is gathered, if they are coarser.
    pub coarse: Option<&'a CoarseElements>,
    pub loss: &'a Loss,
    pub mean_lx: f64,
    pub spent: Spent,
}

/// Elements that lose less.
pub struct Refined {
    /// Elements of the map and what is stored for them, if they have changed.
    pub elements: Option<(Elements, Adaptive)>,
    /// Elements on which indirect light is gathered, if they have changed.
    pub coarse: Option<CoarseElements>,
}

/// Most elements of a scene that adapt, under a time limit and with this much memory. If a scene has more, they stay as given.
pub fn most_that_adapt(time_limit_s: Option<f64>, memory_bytes: u64) -> usize {
    let in_time = time_limit_s.map_or(f64::INFINITY, |limit_s| SIDES_A_SECOND * limit_s);
    let in_memory = (memory_bytes / 2 / BYTES_OF_A_SIDE) as f64;
    (MOST_ELEMENTS as f64).min(in_time).min(in_memory) as usize
}

/// Adds two samples of the direct light of a point. Returns the scores of the mean and of the slopes in lx.
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

/// Edge in m above which elements show slopes in any case. Over a smaller edge light changes less than the target requires.
pub fn slope_from_m(context: &Context, target_error: f64) -> f64 {
    USUAL_SLOPE * target_error * (context.world.area_m2 / 6.0).sqrt()
}

impl Adaptive {
    fn variation(&self, map: &ReplicaMap, index: usize, apart: bool) -> Variation {
        let [Linear(direct), Linear(indirect)] = self.references_lx[index];
        // Counted packets are not compared with a reference.
        let known = f64::from(u8::from(apart));
        let slopes_lx = [[direct[1], direct[2]], [known * indirect[1], known * indirect[2]]];
        let whole = self.contact_free[index] == 1.0;
        self.detail.variation(index, map.scales(index), slopes_lx, [apart, whole])
    }

    /// What the elements, with these areas, cannot show, from the run's samples.
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
            // For an element partly hidden by contact, only the coarse element above it can show this, if there is one.
            let smooth_lx2 = match coarse {
                Some(_) if self.contact_free[index] < 1.0 => 0.0,
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

    /// Finer elements, if at a look the present ones lose too much for the target. `None` if they do not, if going on with them still takes
    /// fewer rays, or if nothing finer is allowed.
    /// `rays_to` returns how many more rays reduce the random error to an error in lx.
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
        // Going on with the present elements leaves less of the target for random error. Starting anew loses the work done.
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
                let contact_free = adaptive.as_ref().map_or(&self.contact_free, |adaptive| &adaptive.contact_free);
                coarse.cut(context, finer_coarse, &finer, contact_free)
            }),
            elements: adaptive.map(|adaptive| (finer, adaptive)),
        };
        (refined.elements.is_some() || refined.coarse.is_some()).then_some(refined)
    }

    /// What is stored for finer elements, from what the present ones have shown.
    fn on_finer(&self, context: &Context, elements: &Elements, finer: &Elements, map: &ReplicaMap) -> Adaptive {
        let parents: Vec<u32> = (0..finer.len() as u32).map(|index| parent_of(elements, finer, index)).collect();
        let was_cut = |index: usize| finer.element(index as u32).cuts() > elements.element(parents[index]).cuts();
        let (contact_free, pilot_rays) = contact_free_shares(context, finer, 0..finer.len(), |index| {
            let before = self.contact_free[parents[index as usize] as usize];
            if before == 0.0 || !was_cut(index as usize) { KnownContact::Known(before) } else { KnownContact::Unknown }
        });
        let is_sloped = |(index, parent): (usize, &u32)| {
            // Constant elements that were cut lost too much by their slopes.
            contact_free[index] == 1.0 && (self.sloped[*parent as usize] || was_cut(index))
        };
        let references = |(index, parent): (usize, &u32)| {
            let corners = corners_within(elements, finer, index as u32, *parent);
            map.parts_lx(*parent as usize).map(|part| reference_on(Linear(part), corners, contact_free[index]))
        };
        Adaptive {
            sloped: parents.iter().enumerate().map(is_sloped).collect(),
            references_lx: parents.iter().enumerate().map(references).collect(),
            contact_free: contact_free.clone(),
            detail: Detail::new(finer.len()),
            rounds: self.rounds + 1,
            pilot_rays,
            target_error: self.target_error,
        }
    }

    /// Shows slopes wherever the coarse elements that gather indirect light do, and uses their values as references.
    pub fn stand_on(&mut self, coarse: &CoarseElements) {
        for (site, child) in coarse.children.iter().enumerate() {
            let whole = self.contact_free[site] == 1.0;
            self.sloped[site] |= whole && coarse.shows_slopes(site);
            let Linear([mean, first, second]) = child.on(&coarse.shape.references_lx[child.parent as usize]);
            self.references_lx[site][1] = Linear(if whole { [mean, first, second] } else { [mean, 0.0, 0.0] });
        }
    }

    /// Which slopes and which parts of the elements are shown.
    pub fn shows(&self) -> Shows<'_> {
        (&self.sloped, &self.contact_free)
    }

    /// Target that the elements adapt to.
    pub fn target_error(&self) -> f64 {
        self.target_error
    }

    /// Adapts to another target from now on.
    pub fn aim_at(&mut self, target_error: f64) {
        self.target_error = target_error;
    }

    /// Number of the element map's streams in this round. A map that starts anew uses new random numbers.
    pub fn stream_number(&self) -> u32 {
        stream_number(self.rounds)
    }
}

fn noise_of(variation: &Variation, sloped: bool) -> f64 {
    let slopes = if sloped { 0.0 } else { variation.slope_noise };
    variation.direct_noise + variation.indirect_noise + slopes
}
