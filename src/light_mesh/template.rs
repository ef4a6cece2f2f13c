//! Lists the mesh points within the radius of a receiver point: by templates for parts of a cell (MU2), or one by one.

use glam::DVec3;

use super::lattice::{Index, Lattice};

/// Parts of a cell along each axis. Each part has its own template.
const PARTS_ALONG: usize = 4;

/// A mesh point that may lie within the radius of a receiver point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemplateEntry {
    /// Index relative to the lowest point of the receiver point's cell.
    pub offset: Index,
    /// The same offset in steps.
    pub steps: DVec3,
    /// Whether it lies within the radius of every position in the part.
    pub sure: bool,
}

/// For every part of a cell, the mesh points within the radius of a position there.
#[derive(Clone, Debug)]
pub struct Templates {
    radius_per_step: f64,
    parts: Vec<Vec<TemplateEntry>>,
}

/// A mesh point of a set: its index, and its offset from the receiver point in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Index of the mesh point.
    pub index: Index,
    /// Offset from the receiver point to the mesh point, in m.
    pub offset_m: DVec3,
}

impl Templates {
    /// Creates templates for a ratio of radius to step.
    pub fn new(radius_per_step: f64) -> Templates {
        let reach = radius_per_step.ceil() as i32;
        let part = |number: usize| {
            let at = |axis: u32| (number / PARTS_ALONG.pow(axis)) % PARTS_ALONG;
            let low = DVec3::new(at(0) as f64, at(1) as f64, at(2) as f64) / PARTS_ALONG as f64;
            let high = low + 1.0 / PARTS_ALONG as f64;
            let mut entries = Vec::new();
            for k in -reach..=reach + 1 {
                for j in -reach..=reach + 1 {
                    for i in -reach..=reach + 1 {
                        let steps = DVec3::new(f64::from(i), f64::from(j), f64::from(k));
                        let nearest = steps.clamp(low, high).distance(steps);
                        let farthest = (steps - low).abs().max((high - steps).abs()).length();
                        if nearest < radius_per_step {
                            entries.push(TemplateEntry { offset: [i, j, k], steps, sure: farthest < radius_per_step });
                        }
                    }
                }
            }
            entries
        };
        Templates { radius_per_step, parts: (0..PARTS_ALONG.pow(3)).map(part).collect() }
    }

    /// Lists the mesh points within the radius of a receiver point and in front of it by more than `least_height_m`.
    #[inline]
    pub fn candidates(
        &self,
        lattice: &Lattice,
        place_m: DVec3,
        normal: DVec3,
        least_height_m: f64,
        found: &mut Vec<Candidate>,
    ) {
        found.clear();
        let (cell, within) = lattice.cell_of(place_m);
        let part = (within * PARTS_ALONG as f64).min(DVec3::splat(PARTS_ALONG as f64 - 1.0)).max(DVec3::ZERO);
        let number = (part.z as usize * PARTS_ALONG + part.y as usize) * PARTS_ALONG + part.x as usize;
        let least = least_height_m / lattice.step_m + normal.dot(within);
        let radius_squared = self.radius_per_step * self.radius_per_step;
        for entry in &self.parts[number] {
            if normal.dot(entry.steps) > least
                && (entry.sure || (entry.steps - within).length_squared() < radius_squared)
            {
                let index = [0, 1, 2].map(|axis| cell[axis] + entry.offset[axis]);
                found.push(Candidate { index, offset_m: (entry.steps - within) * lattice.step_m });
            }
        }
    }
}

/// Lists the same mesh points without templates, by testing every point of the cube around the sphere.
pub fn candidates_one_by_one(
    lattice: &Lattice,
    radius_m: f64,
    place_m: DVec3,
    normal: DVec3,
    least_height_m: f64,
    found: &mut Vec<Candidate>,
) {
    found.clear();
    let low = ((place_m - radius_m - lattice.origin_m) / lattice.step_m).floor();
    let high = ((place_m + radius_m - lattice.origin_m) / lattice.step_m).ceil();
    for k in low.z as i32..=high.z as i32 {
        for j in low.y as i32..=high.y as i32 {
            for i in low.x as i32..=high.x as i32 {
                let offset_m = lattice.position_m([i, j, k]) - place_m;
                if offset_m.length() < radius_m && normal.dot(offset_m) > least_height_m {
                    found.push(Candidate { index: [i, j, k], offset_m });
                }
            }
        }
    }
}

/// Whether a mesh point lies at the rim of the sphere: one of its six neighbours is outside.
#[inline]
pub fn is_outer(offset_m: DVec3, step_m: f64, radius_m: f64) -> bool {
    let farther = offset_m.abs().max_element();
    offset_m.length_squared() + (2.0 * farther + step_m) * step_m >= radius_m * radius_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};
    use crate::sampling::warp::uniform_sphere;

    /// Both methods list the same mesh points for 2,000 receiver points and normals at each of the papers' radii. The mean number of mesh
    /// points is the volume of the half ball. A radius 1% larger gives another number (the planted fault).
    #[test]
    fn templates_list_what_testing_every_point_lists() {
        let lattice = Lattice::over([DVec3::ZERO, DVec3::splat(20.0)], 0.5, 3.0).expect("a small mesh");
        let mut stream = Stream::new(3, Purpose::Pilot, 0, 0);
        for ratio in [0.9, 1.1, 2.1, 3.1] {
            let templates = Templates::new(ratio);
            let (mut quick, mut slow, mut wide) = (Vec::new(), Vec::new(), Vec::new());
            let (mut count, mut wide_count) = (0.0, 0.0);
            const N: u32 = 2000;
            for index in 0..N {
                stream.seek(u64::from(index));
                let place_m = 20.0 * DVec3::new(stream.unit(), stream.unit(), stream.unit());
                let normal = uniform_sphere(stream.pair());
                templates.candidates(&lattice, place_m, normal, 1e-9, &mut quick);
                candidates_one_by_one(&lattice, 0.5 * ratio, place_m, normal, 1e-9, &mut slow);
                candidates_one_by_one(&lattice, 0.505 * ratio, place_m, normal, 1e-9, &mut wide);
                let sorted = |list: &[Candidate]| {
                    let mut numbers: Vec<Index> = list.iter().map(|one| one.index).collect();
                    numbers.sort_unstable();
                    numbers
                };
                assert_eq!(sorted(&quick), sorted(&slow), "{place_m} {normal} {ratio}");
                assert!(
                    quick
                        .iter()
                        .all(|one| { (lattice.position_m(one.index) - place_m).distance(one.offset_m) < 1e-12 })
                );
                count += quick.len() as f64;
                wide_count += wide.len() as f64;
            }
            // The standard deviation of the number is below 3 for all radii, that of the mean below 0.07; α = 1e-6.
            let volume = 2.0 / 3.0 * std::f64::consts::PI * ratio.powi(3);
            assert!((count / f64::from(N) - volume).abs() < 4.9 * 0.07, "{} {volume}", count / f64::from(N));
            assert!(ratio < 3.0 || (wide_count / f64::from(N) - volume).abs() > 4.9 * 0.07, "the fault passed");
        }
    }

    #[test]
    fn outer_points_surround_the_inner_ones() {
        assert!(is_outer(DVec3::new(2.0, 0.0, 0.0), 1.0, 2.1));
        assert!(!is_outer(DVec3::new(1.0, 0.2, 0.0), 1.0, 2.1));
        assert!(is_outer(DVec3::new(1.2, 0.0, 0.0), 1.0, 2.1));
    }
}
