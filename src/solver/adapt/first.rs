//! The first elements of a map whose elements adapt. A pilot cuts them for direct light before the run, a little at a time, so that the run
//! can report its state meanwhile.

use std::ops::Range;

use rayon::prelude::*;

use super::piloted::{DirectSamples, PilotedElement};
use super::{Adaptive, samples_to_error, slope_from_m};
use crate::estimators::basis::Linear;
use crate::estimators::element::Element;
use crate::estimators::expected_light::{ExpectedLight, FoundOfEmitter};
use crate::maps::Detail;
use crate::scene::Elements;
use crate::solver::contact::{KnownContact, contact_free_shares};
use crate::solver::context::Context;
use crate::solver::finer::{corners_within, cuts_of, parent_of};
use crate::solver::pace::TimeLeft;

/// Share of the squared target that the variation of direct light within elements may take before the run.
const DIRECT_SHARE: f64 = 0.15;
/// Points of the pilot in an element, and the largest factor on them in an element above the mean size. A corner that a shadow's edge cuts
/// off is missed more easily with fewer points, and costs more in a larger element.
const POINTS: f64 = 12.0;
const MOST_TIMES: f64 = 16.0;
/// Most rounds of the pilot.
const PILOT_ROUNDS: u32 = 10;
/// Above this number of elements the pilot is left out: the run's own samples show as much.
const MOST_PILOTED: usize = 20_000;
/// Fewest elements of one step: enough to be shared out over threads.
const FEWEST_AT_ONCE: usize = 16;
/// Approximate rays of a point that is tested for contact occlusion.
const RAYS_OF_A_CONTACT_POINT: f64 = 2.0;

/// Elements in the making: they are sampled and cut in turns, then tested for contact occlusion.
pub struct Cutting {
    target_error: f64,
    /// Approximate mean of direct and indirect illuminance over the scene.
    means_lx: [f64; 2],
    /// Approximate rays of a sample of a point.
    rays_of_a_sample: f64,
    elements: Elements,
    samples: Vec<DirectSamples>,
    /// What was found of each emitter, for each element; of its parent for elements that have not been sampled.
    found: Vec<Vec<FoundOfEmitter>>,
    /// Mean area of the elements of this round.
    mean_m2: f64,
    round: u32,
    /// Number of elements sampled in this round; or, if all rounds are done, the number tested for contact occlusion.
    done: usize,
    /// Share of each element that is free of contact, as far as it has been tested; `None` before the last round is done.
    contact_free: Option<Vec<f64>>,
    rays: u64,
}

impl Cutting {
    /// Begins with the given elements. `means_lx` is approximately the mean of direct and indirect illuminance over the scene. A pass over
    /// the direct light of an element takes some `rays_of_a_pass` rays.
    pub fn begin(elements: &Elements, target_error: f64, means_lx: [f64; 2], rays_of_a_pass: f64) -> Cutting {
        Cutting {
            target_error,
            means_lx,
            rays_of_a_sample: (2.0 * rays_of_a_pass).max(1.0),
            elements: elements.clone(),
            samples: Vec::new(),
            found: Vec::new(),
            mean_m2: 0.0,
            round: 0,
            done: 0,
            contact_free: None,
            rays: 0,
        }
    }

    /// Rays that it has taken.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Rays to the end of the present round, approximately. Whether another round follows is unknown.
    pub fn rays_left(&self, context: &Context) -> f64 {
        let left = self.done..self.elements.len();
        match self.contact_free {
            Some(_) => RAYS_OF_A_CONTACT_POINT * left.len() as f64,
            None => self.rays_of_a_sample * left.map(|index| self.wanted(context, index) as f64).sum::<f64>(),
        }
    }

    /// Goes forward by some `rays` rays. Returns whether there is more to do.
    pub fn advance(&mut self, context: &Context, rays: f64) -> bool {
        if self.contact_free.is_none() {
            self.sample(context, rays);
            return true;
        }
        self.test_contact(context, rays);
        self.done < self.elements.len()
    }

    /// The elements, and what a job stores for them, once there is no more to do.
    pub fn end(self, context: &Context) -> (Elements, Adaptive) {
        let sloped: Vec<bool> = (0..self.elements.len()).map(|index| self.is_sloped(context, index)).collect();
        let contact_free = self.contact_free.unwrap_or_default();
        let error_lx = self.target_error * (self.means_lx[0] + self.means_lx[1]);
        let scatters_lx2: Vec<f64> = self.samples.iter().map(|samples| samples.scatter_lx2).collect();
        let direct_samples =
            samples_to_error(context, &self.elements, (&sloped, &contact_free), &scatters_lx2, error_lx);
        let expected = self.found.iter().zip(&self.samples);
        let expected = expected.map(|(found, samples)| ExpectedLight::of(found, samples.points).0).collect();
        let adaptive = Adaptive {
            sloped,
            direct_samples,
            expected,
            references_lx: self
                .samples
                .iter()
                .map(|samples| [samples.reference_lx(), Linear::even(self.means_lx[1])])
                .collect(),
            contact_free,
            detail: Detail::new(self.elements.len()),
            rounds: 0,
            pilot_rays: self.rays,
            target_error: self.target_error,
        };
        (self.elements, adaptive)
    }

    /// Mean square in lx² that elements may lose of direct light.
    fn goal_lx2(&self) -> f64 {
        DIRECT_SHARE * (self.target_error * (self.means_lx[0] + self.means_lx[1])).powi(2)
    }

    fn is_sloped(&self, context: &Context, index: usize) -> bool {
        let (samples, edge_m) = (&self.samples[index], (2.0 * self.area_m2(context, index)).sqrt());
        // A small element may still need slopes for its direct light: two more numbers show more of it than three more children.
        let is_steep = || samples.slope_lx2() > self.goal_lx2().max(f64::MIN_POSITIVE);
        samples.contact_free == 1.0 && (edge_m > slope_from_m(context, self.target_error) || is_steep())
    }

    fn area_m2(&self, context: &Context, index: usize) -> f64 {
        self.elements.area_m2(context.scene, self.elements.element(index as u32))
    }

    /// Points of an element to sample in this round; 0 if about as many have been sampled already.
    fn wanted(&self, context: &Context, index: usize) -> usize {
        let over_mean = if self.mean_m2 > 0.0 { self.area_m2(context, index) / self.mean_m2 } else { 1.0 };
        let points = (POINTS * over_mean.clamp(1.0, MOST_TIMES)) as usize;
        let seen = self.samples.get(index).map_or(0, |samples| samples.points);
        if 2 * seen <= points { points } else { 0 }
    }

    /// Samples some of the new elements, and again those that are now large relative to the others. Cuts after the last.
    fn sample(&mut self, context: &Context, rays: f64) {
        if self.elements.len() > MOST_PILOTED {
            self.end_sampling();
            return;
        }
        if self.done == 0 {
            self.samples.resize(self.elements.len(), DirectSamples::default());
            self.found.resize(self.elements.len(), Vec::new());
            let all_m2: f64 = (0..self.elements.len()).map(|index| self.area_m2(context, index)).sum();
            self.mean_m2 = all_m2 / self.elements.len() as f64;
        }
        let (mut end, mut points) = (self.done, 0);
        while end < self.elements.len()
            && (end < self.done + FEWEST_AT_ONCE || points as f64 * self.rays_of_a_sample < rays)
        {
            points += self.wanted(context, end);
            end += 1;
        }
        let range = self.done..end;
        self.rays += self.sample_range(context, range.clone());
        self.done = range.end;
        if self.done == self.elements.len() {
            self.cut(context);
        }
    }

    /// Cuts elements that lose too much. If none does, or there is no time for another round, this was the last round.
    fn cut(&mut self, context: &Context) {
        let lost_lx2 = |(index, samples): (usize, &DirectSamples)| samples.lost_lx2(self.is_sloped(context, index));
        let lost_lx2 = self.samples.iter().enumerate().map(lost_lx2);
        let cuts = cuts_of(context, &self.elements, lost_lx2, self.goal_lx2(), MOST_PILOTED);
        let is_last = self.round == PILOT_ROUNDS || (context.time_left)() != TimeLeft::Enough;
        if is_last || cuts.iter().all(|cuts| *cuts == 0) {
            self.end_sampling();
            return;
        }
        let finer = self.elements.cut(|element| cuts[element as usize]);
        let of_parent = |index: u32| {
            let parent = parent_of(&self.elements, &finer, index);
            let found = &self.found[parent as usize];
            if finer.element(index) == self.elements.element(parent) {
                return (self.samples[parent as usize], found.clone());
            }
            let corners = corners_within(&self.elements, &finer, index, parent);
            (DirectSamples::default(), found.iter().map(|found| found.on_piece(corners)).collect())
        };
        (self.samples, self.found) = (0..finer.len() as u32).map(of_parent).unzip();
        (self.elements, self.round, self.done) = (finer, self.round + 1, 0);
    }

    /// Ends sampling. Elements without samples (there were too many for the pilot) get the mean direct illuminance.
    fn end_sampling(&mut self) {
        let sampled = || self.samples.iter().filter(|samples| samples.points > 0);
        let scatter_lx2 = sampled().map(|samples| samples.scatter_lx2).sum::<f64>() / sampled().count().max(1) as f64;
        self.samples.resize(self.elements.len(), DirectSamples::default());
        self.found.resize(self.elements.len(), Vec::new());
        let direct_lx = self.means_lx[0];
        for samples in self.samples.iter_mut().filter(|samples| samples.points == 0) {
            (samples.mean_lx, samples.fitted_lx, samples.scatter_lx2) =
                (direct_lx, Linear::even(direct_lx), scatter_lx2);
        }
        (self.contact_free, self.done) = (Some(Vec::new()), 0);
    }

    /// Tests the next elements for contact occlusion, as far as the samples have not decided it.
    fn test_contact(&mut self, context: &Context, rays: f64) {
        let at_once = ((rays / RAYS_OF_A_CONTACT_POINT) as usize).max(FEWEST_AT_ONCE);
        let range = self.done..(self.done + at_once).min(self.elements.len());
        let (contact_free, rays) =
            contact_free_shares(context, &self.elements, range.clone(), |index| match self.samples[index as usize] {
                DirectSamples { points: 0, .. } => KnownContact::Unknown,
                DirectSamples { contact_free, .. } if contact_free > 0.0 && contact_free < 1.0 => KnownContact::InPart,
                DirectSamples { contact_free, .. } => KnownContact::Known(contact_free),
            });
        self.samples[range.clone()]
            .iter_mut()
            .zip(&contact_free)
            .for_each(|(samples, contact_free)| samples.contact_free = *contact_free);
        self.contact_free.get_or_insert_default().extend(contact_free);
        self.rays += rays;
        self.done = range.end;
    }

    /// Samples the elements of a range, as far as they need it. Returns the rays it took.
    fn sample_range(&mut self, context: &Context, range: Range<usize>) -> u64 {
        let wanted: Vec<usize> = range.clone().map(|index| self.wanted(context, index)).collect();
        let (elements, round) = (&self.elements, self.round);
        let samples = self.samples[range.clone()].par_iter_mut().zip(&mut self.found[range.clone()]);
        let rays = samples.zip(wanted).enumerate().map(|(place, ((samples, found), points))| {
            if points == 0 || context.is_over() {
                return 0;
            }
            let index = range.start + place;
            let element = Element::of(context.world, context.scene, elements, index as u32);
            let piloted = PilotedElement { context, element, index: index as u64, round };
            let rays;
            (*samples, *found, rays) = piloted.sampled(points, found);
            rays
        });
        rays.sum()
    }
}
