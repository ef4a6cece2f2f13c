//! Patches of one size and the light that is known of them.

use rayon::prelude::*;

use crate::geometry::SurfaceHit;
use crate::maps::{HALF, REPLICAS};
use crate::scene::patches::{PatchPlace, Patches};

/// Expected deposits of a replica on a patch from which on slopes are worth their noise.
const DEPOSITS_FOR_SLOPES: f64 = 4.0;
/// Standard errors by which the flux that patches gathered must differ from what chains brought.
const SURELY: f64 = 4.0;
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
    /// Share of what shows of a patch for which samples must stand, and of one of joined triangles.
    enough: [f64; 2],
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

/// Weighted samples of a patch: how many, their weight, their sum and that of samples times offsets.
#[derive(Clone, Copy, Debug, Default)]
pub struct PatchMean {
    count: u64,
    /// Area in m² that they stand for.
    pub weight: f64,
    sums: [f64; 3],
}

impl PatchMean {
    /// Adds a sample in lx with a weight in m².
    pub fn add(&mut self, weight: f64, lx: f64, offset: [f64; 2]) {
        self.count += 1;
        self.weight += weight;
        self.sums[0] += weight * lx;
        self.sums[1] += weight * lx * offset[0];
        self.sums[2] += weight * lx * offset[1];
    }
}

/// Mean and slopes of a linear function from the sums of samples and of samples times offsets: the inverse of the
/// offsets' covariances, 1/18 each and −1/36 between them.
fn projected([sum, a, b]: [f64; 3], unit: f64, slopes: bool) -> LinearLx {
    let slope_unit = if slopes { unit } else { 0.0 };
    [sum * unit, (24.0 * a + 12.0 * b) * slope_unit, (12.0 * a + 24.0 * b) * slope_unit]
}

impl<const KEPT: usize> Layer<KEPT> {
    /// Dark patches, of each of which a share is exposed; samples must stand for so much of one, and of one of joined triangles.
    pub fn new(patches: Patches, exposed: Vec<f64>, enough: [f64; 2]) -> Layer<KEPT> {
        let sums = vec![vec![[0.0; 3]; patches.len()]; REPLICAS];
        let dark = vec![[[0.0; KEPT]; 3]; patches.len()];
        Layer {
            patches,
            exposed,
            enough,
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

    /// What samples tell of every patch, with slopes where so many of them were taken evenly; of patches that they do not stand for,
    /// what is known otherwise.
    pub fn means_lx(&self, means: &[PatchMean], for_slopes: u64, otherwise_lx: &[LinearLx]) -> Vec<LinearLx> {
        let value_lx = |(patch, mean): (usize, &PatchMean)| {
            if self.is_told(patch, mean) {
                let slopes = self.exposed[patch] == 1.0 && mean.count >= for_slopes;
                projected(mean.sums, 1.0 / mean.weight, slopes)
            } else {
                otherwise_lx[patch]
            }
        };
        means.iter().enumerate().map(value_lx).collect()
    }

    /// Whether samples stand for a patch, as far as it shows. Those of smaller patches may have been taken in some of these alone: then
    /// they tell no mean, and slopes even less.
    pub fn is_told(&self, patch: usize, mean: &PatchMean) -> bool {
        let enough = self.enough[usize::from(self.patches.is_joined(patch as u32))];
        mean.weight > 0.0 && mean.weight >= enough * self.shown_m2(patch)
    }

    /// Flux that chains brought to each face of a surface over what its patches gathered, replica by replica, where both surely
    /// differ, and 1 elsewhere: a ray that meets a patch sees more of what is lit in it than lies in the shade, and looks up the mean.
    pub fn flux_ratios(&self, gathered_lx: &[Vec<LinearLx>], flux_per_deposit_lm: f64) -> Vec<Vec<f64>> {
        let flux_lm = |values_lx: &[LinearLx], others_lx: &[LinearLx]| {
            let mut sums = vec![0.0; self.patches.faces()];
            for (patch, (value_lx, other_lx)) in values_lx.iter().zip(others_lx).enumerate() {
                if self.keeps_flux(patch, value_lx, other_lx) {
                    sums[self.patches.face(patch)] += self.shown_m2(patch) * value_lx[0];
                }
            }
            sums
        };
        let fluxes_lm: Vec<[Vec<f64>; 2]> = gathered_lx
            .par_iter()
            .with_max_len(1)
            .zip(&self.indirect_lx)
            .map(|(gathered_lx, brought_lx)| [flux_lm(gathered_lx, brought_lx), flux_lm(brought_lx, gathered_lx)])
            .collect();
        let ratios_of = |face: usize| -> Vec<f64> {
            let ratio = |[gathered, brought]: &[Vec<f64>; 2]| {
                if gathered[face] > 0.0 { brought[face] / gathered[face] } else { 1.0 }
            };
            let ratios: Vec<f64> = fluxes_lm.iter().map(ratio).collect();
            let count = ratios.len() as f64;
            let mean = ratios.iter().sum::<f64>() / count;
            let squares = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>();
            // Few deposits scatter among themselves by less than they should: by what was gathered there are so many.
            let deposits = fluxes_lm.iter().map(|[gathered, _]| gathered[face]).sum::<f64>() / flux_per_deposit_lm;
            let error2 = (squares / (count * (count - 1.0))).max(1.0 / deposits);
            if (mean - 1.0).powi(2) > SURELY * SURELY * error2 { ratios } else { vec![1.0; ratios.len()] }
        };
        let of_faces: Vec<Vec<f64>> = (0..self.patches.faces()).map(ratios_of).collect();
        (0..fluxes_lm.len()).map(|replica| of_faces.iter().map(|ratios| ratios[replica]).collect()).collect()
    }

    /// Gives what the patches of every replica gathered these shares of it, face by face.
    pub fn keep_flux(&self, gathered_lx: &mut [Vec<LinearLx>], ratios: &[Vec<f64>]) {
        gathered_lx.par_iter_mut().with_max_len(1).zip(&self.indirect_lx).zip(ratios).for_each(
            |((gathered_lx, brought_lx), ratios)| {
                for (patch, (value_lx, brought_lx)) in gathered_lx.iter_mut().zip(brought_lx).enumerate() {
                    if self.keeps_flux(patch, value_lx, brought_lx) {
                        value_lx.iter_mut().for_each(|lx| *lx *= ratios[self.patches.face(patch)]);
                    }
                }
            },
        );
    }

    /// Whether a patch has gathered anything, and over all of its area: joined triangles tell of where they are asked.
    fn keeps_flux(&self, patch: usize, gathered_lx: &LinearLx, brought_lx: &LinearLx) -> bool {
        !self.patches.is_joined(patch as u32) && gathered_lx != brought_lx
    }

    /// Area of a patch that is not covered, in m².
    pub fn shown_m2(&self, patch: usize) -> f64 {
        self.exposed[patch] * self.patches.area_m2(patch as u32)
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::{Side, scene_from_json};

    /// Samples of 1 lx all over a patch but for one of its corners say of it what was known before: the mean of what they saw is none of
    /// the patch, and its slopes are wild. Where nobody asks how much they stand for (planted) they are taken for them.
    #[test]
    fn samples_of_a_part_of_a_patch_do_not_tell_of_it() {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [ { "name": "floor", "type": "rectangle", "origin": [0,0,0], "u": [1,0,0], "v": [0,1,0], "material": "m" } ],
            "luminaires": [ { "name": "lamp", "type": "point", "position": [0,0,1], "luminous_flux_lm": 1 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a valid scene");
        let layer_of = |enough: [f64; 2]| Layer::<1>::new(Patches::of(&scene, 1.0), vec![1.0; 8], enough);
        // The first of the four patches of a triangle; offsets reach from -1/3 to 2/3.
        let means_of = |layer: &Layer<1>, reach: f64| {
            let mut means = vec![PatchMean::default(); 8];
            for u in 0..40 {
                for v in 0..40 - u {
                    let barycentric = [(f64::from(u) + 0.33) / 40.0, (f64::from(v) + 0.33) / 40.0];
                    let place = layer.patches.place(0, barycentric, Side::Front).expect("a patch");
                    if place.patch == 0 && place.offset[0] < reach {
                        means[0].add(0.125 / 210.0, 1.0, place.offset);
                    }
                }
            }
            layer.means_lx(&means, 4, &[[7.0, 0.0, 0.0]; 8])[0]
        };
        let careful = layer_of([0.95, 0.75]);
        assert_eq!(means_of(&careful, 0.2), [7.0, 0.0, 0.0]);
        let [mean, along_a, along_b] = means_of(&careful, 1.0);
        assert!(
            (mean - 1.0).abs() < 1e-12 && along_a.abs() < 0.05 && along_b.abs() < 0.05,
            "{mean} {along_a} {along_b}"
        );
        let [_, along_a, _] = means_of(&layer_of([0.0; 2]), 0.2);
        assert!(along_a.abs() > 1.0, "the planted fault passed: {along_a}");
    }
}
