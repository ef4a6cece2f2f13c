//! Loss of smooth light on the two sides of surfaces. Single elements show too little of it, so it is pooled over neighbours on a side: over
//! the whole side where the loss is as even as chance allows, over less where it surely is not, as beside a luminaire near a wall.

use std::collections::BTreeMap;
use std::ops::{Add, Range};

use crate::maps::Variation;
use crate::scene::Elements;
use crate::solver::context::Context;
use crate::solver::empty_maps::Shows;

/// Two halves of a group of elements are pooled unless their losses differ by more than this many standard errors.
const CERTAINTY: f64 = 4.0;
/// Standard errors by which a loss must be above a limit to be surely above it.
pub const SURE: f64 = 2.0;
/// Fewest elements that are pooled.
const FEWEST_POOLED: usize = 4;

/// Sums over the elements of a group. The smooth part of their loss is shared out in proportion to the square of what their light is expected
/// to bend if they show slopes, and to slope if they do not.
#[derive(Clone, Copy, Debug, Default)]
struct LossGroup {
    bent_m2_lx2: f64,
    /// Sums of area times the square of the expected bends, and slopes.
    bending: f64,
    sloping_m2_lx2: f64,
    sloping: f64,
    /// Slopes of all elements, and sums of the second and third power of their areas: for elements that are partly hidden by contact.
    any_slope_m2_lx2: f64,
    areas_m4: f64,
    areas_m6: f64,
    /// What elements that are partly hidden by contact lose, and the sum of their squared areas, as far as it is measured.
    hidden_m2_lx2: f64,
    hidden_m4: f64,
    /// Variance of the loss of all elements, in lx⁴ m⁴.
    variance: f64,
}

/// Loss of smooth light on the sides of all surfaces.
pub struct SideLosses<'a> {
    groups: Vec<LossGroup>,
    group_of: Vec<u32>,
    /// For every group, its whole side.
    sides: Vec<LossGroup>,
    expected: &'a [[f64; 2]],
}

impl<'a> SideLosses<'a> {
    /// Computes the losses from the variation of light within elements with these areas, which show slopes or not. The light of each is
    /// expected to slope and to bend in proportion to `expected`.
    pub fn of(
        context: &Context,
        elements: &Elements,
        (areas_m2, expected): (&[f64], &'a [[f64; 2]]),
        (sloped, contact_free): Shows,
        variations: &[Variation],
    ) -> SideLosses<'a> {
        // In an order that no run changes: sums over groups are rounded in it.
        let mut sides: BTreeMap<(u32, &'static str), Vec<usize>> = BTreeMap::new();
        for index in 0..elements.len() {
            sides.entry(side_of(context, elements, index)).or_default().push(index);
        }
        let of_one = |index: &usize| match contact_free[*index] {
            1.0 => LossGroup::of(&variations[*index], (areas_m2[*index], expected[*index]), sloped[*index]),
            _ => LossGroup::beside_contact(&variations[*index], areas_m2[*index]),
        };
        let mut losses =
            SideLosses { groups: Vec::new(), sides: Vec::new(), group_of: vec![0; elements.len()], expected };
        for indices in sides.values() {
            let of_elements: Vec<LossGroup> = indices.iter().map(of_one).collect();
            let (side, ranges) = pooled(&of_elements, 0..indices.len());
            for range in ranges {
                let number = losses.groups.len() as u32;
                losses.groups.push(sum(&of_elements[range.clone()]));
                losses.sides.push(side);
                indices[range].iter().for_each(|index| losses.group_of[*index] = number);
            }
        }
        losses
    }

    /// Mean square in lx² over one of the elements.
    pub fn lx2(&self, index: usize, area_m2: f64, (sloped, contact_free): Shows) -> f64 {
        let group = self.group_of[index] as usize;
        if contact_free[index] == 1.0 {
            return self.groups[group].lx2(self.expected[index], sloped[index]);
        }
        self.sides[group].lx2_beside_contact(area_m2)
    }

    /// Sum over the groups of area times the loss that each surely has, in lx² m². `beside` is another loss of every element, times its area,
    /// with its variance.
    ///
    /// One group with much random error does not hide what the others surely lose.
    pub fn sure_m2_lx2(&self, beside: impl Fn(usize) -> [f64; 2]) -> f64 {
        let mut sums: Vec<[f64; 2]> =
            self.groups.iter().map(|group| [group.bent_m2_lx2 + group.sloping_m2_lx2, group.variance]).collect();
        for (index, group) in self.group_of.iter().enumerate() {
            sums[*group as usize].iter_mut().zip(beside(index)).for_each(|(sum, more)| *sum += more);
        }
        sums.iter().map(|[lost_m2_lx2, variance]| (lost_m2_lx2 - SURE * variance.sqrt()).max(0.0)).sum()
    }
}

fn side_of(context: &Context, elements: &Elements, index: usize) -> (u32, &'static str) {
    let element = elements.element(index as u32);
    (context.scene.surface_id_of(element.triangle), element.side.name())
}

/// The sums of the elements of a range, and the groups in which they are pooled. Elements that follow each other are neighbours.
fn pooled(of_elements: &[LossGroup], range: Range<usize>) -> (LossGroup, Vec<Range<usize>>) {
    if range.len() < 2 * FEWEST_POOLED {
        return (sum(&of_elements[range.clone()]), vec![range]);
    }
    let middle = range.start + range.len() / 2;
    let [(first, mut groups), (second, groups_of_second)] =
        [range.start..middle, middle..range.end].map(|half| pooled(of_elements, half));
    if groups.len() + groups_of_second.len() == 2 && !first.differs_from(&second) {
        return (first + second, vec![range]);
    }
    groups.extend(groups_of_second);
    (first + second, groups)
}

fn sum(of_elements: &[LossGroup]) -> LossGroup {
    of_elements.iter().fold(LossGroup::default(), |sum, one| sum + *one)
}

/// Loss per expected square; 0 where nothing is expected.
fn over(loss_m2_lx2: f64, expected: f64) -> f64 {
    if expected > 0.0 { loss_m2_lx2 / expected } else { 0.0 }
}

impl Add for LossGroup {
    type Output = LossGroup;

    fn add(self, other: LossGroup) -> LossGroup {
        LossGroup {
            bent_m2_lx2: self.bent_m2_lx2 + other.bent_m2_lx2,
            bending: self.bending + other.bending,
            sloping_m2_lx2: self.sloping_m2_lx2 + other.sloping_m2_lx2,
            sloping: self.sloping + other.sloping,
            any_slope_m2_lx2: self.any_slope_m2_lx2 + other.any_slope_m2_lx2,
            areas_m4: self.areas_m4 + other.areas_m4,
            areas_m6: self.areas_m6 + other.areas_m6,
            hidden_m2_lx2: self.hidden_m2_lx2 + other.hidden_m2_lx2,
            hidden_m4: self.hidden_m4 + other.hidden_m4,
            variance: self.variance + other.variance,
        }
    }
}

impl LossGroup {
    fn of(variation: &Variation, (area_m2, [slope, bend]): (f64, [f64; 2]), sloped: bool) -> LossGroup {
        let slope_m2_lx2 = area_m2 * variation.slope_lx2;
        let shows_none = f64::from(u8::from(!sloped));
        LossGroup {
            bent_m2_lx2: area_m2 * variation.indirect_lx2,
            bending: area_m2 * bend * bend,
            sloping_m2_lx2: shows_none * slope_m2_lx2,
            sloping: shows_none * area_m2 * slope * slope,
            any_slope_m2_lx2: slope_m2_lx2,
            areas_m4: area_m2 * area_m2,
            areas_m6: area_m2.powi(3),
            variance: area_m2 * area_m2 * (variation.indirect_noise + shows_none * variation.slope_noise),
            ..LossGroup::default()
        }
    }

    fn beside_contact(variation: &Variation, area_m2: f64) -> LossGroup {
        let is_measured = f64::from(u8::from(variation.slope_noise > 0.0));
        LossGroup {
            hidden_m2_lx2: area_m2 * variation.slope_lx2,
            hidden_m4: is_measured * area_m2 * area_m2,
            ..LossGroup::default()
        }
    }

    /// Whether the loss of one group surely is not what both together would have it lose.
    fn differs_from(&self, other: &LossGroup) -> bool {
        let both = *self + *other;
        let expected_m2_lx2 = |group: &LossGroup| both.of_bends() * group.bending + both.of_slopes() * group.sloping;
        let [own_m2_lx2, others_m2_lx2] = [self, other].map(|group| expected_m2_lx2(group).abs());
        let share = own_m2_lx2 / (own_m2_lx2 + others_m2_lx2).max(f64::MIN_POSITIVE);
        let difference_m2_lx2 = self.bent_m2_lx2 + self.sloping_m2_lx2 - expected_m2_lx2(self);
        let variance = self.variance * (1.0 - share).powi(2) + other.variance * share * share;
        difference_m2_lx2.abs() > CERTAINTY * variance.sqrt()
    }

    /// Mean square in lx² over an element of this side that is partly hidden by contact. If nothing is measured, it loses what elements of its
    /// size lose on the whole side.
    fn lx2_beside_contact(&self, area_m2: f64) -> f64 {
        if self.hidden_m4 > 0.0 {
            return over(self.hidden_m2_lx2, self.hidden_m4) * area_m2;
        }
        over(self.any_slope_m2_lx2, self.areas_m4) * area_m2 + over(self.bent_m2_lx2, self.areas_m6) * area_m2 * area_m2
    }

    fn of_bends(&self) -> f64 {
        over(self.bent_m2_lx2, self.bending)
    }

    fn of_slopes(&self) -> f64 {
        over(self.sloping_m2_lx2, self.sloping)
    }

    /// Mean square in lx² over an element of this group.
    fn lx2(&self, [slope, bend]: [f64; 2], sloped: bool) -> f64 {
        self.of_bends() * bend * bend + if sloped { 0.0 } else { self.of_slopes() * slope * slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// 64 neighbours that lose 1 lx² each, and some that lose more, with a random error of `noise` lx².
    fn groups_of(seed: u64, noise: f64, more: Range<usize>, lost_lx2: f64) -> Vec<Range<usize>> {
        let mut stream = Stream::new(seed, Purpose::Pilot, 0, 0);
        let of_elements: Vec<LossGroup> = (0..64)
            .map(|index| {
                // Sum of 12 variates: about normal.
                let chance = (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
                let exact_lx2 = if more.contains(&index) { lost_lx2 } else { 1.0 };
                let variation = Variation {
                    indirect_lx2: exact_lx2 + noise * chance,
                    indirect_noise: noise * noise,
                    ..Variation::default()
                };
                LossGroup::of(&variation, (1.0, [1.0, 1.0]), true)
            })
            .collect();
        pooled(&of_elements, 0..of_elements.len()).1
    }

    /// 200 seeds. Elements that lose alike are pooled over the whole side but for chance (a few of 15 comparisons per seed at four standard
    /// errors, α = 6e-5 each). Planted: eight neighbours that lose 40 lx² more, with random errors of 8 lx² in each, are told apart in most
    /// seeds, and with smaller errors always and exactly.
    #[test]
    fn neighbours_are_pooled_unless_they_surely_lose_differently() {
        let is_whole = |groups: &Vec<Range<usize>>| groups.len() == 1;
        assert!((0..200).filter(|seed| !is_whole(&groups_of(*seed, 8.0, 0..0, 0.0))).count() <= 3);
        assert!((0..200).filter(|seed| !is_whole(&groups_of(*seed, 8.0, 16..24, 41.0))).count() > 180);
        for seed in 0..200 {
            let groups = groups_of(seed, 0.5, 16..24, 41.0);
            let starts: Vec<usize> = groups.iter().map(|range| range.start).collect();
            assert_eq!(starts[..4], [0, 16, 24, 32], "{groups:?}");
        }
    }

    /// What a group loses is divided by what is expected of its elements, and nothing is lost on the way.
    #[test]
    fn a_group_loses_what_its_elements_lose() {
        let variation = |slope_lx2, indirect_lx2| Variation { slope_lx2, indirect_lx2, ..Variation::default() };
        let of = [
            (variation(3.0, 0.0), 2.0, [1.0, 0.5], false),
            (variation(7.0, 5.0), 1.0, [3.0, 2.0], true),
            (variation(1.0, -1.0), 0.5, [2.0, 0.1], false),
        ];
        let groups: Vec<LossGroup> = of
            .iter()
            .map(|(variation, area_m2, expected, sloped)| LossGroup::of(variation, (*area_m2, *expected), *sloped))
            .collect();
        let whole = sum(&groups);
        let shared: f64 = of.iter().map(|(_, area_m2, expected, sloped)| area_m2 * whole.lx2(*expected, *sloped)).sum();
        // 2 · 3 + 1 · 5 + 0.5 · (1 − 1)
        assert!((shared - 11.0).abs() < 1e-12, "{shared}");
        assert_eq!(sum(&[LossGroup::of(&variation(1.0, 1.0), (1.0, [0.0; 2]), false)]).lx2([0.0; 2], false), 0.0);
    }
}
