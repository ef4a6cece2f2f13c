//! The region that an emitter's light cannot reach: behind the plane that it shines away from.

use glam::DVec3;

use super::light::Light;
use super::{Emitter, EmitterShape, of_light};

/// A ball that contains an emitter, and the half space that receives all its light, if there is one.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    center_m: DVec3,
    radius_m: f64,
    /// Unit normal of the half space, and the least coordinate of its points along that normal, in m.
    half_space: Option<(DVec3, f64)>,
}

impl Reach {
    /// Whether light may reach one side of a triangle, the side that a unit normal points from. It is `false` only where no light does,
    /// except for light within a tolerance of the triangle's plane or of the half space's plane.
    #[inline]
    pub fn may_light(&self, corners_m: &[DVec3; 3], normal: DVec3, tolerance_m: f64) -> bool {
        let is_above = normal.dot(self.center_m - corners_m[0]) + self.radius_m > tolerance_m;
        let is_within = |(axis, least_m): (DVec3, f64)| corners_m.iter().any(|m| axis.dot(*m) > least_m + tolerance_m);
        is_above && self.half_space.is_none_or(is_within)
    }
}

impl Emitter {
    /// Returns the region that its light can reach.
    pub fn reach(&self) -> Reach {
        let beacon = &self.beacon;
        let half_space = of_light!(&self.shape, light => light.half_space());
        Reach { center_m: beacon.center_m, radius_m: beacon.radius_m, half_space }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::Emitters;
    use super::*;
    use crate::sampling::random::{Purpose, Stream};
    use crate::sampling::warp::{uniform_sphere, uniform_triangle};
    use crate::scene_from_json;

    /// Nine emitters of different kinds, and 4,000 random triangles around each. From sides that no light reaches according to `Reach`,
    /// eight random points with 16 light samples each find nothing (seed 4). A half space that begins 0.2 m later and a radius less 0.3 m,
    /// the planted faults, are detected.
    #[test]
    fn nothing_is_found_from_sides_that_no_light_comes_to() {
        let text = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
          "geometry": [ { "name": "panel", "type": "rectangle", "origin": [0,0,1], "u": [0,1,0], "v": [1,0,0], "material": "grey" },
                        { "name": "upper", "type": "rectangle", "origin": [0,2,1], "u": [1,0,0], "v": [0,0.4,0.3], "material": "grey" } ],
          "luminaires": [ { "name": "a", "type": "area", "surface": "panel", "luminous_flux_lm": 1000 },
                          { "name": "b", "type": "area", "surface": "upper", "luminous_flux_lm": 1000 },
                          { "name": "c", "type": "point", "position": [2,2,2], "intensity_cd": 10 },
                          { "name": "d", "type": "point", "distribution": "lambertian", "position": [0,1,2], "aim": [0,1,-1], "luminous_flux_lm": 10 },
                          { "name": "e", "type": "sphere", "center": [1,2,0], "radius": 0.4, "luminous_flux_lm": 10 },
                          { "name": "f", "type": "photometric", "file": "luminaires/troffer.ies", "position": [2,0,1.5], "aim": [0,0.2,-1] },
                          { "name": "g", "type": "photometric", "file": "luminaires/downlight.ldt", "position": [1,1,1.5], "aim": [0,0,-1] } ] }"#;
        let scene = scene_from_json(text, None, Path::new("scenes")).expect("a scene");
        let emitters = Emitters::of(&scene);
        let mut stream = Stream::new(4, Purpose::Walks, 0, 0);
        let mut counts = [[0u32; 3]; 2];
        for (index, emitter) in emitters.list().iter().enumerate() {
            let reach = emitter.reach();
            let later = Reach { half_space: reach.half_space.map(|(axis, least_m)| (axis, least_m + 0.2)), ..reach };
            let smaller = Reach { radius_m: reach.radius_m - 0.3, ..reach };
            for number in 0..4000 {
                stream.seek(4000 * index as u64 + number);
                let middle = reach.center_m + 2.0 * stream.unit() * uniform_sphere(stream.pair());
                let corners_m = [0; 3].map(|_| middle + 0.5 * uniform_sphere(stream.pair()));
                let normal = (corners_m[1] - corners_m[0]).cross(corners_m[2] - corners_m[0]).normalize();
                let finds = |stream: &mut Stream| {
                    (0..8).any(|_| {
                        let [u, v] = uniform_triangle(stream.pair());
                        let [a, b, c] = corners_m;
                        let point_m = a + u * (b - a) + v * (c - a);
                        (0..16).any(|_| {
                            emitter
                                .light_sample(point_m, normal, stream)
                                .is_some_and(|sample| sample.unshadowed_lx > 0.0)
                        })
                    })
                };
                let is_found = finds(&mut stream);
                for (which, reach) in [reach, later, smaller].iter().enumerate() {
                    let is_dark = !reach.may_light(&corners_m, normal, 0.0);
                    counts[0][which] += u32::from(is_dark);
                    counts[1][which] += u32::from(is_dark && is_found);
                }
            }
        }
        assert!(counts[0][0] > 10_000, "{counts:?}");
        assert_eq!(counts[1][0], 0, "{counts:?}");
        assert!(counts[1][1] > 0 && counts[1][2] > 0, "the planted faults passed: {counts:?}");
    }
}
