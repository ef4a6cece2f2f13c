//! Sides of triangles that emit diffusely.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use super::light::{Light, SeenPart};
use super::triangle_view::{TriangleView, place_on};
use super::{Emitted, LightSample, Place};
use crate::base::polygon::triangle_illuminance_factor;
use crate::base::solid_angle::triangle_solid_angle_sr;
use crate::sampling::importance::{Beacon, Profile};
use crate::sampling::random::Stream;
use crate::sampling::triangle::RisenTriangle;
use crate::sampling::warp::{cosine_hemisphere, uniform_triangle};
use crate::scene::{Scene, Side};

/// From this many times its radius on, a triangle is far enough for a cheap sample. Over a triangle seen end-on, d² varies by half of
/// itself (root mean square); mostly it varies much less.
const FAR_FOR_A_CHEAP_SAMPLE: f64 = 2.0;
/// Largest width of the parts of an emitting triangle as seen by the eye, in radians. The position index changes by a few percent over it.
const WIDEST_PART_RAD: f64 = 0.05;
/// Largest number of divisions of a triangle's edges.
const MOST_DIVISIONS: u32 = 64;
/// A triangle is a needle if its area over the squared radius of the ball around it is below the first. The second is the largest number of
/// parts for its importance.
const NEEDLE: f64 = 0.6;
const MOST_PARTS: usize = 8;

/// A side of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleEmitter {
    triangle: u32,
    side: Side,
    /// Counter-clockwise as seen from the emitting side.
    corners_m: [DVec3; 3],
    normal: DVec3,
    centroid_m: DVec3,
    radius_m: f64,
    area_m2: f64,
    exitance_lm_m2: f64,
}

impl TriangleEmitter {
    /// Makes the emitter of one side of a triangle.
    pub(super) fn new(scene: &Scene, triangle: u32, side: Side, exitance_lm_m2: f64) -> TriangleEmitter {
        let [a, b, c] = scene.corners_m(triangle);
        let corners_m = if side == Side::Front { [a, b, c] } else { [a, c, b] };
        let (centroid_m, radius_m) = ball_about(&corners_m);
        let front = scene.triangle_normal(triangle);
        let normal = if side == Side::Front { front } else { -front };
        let area_m2 = scene.triangle_area_m2(triangle);
        TriangleEmitter { triangle, side, corners_m, normal, centroid_m, radius_m, area_m2, exitance_lm_m2 }
    }

    /// Returns the beacons of the parts that replace a needle, a triangle that fills little of the ball around it. Halves of rectangles
    /// about twice as long as wide are needles already. Parts are cut at the middle of their longest edge until `NEEDLE` times the squared
    /// radius of each is at most the area of the whole triangle, or there are [`MOST_PARTS`].
    fn parts(&self) -> Arc<[Beacon]> {
        if self.area_m2 >= NEEDLE * self.radius_m * self.radius_m {
            return Arc::default();
        }
        let is_long = |corners_m: &[DVec3; 3]| NEEDLE * ball_about(corners_m).1.powi(2) > self.area_m2;
        let mut parts = vec![self.corners_m];
        while parts.len() < MOST_PARTS && parts.iter().any(is_long) {
            parts = parts.iter().flat_map(halves).collect();
        }
        let share = 1.0 / parts.len() as f64;
        parts.iter().map(|corners_m| self.beacon_of(corners_m, share)).collect()
    }

    /// Returns the beacon of a part of the triangle.
    fn beacon_of(&self, corners_m: &[DVec3; 3], share: f64) -> Beacon {
        let (center_m, radius_m) = ball_about(corners_m);
        Beacon {
            center_m,
            radius_m,
            axis: self.normal,
            intensity_cd: share * self.exitance_lm_m2 * self.area_m2 / PI,
            profile: Profile::Flat,
            parts: Arc::default(),
        }
    }

    fn place(&self, barycentric: [f64; 2]) -> Place {
        place_on(self.triangle, self.side, barycentric)
    }

    /// Returns its corners relative to a point, in m.
    pub(super) fn seen_from(&self, point_m: DVec3) -> [DVec3; 3] {
        let [a, b, c] = self.corners_m;
        [a - point_m, b - point_m, c - point_m]
    }
}

impl Light for TriangleEmitter {
    fn beacon(&self) -> Beacon {
        Beacon { parts: self.parts(), ..self.beacon_of(&self.corners_m, 1.0) }
    }

    fn emit(&self, stream: &mut Stream) -> Emitted {
        let place = self.place(uniform_triangle(stream.pair()));
        Emitted::new(place, cosine_hemisphere(self.normal, stream.pair()))
    }

    fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        self.exitance_lm_m2 * triangle_illuminance_factor(point_m, normal, self.corners_m)
    }

    fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        let unshadowed_lx = self.unshadowed_lx(point_m, normal);
        if unshadowed_lx <= 0.0 {
            return None;
        }
        // Through a view, which is copied, adaptive elements take some 5 % longer.
        let risen = RisenTriangle::new(self.seen_from(point_m), normal);
        let drawn = risen.as_ref().and_then(|risen| risen.draw(stream));
        Some(LightSample { unshadowed_lx, place: drawn.map(|(_, barycentric)| self.place(barycentric)) })
    }

    fn triangle_view(&self, point_m: DVec3, normal: DVec3) -> Option<TriangleView> {
        let unshadowed_lx = self.unshadowed_lx(point_m, normal);
        let risen = if unshadowed_lx > 0.0 { RisenTriangle::new(self.seen_from(point_m), normal) } else { None };
        Some(TriangleView { triangle: self.triangle, side: self.side, unshadowed_lx, risen })
    }

    /// For a far triangle the point is drawn by area, E = M A cos θ cos θ′/(π d²).
    #[inline]
    fn cheap_light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        let far_m = FAR_FOR_A_CHEAP_SAMPLE * self.radius_m;
        if self.centroid_m.distance_squared(point_m) < far_m * far_m {
            return self.light_sample(point_m, normal, stream);
        }
        let barycentric = uniform_triangle(stream.pair());
        let [a, b, c] = self.corners_m;
        let offset_m = a + barycentric[0] * (b - a) + barycentric[1] * (c - a) - point_m;
        let heights_m = [offset_m.dot(normal), -offset_m.dot(self.normal)];
        if heights_m.iter().any(|height_m| *height_m <= 0.0) {
            return None;
        }
        let exitance_lm = self.exitance_lm_m2 * self.area_m2;
        let unshadowed_lx = exitance_lm * heights_m[0] * heights_m[1] / (PI * offset_m.length_squared().powi(2));
        Some(LightSample { unshadowed_lx, place: Some(self.place(barycentric)) })
    }

    fn half_space(&self) -> Option<(DVec3, f64)> {
        Some((self.normal, self.normal.dot(self.centroid_m)))
    }

    fn seen_from_afar(&self, direction: DVec3, stream: &mut Stream) -> Option<(f64, Place)> {
        let area_m2 = self.area_m2 * self.normal.dot(direction).max(0.0);
        Some((self.exitance_lm_m2 * area_m2 / PI, self.place(uniform_triangle(stream.pair()))))
    }

    fn point_seen_from(&self, _: DVec3, variates: [f64; 2]) -> Option<Place> {
        Some(self.place(uniform_triangle(variates)))
    }

    /// It is cut into parts of a few degrees.
    fn show_parts(&self, eye_m: DVec3, stream: &mut Stream, show: &mut dyn FnMut(SeenPart)) {
        let corners = self.seen_from(eye_m);
        if corners[0].dot(self.normal) >= 0.0 {
            return;
        }
        let luminance = self.exitance_lm_m2 / PI;
        let nearest_m = nearest_m(&corners);
        let longest_m = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3])).fold(0.0, f64::max);
        let divisions =
            ((longest_m / nearest_m.max(1e-3 * longest_m) / WIDEST_PART_RAD).ceil() as u32).clamp(1, MOST_DIVISIONS);
        for part in 0..divisions * divisions {
            let inner = part_corners(part, divisions);
            let at = |[u, v]: [f64; 2]| corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
            let [a, b, c] = inner.map(at);
            let [s, t] = uniform_triangle(stream.pair());
            let mixed = |k: usize| inner[0][k] + s * (inner[1][k] - inner[0][k]) + t * (inner[2][k] - inner[0][k]);
            show(SeenPart {
                towards: ((a + b + c) / 3.0).normalize_or(self.normal),
                squared_luminance_sr: luminance * luminance * triangle_solid_angle_sr(a, b, c),
                place: self.place([mixed(0), mixed(1)]),
            });
        }
    }

    fn exitance_lm_m2(&self) -> Option<f64> {
        Some(self.exitance_lm_m2)
    }

    fn side(&self) -> Option<(u32, Side)> {
        Some((self.triangle, self.side))
    }

    fn cosine_towards(&self, direction: DVec3) -> f64 {
        self.normal.dot(direction).max(0.0)
    }
}

/// Returns centre and radius of a ball that contains a triangle, in m.
fn ball_about(corners_m: &[DVec3; 3]) -> (DVec3, f64) {
    let center_m = corners_m.iter().sum::<DVec3>() / 3.0;
    (center_m, corners_m.iter().map(|corner| corner.distance(center_m)).fold(0.0, f64::max))
}

/// Cuts a triangle at the middle of its longest edge.
fn halves(corners_m: &[DVec3; 3]) -> [[DVec3; 3]; 2] {
    let edge = |k: usize| corners_m[k].distance_squared(corners_m[(k + 1) % 3]);
    let longest = (0..3).max_by(|one, other| edge(*one).total_cmp(&edge(*other))).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| corners_m[(longest + k) % 3]);
    let middle = 0.5 * (a + b);
    [[a, middle, c], [middle, b, c]]
}

/// Returns the barycentric corners of one of `divisions`² similar parts of a triangle.
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
    // Rows are counted from the first corner. Row r has r + 1 upright parts and r inverted ones.
    let node = |r: u32, c: u32| [f64::from(r - c) / f64::from(divisions), f64::from(c) / f64::from(divisions)];
    if turned {
        [node(row, column), node(row + 1, column + 1), node(row, column + 1)]
    } else {
        [node(row, column), node(row + 1, column), node(row + 1, column + 1)]
    }
}

/// Returns a lower bound of the distance from the origin to a triangle.
fn nearest_m(corners: &[DVec3; 3]) -> f64 {
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
    let plane = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero().dot(corners[0]).abs();
    (middle.length() - radius).max(plane)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::Emitters;
    use super::*;
    use crate::sampling::random::Purpose;
    use crate::scene_from_json;

    /// Cheap light samples of a triangle of 1 m from four points, from one in front of it to one whose horizon cuts it. The mean of
    /// 2,000,000 equals the exact illuminance within 4.5 standard errors (α = 7e-6 each; seed 9), and 1% more, the planted fault, does not.
    #[test]
    fn cheap_samples_have_the_mean_of_full_ones() {
        const N: u64 = 2_000_000;
        let text = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
          "geometry": [ { "name": "panel", "type": "rectangle", "origin": [0,0,3], "u": [0,1,0], "v": [1,0,0], "material": "grey" } ],
          "luminaires": [ { "name": "a", "type": "area", "surface": "panel", "luminous_flux_lm": 1000 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a scene");
        let emitters = Emitters::of(&scene);
        let emitter = &emitters.list()[0];
        let mut stream = Stream::new(9, Purpose::Walks, 0, 0);
        let slanting = DVec3::new(-1.0, 0.0, 0.5).normalize();
        for (point_m, normal) in [
            (DVec3::new(0.5, 0.5, 0.0), DVec3::Z),
            (DVec3::new(3.5, 0.2, 0.4), DVec3::Z),
            (DVec3::new(4.0, 0.5, 1.0), slanting),
            (DVec3::new(0.5, 0.5, -0.5), DVec3::X),
        ] {
            let exact_lx = emitter.unshadowed_lx(point_m, normal);
            let (mut sum_lx, mut squares) = (0.0, 0.0);
            for index in 0..N {
                stream.seek(index);
                let lx =
                    emitter.cheap_light_sample(point_m, normal, &mut stream).map_or(0.0, |sample| sample.unshadowed_lx);
                sum_lx += lx;
                squares += lx * lx;
            }
            let mean_lx = sum_lx / N as f64;
            let error_lx = ((squares / N as f64 - mean_lx * mean_lx) / N as f64).sqrt();
            assert!(error_lx > 0.0, "{point_m}: no cheap sample");
            assert!(
                (mean_lx - exact_lx).abs() < 4.5 * error_lx,
                "{point_m}: {mean_lx} ± {error_lx}, exactly {exact_lx}"
            );
            assert!((1.01 * mean_lx - exact_lx).abs() > 4.5 * error_lx, "{point_m}: the planted fault passed");
        }
    }

    /// At 40,000 random points within 3 m of a panel the importances of its two triangles are at least a fourth of their illuminances, and
    /// 0 behind the panel. Planted fault: with heights over distances to the centre, some are lower.
    #[test]
    fn importances_are_bounds_and_vanish_behind_a_panel() {
        let text = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
          "geometry": [ { "name": "panel", "type": "rectangle", "origin": [0,0,3], "u": [0,1,0], "v": [2,0,0.3], "material": "grey" } ],
          "luminaires": [ { "name": "a", "type": "area", "surface": "panel", "luminous_flux_lm": 1000 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a scene");
        let emitters = Emitters::of(&scene);
        let mut stream = Stream::new(4, Purpose::Walks, 0, 0);
        let (mut behind, mut too_low) = (0, 0);
        for index in 0..20_000 {
            stream.seek(index);
            let [x, y, z, u] = [0; 4].map(|_| stream.unit());
            let offset_m = 6.0 * (DVec3::new(x, y, z) - 0.5);
            let normal = DVec3::new(stream.unit() - 0.5, stream.unit() - 0.5, u - 0.5).normalize();
            for emitter in emitters.list() {
                let point_m = emitter.center_m() + offset_m;
                let (bound_lx, lx) = (emitter.importance_lx(point_m, normal), emitter.unshadowed_lx(point_m, normal));
                assert!(bound_lx >= 0.25 * lx, "{point_m} {normal}: {bound_lx} {lx}");
                let Beacon { axis, intensity_cd, .. } = emitter.beacon;
                let height_m = offset_m.dot(axis);
                assert!(height_m > 0.0 || bound_lx == 0.0, "{point_m} {normal}: {bound_lx}");
                behind += usize::from(height_m < 0.0);
                let of_centre_lx = intensity_cd * height_m / offset_m.length().powi(3);
                too_low += usize::from(of_centre_lx < 0.25 * lx);
            }
        }
        assert!(behind > 10_000 && too_low > 100, "{behind} behind, the planted fault passed {too_low} times");
    }

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
