//! Coarse elements: elements on which the indirect light of adaptive elements is gathered.
//! Direct light has edges but little random error, and elements are cut along its edges. Indirect light is smooth but noisy, and takes rays
//! on every element that gathers it. So it is gathered on coarser elements, as large as possible. The elements of the map are their
//! children. The mean and slopes of a coarse element are shown on all of its children.

use serde::{Deserialize, Serialize};

use super::allotment::Allotment;
use super::context::Context;
use super::empty_maps::{Shows, element_weights_m2};
use super::finer::{corners_within, cuts_of, parent_of, reference_on};
use super::side_losses::SideLosses;
use super::streams::stream_number;
use crate::estimators::basis::Linear;
use crate::maps::{ChildElement, IndirectDetail, ReplicaMap, Unit, Variation};
use crate::scene::Elements;

/// Standard errors that are subtracted from the apparent loss of a single element, so that random error does not cut it.
const SURE: f64 = 3.0;

/// Elements on which indirect light is gathered, and what was gathered.
#[derive(Serialize, Deserialize)]
pub struct CoarseElements {
    /// The elements.
    pub elements: Elements,
    /// What was gathered: only indirect light.
    pub map: ReplicaMap,
    /// Areas in m² of all entries of the map; 0 for slopes that are not shown.
    pub weights_m2: Vec<f64>,
    /// Share of each element that is free of contact.
    pub contact_free: Vec<f64>,
    /// Whether each element shows slopes.
    pub sloped: Vec<bool>,
    /// Data that the elements keep in addition to their sums.
    pub shape: Shape,
    /// How the elements of the job's map lie in them.
    pub children: Vec<ChildElement>,
}

/// Data that elements that gather keep in addition to their sums.
#[derive(Serialize, Deserialize)]
pub struct Shape {
    /// Indirect illuminance in lx that samples are compared with. It causes no bias.
    pub references_lx: Vec<Linear>,
    /// Variation of light within the elements.
    pub detail: IndirectDetail,
    /// How often they were cut.
    pub rounds: u32,
    /// Gathering rays of each element in a pass.
    pub rays: Allotment,
}

/// What coarse elements cannot show.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct CoarseLoss {
    /// Mean square of each element over its area in lx². It may be below 0 by random error.
    pub lost_lx2: Vec<f64>,
    /// The loss by which elements are cut, in lx².
    sure_lx2: Vec<f64>,
    /// Sum over all elements of area times loss, in lx² m², and the part of it that is sure.
    pub sum_lx2_m2: f64,
    pub sure_lx2_m2: f64,
    /// Variance of that sum.
    pub variance: f64,
}

impl Shape {
    /// Number of the streams of this round.
    pub fn stream_number(&self) -> u32 {
        stream_number(self.rounds)
    }
}

impl CoarseElements {
    /// Joins the elements of a map to elements with edges of about `edge_m`. Those with edges over `slope_from_m` show slopes.
    pub fn first(
        context: &Context,
        fine: &Elements,
        fine_contact_free: &[f64],
        [edge_m, slope_from_m]: [f64; 2],
        indirect_lx: f64,
    ) -> CoarseElements {
        let elements = fine.joined(context.scene, edge_m);
        let count = elements.len();
        let contact_free = contact_free_of(context, &elements, fine, fine_contact_free);
        let is_sloped = |index: usize| {
            let area_m2 = elements.area_m2(context.scene, elements.element(index as u32));
            contact_free[index] == 1.0 && (2.0 * area_m2).sqrt() > slope_from_m
        };
        let sloped = (0..count).map(is_sloped).collect();
        let references_lx = vec![Linear::even(indirect_lx); count];
        CoarseElements::new(context, elements, (sloped, contact_free), references_lx, 0, fine)
    }

    fn new(
        context: &Context,
        elements: Elements,
        (sloped, contact_free): (Vec<bool>, Vec<f64>),
        references_lx: Vec<Linear>,
        rounds: u32,
        fine: &Elements,
    ) -> CoarseElements {
        let weights = element_weights_m2(context, &elements, Some((&sloped, &contact_free)));
        let shape = Shape { references_lx, detail: IndirectDetail::new(0), rounds, rays: Allotment::default() };
        let children = children_of(&elements, fine);
        let mut coarse = CoarseElements {
            elements,
            map: ReplicaMap::linear(0, Unit::Scores),
            weights_m2: weights,
            contact_free,
            sloped,
            shape,
            children,
        };
        coarse.restart();
        coarse
    }

    /// Which slopes and which parts of the elements are shown.
    fn shows(&self) -> Shows<'_> {
        (&self.sloped, &self.contact_free)
    }

    /// Forgets what was gathered.
    pub fn restart(&mut self) {
        let sites = self.elements.len();
        self.map = ReplicaMap::linear(sites, Unit::Scores);
        self.shape.detail = IndirectDetail::new(sites);
    }

    /// Keeps what was gathered for a map whose elements have become finer. Returns whether that is possible. It is not possible if the
    /// finer ones show that something hides what seemed free, or the other way round.
    pub fn lay_under(&mut self, context: &Context, fine: &Elements, fine_contact_free: &[f64]) -> bool {
        let contact_free = contact_free_of(context, &self.elements, fine, fine_contact_free);
        let kind = |share: &f64| (*share > 0.0, *share < 1.0);
        if contact_free.iter().zip(&self.contact_free).any(|(now, before)| kind(now) != kind(before)) {
            return false;
        }
        self.contact_free = contact_free;
        self.weights_m2 = element_weights_m2(context, &self.elements, Some(self.shows()));
        self.children = children_of(&self.elements, fine);
        true
    }

    /// Whether the parent of the element `site` shows slopes.
    pub fn shows_slopes(&self, site: usize) -> bool {
        self.sloped[self.children[site].parent as usize]
    }

    fn variation(&self, index: usize) -> Variation {
        let Linear([_, first, second]) = self.shape.references_lx[index];
        let whole = self.contact_free[index] == 1.0;
        self.shape.detail.variation(index, self.map.scales(index).1, [first, second], whole)
    }

    /// What they cannot show, from all that was gathered.
    pub fn loss(&self, context: &Context) -> CoarseLoss {
        let sites = self.elements.len();
        let variations: Vec<Variation> = (0..sites).map(|index| self.variation(index)).collect();
        let (areas_m2, sloped) = (&self.weights_m2[..sites], &self.sloped);
        let sides =
            SideLosses::of(context, &self.elements, (areas_m2, &self.shape.detail.near_lx), self.shows(), &variations);
        let mut loss = CoarseLoss { sure_lx2_m2: sides.sure_m2_lx2(|_| [0.0; 2]), ..CoarseLoss::default() };
        for (index, (variation, area_m2)) in variations.iter().zip(areas_m2).enumerate() {
            let smooth_lx2 = sides.lx2(index, *area_m2, self.shows());
            let (of_slope, noise_of_slope) =
                if sloped[index] { (0.0, 0.0) } else { (variation.slope_lx2, variation.slope_noise) };
            let noise = variation.indirect_noise + noise_of_slope;
            // Loss that lies together on one side shows in single elements once it is significant there. An example is the shadow of a
            // bright surface.
            let alone_lx2 = variation.indirect_lx2 + of_slope - SURE * noise.sqrt();
            loss.lost_lx2.push(smooth_lx2);
            loss.sure_lx2.push(smooth_lx2.max(alone_lx2).max(0.0));
            loss.sum_lx2_m2 += area_m2 * smooth_lx2;
            loss.variance += area_m2 * area_m2 * noise;
        }
        loss
    }

    /// How often to cut each element so that all lose no more than a goal in lx².
    pub fn cuts(&self, context: &Context, loss: &CoarseLoss, goal_lx2: f64, most: usize) -> Vec<u32> {
        cuts_of(context, &self.elements, loss.sure_lx2.iter().copied(), goal_lx2, most)
    }

    /// The elements after they were cut to `elements`, under a map of elements `fine`.
    pub fn cut(
        &self,
        context: &Context,
        elements: Elements,
        fine: &Elements,
        fine_contact_free: &[f64],
    ) -> CoarseElements {
        let contact_free = contact_free_of(context, &elements, fine, fine_contact_free);
        let parents: Vec<u32> =
            (0..elements.len() as u32).map(|index| parent_of(&self.elements, &elements, index)).collect();
        let reference = |(index, parent): (usize, &u32)| {
            let [_, shown_lx] = self.map.parts_lx(*parent as usize);
            reference_on(
                Linear(shown_lx),
                corners_within(&self.elements, &elements, index as u32, *parent),
                contact_free[index],
            )
        };
        let cuts = |index: usize| elements.element(index as u32).cuts();
        let is_sloped = |(index, parent): (usize, &u32)| {
            // Constant elements that were cut lost too much by their slopes.
            let were = self.sloped[*parent as usize];
            contact_free[index] == 1.0 && (were || cuts(index) > self.elements.element(*parent).cuts())
        };
        let sloped = parents.iter().enumerate().map(is_sloped).collect();
        let references_lx = parents.iter().enumerate().map(reference).collect();
        CoarseElements::new(context, elements, (sloped, contact_free), references_lx, self.shape.rounds + 1, fine)
    }
}

/// Contact-free share of coarse elements, from that of the finer ones in them.
fn contact_free_of(context: &Context, coarse: &Elements, fine: &Elements, fine_contact_free: &[f64]) -> Vec<f64> {
    let mut found = vec![[0.0; 2]; coarse.len()];
    for (index, contact_free) in fine_contact_free.iter().enumerate() {
        let [whole_m2, contact_free_m2] = &mut found[parent_of(coarse, fine, index as u32) as usize];
        let area_m2 = fine.area_m2(context.scene, fine.element(index as u32));
        *whole_m2 += area_m2;
        *contact_free_m2 += area_m2 * contact_free;
    }
    let share = |[whole_m2, contact_free_m2]: [f64; 2]| {
        if contact_free_m2 < whole_m2 { contact_free_m2 / whole_m2 } else { 1.0 }
    };
    found.into_iter().map(share).collect()
}

fn children_of(coarse: &Elements, fine: &Elements) -> Vec<ChildElement> {
    let child = |index: u32| {
        let parent = parent_of(coarse, fine, index);
        ChildElement::of(parent, corners_within(coarse, fine, index, parent))
    };
    (0..fine.len() as u32).map(child).collect()
}
