//! Choice among few emitters: every one is weighed for every choice, eight at a time, which is faster than descending a tree.
//!
//! Weights are those of [`Beacon::importance`] in single precision. They only decide how often an emitter is sampled. The probability of a
//! choice is computed from the same weights, so no result depends on their precision.

use glam::{DVec3, Vec3};

use super::abreast::{ABREAST, larger, smaller};
use super::importance::{Beacon, Profile};

/// Largest number of beacons that count as few. With more, the tree takes less time.
const FEW: usize = 256;
/// Limits of coordinates about the centre and of intensities. Below them, all derived values fit in single precision.
const LARGEST_M: f64 = 1e8;
const LARGEST_CD: f64 = 1e20;
/// Squared distances in m² below this are raised to it, so that intensities divided by them stay finite.
const LEAST_SQUARED_M2: f32 = 1e-16;
/// Height in m of a point at which the plane of an emitter does not matter, and a height of none.
const HIGH_ABOVE_M: f32 = 1e30;
const LEAST_HEIGHT_M: f32 = 1e-30;
/// Rounding of single precision as a share of the largest coordinate. Radii grow by this, so that an emitter just above the horizon is
/// never taken to be below it.
const RELATIVE_ROUNDING_F32: f64 = 4e-7;

/// Beacons in blocks of eight. Successive beacons go from block to block, and after the last block to the next lane. The sums of the lanes,
/// made by eight additions at a time, are therefore sums of runs of successive beacons.
#[derive(Clone, Debug)]
pub(super) struct FewBeacons {
    /// Origin of the coordinates.
    middle_m: DVec3,
    blocks: Vec<BeaconBlock>,
    /// The emitter of each beacon.
    emitters: Vec<u32>,
    /// The first beacon of each emitter; at the end the number of all beacons.
    firsts: Vec<u32>,
    /// Beacons whose profile is a table: block, lane and profile, ordered by block.
    tables: Vec<(usize, usize, Profile)>,
    #[cfg(target_arch = "x86_64")]
    has_avx2: bool,
}

/// Eight beacons, in m relative to the centre, and in cd.
#[derive(Clone, Copy, Debug, Default)]
struct BeaconBlock {
    center: [[f32; ABREAST]; 3],
    axis: [[f32; ABREAST]; 3],
    radius: [f32; ABREAST],
    /// Largest 1/d² that is used: that of the radius without the margin for rounding.
    most_per_m2: [f32; ABREAST],
    intensity: [f32; ABREAST],
    /// 1 where the intensity is independent of the angle from the axis or given by a table; otherwise 0.
    is_even: [f32; ABREAST],
    /// Added to the height in m above the plane through the centre: the margin for rounding of a flat emitter; otherwise a height at which
    /// planes do not matter.
    lift: [f32; ABREAST],
}

/// Weights of all beacons at one point, with reusable storage.
#[derive(Clone, Debug, Default)]
pub(super) struct Weights {
    /// Weights by block.
    eights: Vec<[f32; ABREAST]>,
    /// Sum of each lane.
    lanes: [f64; ABREAST],
    total: f64,
}

impl Weights {
    /// Returns the weights from a beacon on.
    #[inline]
    fn starting_at(&self, place: usize) -> impl Iterator<Item = f64> {
        let blocks = self.eights.len();
        let (mut block, mut lane) = (place % blocks, place / blocks);
        std::iter::from_fn(move || {
            let weight = f64::from(*self.eights[block].get(lane)?);
            block += 1;
            if block == blocks {
                (block, lane) = (0, lane + 1);
            }
            Some(weight)
        })
    }

    /// Lessens the weights w of some beacons to w/(1 + w `per_lx`).
    #[inline]
    pub fn lessen(&mut self, mask: &BeaconMask, per_lx: f64) {
        let (per_lx, mut lanes) = (per_lx as f32, [0.0; ABREAST]);
        for (weights, mask) in self.eights.iter_mut().zip(&mask.0) {
            for ((weight, mask), sum) in weights.iter_mut().zip(mask).zip(&mut lanes) {
                *weight /= 1.0 + mask * per_lx * *weight;
                *sum += f64::from(*weight);
            }
        }
        self.sum_up(lanes);
    }

    #[inline(always)]
    fn sum_up(&mut self, lanes: [f64; ABREAST]) {
        self.lanes = lanes;
        let [a, b, c, d, e, f, g, h] = lanes;
        self.total = ((a + e) + (b + f)) + ((c + g) + (d + h));
    }

    /// Returns the beacon at which the running sum exceeds `aim`, which is below the total. If rounding leaves the sum too small, it
    /// returns the last beacon with a weight. Lanes and blocks are counted to the end, because a branch on the position would be
    /// mispredicted.
    fn place_at(&self, aim: f64) -> Option<usize> {
        let (lane, before) = passed(self.lanes, aim);
        if lane < ABREAST {
            let in_lane = self.eights.iter().map(|eight| f64::from(eight[lane]));
            let (block, _) = passed(in_lane, aim - before);
            if block < self.eights.len() {
                return Some(lane * self.eights.len() + block);
            }
        }
        self.starting_at(0).enumerate().filter(|(_, weight)| *weight > 0.0).map(|(place, _)| place).last()
    }
}

/// Returns how many numbers a running sum includes before it exceeds an aim, and their sum.
#[inline(always)]
fn passed(numbers: impl IntoIterator<Item = f64>, aim: f64) -> (usize, f64) {
    let (mut count, mut sum, mut before) = (0, 0.0, 0.0);
    for number in numbers {
        sum += number;
        count += usize::from(sum <= aim);
        before = if sum <= aim { sum } else { before };
    }
    (count, before)
}

/// Which beacons belong to some of the emitters: 1 for each that does, otherwise 0.
#[derive(Clone, Debug)]
pub struct BeaconMask(Vec<[f32; ABREAST]>);

/// Weights of a block, and the largest cos γ that each beacon's extent allows.
type Weighed = [[f32; ABREAST]; 2];

impl FewBeacons {
    /// Makes the beacons of emitters, each with its parts if it has any. `None` if they are too many or exceed single precision.
    pub fn of(beacons: &[&Beacon]) -> Option<FewBeacons> {
        let parts = |beacon: &'_ Beacon| beacon.parts.len().max(1);
        let count: usize = beacons.iter().map(|beacon| parts(beacon)).sum();
        if count == 0 || count > FEW {
            return None;
        }
        let middle_m = beacons.iter().map(|beacon| beacon.center_m).sum::<DVec3>() / beacons.len() as f64;
        let mut few = FewBeacons {
            middle_m,
            blocks: vec![BeaconBlock::default(); count.div_ceil(ABREAST)],
            emitters: Vec::with_capacity(count),
            firsts: Vec::with_capacity(beacons.len() + 1),
            tables: Vec::new(),
            #[cfg(target_arch = "x86_64")]
            has_avx2: is_x86_feature_detected!("avx2"),
        };
        let largest_m = beacons.iter().map(|beacon| (beacon.center_m - middle_m).abs().max_element() + beacon.radius_m);
        let largest_m = largest_m.fold(0.0, f64::max);
        let largest_cd = beacons.iter().map(|beacon| beacon.largest_intensity_cd()).fold(0.0, f64::max);
        if !(largest_m < LARGEST_M && largest_cd < LARGEST_CD) {
            return None;
        }
        for (emitter, beacon) in (0u32..).zip(beacons) {
            few.firsts.push(few.emitters.len() as u32);
            let own = if beacon.parts.is_empty() { std::slice::from_ref(*beacon) } else { &beacon.parts[..] };
            own.iter().for_each(|part| few.push(emitter, part, largest_m));
        }
        few.firsts.push(count as u32);
        few.tables.sort_by_key(|(block, lane, _)| (*block, *lane));
        Some(few)
    }

    fn push(&mut self, emitter: u32, beacon: &Beacon, largest_m: f64) {
        let (place, blocks) = (self.emitters.len(), self.blocks.len());
        let (number, lane) = (place % blocks, place / blocks);
        let block = &mut self.blocks[number];
        let center = beacon.center_m - self.middle_m;
        for (axis, lanes) in block.center.iter_mut().enumerate() {
            lanes[lane] = center[axis] as f32;
        }
        for (axis, lanes) in block.axis.iter_mut().enumerate() {
            lanes[lane] = beacon.axis[axis] as f32;
        }
        let margin_m = RELATIVE_ROUNDING_F32 * largest_m;
        block.radius[lane] = (beacon.radius_m + margin_m) as f32;
        block.lift[lane] = if matches!(beacon.profile, Profile::Flat) { margin_m as f32 } else { HIGH_ABOVE_M };
        block.most_per_m2[lane] = (1.0 / (beacon.radius_m * beacon.radius_m)) as f32;
        block.intensity[lane] = beacon.intensity_cd as f32;
        block.is_even[lane] = f32::from(u8::from(!matches!(beacon.profile, Profile::Cosine | Profile::Flat)));
        if matches!(beacon.profile, Profile::Table(_)) {
            self.tables.push((number, lane, beacon.profile.clone()));
        }
        self.emitters.push(emitter);
    }

    /// Returns the number of beacons; parts of an emitter count separately.
    pub fn len(&self) -> usize {
        self.emitters.len()
    }

    /// Computes the weights of all beacons at a point with a unit normal.
    #[inline]
    pub fn weigh(&self, point_m: DVec3, normal: DVec3, weights: &mut Weights) {
        let (point, normal) = ((point_m - self.middle_m).as_vec3(), normal.as_vec3());
        weights.eights.resize(self.blocks.len(), [0.0; ABREAST]);
        #[cfg(target_arch = "x86_64")]
        if self.has_avx2 {
            // SAFETY: the processor has AVX2.
            return unsafe { self.weigh_avx2(point, normal, weights) };
        }
        self.weigh_all(point, normal, weights);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn weigh_avx2(&self, point: Vec3, normal: Vec3, weights: &mut Weights) {
        self.weigh_all(point, normal, weights);
    }

    /// Computes all weights and their sums.
    #[inline(always)]
    fn weigh_all(&self, point: Vec3, normal: Vec3, weights: &mut Weights) {
        let mut tables = self.tables.as_slice();
        let mut lanes = [0.0; ABREAST];
        for (number, (block, weights_of_eight)) in self.blocks.iter().zip(&mut weights.eights).enumerate() {
            let cosines;
            [*weights_of_eight, cosines] = block.weigh(point, normal);
            while let [(of, lane, profile), rest @ ..] = tables
                && *of == number
            {
                if weights_of_eight[*lane] > 0.0 {
                    weights_of_eight[*lane] *= profile.at(f64::from(cosines[*lane])) as f32;
                }
                tables = rest;
            }
            for (lane, weight) in lanes.iter_mut().zip(weights_of_eight) {
                *lane += f64::from(*weight);
            }
        }
        weights.sum_up(lanes);
    }

    /// Returns the mask of the emitters that `is_in` accepts.
    pub fn mask(&self, is_in: impl Fn(u32) -> bool) -> BeaconMask {
        let mut mask = vec![[0.0; ABREAST]; self.blocks.len()];
        for (place, emitter) in self.emitters.iter().enumerate() {
            mask[place % self.blocks.len()][place / self.blocks.len()] = f32::from(u8::from(is_in(*emitter)));
        }
        BeaconMask(mask)
    }

    /// Chooses an emitter by a variate in [0, 1) from the weights of [`FewBeacons::weigh`]. Returns it with the probability of the choice.
    pub fn choose(&self, variate: f64, weights: &Weights) -> Option<(u32, f64)> {
        if weights.total <= 0.0 {
            return None;
        }
        let emitter = self.emitters[weights.place_at(variate * weights.total)?];
        Some((emitter, self.probability(emitter, weights)))
    }

    /// Returns the probability with which [`FewBeacons::choose`] chooses an emitter.
    pub fn probability(&self, emitter: u32, weights: &Weights) -> f64 {
        let (first, end) = (self.firsts[emitter as usize] as usize, self.firsts[emitter as usize + 1] as usize);
        let weight: f64 = weights.starting_at(first).take(end - first).sum();
        if weights.total > 0.0 { weight / weights.total } else { 0.0 }
    }
}

impl BeaconBlock {
    /// Returns the weights of all eight: see [`Beacon::importance`].
    #[inline(always)]
    fn weigh(&self, point: Vec3, normal: Vec3) -> Weighed {
        let [mut weights, mut cosines] = [[0.0; ABREAST]; 2];
        for (lane, (weight, reached)) in weights.iter_mut().zip(&mut cosines).enumerate() {
            let of_lane = |axes: &[[f32; ABREAST]; 3]| [axes[0][lane], axes[1][lane], axes[2][lane]];
            let center = of_lane(&self.center);
            let offset = [center[0] - point.x, center[1] - point.y, center[2] - point.z];
            let dot = |[x, y, z]: [f32; 3]| offset[0] * x + offset[1] * y + offset[2] * z;
            let squared = larger(dot(offset), LEAST_SQUARED_M2);
            let inverse = 1.0 / squared.sqrt();
            let spread = self.radius[lane] * inverse;
            // For a point inside the ball, the emitter can be anywhere above the horizon.
            let within = if spread >= 1.0 { 1.0 } else { 0.0 };
            let at_receiver = larger((dot(normal.to_array()) * inverse + spread).clamp(0.0, 1.0), within);
            let along = dot(of_lane(&self.axis));
            let cosine = spread - along * inverse;
            let even = larger(self.is_even[lane], within);
            // At most 1, also for a point in the plane of a flat emitter.
            let height = larger(self.lift[lane] - along, 0.0);
            let flat = height / larger(larger(squared * inverse - self.radius[lane], height), LEAST_HEIGHT_M);
            let profile = smaller(larger(cosine.clamp(0.0, 1.0), even), flat);
            let most = self.most_per_m2[lane];
            let per_m2 = if inverse * inverse < most { inverse * inverse } else { most };
            *weight = self.intensity[lane] * profile * at_receiver * per_m2;
            *reached = cosine.min(1.0);
        }
        [weights, cosines]
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    /// 37 beacons, some in parts, at points near and far, and with the weights of every second one lessened. Weights equal the importances
    /// to 1e-4 plus the effect of the enlarged radii.
    /// Choices occur with the stated probabilities. The portable version gives the same bytes.
    #[test]
    fn weights_are_importances_and_choices_are_as_reported() {
        const N: u32 = 400_000;
        let beacons: Vec<Beacon> = (0..37)
            .map(|i| {
                let beacon = Beacon {
                    center_m: DVec3::new(f64::from(i % 7), f64::from(i / 7), 3.0 + 0.1 * f64::from(i % 3)),
                    radius_m: 0.05 * f64::from(i % 2),
                    axis: -DVec3::Z,
                    intensity_cd: 10f64.powi(i % 5),
                    profile: [Profile::Cosine, Profile::Flat, Profile::Uniform][i as usize % 3].clone(),
                    parts: Arc::default(),
                };
                let part = |shift: f64| Beacon {
                    center_m: beacon.center_m + shift * DVec3::X,
                    intensity_cd: 0.5 * beacon.intensity_cd,
                    ..beacon.clone()
                };
                let parts = if i % 4 == 1 { [part(-0.2), part(0.2)].into() } else { Arc::default() };
                Beacon { parts, ..beacon }
            })
            .collect();
        let few = FewBeacons::of(&beacons.iter().collect::<Vec<_>>()).expect("they are few");
        for (point_m, normal, lessened_per_lx) in
            [(DVec3::ZERO, DVec3::Z, 0.0), (DVec3::new(3.0, 3.1, 2.7), DVec3::X, 0.0), (DVec3::ZERO, DVec3::Z, 0.01)]
        {
            let mut weights = Weights::default();
            few.weigh(point_m, normal, &mut weights);
            let mut portable = weights.clone();
            few.weigh_all((point_m - few.middle_m).as_vec3(), normal.as_vec3(), &mut portable);
            assert_eq!(weights.eights, portable.eights);
            let is_lessened = |emitter: usize| emitter.is_multiple_of(2);
            if lessened_per_lx > 0.0 {
                weights.lessen(&few.mask(|emitter| is_lessened(emitter as usize)), lessened_per_lx);
            }
            let weight_of = |emitter: usize| {
                let beacon = &beacons[emitter];
                let parts = if beacon.parts.is_empty() { std::slice::from_ref(beacon) } else { &beacon.parts[..] };
                let per_lx = if is_lessened(emitter) { lessened_per_lx } else { 0.0 };
                let importances_lx = parts.iter().map(|part| part.importance_lx(point_m, normal));
                importances_lx.map(|lx| lx / (1.0 + lx * per_lx)).sum::<f64>()
            };
            let mut counts = vec![0; beacons.len()];
            for i in 0..N {
                let (emitter, probability) =
                    few.choose((f64::from(i) + 0.5) / f64::from(N), &weights).expect("some bring light");
                counts[emitter as usize] += 1;
                assert_eq!(probability, few.probability(emitter, &weights));
            }
            for (emitter, beacon) in beacons.iter().enumerate() {
                let probability = few.probability(emitter as u32, &weights);
                let exact = weight_of(emitter);
                // The rounding added to a radius may lift a beacon over the horizon: I/d² times a millionth of the scene's size over d.
                let lifted = 1e-5 * beacon.intensity_cd / beacon.center_m.distance(point_m).powi(3);
                assert!((probability * weights.total - exact).abs() < 1e-4 * exact + lifted, "{emitter}");
                assert!(exact == 0.0 || probability > 0.0, "emitter {emitter} is never chosen");
                // The variates are equidistant, so each share is exact to within a few of them.
                let share = f64::from(counts[emitter]) / f64::from(N);
                assert!((share - probability).abs() < 8.0 / f64::from(N), "{emitter}: {share} {probability}");
            }
        }
    }

    #[test]
    fn what_single_precision_does_not_hold_is_left_to_the_tree() {
        let beacon = |center_m: DVec3, intensity_cd: f64| Beacon {
            center_m,
            radius_m: 0.0,
            axis: -DVec3::Z,
            intensity_cd,
            profile: Profile::Uniform,
            parts: Arc::default(),
        };
        let (near, far) = (beacon(DVec3::ZERO, 1.0), beacon(1e12 * DVec3::X, 1.0));
        assert!(FewBeacons::of(&[&near, &near]).is_some());
        assert!(FewBeacons::of(&[&near, &far]).is_none());
        assert!(FewBeacons::of(&[&near, &beacon(DVec3::ONE, 1e30)]).is_none());
        assert!(FewBeacons::of(&vec![&near; FEW + 1]).is_none() && FewBeacons::of(&[]).is_none());
    }
}
