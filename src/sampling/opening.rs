//! Points of a luminous opening: each part of it emits alike, I(θ, φ) dA/A, so that the far field is the file's.

mod seen;

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::random::Stream;
use super::triangle::SeenTriangle;
use super::warp::{sin_cos_of_turns, uniform_sphere};
use crate::base::polygon::triangle_illuminance_factor;
use crate::scene::photometry::Opening;

/// Steps of the sum over an ellipse that gives its perimeter: for a periodic function more than exact enough.
const PERIMETER_STEPS: usize = 256;
/// Draws that thinning may take: the speeds along an ellipse and over an ellipsoid of sides 1 : 100 keep 1 in 64 or
/// more on average.
const MOST_DRAWS: u32 = 20_000;
/// A rectangle nearer than this, over half its diagonal, is looked at by solid angle as well as by area.
const NEAR: f64 = 6.0;
/// Share of those looks that go by solid angle.
const BY_SOLID_ANGLE: f64 = 0.9;

/// A luminous opening in its place.
#[derive(Clone, Debug)]
pub struct Aperture {
    center_m: DVec3,
    shape: Shape,
}

/// Vectors from the middle to the rim, in m.
#[derive(Clone, Copy, Debug)]
enum Shape {
    /// A parallelogram.
    Flat([DVec3; 2]),
    /// A flat ellipse.
    Ellipse([DVec3; 2]),
    /// A box, all six faces.
    Box([DVec3; 3]),
    /// An elliptic cylinder with both ends: two half axes across, half its length.
    Cylinder { half_axes_m: [DVec3; 3], barrel_share: f64 },
    /// An ellipsoid by its half axes.
    Ellipsoid([DVec3; 3]),
}

impl Aperture {
    /// Puts an opening in its place; `frame` holds the unit vectors of C0, C90 and γ = 0. `None` for one without extent.
    pub fn new(opening: &Opening, center_m: DVec3, frame: &[DVec3; 3]) -> Option<Aperture> {
        let [c0, c90, axis] = *frame;
        let half = |extent_m: f64, along: DVec3| 0.5 * extent_m * along;
        let shape = match *opening {
            Opening::Point => return None,
            Opening::Rectangle { c0_m, c90_m } => Shape::Flat([half(c0_m, c0), half(c90_m, c90)]),
            Opening::Box { c0_m, c90_m, height_m } => {
                Shape::Box([half(c0_m, c0), half(c90_m, c90), half(height_m, axis)])
            }
            Opening::Disk { diameter_m } => Shape::Ellipse([half(diameter_m, c0), half(diameter_m, c90)]),
            Opening::Ellipse { c0_m, c90_m, height_m: 0.0 } => Shape::Ellipse([half(c0_m, c0), half(c90_m, c90)]),
            Opening::UprightEllipse { width_m, height_m } => Shape::Ellipse([half(width_m, c90), half(height_m, axis)]),
            Opening::Ellipse { c0_m, c90_m, height_m } => {
                cylinder([half(c0_m, c0), half(c90_m, c90), half(height_m, axis)])
            }
            Opening::VerticalCylinder { diameter_m, height_m } => {
                cylinder([half(diameter_m, c0), half(diameter_m, c90), half(height_m, axis)])
            }
            Opening::HorizontalCylinder { along_c0: true, length_m, width_m, height_m } => {
                cylinder([half(width_m, c90), half(height_m, axis), half(length_m, c0)])
            }
            Opening::HorizontalCylinder { along_c0: false, length_m, width_m, height_m } => {
                cylinder([half(width_m, c0), half(height_m, axis), half(length_m, c90)])
            }
            Opening::Sphere { diameter_m } => {
                Shape::Ellipsoid([half(diameter_m, c0), half(diameter_m, c90), half(diameter_m, axis)])
            }
            Opening::Ellipsoid { c0_m, c90_m, height_m } => {
                Shape::Ellipsoid([half(c0_m, c0), half(c90_m, c90), half(height_m, axis)])
            }
        };
        let aperture = Aperture { center_m, shape };
        (aperture.radius_m() > 0.0).then_some(aperture)
    }

    /// Radius of a ball about the centre that holds the opening, in m.
    pub fn radius_m(&self) -> f64 {
        match &self.shape {
            Shape::Flat(half) => half.iter().map(|h| h.length_squared()).sum::<f64>().sqrt(),
            Shape::Box(half) | Shape::Cylinder { half_axes_m: half, .. } => {
                half.iter().map(|h| h.length_squared()).sum::<f64>().sqrt()
            }
            Shape::Ellipse(half) => half.iter().map(|h| h.length()).fold(0.0, f64::max),
            Shape::Ellipsoid(half) => half.iter().map(|h| h.length()).fold(0.0, f64::max),
        }
    }

    /// Half of a length that holds it along a unit direction, about its centre, in m.
    pub fn half_extent_m(&self, along: DVec3) -> f64 {
        let reach_m = |half: &[DVec3]| half.iter().map(|half| half.dot(along).abs()).sum();
        match &self.shape {
            Shape::Flat(half) | Shape::Ellipse(half) => reach_m(half),
            Shape::Box(half) | Shape::Ellipsoid(half) | Shape::Cylinder { half_axes_m: half, .. } => reach_m(half),
        }
    }

    /// A point drawn uniformly over the opening's surface.
    pub fn draw(&self, stream: &mut Stream) -> DVec3 {
        let both_ways = |variate: f64| 2.0 * variate - 1.0;
        let offset_m = match &self.shape {
            Shape::Flat([a, b]) => {
                let [u, v] = stream.pair();
                both_ways(u) * *a + both_ways(v) * *b
            }
            Shape::Ellipse([a, b]) => {
                let [u, v] = stream.pair();
                let (sin, cos) = sin_cos_of_turns(v);
                u.sqrt() * (cos * *a + sin * *b)
            }
            Shape::Box(half) => {
                let [a, b, c] = half.map(DVec3::length);
                let areas = [b * c, c * a, a * b];
                let mut aim = stream.unit() * areas.iter().sum::<f64>();
                let fixed = areas[..2].iter().position(|area| {
                    let found = aim < *area;
                    aim -= area;
                    found
                });
                let fixed = fixed.unwrap_or(2);
                let end = if stream.unit() < 0.5 { -1.0 } else { 1.0 };
                let [u, v] = stream.pair();
                let (one, other) = ((fixed + 1) % 3, (fixed + 2) % 3);
                end * half[fixed] + both_ways(u) * half[one] + both_ways(v) * half[other]
            }
            Shape::Cylinder { half_axes_m: [a, b, along], barrel_share } => {
                if stream.unit() < *barrel_share {
                    draw_rim(a, b, stream) + both_ways(stream.unit()) * *along
                } else {
                    let end = if stream.unit() < 0.5 { -1.0 } else { 1.0 };
                    let [u, v] = stream.pair();
                    let (sin, cos) = sin_cos_of_turns(v);
                    u.sqrt() * (cos * *a + sin * *b) + end * *along
                }
            }
            Shape::Ellipsoid(half) => draw_ellipsoid(half, stream),
        };
        self.center_m + offset_m
    }

    /// One look from a point with a unit normal: a point of the opening, and the illuminance in lx of which the mean
    /// over all looks is what the opening brings unshadowed; `intensity_cd` tells the intensity towards a direction.
    ///
    /// By area the score is I cos θ/d². A near rectangle is looked at by projected solid angle as well; the two are
    /// combined by their densities (Veach and Guibas 1995), so that near a rectangle that shines by Lambert's law no
    /// score is far from the mean.
    pub fn look(
        &self,
        point_m: DVec3,
        normal: DVec3,
        intensity_cd: impl Fn(DVec3) -> f64,
        stream: &mut Stream,
    ) -> Option<(f64, DVec3)> {
        let score = |at_m: DVec3| {
            let offset_m = at_m - point_m;
            let distance_squared = offset_m.length_squared();
            let height_m = offset_m.dot(normal);
            if height_m <= 0.0 {
                return None;
            }
            let lx = intensity_cd(-offset_m) * height_m / (distance_squared * distance_squared.sqrt());
            (lx > 0.0).then_some((lx, at_m))
        };
        let Some(near) = self.near_rectangle(point_m, normal) else {
            return score(self.draw(stream));
        };
        let at_m = if stream.unit() < BY_SOLID_ANGLE { near.draw(normal, stream)? } else { self.draw(stream) };
        let (lx, at_m) = score(at_m)?;
        // Density by solid angle over that by area: A cos θ cos θ′/(d² F), F the projected solid angle.
        let offset_m = at_m - point_m;
        let cosines = offset_m.dot(normal) * offset_m.dot(near.face).abs();
        let ratio = near.area_m2 * cosines / (offset_m.length_squared().powi(2) * near.projected_sr);
        Some((lx / (1.0 - BY_SOLID_ANGLE + BY_SOLID_ANGLE * ratio), at_m))
    }

    /// A rectangle that is near and partly above the horizon, as two triangles.
    fn near_rectangle(&self, point_m: DVec3, normal: DVec3) -> Option<NearRectangle> {
        let Shape::Flat([a, b]) = self.shape else {
            return None;
        };
        let twice_quarter = a.cross(b);
        let offset_m = self.center_m - point_m;
        let reach_m = NEAR * self.radius_m();
        if twice_quarter == DVec3::ZERO || offset_m.length_squared() > reach_m * reach_m {
            return None;
        }
        // Counter-clockwise as the point sees it.
        let b = if offset_m.dot(twice_quarter) < 0.0 { b } else { -b };
        let corners_m = [-a - b, a - b, a + b, b - a].map(|corner| self.center_m + corner);
        let triangles_m = [[corners_m[0], corners_m[1], corners_m[2]], [corners_m[0], corners_m[2], corners_m[3]]];
        let projected = triangles_m.map(|corners_m| PI * triangle_illuminance_factor(point_m, normal, corners_m));
        let projected_sr = projected[0] + projected[1];
        (projected_sr > 0.0).then(|| NearRectangle {
            triangles: triangles_m.map(|corners_m| corners_m.map(|corner_m| corner_m - point_m)),
            first_share: projected[0] / projected_sr,
            projected_sr,
            area_m2: 4.0 * twice_quarter.length(),
            face: twice_quarter.normalize(),
            point_m,
        })
    }
}

/// A rectangle as a point near it sees it.
struct NearRectangle {
    triangles: [[DVec3; 3]; 2],
    first_share: f64,
    projected_sr: f64,
    area_m2: f64,
    face: DVec3,
    point_m: DVec3,
}

impl NearRectangle {
    /// A point drawn in proportion to projected solid angle.
    fn draw(&self, normal: DVec3, stream: &mut Stream) -> Option<DVec3> {
        let corners = self.triangles[usize::from(stream.unit() >= self.first_share)];
        let (_, [u, v]) = SeenTriangle::new(corners).draw_projected(normal, stream)?;
        let [a, b, c] = corners;
        Some(self.point_m + a + u * (b - a) + v * (c - a))
    }
}

fn cylinder(half_axes_m: [DVec3; 3]) -> Shape {
    let [a, b, along] = half_axes_m;
    let speed = |step: usize| {
        let (sin, cos) = (TAU * (step as f64 + 0.5) / PERIMETER_STEPS as f64).sin_cos();
        (cos * b - sin * a).length()
    };
    let perimeter_m = (0..PERIMETER_STEPS).map(speed).sum::<f64>() * TAU / PERIMETER_STEPS as f64;
    let barrel_m2 = perimeter_m * 2.0 * along.length();
    let ends_m2 = TAU * a.length() * b.length();
    let barrel_share = if barrel_m2 + ends_m2 > 0.0 { barrel_m2 / (barrel_m2 + ends_m2) } else { 1.0 };
    Shape::Cylinder { half_axes_m, barrel_share }
}

/// A point of an ellipse's rim, evenly along it: by the angle, thinned by the speed.
fn draw_rim(a: &DVec3, b: &DVec3, stream: &mut Stream) -> DVec3 {
    let largest = a.length().max(b.length());
    let mut point = *a;
    for _ in 0..MOST_DRAWS {
        let (sin, cos) = sin_cos_of_turns(stream.unit());
        point = cos * *a + sin * *b;
        if stream.unit() * largest < (cos * *b - sin * *a).length() {
            break;
        }
    }
    point
}

/// A point of an ellipsoid, evenly over it: a point of the sphere, thinned by how much the area there is stretched.
fn draw_ellipsoid(half: &[DVec3; 3], stream: &mut Stream) -> DVec3 {
    let [a, b, c] = half.map(DVec3::length);
    let stretches = DVec3::new(b * c, c * a, a * b);
    let largest = stretches.max_element();
    let mut point = DVec3::ZERO;
    for _ in 0..MOST_DRAWS {
        let on_sphere = uniform_sphere(stream.pair());
        point = on_sphere.x * half[0] + on_sphere.y * half[1] + on_sphere.z * half[2];
        if largest <= 0.0 || stream.unit() * largest < (on_sphere * stretches).length() {
            break;
        }
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::polygon::polygon_illuminance_factor;
    use crate::sampling::random::Purpose;

    const FRAME: [DVec3; 3] = [DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z];

    /// Means of squares of the coordinates over N = 200,000 draws (seed 2) must lie within 4.9 standard errors
    /// (α = 1e-6) of the surface's own, and those of a shape 2% larger must not.
    #[test]
    fn points_spread_evenly_over_every_shape() {
        let disk = Opening::Disk { diameter_m: 2.0 };
        let ball = Opening::Sphere { diameter_m: 2.0 };
        // Unit half axes: of a cube ⟨x²⟩ = (1 + 1/3 + 1/3)/3, of a cylinder of height 2 ⟨z²⟩ = (2/3·1/3 + 1/3·1).
        let cases = [
            (Opening::Rectangle { c0_m: 2.0, c90_m: 4.0 }, DVec3::new(1.0 / 3.0, 4.0 / 3.0, 0.0)),
            (disk, DVec3::new(0.25, 0.25, 0.0)),
            (Opening::Box { c0_m: 2.0, c90_m: 2.0, height_m: 2.0 }, DVec3::splat(5.0 / 9.0)),
            (
                Opening::VerticalCylinder { diameter_m: 2.0, height_m: 2.0 },
                DVec3::new(2.0 / 3.0 * 0.5 + 1.0 / 12.0, 2.0 / 3.0 * 0.5 + 1.0 / 12.0, 5.0 / 9.0),
            ),
            (
                Opening::HorizontalCylinder { along_c0: true, length_m: 2.0, width_m: 2.0, height_m: 2.0 },
                DVec3::new(5.0 / 9.0, 5.0 / 12.0, 5.0 / 12.0),
            ),
            (ball, DVec3::splat(1.0 / 3.0)),
            (Opening::UprightEllipse { width_m: 2.0, height_m: 4.0 }, DVec3::new(0.0, 0.25, 1.0)),
        ];
        const N: u64 = 200_000;
        for (opening, exact) in cases {
            let center_m = DVec3::new(3.0, -2.0, 1.0);
            let aperture = Aperture::new(&opening, center_m, &FRAME).expect("it has an extent");
            let mut stream = Stream::new(2, Purpose::Pilot, 0, 0);
            let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
            for index in 0..N {
                stream.seek(index);
                let offset_m = aperture.draw(&mut stream) - center_m;
                assert!(offset_m.length() <= aperture.radius_m() * (1.0 + 1e-12), "{opening:?}");
                sum += offset_m * offset_m;
                squares += offset_m * offset_m * offset_m * offset_m;
            }
            let mean = sum / N as f64;
            for k in 0..3 {
                let error = ((squares[k] / N as f64 - mean[k] * mean[k]) / N as f64).max(0.0).sqrt();
                assert!((mean[k] - exact[k]).abs() <= 4.9 * error + 1e-12, "{opening:?}: {mean} {exact}");
                let faulty = 1.02f64.powi(2) * exact[k];
                assert!(exact[k] == 0.0 || (mean[k] - faulty).abs() > 4.9 * error, "{opening:?}: the fault passed");
            }
        }
        assert!(Aperture::new(&Opening::Point, DVec3::ZERO, &FRAME).is_none());
        assert!(Aperture::new(&Opening::Disk { diameter_m: 0.0 }, DVec3::ZERO, &FRAME).is_none());
    }

    /// On an ellipsoid of half axes 1, 1, 3 the area between the planes z = ±1.5, by the surface's own integral.
    #[test]
    fn long_ellipsoids_and_cylinders_are_covered_evenly() {
        let opening = Opening::Ellipsoid { c0_m: 2.0, c90_m: 2.0, height_m: 6.0 };
        let aperture = Aperture::new(&opening, DVec3::ZERO, &FRAME).expect("it has an extent");
        let mut stream = Stream::new(2, Purpose::Pilot, 0, 1);
        const N: u64 = 200_000;
        let mut within = 0.0;
        for index in 0..N {
            stream.seek(index);
            within += f64::from(u8::from(aperture.draw(&mut stream).z.abs() < 1.5));
        }
        // dA = 2π √(1 − z²/9 + z²/81) dz.
        let area = |to: f64| {
            let strip = |i: usize| (1.0 - (to * (i as f64 + 0.5) / 1e5).powi(2) * (1.0 / 9.0 - 1.0 / 81.0)).sqrt();
            (0..100_000).map(strip).sum::<f64>() * to
        };
        let share = area(1.5) / area(3.0);
        let error = (share * (1.0 - share) / N as f64).sqrt();
        assert!((within / N as f64 - share).abs() < 4.9 * error, "{} {share}", within / N as f64);
    }

    #[test]
    fn a_near_lambertian_rectangle_brings_what_the_polygon_formula_says() {
        let (c0_m, c90_m) = (1.2, 0.6);
        let aperture = Aperture::new(&Opening::Rectangle { c0_m, c90_m }, DVec3::ZERO, &FRAME).expect("an extent");
        let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]]
            .map(|[x, y]: [f64; 2]| DVec3::new(0.5 * c0_m * x, 0.5 * c90_m * y, 0.0));
        let mut stream = Stream::new(4, Purpose::Pilot, 0, 0);
        for (point_m, normal) in [
            (DVec3::new(0.0, 0.0, -0.12), DVec3::Z),
            (DVec3::new(0.5, 0.2, -0.02), DVec3::Z),
            (DVec3::new(0.9, 0.1, -0.05), DVec3::NEG_X),
            (DVec3::new(2.0, 1.0, -0.9), DVec3::new(-0.6, 0.0, 0.8)),
            (DVec3::new(0.0, 3.0, -12.0), DVec3::Z),
        ] {
            let exact = PI * 1000.0 / (PI * c0_m * c90_m) * polygon_illuminance_factor(point_m, normal, &corners) * PI;
            const N: u64 = 40_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for index in 0..N {
                stream.seek(index);
                let cosine = |direction: DVec3| 1000.0 * (-direction.z / direction.length()).max(0.0);
                let lx = aperture.look(point_m, normal, cosine, &mut stream).map_or(0.0, |(lx, _)| lx);
                sum += lx;
                squares += lx * lx;
            }
            let mean = sum / N as f64;
            let error = ((squares / N as f64 - mean * mean) / N as f64).sqrt();
            assert!((mean - exact).abs() < 4.9 * error + 1e-9 * exact, "{point_m}: {mean} ± {error} {exact}");
            assert!(error < 3e-3 * exact, "{point_m}: {mean} ± {error}");
            assert!((1.02 * mean - exact).abs() > 4.9 * error, "the planted fault passed");
        }
    }
}
