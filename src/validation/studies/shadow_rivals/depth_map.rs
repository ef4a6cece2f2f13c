//! A shadow map over level ground, and two kinds of soft shadows from it.
//!
//! A texel represents a point of the ground. It records whether light of the lamp reaches this point. Percentage-closer filtering
//! (Reeves, Salesin and Cook 1987, "Rendering antialiased shadows with depth maps") uses the share of lit texels around a point.
//! Single-sample soft shadows (Brabec and Seidel 2002, "Single sample soft shadows using depth maps") use the distance to the
//! nearest texel of the other kind.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::Meeting;
use crate::validation::studies::study_scene::StudyScene;

/// Depth bias of the map: a point is unlit if the ray ends before the ground by more than this share of its length.
const BIAS: f64 = 2e-3;

/// A map of the ground points that a lamp's centre lights, one per texel.
pub struct DepthMap {
    lit: Vec<bool>,
    counts: [usize; 2],
    /// Texels per metre along both axes.
    per_m: [f64; 2],
    /// Rays to make the map; in games the graphics card does this work.
    pub rays: u64,
}

impl DepthMap {
    /// Creates the map of a lamp over the ground from (0, 0, 0) to a far corner. The lamp itself is not part of the study's
    /// geometry.
    pub fn of(study: &StudyScene, lamp_m: DVec3, size_m: [f64; 2], counts: [usize; 2]) -> DepthMap {
        let from = study.world.tracer.free_origin(lamp_m);
        let middle_m = |number: usize, axis: usize| size_m[axis] * (number as f64 + 0.5) / counts[axis] as f64;
        let is_lit = |texel: usize| {
            let place_m = DVec3::new(middle_m(texel % counts[0], 0), middle_m(texel / counts[0], 1), 0.0);
            let way_m = place_m - lamp_m;
            match study.world.tracer.first_hit(&from, way_m.normalize()) {
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

    /// Returns whether a texel is lit; `None` outside the map.
    fn at(&self, [column, row]: [i64; 2]) -> Option<bool> {
        let [columns, rows] = self.counts.map(|count| count as i64);
        let is_there = (0..columns).contains(&column) && (0..rows).contains(&row);
        is_there.then(|| self.lit[(row * columns + column) as usize])
    }

    /// Share of lit texels among `edge`² texels around a point (`edge` odd).
    pub fn share_of_lit(&self, place_m: DVec3, edge: i64) -> f64 {
        let [column, row] = self.texel_of(place_m);
        let reach = edge / 2;
        let about = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [column + dx, row + dy]));
        let known: Vec<bool> = about.filter_map(|texel| self.at(texel)).collect();
        known.iter().filter(|lit| **lit).count() as f64 / known.len() as f64
    }

    /// Light share ½ (1 ± r/R): r is the distance to the nearest texel of the other kind, R the search radius.
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
