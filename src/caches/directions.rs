//! What neighbours receive from each direction: a control variate of each one's own rays, and where further rays are best sent.
//!
//! Neighbours see nearly the same surroundings. The mean of what a region's rays brought from each part of the hemisphere is a
//! function of direction; its mean over the hemisphere is known, since the parts are equally likely. Each entry takes the function
//! off its own rays and adds the known mean: what is left varies only as the entry differs from its neighbours. The function for one
//! half comes from the other half's rays, so that it knows nothing of the rays it is taken off, and no mean changes.
//!
//! What is left scatters more in some parts of the hemisphere than in others: a small bright spot, the edge of a shadow. Further rays go
//! into each part in proportion to its standard deviation, and count by the inverse.

/// Parts of the hemisphere along either variate of a direction, and in all.
const PARTS: usize = 16;
const BINS: usize = PARTS * PARTS;
/// Weight, in rays, of what the next larger part of the hemisphere says.
const WEIGHT_OF_LARGER: f32 = 2.0;
/// Share of the rays that goes evenly into all parts: what no ray has met yet is still found, and no ray counts more than the inverse.
const EVEN_SHARE: f64 = 0.3;
/// The largest variate below 1 whose sixteenth, beside a whole number, keeps its part.
const LAST: f64 = 1.0 - 1e-12;

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

    /// Adds the rays of others.
    pub fn add_all(&mut self, others: &DirectionSums) {
        for (sum, other) in self.sums.iter_mut().zip(&others.sums) {
            *sum = [sum[0] + other[0], sum[1] + other[1]];
        }
    }

    /// The function of direction of each region.
    ///
    /// A part with few rays leans on the next larger one, of twice the width in either variate.
    pub fn control(self) -> DirectionControl {
        let told = self.sums.chunks_exact(BINS).flat_map(told_by_parts);
        let told_lx: Vec<f32> = told.collect();
        let means_lx = told_lx.chunks_exact(BINS).map(|told| told.iter().sum::<f32>() / BINS as f32).collect();
        DirectionControl { told_lx, means_lx }
    }

    /// Where rays of entries in such regions are best sent, if these are sums of squared deviations.
    pub fn guide(self, regions: Vec<u32>) -> DirectionGuide {
        let (mut rows, mut columns) = (Vec::new(), Vec::new());
        for region in self.sums.chunks_exact(BINS) {
            let deviations: Vec<f64> = told_by_parts(region).iter().map(|squared| f64::from(*squared).sqrt()).collect();
            let even = deviations.iter().sum::<f64>() / BINS as f64;
            let share = |deviation: f64| match even > 0.0 {
                true => ((1.0 - EVEN_SHARE) * deviation / even + EVEN_SHARE) / BINS as f64,
                false => 1.0 / BINS as f64,
            };
            let shares: Vec<f64> = deviations.into_iter().map(share).collect();
            let of_rows: Vec<f64> = shares.chunks_exact(PARTS).map(|row| row.iter().sum()).collect();
            rows.extend(cumulative(&of_rows));
            columns.extend(shares.chunks_exact(PARTS).flat_map(cumulative));
        }
        DirectionGuide { regions, rows, columns }
    }
}

/// Cumulative shares; the last is 1.
fn cumulative(shares: &[f64]) -> Vec<f32> {
    let total: f64 = shares.iter().sum();
    let mut sum = 0.0;
    let mut all: Vec<f32> = shares
        .iter()
        .map(|share| {
            sum += share / total;
            sum as f32
        })
        .collect();
    all[PARTS - 1] = 1.0;
    all
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

/// What the rays of a region bring from each part of the hemisphere.
#[derive(Clone, Debug)]
pub struct DirectionControl {
    told_lx: Vec<f32>,
    means_lx: Vec<f32>,
}

impl DirectionControl {
    /// What a ray is expected to bring, in lx.
    #[inline]
    pub fn told_lx(&self, region: u32, bin: u8) -> f32 {
        self.told_lx[region as usize * BINS + usize::from(bin)]
    }

    /// What a ray that brought some light stands for once that is taken off, in lx: its weight is even density over the one it was drawn by.
    #[inline]
    pub fn controlled_lx(&self, region: u32, bin: u8, lx: f32, weight: f32) -> f64 {
        let beyond_lx = f64::from(lx) - f64::from(self.told_lx(region, bin));
        f64::from(weight) * beyond_lx + f64::from(self.means_lx[region as usize])
    }
}

/// Into which parts of the hemisphere rays are sent.
#[derive(Clone, Debug)]
pub struct DirectionGuide {
    /// Region of every entry.
    regions: Vec<u32>,
    /// Of every region: cumulative shares of the parts along the first variate, and within each of these along the second.
    rows: Vec<f32>,
    columns: Vec<f32>,
}

impl DirectionGuide {
    /// Two variates by which an entry's direction is to be drawn in the place of two even ones, and the weight of the ray.
    #[inline]
    pub fn draw(&self, entry: usize, [u, v]: [f64; 2]) -> ([f64; 2], f64) {
        let region = self.regions[entry] as usize;
        let (row, u, of_row) = invert(&self.rows[region * PARTS..][..PARTS], u);
        let (column, v, of_column) = invert(&self.columns[region * BINS + row * PARTS..][..PARTS], v);
        let place = |part: usize, variate: f64| (part as f64 + variate) / PARTS as f64;
        ([place(row, u), place(column, v)], 1.0 / (BINS as f64 * of_row * of_column))
    }
}

/// The part in which a variate falls by cumulative shares, the variate within it, and the part's share.
#[inline]
fn invert(cumulative: &[f32], variate: f64) -> (usize, f64, f64) {
    let part = cumulative.iter().take_while(|share| f64::from(**share) <= variate).count().min(PARTS - 1);
    let before = if part == 0 { 0.0 } else { f64::from(cumulative[part - 1]) };
    let share = f64::from(cumulative[part]) - before;
    (part, ((variate - before) / share).clamp(0.0, LAST), share)
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
        let mean = (0..BINS).map(|bin| lx(middle(bin / PARTS), middle(bin % PARTS))).sum::<f32>() / BINS as f32;
        for bin in 0..BINS {
            let (told, expected) = (control.told_lx(1, bin as u8), lx(middle(bin / PARTS), middle(bin % PARTS)));
            assert!((told - expected).abs() < 0.1, "{bin}: {told} for {expected}");
            // What is told counts as the mean.
            assert!((control.controlled_lx(1, bin as u8, told, 3.0) - f64::from(mean)).abs() < 0.01);
        }
        // Nothing is known of the other region.
        assert!((0..BINS).all(|bin| control.told_lx(0, bin as u8) == 0.0));
    }

    #[test]
    fn few_rays_tell_of_large_parts_alone() {
        // One ray in each quarter of the hemisphere: parts without rays of their own tell the same.
        let mut sums = DirectionSums::new(1);
        for (u, v, lx) in [(0.2, 0.2, 0.0), (0.2, 0.7, 10.0), (0.7, 0.2, 20.0), (0.7, 0.7, 30.0)] {
            sums.add(0, bin_of([u, v]), lx);
        }
        let control = sums.control();
        let told = |u, v| control.told_lx(0, bin_of([u, v]));
        assert_eq!(told(0.01, 0.01), told(0.05, 0.05));
        assert!(told(0.05, 0.05) < told(0.05, 0.95) && told(0.05, 0.95) < told(0.95, 0.05));
    }

    #[test]
    fn guided_rays_have_the_mean_of_even_ones_and_go_where_light_scatters() {
        // A spot in one corner of the square of variates; entry 0 lies in region 1.
        let spot = |[u, v]: [f64; 2]| if u < 0.05 && v < 0.03 { 1.0 } else { 0.01 * u };
        let mut sums = DirectionSums::new(2);
        let steps = 200;
        let even =
            |place: usize| [(place / steps) as f64 + 0.5, (place % steps) as f64 + 0.5].map(|step| step / steps as f64);
        for place in 0..steps * steps {
            sums.add(1, bin_of(even(place)), spot(even(place)).powi(2) as f32);
        }
        let guide = sums.guide(vec![1, 0]);
        let (mut mean, mut guided, mut weights, mut met) = (0.0, 0.0, 0.0, 0);
        for place in 0..steps * steps {
            let (variates, weight) = guide.draw(0, even(place));
            assert!(variates.iter().all(|variate| (0.0..1.0).contains(variate)) && weight < 1.0 / EVEN_SHARE + 1e-3);
            mean += spot(even(place));
            guided += weight * spot(variates);
            weights += weight;
            met += usize::from(spot(variates) == 1.0);
        }
        let count = (steps * steps) as f64;
        assert!((guided / mean - 1.0).abs() < 0.01, "{guided} {mean}");
        assert!((weights / count - 1.0).abs() < 0.01, "{weights}");
        assert!(met as f64 > 20.0 * 0.05 * 0.03 * count, "{met}");
        // Nothing is known of region 0: rays go evenly.
        let (variates, weight) = guide.draw(1, [0.3, 0.999_999]);
        assert!((variates[0] - 0.3).abs() < 1e-6 && (weight - 1.0).abs() < 1e-5);
    }
}
