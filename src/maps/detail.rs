//! Variation of the illuminance within elements, which an element map cannot show (docs/methods.md (20)).
//!
//! An element shows its mean, or its mean and two slopes. The rest is measured without bias. For linear and quadratic parts, it comes from
//! products of the coefficients of the even and the odd half. Direct light has edges that no polynomial follows; for it, the product of two
//! light samples from the same point is used.

use serde::{Deserialize, Serialize};

use super::children::ChildElement;
use super::{HALF, REPLICAS};
use crate::estimators::basis::{BENDS, MEANS_OVER_PARTS, PARTS, SLOPES};

/// Largest number of elements for which the indirect variation beyond quadratic functions is measured. More would take too much memory.
const MOST_WITH_PARTS: usize = 50_000;

/// Sums over the samples of one replica in one element.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct DirectDetail {
    /// Sum of (direct light − reference at the point) times the polynomials, in lx.
    pub bends_lx: [f64; BENDS],
    /// Sum of (direct light − reference), in lx.
    pub sum_lx: f64,
    /// Sum of the products of two light samples, each minus the reference, in lx².
    pub product_lx2: f64,
}

/// Sums for the variation of light within elements.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Detail {
    /// One slab per replica.
    pub direct: Vec<Vec<DirectDetail>>,
    /// One slab per replica: sums of (indirect scores − reference) times the polynomials, in the unit of the map's scores.
    pub indirect: Vec<Vec<[f64; BENDS]>>,
}

/// Variation of the light within one element: mean squares over its area in lx².
#[derive(Clone, Copy, Debug, Default)]
pub struct Variation {
    /// Variation of direct light, without its linear part.
    pub direct_lx2: f64,
    /// Variance of the estimate `direct_lx2`.
    pub direct_noise: f64,
    /// Additional variation by indirect light: its quadratic part, and its product with that of direct light.
    pub indirect_lx2: f64,
    /// Variance of the estimate `indirect_lx2`.
    pub indirect_noise: f64,
    /// Variation of the linear part, of direct and indirect light together.
    pub slope_lx2: f64,
    /// Variance of the estimate `slope_lx2`.
    pub slope_noise: f64,
}

impl Detail {
    /// Returns empty sums for `sites` elements.
    pub fn new(sites: usize) -> Detail {
        Detail {
            direct: vec![vec![DirectDetail::default(); sites]; REPLICAS],
            indirect: vec![vec![[0.0; BENDS]; sites]; REPLICAS],
        }
    }

    /// Takes over the variation of indirect light within coarser elements, whose children these elements are.
    pub fn take_indirect(&mut self, coarse: &IndirectDetail, children: &[ChildElement]) {
        for (slab, coarse) in self.indirect.iter_mut().zip(&coarse.bends_lx) {
            slab.iter_mut()
                .zip(children)
                .for_each(|(bends, child)| *bends = child.bends(coarse[child.parent as usize]));
        }
    }

    /// Clears the sums of indirect light.
    pub fn restart_indirect(&mut self) {
        self.indirect.iter_mut().for_each(|slab| slab.fill([0.0; BENDS]));
    }

    /// Returns the variation of the light within an element. The scales are the values of one unit of its direct and indirect sums
    /// ([`ReplicaMap::scales`](super::ReplicaMap::scales)). `reference_slopes_lx` are the slopes of both references.
    ///
    /// With `apart`, indirect light is that of coarser elements, which report their own variation of it. Here only its product with direct
    /// light counts. An element that is not `whole` is partly hidden by contact. Its samples lie unevenly, so polynomials give no
    /// information. Then all the variance of direct light is reported, and none of indirect light.
    pub fn variation(
        &self,
        site: usize,
        (direct_scale, indirect_scale): (f64, f64),
        reference_slopes_lx: [[f64; SLOPES]; 2],
        [apart, whole]: [bool; 2],
    ) -> Variation {
        let direct: [[f64; BENDS]; REPLICAS] =
            std::array::from_fn(|replica| self.direct[replica][site].bends_lx.map(|sum_lx| sum_lx * direct_scale));
        let indirect: [[f64; BENDS]; REPLICAS] =
            std::array::from_fn(|replica| self.indirect[replica][site].map(|sum| sum * indirect_scale));
        let sums_lx: [f64; REPLICAS] = std::array::from_fn(|replica| self.direct[replica][site].sum_lx * direct_scale);
        let products_lx2: [f64; REPLICAS] =
            std::array::from_fn(|replica| self.direct[replica][site].product_lx2 * direct_scale);

        let mut found = Variation::default();
        // Direct light: all its variance, minus the part that linear functions of the element follow.
        let follows = f64::from(u8::from(whole));
        let followed = [0, 1].map(|k| Halves::of(|replica| follows * direct[replica][k]));
        let mean = Halves::of(|replica| sums_lx[replica]);
        found.direct_lx2 = products_lx2.iter().sum::<f64>() / REPLICAS as f64
            - mean.product()
            - followed.iter().map(Halves::product).sum::<f64>();
        let influence = Halves::of(|replica| {
            products_lx2[replica]
                - 2.0 * mean.mean() * sums_lx[replica]
                - (0..SLOPES).map(|k| 2.0 * followed[k].mean() * direct[replica][k]).sum::<f64>()
        });
        found.direct_noise = influence.variance_of_mean();
        if !whole {
            return found;
        }
        for k in 0..BENDS {
            let (d, i) = (Halves::of(|replica| direct[replica][k]), Halves::of(|replica| indirect[replica][k]));
            let both = Halves::of(|replica| direct[replica][k] + indirect[replica][k]);
            if k < SLOPES {
                let [of_direct, of_indirect] = reference_slopes_lx.map(|slopes| slopes[k]);
                let both = both.beyond(of_direct + of_indirect);
                let alone = if apart { i.beyond(of_indirect).product() } else { 0.0 };
                found.slope_lx2 += both.product() - alone;
                found.slope_noise += match apart {
                    true => {
                        let d = d.beyond(of_direct);
                        d.variance_of_product() + d.variance_of_cross(&i.beyond(of_indirect))
                    }
                    false => both.variance_of_product(),
                };
            } else {
                let (alone, noise) = if apart { (i.product(), 0.0) } else { (0.0, i.variance_of_product()) };
                found.indirect_lx2 += both.product() - d.product() - alone;
                found.indirect_noise += noise + d.variance_of_cross(&i);
            }
        }
        found
    }
}

/// Sums for the variation of gathered light within elements, one slab per replica.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct IndirectDetail {
    /// Sums of (samples − reference) times the polynomials, in lx.
    pub bends_lx: Vec<Vec<[f64; BENDS]>>,
    /// Sums of (samples − reference) in each part of the elements, in lx. Empty where there are too many elements.
    pub parts_lx: Vec<Vec<[f64; PARTS]>>,
    /// Rays of the even and of the odd replicas that started in each part of the elements, as passes. Empty where `parts_lx` is.
    pub passes_of_parts: Vec<[[f64; PARTS]; 2]>,
    /// For each element, its light times the first and the second power of its nearness, in lx (docs/methods.md (58)). About in proportion
    /// to the slopes and the bends of the light.
    pub near_lx: Vec<[f64; 2]>,
}

impl IndirectDetail {
    /// Returns empty sums for `sites` elements.
    pub fn new(sites: usize) -> IndirectDetail {
        let with_parts = IndirectDetail::with_parts(sites);
        IndirectDetail {
            bends_lx: vec![vec![[0.0; BENDS]; sites]; REPLICAS],
            parts_lx: vec![vec![[0.0; PARTS]; with_parts]; REPLICAS],
            passes_of_parts: vec![[[0.0; PARTS]; 2]; with_parts],
            near_lx: vec![[0.0; 2]; sites],
        }
    }

    /// Returns the number of elements, out of `sites`, with separate sums of their parts: all or none.
    pub fn with_parts(sites: usize) -> usize {
        if sites <= MOST_WITH_PARTS { sites } else { 0 }
    }

    /// Returns the variation of the light within an element. `inverse_samples` is 1 over the samples of a replica. `reference_slopes_lx`
    /// are the slopes of the reference.
    ///
    /// Variation beyond quadratic functions, for example edges of the shadows of bright surfaces, appears in the means over parts of the
    /// element. An element that is not `whole` shows no slopes, and its samples lie more often in some parts than in others. All that its
    /// parts differ counts as slopes.
    pub fn variation(
        &self,
        site: usize,
        inverse_samples: f64,
        reference_slopes_lx: [f64; SLOPES],
        whole: bool,
    ) -> Variation {
        if !whole {
            return self.variation_between_parts(site);
        }
        let mut found = Variation::default();
        let bends: [[f64; BENDS]; REPLICAS] =
            std::array::from_fn(|replica| self.bends_lx[replica][site].map(|sum_lx| sum_lx * inverse_samples));
        for k in 0..BENDS {
            let seen = Halves::of(|replica| bends[replica][k]);
            if k < SLOPES {
                let seen = seen.beyond(reference_slopes_lx[k]);
                found.slope_lx2 += seen.product();
                found.slope_noise += seen.variance_of_product();
            } else {
                found.indirect_lx2 += seen.product();
                found.indirect_noise += seen.variance_of_product();
            }
        }
        if site >= self.parts_lx[0].len() {
            return found;
        }
        let polynomials = &*MEANS_OVER_PARTS;
        let left: [[f64; PARTS]; REPLICAS] = std::array::from_fn(|replica| {
            let sums_lx = &self.parts_lx[replica][site];
            let mean_lx = sums_lx.iter().sum::<f64>() * inverse_samples;
            std::array::from_fn(|part| {
                let followed: f64 = bends[replica].iter().zip(&polynomials[part]).map(|(bend, mean)| bend * mean).sum();
                PARTS as f64 * inverse_samples * sums_lx[part] - mean_lx - followed
            })
        });
        let of_parts = (0..PARTS).map(|part| Halves::of(|replica| left[replica][part]));
        for seen in of_parts {
            found.indirect_lx2 += seen.product() / PARTS as f64;
            found.indirect_noise += seen.variance_of_product() / (PARTS * PARTS) as f64;
        }
        found
    }
}

impl IndirectDetail {
    /// Variation of the light between the parts of an element, each with the weight of its rays. 0 where parts have no sums.
    /// A part's mean over a half is its sum over its own rays, so that it does not matter how many there were.
    fn variation_between_parts(&self, site: usize) -> Variation {
        let mut found = Variation::default();
        let Some([even, odd]) = self.passes_of_parts.get(site) else {
            return found;
        };
        let is_seen = |part: &usize| even[*part] > 0.0 && odd[*part] > 0.0;
        let seen_parts: Vec<usize> = (0..PARTS).filter(is_seen).collect();
        let passes = |part: usize| even[part] + odd[part];
        let all: f64 = seen_parts.iter().map(|part| passes(*part)).sum();
        let mean_lx = |replica: usize, part: usize| {
            let of_half = if replica.is_multiple_of(2) { even[part] } else { odd[part] };
            self.parts_lx[replica][site][part] * HALF as f64 / of_half
        };
        let of_element_lx: [f64; REPLICAS] = std::array::from_fn(|replica| {
            seen_parts.iter().map(|part| passes(*part) / all * mean_lx(replica, *part)).sum()
        });
        for part in seen_parts.iter().copied() {
            let seen = Halves::of(|replica| mean_lx(replica, part) - of_element_lx[replica]);
            let weight = passes(part) / all;
            found.slope_lx2 += weight * seen.product();
            found.slope_noise += weight * weight * seen.variance_of_product();
        }
        found
    }
}

/// Means of the even and of the odd replicas, and the variances of these means.
struct Halves {
    means: [f64; 2],
    variances: [f64; 2],
}

impl Halves {
    fn of(value: impl Fn(usize) -> f64) -> Halves {
        let means = [0, 1].map(|parity| (0..HALF).map(|j| value(2 * j + parity)).sum::<f64>() / HALF as f64);
        let variances = [0, 1].map(|parity| {
            let squares: f64 = (0..HALF).map(|j| (value(2 * j + parity) - means[parity]).powi(2)).sum();
            squares / (HALF * (HALF - 1)) as f64
        });
        Halves { means, variances }
    }

    fn beyond(&self, known: f64) -> Halves {
        Halves { means: self.means.map(|mean| known + mean), variances: self.variances }
    }

    fn mean(&self) -> f64 {
        0.5 * (self.means[0] + self.means[1])
    }

    /// Returns the square of the expectation, without bias.
    fn product(&self) -> f64 {
        self.means[0] * self.means[1]
    }

    fn variance_of_mean(&self) -> f64 {
        0.25 * (self.variances[0] + self.variances[1])
    }

    /// Returns the variance of twice the product with the expectation of another quantity. Each product uses opposite halves of the two
    /// quantities.
    fn variance_of_cross(&self, other: &Halves) -> f64 {
        let ([one, two], [here, there]) = (self.variances, other.variances);
        let (self_squared, other_squared) = (self.mean().powi(2), other.mean().powi(2));
        self_squared * (here + there) + other_squared * (one + two) + one * there + two * here
    }

    fn variance_of_product(&self) -> f64 {
        self.variances[0] * self.variances[1] + 4.0 * self.product().max(0.0) * self.variance_of_mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimators::basis::{bends_at, part_of};
    use crate::sampling::random::{Purpose, Stream};
    use crate::sampling::warp::uniform_triangle;

    const SAMPLES: u64 = 64;

    /// Returns the measured variation of a function and its stated noise, averaged over `elements` elements. Every sample has a random
    /// error of 1 lx.
    fn estimated(seed: u64, elements: u64, with_parts: bool, lx: impl Fn([f64; 2]) -> f64) -> Variation {
        let mut detail = IndirectDetail::new(1);
        if !with_parts {
            detail.parts_lx.iter_mut().for_each(Vec::clear);
        }
        let mut found = Variation::default();
        for element in 0..elements {
            detail.bends_lx.iter_mut().for_each(|slab| slab.fill([0.0; BENDS]));
            detail.parts_lx.iter_mut().for_each(|slab| slab.fill([0.0; PARTS]));
            for replica in 0..REPLICAS {
                let mut stream = Stream::new(seed, Purpose::Pilot, 0, replica as u32);
                for sample in 0..SAMPLES {
                    stream.seek_quasi((element << 32) | sample, element, sample);
                    let at = uniform_triangle(stream.pair());
                    let value_lx = lx(at) + if stream.unit() < 0.5 { 1.0 } else { -1.0 };
                    let bends = &mut detail.bends_lx[replica][0];
                    bends.iter_mut().zip(bends_at(at)).for_each(|(sum, bend)| *sum += value_lx * bend);
                    if let Some(parts) = detail.parts_lx[replica].get_mut(0) {
                        parts[part_of(at)] += value_lx;
                    }
                }
            }
            let one = detail.variation(0, 1.0 / SAMPLES as f64, [0.0; SLOPES], true);
            found.indirect_lx2 += one.indirect_lx2 / elements as f64;
            found.indirect_noise += one.indirect_noise / elements as f64;
        }
        found
    }

    /// Returns the mean square over a triangle, on a fine lattice, of a function minus its linear part.
    fn exact(lx: impl Fn([f64; 2]) -> f64) -> f64 {
        const STEPS: u32 = 200;
        let middles = (0..STEPS * STEPS).map(|part| {
            let [a, b, c] = crate::scene::elements::part_corners(STEPS, part);
            [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0)
        });
        let (mut square, mut mean, mut slopes) = (0.0, 0.0, [0.0; SLOPES]);
        for at in middles {
            let value_lx = lx(at) / f64::from(STEPS * STEPS).sqrt();
            let weight = f64::from(STEPS * STEPS).sqrt().recip();
            square += value_lx * value_lx;
            mean += value_lx * weight;
            (0..SLOPES).for_each(|k| slopes[k] += value_lx * weight * bends_at(at)[k]);
        }
        square - mean * mean - slopes.iter().map(|slope| slope * slope).sum::<f64>()
    }

    /// 400 elements, seed 3. The tolerance is four standard errors of the mean over all elements, from their stated noise (α = 6e-5). A
    /// curve is measured completely, within that and a tenth for what parts do not show. A plane gives nothing, an edge at least a third.
    /// Quadratic polynomials alone, the planted fault, give an eighth of the edge.
    #[test]
    fn edges_of_indirect_light_are_reported_and_chance_is_not() {
        let plane = |[a, b]: [f64; 2]| 3.0 + 2.0 * a - b;
        let curve = |[a, b]: [f64; 2]| 4.0 * (a - b) * (a - b);
        let edge = |[a, b]: [f64; 2]| if a + 0.3 * b > 0.45 { 1.5 } else { 0.0 };
        let sure = |estimated: &Variation| 4.0 * (estimated.indirect_noise / 400.0).sqrt();
        let of_plane = estimated(3, 400, true, plane);
        assert!(of_plane.indirect_lx2.abs() < sure(&of_plane), "{of_plane:?}");
        let (of_curve, all) = (estimated(3, 400, true, curve), exact(curve));
        assert!((of_curve.indirect_lx2 - all).abs() < sure(&of_curve) + 0.1 * all, "{of_curve:?} {all}");
        let [of_edge, of_bends] = [true, false].map(|with_parts| estimated(3, 400, with_parts, edge));
        let all = exact(edge);
        let is_reported =
            |estimated: &Variation| (0.33 * all..all).contains(&(estimated.indirect_lx2 - sure(estimated)));
        assert!(is_reported(&of_edge), "{of_edge:?} {all}");
        assert!(!is_reported(&of_bends), "the planted fault passed: {of_bends:?} {all}");
    }

    /// Mean variation between the parts of 400 elements of which only points with b < 0.55 are free, its standard error, and what it would be
    /// if samples were taken to lie evenly. Every sample has a random error of 1 lx.
    fn between_parts(seed: u64, lx: impl Fn([f64; 2]) -> f64) -> [f64; 3] {
        let (mut found, mut noise, mut as_even) = (0.0, 0.0, 0.0);
        for element in 0..400u64 {
            let mut detail = IndirectDetail::new(1);
            for replica in 0..REPLICAS {
                let mut stream = Stream::new(seed, Purpose::Pilot, 0, replica as u32);
                for sample in 0..SAMPLES {
                    stream.seek((element << 32) | sample);
                    let at = std::iter::repeat_with(|| uniform_triangle(stream.pair())).find(|at| at[1] < 0.55);
                    let at = at.expect("most points are free");
                    let value_lx = lx(at) + if stream.unit() < 0.5 { 1.0 } else { -1.0 };
                    detail.parts_lx[replica][0][part_of(at)] += value_lx;
                    detail.passes_of_parts[0][replica % 2][part_of(at)] += 1.0;
                }
            }
            let one = detail.variation(0, 1.0 / SAMPLES as f64, [0.0; SLOPES], false);
            found += one.slope_lx2 / 400.0;
            noise += one.slope_noise / 400.0;
            as_even += detail.variation(0, 1.0 / SAMPLES as f64, [0.0; SLOPES], true).indirect_lx2 / 400.0;
        }
        [found, (noise / 400.0).sqrt(), as_even]
    }

    /// 400 elements, seed 7, tolerance four standard errors (α = 6e-5). Even light gives nothing where points lie unevenly; an edge across half
    /// of the free points, of 2 lx, gives most of its 1 lx² and no more. Planted fault: samples that are taken to lie evenly show a variation
    /// of even light.
    #[test]
    fn elements_beside_contact_report_what_their_parts_differ() {
        let [of_even, error, as_even] = between_parts(7, |_| 3.0);
        assert!(of_even.abs() < 4.0 * error + 0.01, "{of_even} ± {error}");
        assert!(as_even > 1.0, "the planted fault passed: {as_even}");
        let [of_edge, error, _] = between_parts(7, |[a, _]| if a > 0.31 { 2.0 } else { 0.0 });
        assert!(of_edge > 0.5 && of_edge < 1.0 + 4.0 * error, "{of_edge} ± {error}");
    }
}
