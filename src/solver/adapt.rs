//! Elements that adapt: cut and sloped until what they cannot show is as small as a target asks.
//!
//! Direct light has edges, but little chance: its variation in every element is measured before the run, by a pilot whose
//! samples enter no result. Indirect light is smooth, but noisy: its variation shows only in the run, for whole sides of
//! surfaces together; if it is too large there, the map starts anew on finer elements.

use std::collections::HashMap;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::job::Context;
use crate::control::{ElementLoss, cuts_for};
use crate::estimators::direct::DirectPass;
use crate::estimators::element::{Element, TwoLooks};
use crate::maps::basis::{Linear, SLOPES, bends_at, slopes_at};
use crate::maps::{Detail, DirectDetail, Judgement, MapKind, ReplicaMap, Variation};
use crate::sampling::random::{Purpose, Stream};
use crate::scene::Elements;
use crate::scene::elements::MOST_CUTS;

/// Share of the squared target that direct light's variation within elements may take before the run.
const DIRECT_SHARE: f64 = 0.15;
/// Share of the squared target that the whole discretisation may take in the run, and that it is brought down to where
/// it takes more; up to so much it may stay as it is, if going on is less work than starting anew.
const MOST_SHARE: f64 = 0.5;
const AIM_SHARE: f64 = 0.25;
const BEARABLE_SHARE: f64 = 0.8;
/// Power of the squared error with which work goes: the points are quasi-random.
const WORK_EXPONENT: f64 = -2.0 / 3.0;
/// Relative slope of illuminance over a scene's size that a constant element is taken to stand for.
const USUAL_SLOPE: f64 = 2.0;
/// Points of the pilot in an element, and how often so many lie in one that is larger than the mean: a corner that a shadow's
/// edge cuts off is missed the more easily the fewer points there are, and costs the more the larger the element is.
const POINTS: f64 = 12.0;
const MOST_TIMES: f64 = 16.0;
/// Rounds of the pilot, and of the run, at most.
const PILOT_ROUNDS: u32 = 10;
const RUN_ROUNDS: u32 = 12;
/// Above so many elements the pilot is left out: the run's own samples tell as much.
const MOST_PILOTED: usize = 20_000;
/// Elements of an adaptive map, at most.
const MOST_ELEMENTS: usize = 400_000;
/// The loss must be known this many standard errors above what is allowed to start anew.
const CERTAINTY: f64 = 2.0;

/// What a job keeps of elements that adapt, beside its sums.
pub struct Adaptive {
    /// Whether each element shows slopes.
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
#[derive(Clone, Debug, Default)]
pub struct Loss {
    /// Estimate of each element's mean square over its area in lx²; may be below 0 by chance.
    pub lost_lx2: Vec<f64>,
    /// The same less one standard error of the direct part, which is all that a single element's samples tell.
    sure_lx2: Vec<f64>,
    /// Of the whole map, weighted by area, in lx².
    pub mean_lx2: f64,
    /// Standard error of that.
    pub standard_error_lx2: f64,
}

/// Elements for a target, and what a job keeps of them.
///
/// `mean_lx` is about the mean of direct and indirect illuminance over the scene.
pub fn first_elements(
    context: &Context,
    target_error: f64,
    [direct_lx, indirect_lx]: [f64; 2],
) -> (Elements, Adaptive) {
    let mut elements = context.stage.elements.clone();
    let mut looks: Vec<DirectLooks> = Vec::new();
    let mut pilot_rays = 0;
    let goal_lx2 = DIRECT_SHARE * (target_error * (direct_lx + indirect_lx)).powi(2);
    // Over a small element light changes less than the target asks to show.
    let slope_from_m = USUAL_SLOPE * target_error * (context.scene.area_m2() / 6.0).sqrt();
    // It may still need slopes for the direct light's sake: two more numbers show more of it than three more pieces.
    let slope_goal_lx2 = goal_lx2.max(f64::MIN_POSITIVE);
    let is_sloped = |elements: &Elements, index: u32, looks: Option<&DirectLooks>| {
        let edge_m = (2.0 * elements.area_m2(context.scene, elements.cell(index))).sqrt();
        edge_m > slope_from_m || looks.is_some_and(|looks| looks.slope_lx2() > slope_goal_lx2)
    };
    for round in 0..=PILOT_ROUNDS {
        if elements.len() > MOST_PILOTED {
            break;
        }
        pilot_rays += look_at_new(context, &elements, &mut looks, round);
        let losses: Vec<ElementLoss> = (0..elements.len())
            .map(|index| {
                let sloped = is_sloped(&elements, index as u32, Some(&looks[index]));
                loss_of(context, &elements, index as u32, looks[index].lost_lx2(sloped))
            })
            .collect();
        let cuts = cuts_for(&losses, goal_lx2, MOST_PILOTED);
        if round == PILOT_ROUNDS || cuts.iter().all(|cuts| *cuts == 0) || (context.is_urgent)() {
            break;
        }
        let finer = elements.cut(|cell| cuts[cell as usize]);
        looks = (0..finer.len() as u32)
            .map(|index| {
                let above = cell_above(&elements, &finer, index);
                let kept = finer.cell(index) == elements.cell(above);
                if kept { looks[above as usize] } else { DirectLooks::default() }
            })
            .collect();
        elements = finer;
    }
    let sloped = (0..elements.len()).map(|index| is_sloped(&elements, index as u32, looks.get(index))).collect();
    let even = |lx: f64| Linear([lx, 0.0, 0.0]);
    let reference =
        |index: usize| [looks.get(index).map_or(even(direct_lx), |looks| looks.fitted_lx), even(indirect_lx)];
    let adaptive = Adaptive {
        sloped,
        references_lx: (0..elements.len()).map(reference).collect(),
        detail: Detail::new(elements.len()),
        rounds: 0,
        pilot_rays,
        target_error,
    };
    (elements, adaptive)
}

/// Work, in some unit, that brings the chance of so many elements down to a share of the squared target.
fn work_of(elements: usize, share: f64) -> f64 {
    elements as f64 * share.powf(WORK_EXPONENT)
}

fn loss_of(context: &Context, elements: &Elements, index: u32, lost_lx2: f64) -> ElementLoss {
    let cell = elements.cell(index);
    ElementLoss {
        area_m2: elements.area_m2(context.scene, cell),
        lost_lx2: lost_lx2.max(0.0),
        cuts_left: MOST_CUTS - cell.cuts(),
    }
}

/// The element from which one of the finer ones was cut.
fn cell_above(elements: &Elements, finer: &Elements, index: u32) -> u32 {
    let cell = finer.cell(index);
    let [a, b, c] = finer.corners(&cell);
    let middle = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
    elements.cell_at(cell.triangle, middle, cell.side).unwrap_or(0)
}

/// Corners of a finer element within the one that it was cut from: the weights of that one's second and third corner.
fn corners_within(elements: &Elements, finer: &Elements, index: u32, above: u32) -> [[f64; 2]; 3] {
    let [a, b, c] = elements.corners(&elements.cell(above));
    let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let inverse = 1.0 / (p[0] * q[1] - p[1] * q[0]);
    finer.corners(&finer.cell(index)).map(|corner| {
        let at = [corner[0] - a[0], corner[1] - a[1]];
        [(at[0] * q[1] - at[1] * q[0]) * inverse, (p[0] * at[1] - p[1] * at[0]) * inverse]
    })
}

/// What the pilot saw of an element's direct light.
#[derive(Clone, Copy, Debug, Default)]
struct DirectLooks {
    /// Points that were looked at, 0 at first.
    points: usize,
    /// The linear function nearest to what was seen, in lx.
    fitted_lx: Linear,
    /// Mean square of what it leaves out, in lx², less one standard error: penumbrae are noisy, and chance must not cut.
    left_lx2: f64,
}

impl DirectLooks {
    fn slope_lx2(&self) -> f64 {
        let Linear([_, first_lx, second_lx]) = self.fitted_lx;
        first_lx * first_lx + second_lx * second_lx
    }

    fn lost_lx2(&self, sloped: bool) -> f64 {
        self.left_lx2 + if sloped { 0.0 } else { self.slope_lx2() }
    }

    /// Fits a linear function to looks at random points by least squares.
    ///
    /// Both looks are fitted apart: the product of their residuals has no part of their chance, and none at all where
    /// the light is linear.
    fn fit(seen: &[TwoLooks]) -> DirectLooks {
        let rows: Vec<Vector3<f64>> = seen
            .iter()
            .map(|seen| {
                let [p, q] = slopes_at(seen.at);
                Vector3::new(1.0, p, q)
            })
            .collect();
        let normal: Matrix3<f64> = rows.iter().map(|row| row * row.transpose()).sum();
        let Some(inverse) = normal.try_inverse() else {
            return DirectLooks { points: seen.len(), ..DirectLooks::default() };
        };
        let [one, other] = [0, 1].map(|look| {
            let sums: Vector3<f64> = rows.iter().zip(seen).map(|(row, seen)| row * seen.looks_lx[look]).sum();
            inverse * sums
        });
        let product = |(row, seen): (&Vector3<f64>, &TwoLooks)| {
            (seen.looks_lx[0] - row.dot(&one)) * (seen.looks_lx[1] - row.dot(&other))
        };
        let sum: f64 = rows.iter().zip(seen).map(product).sum();
        let squares: f64 = rows.iter().zip(seen).map(|pair| product(pair).powi(2)).sum();
        let count = seen.len() as f64;
        let left_lx2 = (sum - (squares - sum * sum / count).max(0.0).sqrt()) / (count - 3.0);
        let fitted = 0.5 * (one + other);
        DirectLooks { points: seen.len(), fitted_lx: Linear([fitted.x, fitted.y, fitted.z]), left_lx2 }
    }
}

/// Looks at the elements that are new, and again at those that are large beside the others by now; returns the rays it took.
fn look_at_new(context: &Context, elements: &Elements, looks: &mut Vec<DirectLooks>, round: u32) -> u64 {
    looks.resize(elements.len(), DirectLooks::default());
    let area_m2 = |index: usize| elements.area_m2(context.scene, elements.cell(index as u32));
    let mean_m2 = (0..elements.len()).map(area_m2).sum::<f64>() / elements.len() as f64;
    let wanted = |index: usize| (POINTS * (area_m2(index) / mean_m2).clamp(1.0, MOST_TIMES)) as usize;
    let unknown = looks.par_iter_mut().enumerate().filter(|(index, looks)| 2 * looks.points <= wanted(*index));
    let rays = unknown.map(|(index, looks)| {
        let element = Element::of(context.stage, context.scene, elements, index as u32);
        let mut pass = DirectPass::default();
        let mut stream = Stream::new(context.seed, Purpose::Pilot, u32::MAX - round, 0);
        let look = |point: usize| {
            stream.seek_quasi(((index as u64) << 32) | point as u64, index as u64, point as u64);
            element.look_twice(context.stage, &mut pass, &mut stream)
        };
        let seen: Vec<TwoLooks> = (0..wanted(index)).map(look).collect();
        *looks = DirectLooks::fit(&seen);
        seen.iter().map(|seen| seen.rays).sum::<u64>()
    });
    rays.sum()
}

/// Adds two looks at the direct light of a point; returns the scores of the mean and of the slopes in lx.
#[inline]
pub fn add_direct(detail: &mut DirectDetail, seen: &TwoLooks, reference: &Linear) -> [f64; 1 + SLOPES] {
    let known_lx = reference.at(seen.at);
    let [one_lx, other_lx] = seen.looks_lx.map(|lx| lx - known_lx);
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

impl Adaptive {
    fn variation(&self, map: &ReplicaMap, index: usize) -> Variation {
        let [Linear(direct), Linear(indirect)] = self.references_lx[index];
        // Counted packets are compared with nothing.
        let known = f64::from(u8::from(map.crossing.is_some()));
        let slopes_lx = [direct[1] + known * indirect[1], direct[2] + known * indirect[2]];
        self.detail.variation(index, map.scales(index), slopes_lx)
    }

    /// What the elements, of these areas, cannot show, by the run's samples.
    pub fn loss(&self, context: &Context, elements: &Elements, areas_m2: &[f64], map: &ReplicaMap) -> Loss {
        let mut sides: HashMap<(u32, &str), SideOfSurface> = HashMap::new();
        let side_of = |index: usize| {
            let cell = elements.cell(index as u32);
            (context.scene.surface_id_of(cell.triangle), cell.side.name())
        };
        let variations: Vec<Variation> =
            (0..elements.len()).into_par_iter().map(|index| self.variation(map, index)).collect();
        for (index, (variation, area_m2)) in variations.iter().zip(areas_m2).enumerate() {
            sides.entry(side_of(index)).or_default().add(variation, *area_m2, self.sloped[index]);
        }
        let mut loss = Loss::default();
        let mut area_sum_m2 = 0.0;
        let mut variance = 0.0;
        for (index, (variation, area_m2)) in variations.iter().zip(areas_m2).enumerate() {
            let smooth_lx2 = sides.get(&side_of(index)).map_or(0.0, |side| side.lx2(*area_m2, self.sloped[index]));
            loss.lost_lx2.push(variation.direct_lx2 + smooth_lx2);
            loss.sure_lx2.push((variation.direct_lx2 - variation.direct_noise.sqrt()).max(0.0) + smooth_lx2.max(0.0));
            loss.mean_lx2 += area_m2 * (variation.direct_lx2 + smooth_lx2);
            variance += area_m2 * area_m2 * noise_of(variation, self.sloped[index]);
            area_sum_m2 += area_m2;
        }
        loss.mean_lx2 /= area_sum_m2;
        loss.standard_error_lx2 = variance.sqrt() / area_sum_m2;
        loss
    }

    /// Whether the elements surely lose more than this share of the squared target.
    pub fn loses_over(&self, share: f64, loss: &Loss, mean_lx: f64) -> bool {
        let target_lx2 = (self.target_error * mean_lx).powi(2);
        loss.mean_lx2 - CERTAINTY * loss.standard_error_lx2 > share * target_lx2
    }

    /// Finer elements, where these lose too much for the target by all that a look has shown; `None` where they do not, where
    /// going on with them is less work all the same, or where nothing finer is allowed.
    pub fn refined(
        &self,
        context: &Context,
        elements: &Elements,
        map: &ReplicaMap,
        loss: &Loss,
        judgement: &Judgement,
    ) -> Option<(Elements, Adaptive)> {
        let mean_lx = judgement.mean_lx;
        let target_lx2 = (self.target_error * mean_lx).powi(2);
        if self.rounds >= RUN_ROUNDS || !self.loses_over(MOST_SHARE, loss, mean_lx) {
            return None;
        }
        let losses: Vec<ElementLoss> = loss
            .sure_lx2
            .iter()
            .enumerate()
            .map(|(index, lost)| loss_of(context, elements, index as u32, *lost))
            .collect();
        let cuts = cuts_for(&losses, AIM_SHARE * target_lx2, MOST_ELEMENTS);
        let pieces = cuts.iter().map(|cuts| 1usize << (2 * cuts)).sum();
        let share = (loss.mean_lx2 + loss.standard_error_lx2) / target_lx2;
        if share < BEARABLE_SHARE {
            let done = work_of(elements.len(), (judgement.expected_error / self.target_error).powi(2));
            if work_of(elements.len(), 1.0 - share) - done < work_of(pieces, 1.0 - AIM_SHARE) {
                return None;
            }
        }
        let finer = elements.cut(|cell| cuts[cell as usize]);
        if finer.len() == elements.len() {
            return None;
        }
        let above: Vec<u32> = (0..finer.len() as u32).map(|index| cell_above(elements, &finer, index)).collect();
        let adaptive = Adaptive {
            // Constant elements that were cut lost too much by their slopes.
            sloped: above.iter().map(|above| self.sloped[*above as usize] || cuts[*above as usize] > 0).collect(),
            references_lx: above
                .iter()
                .enumerate()
                .map(|(index, above)| {
                    let corners = corners_within(elements, &finer, index as u32, *above);
                    map.parts_lx(*above as usize).map(|part| Linear(part).on_piece(corners))
                })
                .collect(),
            detail: Detail::new(finer.len()),
            rounds: self.rounds + 1,
            pilot_rays: 0,
            target_error: self.target_error,
        };
        Some((finer, adaptive))
    }

    /// Number of the element map's streams in this round: a map that starts anew draws anew.
    pub fn stream_number(&self) -> u32 {
        if self.rounds == 0 { MapKind::Elements.number() } else { u32::MAX - self.rounds }
    }
}

fn noise_of(variation: &Variation, sloped: bool) -> f64 {
    let slopes = if sloped { 0.0 } else { variation.slope_noise };
    variation.direct_noise + variation.indirect_noise + slopes
}

/// The smooth part of what the elements of one side of a surface lose: with the square of the area where they show
/// slopes, with the area itself where they do not.
#[derive(Clone, Copy, Debug, Default)]
struct SideOfSurface {
    bent_m2_lx2: f64,
    bent_m6: f64,
    sloping_m2_lx2: f64,
    sloping_m4: f64,
}

impl SideOfSurface {
    fn add(&mut self, variation: &Variation, area_m2: f64, sloped: bool) {
        self.bent_m2_lx2 += area_m2 * variation.indirect_lx2;
        self.bent_m6 += area_m2.powi(3);
        if !sloped {
            self.sloping_m2_lx2 += area_m2 * variation.slope_lx2;
            self.sloping_m4 += area_m2.powi(2);
        }
    }

    fn lx2(&self, area_m2: f64, sloped: bool) -> f64 {
        let bent_lx2 = self.bent_m2_lx2 / self.bent_m6.max(f64::MIN_POSITIVE) * area_m2 * area_m2;
        let sloping_lx2 = self.sloping_m2_lx2 / self.sloping_m4.max(f64::MIN_POSITIVE) * area_m2;
        bent_lx2 + if sloped { 0.0 } else { sloping_lx2 }
    }
}
