//! A shadow map over level ground, and the two soft shadows that are made of it.
//!
//! A texel stands for a place of the ground and keeps how far light gets on its way there. Percentage-closer filtering (Reeves, Salesin
//! and Cook 1987, "Rendering antialiased shadows with depth maps") takes the share of lit texels about a place. Single-sample soft
//! shadows (Brabec and Seidel 2002, "Single sample soft shadows using depth maps") look for the nearest texel of the other kind.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::Meeting;
use crate::validation::studies::world::World;

/// A ray that ends this share of its way before the ground is stopped: the depth bias of such maps.
const BIAS: f64 = 2e-3;

/// Which places of the ground a lamp's centre lights, texel by texel.
pub struct DepthMap {
    lit: Vec<bool>,
    counts: [usize; 2],
    /// Texels per metre.
    per_m: [f64; 2],
    /// Rays that making it took; games let the graphics card do the same.
    pub rays: u64,
}

impl DepthMap {
    /// The map of a lamp over the ground from (0, 0, 0) to a far corner; nothing of the lamp itself stands in the world.
    pub fn of(world: &World, lamp_m: DVec3, size_m: [f64; 2], counts: [usize; 2]) -> DepthMap {
        let from = world.stage.tracer.free_origin(lamp_m);
        let middle_m = |number: usize, axis: usize| size_m[axis] * (number as f64 + 0.5) / counts[axis] as f64;
        let is_lit = |texel: usize| {
            let place_m = DVec3::new(middle_m(texel % counts[0], 0), middle_m(texel / counts[0], 1), 0.0);
            let way_m = place_m - lamp_m;
            match world.stage.tracer.first_hit(&from, way_m.normalize()) {
                Meeting::Surface(hit) => hit.distance_m >= (1.0 - BIAS) * way_m.length(),
                _ => true,
            }
        };
        let lit: Vec<bool> = (0..counts[0] * counts[1]).into_par_iter().map(is_lit).collect();
        let per_m = [0, 1].map(|axis| counts[axis] as f64 / size_m[axis]);
        DepthMap { rays: lit.len() as u64, lit, counts, per_m }
    }

    fn texel_of(&self, place_m: DVec3) -> [i64; 2] {
        let at =
            |place_m: f64, axis: usize| ((place_m * self.per_m[axis]) as i64).clamp(0, self.counts[axis] as i64 - 1);
        [at(place_m.x, 0), at(place_m.y, 1)]
    }

    /// Whether a texel is lit; nothing is known beyond the rim.
    fn at(&self, [column, row]: [i64; 2]) -> Option<bool> {
        let [columns, rows] = self.counts.map(|count| count as i64);
        let is_there = (0..columns).contains(&column) && (0..rows).contains(&row);
        is_there.then(|| self.lit[(row * columns + column) as usize])
    }

    /// Share of lit texels of `edge`² about a place (`edge` odd).
    pub fn share_of_lit(&self, place_m: DVec3, edge: i64) -> f64 {
        let [column, row] = self.texel_of(place_m);
        let reach = edge / 2;
        let about = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [column + dx, row + dy]));
        let known: Vec<bool> = about.filter_map(|texel| self.at(texel)).collect();
        known.iter().filter(|lit| **lit).count() as f64 / known.len() as f64
    }

    /// ½ (1 ± r/R), r the distance to the nearest texel of the other kind, R how far it is looked for.
    pub fn single_sample(&self, place_m: DVec3, reach_m: f64) -> f64 {
        let [column, row] = self.texel_of(place_m);
        let is_lit = self.at([column, row]).unwrap_or(true);
        let steps = [0, 1].map(|axis| (reach_m * self.per_m[axis]).ceil() as i64);
        let mut nearest_m = reach_m;
        for dy in -steps[1]..=steps[1] {
            for dx in -steps[0]..=steps[0] {
                if self.at([column + dx, row + dy]).is_some_and(|other| other != is_lit) {
                    nearest_m = nearest_m.min((dx as f64 / self.per_m[0]).hypot(dy as f64 / self.per_m[1]));
                }
            }
        }
        0.5 * (1.0 + if is_lit { 1.0 } else { -1.0 } * nearest_m / reach_m)
    }
}
