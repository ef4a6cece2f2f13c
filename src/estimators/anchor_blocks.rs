//! Choice of the anchors that a vertex of a chain connects to: all anchors are weighed, eight at a time, and few are chosen.
//!
//! Weights are approximate scores in single precision. They only decide how often an anchor is chosen. What a chosen anchor scores is
//! computed in double precision and divided by the probability of the choice, so no result depends on the precision of the weights.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::sampling::abreast::{ABREAST, larger};

/// Cosines times distances grow by this share of the largest coordinate, a bound of their rounding in single precision. An anchor that
/// can see a vertex then never has the weight 0.
const ROUNDING_SHARE: f64 = 1e-6;
/// Bounds of the kernel in 1/m² are lowered to this, so that products stay finite in single precision.
const LARGEST_BOUND_PER_M2: f64 = 1e25;

/// Anchors on planes, in blocks of eight.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct AnchorBlocks {
    /// Origin of the coordinates.
    middle_m: DVec3,
    /// Largest coordinate about the origin, in m.
    largest_m: f64,
    blocks: Vec<AnchorBlock>,
}

/// Eight anchors, in m relative to the origin. Free places at the end of the last block have a scale of 0.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct AnchorBlock {
    point: [[f32; ABREAST]; 3],
    normal: [[f32; ABREAST]; 3],
    /// Value of a full response relative to the anchor's own level.
    relative_scale: [f32; ABREAST],
    /// Ratio of the anchor's bound to the usual bound.
    bound_factor: [f32; ABREAST],
}

/// An anchor as the blocks store it.
pub(super) struct PlaneAnchor {
    pub(super) point_m: DVec3,
    pub(super) normal: DVec3,
    /// Value of a full response relative to the anchor's own level.
    pub(super) relative_scale: f64,
    /// Ratio of the anchor's bound to the usual bound.
    pub(super) bound_factor: f64,
}

/// A diffuse vertex of a chain.
pub(super) struct ScoringVertex {
    pub(super) point_m: DVec3,
    pub(super) normal: DVec3,
    /// Score for a kernel of 1/m² and a full response of 1, in units of the threshold of full scores.
    pub(super) factor: f64,
    /// Bound of the kernel in 1/m².
    pub(super) bound_per_m2: f64,
}

/// A vertex in single precision.
struct VertexF32 {
    point: Vec3,
    normal: Vec3,
    factor: f32,
    bound_per_m2: f32,
    /// What cosines times distances in m grow by.
    margin_m: f32,
}

/// A chosen anchor and the probability of its choice.
pub(super) type Choice = (usize, f64);

impl AnchorBlocks {
    /// Stores anchors in their order.
    pub(super) fn of(anchors: &[PlaneAnchor]) -> AnchorBlocks {
        let middle_m = anchors.iter().map(|anchor| anchor.point_m).sum::<DVec3>() / anchors.len().max(1) as f64;
        let mut blocks = vec![AnchorBlock::default(); anchors.len().div_ceil(ABREAST)];
        let mut largest_m = 0.0f64;
        for (number, anchor) in anchors.iter().enumerate() {
            let (block, lane) = (&mut blocks[number / ABREAST], number % ABREAST);
            let point_m = anchor.point_m - middle_m;
            largest_m = largest_m.max(point_m.abs().max_element());
            for axis in 0..3 {
                block.point[axis][lane] = point_m[axis] as f32;
                block.normal[axis][lane] = anchor.normal[axis] as f32;
            }
            block.relative_scale[lane] = anchor.relative_scale as f32;
            block.bound_factor[lane] = anchor.bound_factor as f32;
        }
        AnchorBlocks { middle_m, largest_m, blocks }
    }

    /// Lists the anchors that a vertex connects to. Those with a weight of 1 or more are all chosen. The others are chosen in proportion to
    /// their weights, by equal steps of 1 through the running sum. `variate`, in [0, 1), is where the first step ends.
    pub(super) fn choose(&self, vertex: &ScoringVertex, variate: f64, chosen: &mut Vec<Choice>) {
        let vertex = self.in_f32(vertex);
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            return unsafe { self.choose_avx2(&vertex, variate, chosen) };
        }
        self.choose_among_all(&vertex, variate, chosen);
    }

    fn in_f32(&self, vertex: &ScoringVertex) -> VertexF32 {
        let point_m = vertex.point_m - self.middle_m;
        let largest_m = self.largest_m + point_m.abs().max_element();
        VertexF32 {
            point: point_m.as_vec3(),
            normal: vertex.normal.as_vec3(),
            factor: vertex.factor as f32,
            bound_per_m2: vertex.bound_per_m2.min(LARGEST_BOUND_PER_M2) as f32,
            margin_m: (ROUNDING_SHARE * largest_m) as f32,
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn choose_avx2(&self, vertex: &VertexF32, variate: f64, chosen: &mut Vec<Choice>) {
        self.choose_among_all(vertex, variate, chosen);
    }

    #[inline(always)]
    fn choose_among_all(&self, vertex: &VertexF32, variate: f64, chosen: &mut Vec<Choice>) {
        chosen.clear();
        let mut until_next = variate;
        for (number, block) in self.blocks.iter().enumerate() {
            let weights = block.weigh(vertex);
            let (sum, largest) = sum_and_largest(&weights);
            if largest < 1.0 && f64::from(sum) <= until_next {
                until_next -= f64::from(sum);
                continue;
            }
            for (lane, weight) in weights.iter().map(|weight| f64::from(*weight)).enumerate() {
                let anchor = number * ABREAST + lane;
                if weight >= 1.0 {
                    chosen.push((anchor, 1.0));
                    continue;
                }
                until_next -= weight;
                if until_next < 0.0 {
                    chosen.push((anchor, weight));
                    until_next += 1.0;
                }
            }
        }
    }
}

impl AnchorBlock {
    /// Returns the weight of each anchor: its score without occlusion, in units of the threshold.
    #[inline(always)]
    fn weigh(&self, vertex: &VertexF32) -> [f32; ABREAST] {
        let mut weights = [0.0; ABREAST];
        for (lane, weight) in weights.iter_mut().enumerate() {
            let of_lane = |axes: &[[f32; ABREAST]; 3]| [axes[0][lane], axes[1][lane], axes[2][lane]];
            let [x, y, z] = of_lane(&self.point);
            let offset = [x - vertex.point.x, y - vertex.point.y, z - vertex.point.z];
            let dot = |[x, y, z]: [f32; 3]| offset[0] * x + offset[1] * y + offset[2] * z;
            let leaving = larger(dot(vertex.normal.to_array()) + vertex.margin_m, 0.0);
            let arriving = larger(vertex.margin_m - dot(of_lane(&self.normal)), 0.0);
            let squared = dot(offset);
            let kernel = leaving * arriving / (squared * squared + f32::MIN_POSITIVE);
            let bound = vertex.bound_per_m2 * self.bound_factor[lane];
            *weight = vertex.factor * self.relative_scale[lane] * if kernel < bound { kernel } else { bound };
        }
        weights
    }
}

/// Returns the sum and the largest of eight numbers, by halves.
#[inline(always)]
fn sum_and_largest(numbers: &[f32; ABREAST]) -> (f32, f32) {
    let halved = |[a, b, c, d, e, f, g, h]: [f32; ABREAST], of: fn(f32, f32) -> f32| {
        of(of(of(a, e), of(c, g)), of(of(b, f), of(d, h)))
    };
    (halved(*numbers, |one, other| one + other), halved(*numbers, larger))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    const THRESHOLD: f64 = 0.02;

    /// 45 anchors: a floor, some of it in the vertex' plane by rounding alone, and some around the vertex.
    fn anchors() -> Vec<PlaneAnchor> {
        let mut stream = Stream::new(7, Purpose::Pilot, 0, 0);
        let mut random = || stream.unit() - 0.5;
        (0..45)
            .map(|number| {
                let around_m = DVec3::new(8.0 * random(), 5.0 * random(), 1.5 * random());
                let normal = DVec3::new(random(), random(), random()).normalize();
                let is_of_floor = number % 3 == 0;
                PlaneAnchor {
                    point_m: if is_of_floor { DVec3::new(around_m.x, around_m.y, 1e-9) } else { around_m },
                    normal: if number % 2 == 0 { normal } else { -DVec3::X },
                    relative_scale: 0.5 + 0.1 * f64::from(number),
                    bound_factor: f64::from(1 << (number % 3)),
                }
            })
            .collect()
    }

    fn vertex() -> ScoringVertex {
        ScoringVertex {
            point_m: DVec3::new(0.3, 0.2, 0.0),
            normal: DVec3::Z,
            factor: 0.1 / THRESHOLD,
            bound_per_m2: 0.8,
        }
    }

    /// The score in double precision, in units of the threshold.
    fn exact(vertex: &ScoringVertex, anchor: &PlaneAnchor) -> f64 {
        let offset_m = anchor.point_m - vertex.point_m;
        let (leaving, arriving) = (offset_m.dot(vertex.normal).max(0.0), (-offset_m.dot(anchor.normal)).max(0.0));
        let kernel_per_m2 = leaving * arriving / offset_m.length_squared().powi(2);
        vertex.factor * anchor.relative_scale * kernel_per_m2.min(vertex.bound_per_m2 * anchor.bound_factor)
    }

    /// 400,000 evenly spaced variates: every anchor is chosen as often as stated (within 2 choices), and as its score in double precision
    /// says, to 1e-3 where that is not near 0. Scores over probabilities have the score as their mean, for the anchors at grazing angles
    /// too. The portable version gives the same bytes. Planted fault: without a margin, one that sees the vertex is never chosen.
    #[test]
    fn every_anchor_that_sees_the_vertex_is_chosen_as_often_as_stated() {
        const N: usize = 400_000;
        let (anchors, vertex) = (anchors(), vertex());
        let blocks = AnchorBlocks::of(&anchors);
        let (mut chosen, mut again) = (Vec::new(), Vec::new());
        let (mut counts, mut stated) = (vec![0usize; anchors.len()], vec![0.0; anchors.len()]);
        for number in 0..N {
            let variate = (number as f64 + 0.5) / N as f64;
            blocks.choose(&vertex, variate, &mut chosen);
            if number % 1000 == 0 {
                blocks.choose_among_all(&blocks.in_f32(&vertex), variate, &mut again);
                assert_eq!(chosen, again);
            }
            for (anchor, probability) in &chosen {
                counts[*anchor] += 1;
                stated[*anchor] = *probability;
            }
        }
        let mut grazing = 0;
        for ((anchor, count), stated) in anchors.iter().zip(&counts).zip(&stated) {
            let expected = exact(&vertex, anchor);
            assert!((*count as f64 - stated * N as f64).abs() < 2.0, "{count} of {N}, stated {stated}");
            if expected > 1e-4 {
                assert!((stated / expected.min(1.0) - 1.0).abs() < 1e-3, "{stated} for {expected}");
            }
            grazing += usize::from(expected > 0.0 && expected < 1e-6);
        }
        assert!(grazing > 3 && counts.iter().sum::<usize>() > N, "a test of nothing: {grazing} at grazing angles");
        // Which anchors have a weight at all, with and without the margin.
        let seen = |vertex: &VertexF32| {
            let weights: Vec<f32> = blocks.blocks.iter().flat_map(|block| block.weigh(vertex)).collect();
            anchors.iter().zip(weights).all(|(anchor, weight)| weight > 0.0 || exact(&self::vertex(), anchor) <= 0.0)
        };
        let with_margin = blocks.in_f32(&vertex);
        assert!(seen(&with_margin));
        assert!(!seen(&VertexF32 { margin_m: 0.0, ..with_margin }), "the fault passed");
    }
}
