//! Patches of one size and the light that is known of them.

use rayon::prelude::*;

use crate::geometry::SurfaceHit;
use crate::maps::{HALF, REPLICAS};
use crate::scene::patches::{PatchPlace, Patches};

/// Expected deposits of a replica on a patch from which on slopes are worth their noise.
const DEPOSITS_FOR_SLOPES: f64 = 4.0;
/// Points of a patch that tell how much of it shows.
pub const EXPOSURE_POINTS: u64 = 16;

/// Illuminance in lx at the middle of a patch, and its slopes along the two offsets.
pub type LinearLx = [f64; 3];

/// Patches of one size, what was left in them, and what each half keeps of it: what its eight memories say (`KEPT` 8) or their
/// mean (`KEPT` 1).
pub struct Layer<const KEPT: usize> {
    pub patches: Patches,
    /// Share of each patch that is not hidden inside of a solid that stands on it: all that rays can meet.
    pub exposed: Vec<f64>,
    /// Deposits of each replica on each patch: their number and the sums of their offsets.
    pub sums: Vec<Vec<[f64; 3]>>,
    /// Indirect light of each patch, replica by replica.
    pub indirect_lx: Vec<Vec<LinearLx>>,
    /// Direct light of each patch, replica by replica, where it is looked up.
    pub direct_lx: Vec<Vec<LinearLx>>,
    /// Indirect light as the even and the odd half look it up.
    indirect: [Vec<Kept<KEPT>>; 2],
    /// Both together; empty where direct light is not looked up.
    whole: [Vec<Kept<KEPT>>; 2],
}

/// What a half keeps of a patch: illuminance in lx at its middle, and its slopes along the two offsets.
type Kept<const KEPT: usize> = [[f64; KEPT]; 3];

/// Of what light a memory is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Of light that surfaces reflected.
    Indirect,
    /// Of all light.
    Whole,
}

/// A linear function at a place of its patch.
#[inline]
fn linear_at([middle, along_a, along_b]: LinearLx, [a, b]: [f64; 2]) -> f64 {
    middle + along_a * a + along_b * b
}

/// Mean of what the eight memories of a half say.
#[inline]
pub fn mean_of(memories_lx: &[f64; HALF]) -> f64 {
    memories_lx.iter().sum::<f64>() / HALF as f64
}

/// Mean and slopes of a linear function from the sums of samples and of samples times offsets: the inverse of the
/// offsets' covariances, 1/18 each and −1/36 between them.
pub fn projected([sum, a, b]: [f64; 3], unit: f64, slopes: bool) -> LinearLx {
    let slope_unit = if slopes { unit } else { 0.0 };
    [sum * unit, (24.0 * a + 12.0 * b) * slope_unit, (12.0 * a + 24.0 * b) * slope_unit]
}

impl<const KEPT: usize> Layer<KEPT> {
    /// Dark patches, of each of which a share is exposed.
    pub fn new(patches: Patches, exposed: Vec<f64>) -> Layer<KEPT> {
        let sums = vec![vec![[0.0; 3]; patches.len()]; REPLICAS];
        let dark = vec![[[0.0; KEPT]; 3]; patches.len()];
        Layer {
            patches,
            exposed,
            indirect_lx: sums.clone(),
            direct_lx: Vec::new(),
            sums,
            indirect: [dark.clone(), dark],
            whole: Default::default(),
        }
    }

    /// Turns deposits into illuminances; slopes only where deposits are dense enough.
    pub fn value(&mut self, flux_per_chain_lm: f64) {
        let deposits: f64 = self.sums.iter().flatten().map(|sum| sum[0]).sum();
        let density_m2 = deposits / REPLICAS as f64 / self.patches.all_area_m2();
        let (patches, exposed) = (&self.patches, &self.exposed);
        self.indirect_lx.par_iter_mut().with_max_len(1).zip(&self.sums).for_each(|(values_lx, sums)| {
            for (patch, (value_lx, sum)) in values_lx.iter_mut().zip(sums).enumerate() {
                // A patch of which nothing is known to show still takes what reaches it.
                let area_m2 = patches.area_m2(patch as u32) * exposed[patch].max(1.0 / EXPOSURE_POINTS as f64);
                let slopes = exposed[patch] == 1.0 && density_m2 * area_m2 >= DEPOSITS_FOR_SLOPES;
                *value_lx = projected(*sum, flux_per_chain_lm / area_m2, slopes);
            }
        });
    }

    /// Makes the halves keep what the replicas know.
    pub fn tabulate(&mut self) {
        let (indirect_lx, direct_lx) = (&self.indirect_lx, &self.direct_lx);
        let len = self.patches.len();
        for (parity, (indirect, whole)) in self.indirect.iter_mut().zip(&mut self.whole).enumerate() {
            indirect.par_iter_mut().enumerate().for_each(|(patch, kept)| {
                *kept = kept_of(|memory| indirect_lx[2 * memory + parity][patch]);
            });
            if direct_lx.is_empty() {
                continue;
            }
            whole.resize(len, [[0.0; KEPT]; 3]);
            whole.par_iter_mut().enumerate().for_each(|(patch, kept)| {
                *kept = kept_of(|memory| {
                    let replica = 2 * memory + parity;
                    let (indirect, direct) = (indirect_lx[replica][patch], direct_lx[replica][patch]);
                    std::array::from_fn(|coefficient| indirect[coefficient] + direct[coefficient])
                });
            });
        }
    }

    /// Where something met a patch.
    #[inline]
    pub fn place(&self, hit: &SurfaceHit) -> Option<PatchPlace> {
        self.patches.place(hit.triangle, hit.barycentric, hit.side)
    }

    /// What a half keeps of a place, in lx.
    #[inline]
    pub fn at(&self, light: Light, parity: usize, place: &PatchPlace) -> [f64; KEPT] {
        let table = match light {
            Light::Indirect => &self.indirect[parity],
            Light::Whole => &self.whole[parity],
        };
        let [middle, along_a, along_b] = &table[place.patch as usize];
        let [a, b] = place.offset;
        std::array::from_fn(|kept| middle[kept] + along_a[kept] * a + along_b[kept] * b)
    }

    /// Mean over all replicas of the direct light that a place is told, and the square of its standard error at the patch's middle.
    pub fn mean_direct_lx(&self, place: &PatchPlace) -> (f64, f64) {
        let (mut sums, mut squares) = ([0.0; 3], 0.0);
        for values_lx in &self.direct_lx {
            let known_lx = values_lx[place.patch as usize];
            sums.iter_mut().zip(known_lx).for_each(|(sum, lx)| *sum += lx);
            squares += known_lx[0] * known_lx[0];
        }
        let count = self.direct_lx.len().max(1) as f64;
        let mean = sums.map(|sum| sum / count);
        let error_lx2 = (squares / count - mean[0] * mean[0]).max(0.0) / (count - 1.0).max(1.0);
        (linear_at(mean, place.offset), error_lx2)
    }

    /// Mean over all replicas of all light at the middle of a patch, in lx.
    pub fn mean_lx(&self, patch: u32) -> f64 {
        let sum_lx =
            |known: &Vec<Vec<LinearLx>>| known.iter().map(|values_lx| values_lx[patch as usize][0]).sum::<f64>();
        (sum_lx(&self.indirect_lx) + sum_lx(&self.direct_lx)) / REPLICAS as f64
    }

    /// What a single replica knows of a place in lx: indirect light, and direct light where it is looked up.
    #[inline]
    pub fn of_replica(&self, replica: usize, place: &PatchPlace) -> (f64, Option<f64>) {
        let lx = |values_lx: &Vec<LinearLx>| linear_at(values_lx[place.patch as usize], place.offset);
        (lx(&self.indirect_lx[replica]), self.direct_lx.get(replica).map(lx))
    }
}

/// What a half keeps of what its memories know.
fn kept_of<const KEPT: usize>(known_lx: impl Fn(usize) -> LinearLx) -> Kept<KEPT> {
    let memories: [LinearLx; HALF] = std::array::from_fn(known_lx);
    std::array::from_fn(|coefficient| {
        let values: [f64; HALF] = memories.map(|memory| memory[coefficient]);
        std::array::from_fn(|kept| if KEPT == HALF { values[kept] } else { mean_of(&values) })
    })
}
