//! Emitters as an observer sees them: openings on a line of sight, and the parts of a source that may glare.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{Emitter, EmitterShape, Place};
use crate::base::solid_angle::triangle_solid_angle_sr;
use crate::sampling::random::Stream;
use crate::sampling::warp::{uniform_cone, uniform_triangle};

/// Smallest projected area of a source in m²: what is smaller counts as small and as bright as this
/// (CIE 147:2002, small sources).
pub const SMALLEST_SOURCE_M2: f64 = 0.005;
/// Parts of an emitting triangle are no wider than this as the eye sees them, in radians: the position index changes
/// by some percent over it.
const WIDEST_PART: f64 = 0.05;
/// Divisions of a triangle's edges at most.
const MOST_DIVISIONS: u32 = 64;

/// A part of a luminaire as an eye sees it where nothing stands between.
#[derive(Clone, Copy, Debug)]
pub struct SeenPart {
    /// Unit direction of its middle from the eye.
    pub towards: DVec3,
    /// Luminance towards the eye, squared, times solid angle, in cd²·sr/m⁴.
    pub squared_luminance_sr: f64,
    /// A point of it drawn at random.
    pub place: Place,
}

impl Emitter {
    /// Luminance in cd/m² of a luminous opening that a line of sight meets, I/A_projected, and at which distance in m.
    pub fn opening_on_sight(&self, eye_m: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let EmitterShape::Web(web) = &self.shape else {
            return None;
        };
        let aperture = web.aperture.as_ref()?;
        let distance_m = aperture.met_at_m(eye_m, direction)?;
        let luminance_cd_m2 = web.intensity_cd(-direction) / aperture.projected_area_m2(direction);
        (luminance_cd_m2 > 0.0 && luminance_cd_m2.is_finite()).then_some((distance_m, luminance_cd_m2))
    }

    /// Distance in m at which a line of sight that meets the emitter's ball meets it; infinite for other emitters.
    pub fn ball_at_m(&self, eye_m: DVec3, direction: DVec3) -> f64 {
        let EmitterShape::Ball { center_m, radius_m, .. } = &self.shape else {
            return f64::INFINITY;
        };
        let offset_m = *center_m - eye_m;
        let along_m = direction.dot(offset_m);
        let miss_squared = (offset_m - along_m * direction).length_squared();
        along_m - (radius_m * radius_m - miss_squared).max(0.0).sqrt()
    }

    /// Shows the parts of the emitter that an eye would see, each with a point of it drawn at random.
    ///
    /// A point-like luminaire is one part: its intensity towards the eye over its projected area, both from the middle
    /// of the opening. So is a ball. Triangles are cut into parts of some degrees.
    pub fn show_parts(&self, eye_m: DVec3, stream: &mut Stream, mut show: impl FnMut(SeenPart)) {
        match &self.shape {
            EmitterShape::Triangle(triangle) => {
                let corners = triangle.seen_from(eye_m);
                if corners[0].dot(triangle.normal) >= 0.0 {
                    return;
                }
                let luminance = triangle.exitance_lm_m2 / PI;
                let nearest_m = nearest_m(&corners);
                let longest_m = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3])).fold(0.0, f64::max);
                let divisions = ((longest_m / nearest_m.max(1e-3 * longest_m) / WIDEST_PART).ceil() as u32)
                    .clamp(1, MOST_DIVISIONS);
                for part in 0..divisions * divisions {
                    let inner = part_corners(part, divisions);
                    let at =
                        |[u, v]: [f64; 2]| corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
                    let [a, b, c] = inner.map(at);
                    let [s, t] = uniform_triangle(stream.pair());
                    let mixed =
                        |k: usize| inner[0][k] + s * (inner[1][k] - inner[0][k]) + t * (inner[2][k] - inner[0][k]);
                    show(SeenPart {
                        towards: ((a + b + c) / 3.0).normalize_or(triangle.normal),
                        squared_luminance_sr: luminance * luminance * triangle_solid_angle_sr(a, b, c),
                        place: triangle.place([mixed(0), mixed(1)]),
                    });
                }
            }
            EmitterShape::Ball { center_m, radius_m, exitance_lm_m2 } => {
                let offset_m = *center_m - eye_m;
                let distance_m = offset_m.length();
                if distance_m <= *radius_m {
                    return;
                }
                let sine = radius_m / distance_m;
                let one_minus_cos = sine * sine / (1.0 + (1.0 - sine * sine).sqrt());
                let towards = offset_m / distance_m;
                let direction = uniform_cone(towards, one_minus_cos, stream.pair());
                let luminance = exitance_lm_m2 / PI;
                show(SeenPart {
                    towards,
                    squared_luminance_sr: luminance * luminance * TAU * one_minus_cos,
                    place: Place::Ball {
                        luminaire: self.luminaire,
                        position_m: eye_m + direction * self.ball_at_m(eye_m, direction),
                    },
                });
            }
            // Its glare is rated by other formulas.
            EmitterShape::Sky(_) | EmitterShape::Sun(_) => {}
            EmitterShape::Isotropic { position_m, .. } | EmitterShape::Lambertian { position_m, .. } => {
                show_point(self, *position_m, *position_m, 0.0, eye_m, &mut show);
            }
            EmitterShape::Web(web) => {
                let towards = (web.position_m - eye_m).normalize_or(web.frame[2]);
                let area_m2 = web.aperture.as_ref().map_or(0.0, |aperture| aperture.projected_area_m2(towards));
                show_point(self, web.position_m, web.draw_point_towards(-towards, stream), area_m2, eye_m, &mut show);
            }
        }
    }
}

/// L²ω = I²/(A d²).
fn show_point(
    emitter: &Emitter,
    middle_m: DVec3,
    point_m: DVec3,
    area_m2: f64,
    eye_m: DVec3,
    show: &mut impl FnMut(SeenPart),
) {
    let offset_m = middle_m - eye_m;
    let square_m2 = offset_m.length_squared();
    let towards = offset_m.normalize_or_zero();
    let intensity_cd = emitter.intensity_cd(-towards);
    if square_m2 > 0.0 && intensity_cd > 0.0 {
        let squared_luminance_sr = intensity_cd * intensity_cd / (area_m2.max(SMALLEST_SOURCE_M2) * square_m2);
        show(SeenPart { towards, squared_luminance_sr, place: emitter.place_of_point(point_m) });
    }
}

/// Barycentric corners of one of `divisions`² like parts of a triangle.
fn part_corners(part: u32, divisions: u32) -> [[f64; 2]; 3] {
    let row = f64::from(part).sqrt() as u32;
    let row = if row * row > part {
        row - 1
    } else if (row + 1) * (row + 1) <= part {
        row + 1
    } else {
        row
    };
    let within = part - row * row;
    let (column, turned) = (within / 2, within % 2 == 1);
    // Rows run from the first corner; row r holds r + 1 upright parts and r turned ones.
    let node = |r: u32, c: u32| [f64::from(r - c) / f64::from(divisions), f64::from(c) / f64::from(divisions)];
    if turned {
        [node(row, column), node(row + 1, column + 1), node(row, column + 1)]
    } else {
        [node(row, column), node(row + 1, column), node(row + 1, column + 1)]
    }
}

/// Distance from the origin to a triangle, not above the true one.
fn nearest_m(corners: &[DVec3; 3]) -> f64 {
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
    let plane = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero().dot(corners[0]).abs();
    (middle.length() - radius).max(plane)
}

#[cfg(test)]
mod tests {
    use super::part_corners;

    #[test]
    fn parts_tile_the_triangle() {
        for divisions in 1..6 {
            let area: f64 = (0..divisions * divisions)
                .map(|part| {
                    let [a, b, c] = part_corners(part, divisions);
                    assert!([a, b, c].iter().all(|[u, v]| *u >= 0.0 && *v >= 0.0 && u + v <= 1.0 + 1e-12));
                    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
                })
                .sum();
            assert!((area - 0.5).abs() < 1e-12, "{area}");
        }
    }
}
