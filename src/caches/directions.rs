//! What neighbours receive from each direction, as a control variate of each one's own rays.
//!
//! Neighbours see nearly the same surroundings. The mean of what a region's rays brought from each part of the hemisphere is a
//! function of direction; its mean over the hemisphere is known, since the parts are equally likely. Each entry takes the function
//! off its own rays and adds the known mean: what is left varies only as the entry differs from its neighbours. The function for one
//! half comes from the other half's rays, so that it knows nothing of the rays it is taken off, and no mean changes.

/// Parts of the hemisphere along either variate of a direction, and in all.
const PARTS: usize = 16;
const BINS: usize = PARTS * PARTS;
/// Weight, in rays, of what the next larger part of the hemisphere says.
const WEIGHT_OF_LARGER: f32 = 2.0;

/// Part of the hemisphere in which a direction lies that was drawn by two variates.
#[inline]
pub fn bin_of([u, v]: [f64; 2]) -> u8 {
    let part = |variate: f64| (variate * PARTS as f64) as u8;
    part(u) << 4 | part(v)
}

/// Sums over the rays of regions, by parts of the hemisphere.
#[derive(Clone, Debug)]
pub struct DirectionSums {
    /// Of every region and part: sum in lx, and number of rays.
    sums: Vec<[f32; 2]>,
}

impl DirectionSums {
    /// No rays yet.
    pub fn new(regions: usize) -> DirectionSums {
        DirectionSums { sums: vec![[0.0; 2]; regions * BINS] }
    }

    /// Adds a ray.
    #[inline]
    pub fn add(&mut self, region: u32, bin: u8, lx: f32) {
        let sum = &mut self.sums[region as usize * BINS + usize::from(bin)];
        sum[0] += lx;
        sum[1] += 1.0;
    }

    /// The function of direction of each region, less its mean.
    ///
    /// A part with few rays leans on the next larger one, of twice the width in either variate.
    pub fn control(mut self) -> DirectionControl {
        for region in self.sums.chunks_exact_mut(BINS) {
            let told = told_by_parts(region);
            let mean = told.iter().sum::<f32>() / BINS as f32;
            region.iter_mut().zip(told).for_each(|(sum, told)| sum[0] = told - mean);
        }
        DirectionControl { differences_lx: self.sums.into_iter().map(|sum| sum[0]).collect() }
    }
}

/// What each part tells, by its own rays and by those of the larger parts that it lies in.
fn told_by_parts(sums: &[[f32; 2]]) -> Vec<f32> {
    // From the finest to the whole hemisphere.
    let mut levels = vec![sums.to_vec()];
    let mut parts = PARTS;
    while parts > 1 {
        parts /= 2;
        let finer = &levels[levels.len() - 1];
        let coarser = (0..parts * parts).map(|bin| {
            let (row, column) = (2 * (bin / parts), 2 * (bin % parts));
            let children =
                [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(down, on)| finer[(row + down) * 2 * parts + column + on]);
            children.iter().fold([0.0; 2], |sum, child| [sum[0] + child[0], sum[1] + child[1]])
        });
        let coarser = coarser.collect();
        levels.push(coarser);
    }
    let mut told = vec![0.0];
    for level in levels.iter().rev() {
        let larger = told;
        told = level
            .iter()
            .enumerate()
            .map(|(bin, [sum, count])| {
                let above = match level.len() {
                    1 => 0,
                    _ => (bin / parts / 2) * (parts / 2) + bin % parts / 2,
                };
                let weight = if level.len() == 1 { 0.0 } else { WEIGHT_OF_LARGER };
                let rays = count + weight;
                if rays > 0.0 { (sum + weight * larger[above]) / rays } else { 0.0 }
            })
            .collect();
        parts *= 2;
    }
    told
}

/// What the rays of a region bring from each part of the hemisphere beyond their mean.
#[derive(Clone, Debug)]
pub struct DirectionControl {
    differences_lx: Vec<f32>,
}

impl DirectionControl {
    /// What a ray is expected to bring beyond the mean, in lx: of mean 0 over the hemisphere.
    #[inline]
    pub fn expected_lx(&self, region: u32, bin: u8) -> f32 {
        self.differences_lx[region as usize * BINS + usize::from(bin)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_is_the_function_where_rays_are_many_and_has_no_mean() {
        let lx = |u: f64, v: f64| (100.0 * u + 30.0 * (v - 0.5).powi(2)) as f32;
        let mut sums = DirectionSums::new(2);
        let middle = |part: usize| (part as f64 + 0.5) / PARTS as f64;
        for bin in 0..BINS {
            let [u, v] = [middle(bin / PARTS), middle(bin % PARTS)];
            assert_eq!(usize::from(bin_of([u, v])), bin);
            (0..400).for_each(|_| sums.add(1, bin as u8, lx(u, v)));
        }
        let control = sums.control();
        let all = (0..BINS).map(|bin| control.expected_lx(1, bin as u8));
        assert!(all.clone().sum::<f32>().abs() < 0.01);
        let mean = (0..BINS).map(|bin| lx(middle(bin / PARTS), middle(bin % PARTS))).sum::<f32>() / BINS as f32;
        for (bin, told) in all.enumerate() {
            let expected = lx(middle(bin / PARTS), middle(bin % PARTS)) - mean;
            assert!((told - expected).abs() < 0.1, "{bin}: {told} for {expected}");
        }
        // Nothing is known of the other region.
        assert!((0..BINS).all(|bin| control.expected_lx(0, bin as u8) == 0.0));
    }

    #[test]
    fn few_rays_tell_of_large_parts_alone() {
        // One ray in each quarter of the hemisphere: parts without rays of their own tell the same.
        let mut sums = DirectionSums::new(1);
        for (u, v, lx) in [(0.2, 0.2, 0.0), (0.2, 0.7, 10.0), (0.7, 0.2, 20.0), (0.7, 0.7, 30.0)] {
            sums.add(0, bin_of([u, v]), lx);
        }
        let control = sums.control();
        let told = |u, v| control.expected_lx(0, bin_of([u, v]));
        assert_eq!(told(0.01, 0.01), told(0.05, 0.05));
        assert!(told(0.05, 0.05) < told(0.05, 0.95) && told(0.05, 0.95) < told(0.95, 0.05));
    }
}
