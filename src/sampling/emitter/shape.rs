//! What luminaires look like from afar, and luminous triangles.

use std::f64::consts::PI;

use glam::DVec3;

use super::{EmitterShape, Place, TriangleEmitter};
use crate::sampling::importance::{Beacon, Profile};
use crate::scene::{Scene, Side};

impl EmitterShape {
    /// What decides how often an emitter is looked at.
    pub(super) fn beacon(&self) -> Beacon {
        let point = |position_m: &DVec3, axis: DVec3, intensity_cd: f64, profile: Profile| Beacon {
            center_m: *position_m,
            radius_m: 0.0,
            axis,
            intensity_cd,
            profile,
            is_needle: false,
        };
        match self {
            EmitterShape::Isotropic { position_m, intensity_cd } => {
                point(position_m, DVec3::Z, *intensity_cd, Profile::Uniform)
            }
            EmitterShape::Lambertian { position_m, axis, intensity_cd } => {
                point(position_m, *axis, *intensity_cd, Profile::Cosine)
            }
            EmitterShape::Web(web) => Beacon {
                center_m: web.position_m,
                radius_m: web.aperture.as_ref().map_or(0.0, |aperture| aperture.radius_m()),
                axis: web.frame[2],
                intensity_cd: web.scale,
                profile: web.profile.clone(),
                is_needle: false,
            },
            EmitterShape::Triangle(triangle) => Beacon {
                center_m: triangle.centroid_m,
                radius_m: triangle.radius_m,
                axis: triangle.normal,
                intensity_cd: triangle.exitance_lm_m2 * triangle.area_m2 / PI,
                profile: Profile::Cosine,
                is_needle: triangle.is_needle(),
            },
            EmitterShape::Sky(sky) => sky.beacon(),
            EmitterShape::Sun(sun) => sun.beacon(),
            EmitterShape::Ball { center_m, radius_m, exitance_lm_m2 } => Beacon {
                center_m: *center_m,
                radius_m: *radius_m,
                axis: DVec3::Z,
                intensity_cd: exitance_lm_m2 * radius_m * radius_m,
                profile: Profile::Uniform,
                is_needle: false,
            },
        }
    }
}

impl TriangleEmitter {
    /// The emitting side of a triangle.
    pub(super) fn new(scene: &Scene, triangle: u32, side: Side, exitance_lm_m2: f64) -> TriangleEmitter {
        let [a, b, c] = scene.corners_m(triangle);
        let corners_m = if side == Side::Front { [a, b, c] } else { [a, c, b] };
        let centroid_m = (a + b + c) / 3.0;
        let radius_m = [a, b, c].iter().map(|corner| corner.distance(centroid_m)).fold(0.0, f64::max);
        let front = scene.triangle_normal(triangle);
        let normal = if side == Side::Front { front } else { -front };
        let area_m2 = scene.triangle_area_m2(triangle);
        TriangleEmitter { triangle, side, corners_m, normal, centroid_m, radius_m, area_m2, exitance_lm_m2 }
    }

    /// Whether it fills little of the ball about it: halves of rectangles about twice as long as wide do.
    fn is_needle(&self) -> bool {
        self.area_m2 < 0.6 * self.radius_m * self.radius_m
    }

    /// The barycentric coordinates of the scene's triangle for those of this one (whose turn depends on the side).
    pub(super) fn place(&self, [u, v]: [f64; 2]) -> Place {
        let barycentric = if self.side == Side::Front { [u, v] } else { [v, u] };
        Place::Surface { triangle: self.triangle, barycentric, side: self.side }
    }

    /// Its corners seen from a point, in m.
    pub(super) fn seen_from(&self, point_m: DVec3) -> [DVec3; 3] {
        self.corners_m.map(|corner| corner - point_m)
    }
}
