//! Tests of luminous openings: points, light samples, and visible faces.

use super::*;
use crate::base::polygon::polygon_illuminance_factor;
use crate::sampling::random::Purpose;

const FRAME: [DVec3; 3] = [DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z];

/// Means of squared coordinates over N = 200,000 draws (seed 2) must lie within 4.9 standard errors (α = 1e-6) of the values of the surface
/// itself. The values of a shape 2% larger must not.
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
            let offset_m = aperture.draw(&mut stream).position_m - center_m;
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

/// Checks the area between the planes z = ±1.5 on an ellipsoid of half axes 1, 1, 3 against the integral over the surface.
#[test]
fn long_ellipsoids_and_cylinders_are_covered_evenly() {
    let opening = Opening::Ellipsoid { c0_m: 2.0, c90_m: 2.0, height_m: 6.0 };
    let aperture = Aperture::new(&opening, DVec3::ZERO, &FRAME).expect("it has an extent");
    let mut stream = Stream::new(2, Purpose::Pilot, 0, 1);
    const N: u64 = 200_000;
    let mut within = 0.0;
    for index in 0..N {
        stream.seek(index);
        within += f64::from(u8::from(aperture.draw(&mut stream).position_m.z.abs() < 1.5));
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
            let lx = aperture.light_sample(point_m, normal, cosine, &mut stream).map_or(0.0, |(lx, _)| lx);
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

/// Solids whose faces emit to where they face: a box, an upright barrel, a lying barrel, an ellipsoid.
const SOLIDS: [Opening; 4] = [
    Opening::Box { c0_m: 1.0, c90_m: 0.6, height_m: 0.3 },
    Opening::VerticalCylinder { diameter_m: 0.8, height_m: 0.5 },
    Opening::HorizontalCylinder { along_c0: false, length_m: 1.2, width_m: 0.5, height_m: 0.3 },
    Opening::Ellipsoid { c0_m: 0.6, c90_m: 1.0, height_m: 0.4 },
];

/// Points drawn towards a direction have the same distribution as uniform points weighted by how much they face it. Means of the
/// coordinates and of their squares agree within 4.9 standard errors (N = 100,000, seed 6, α = 1e-6 each), and all points face the
/// direction. Uniform points without these weights, the planted fault, have a different distribution.
#[test]
fn points_drawn_towards_a_direction_are_those_that_face_it() {
    const N: u64 = 100_000;
    let direction = DVec3::new(0.48, -0.6, -0.64);
    for opening in SOLIDS {
        let aperture = Aperture::new(&opening, DVec3::ZERO, &FRAME).expect("an extent");
        let mut stream = Stream::new(6, Purpose::Pilot, 0, 0);
        let mut moments = |weighed: &dyn Fn(&mut Stream) -> (DVec3, f64)| -> [(f64, f64); 6] {
            let (mut sums, mut squares) = ([0.0; 6], [0.0; 6]);
            for index in 0..N {
                stream.seek(index);
                let (at_m, weight) = weighed(&mut stream);
                let values = [at_m.x, at_m.y, at_m.z, at_m.x * at_m.x, at_m.y * at_m.y, at_m.z * at_m.z];
                for (k, value) in values.into_iter().enumerate() {
                    sums[k] += weight * value;
                    squares[k] += (weight * value).powi(2);
                }
            }
            std::array::from_fn(|k| {
                let mean = sums[k] / N as f64;
                (mean, (squares[k] / N as f64 - mean * mean) / N as f64)
            })
        };
        let towards = moments(&|stream| {
            let point = aperture.draw_towards(direction, stream);
            assert!(point.face.is_some_and(|face| face.dot(direction) > -1e-12), "{opening:?}: {point:?}");
            (point.position_m, 1.0)
        });
        let counted = moments(&|stream| {
            let point = aperture.draw(stream);
            (point.position_m, aperture.share_towards(&point, direction))
        });
        let even = moments(&|stream| (aperture.draw(stream).position_m, 1.0));
        let apart = |one: &[(f64, f64); 6], other: &[(f64, f64); 6]| {
            let deviations =
                one.iter().zip(other).map(|(one, other)| (one.0 - other.0).abs() / (one.1 + other.1).sqrt());
            deviations.fold(0.0, f64::max)
        };
        assert!(apart(&towards, &counted) < 4.9, "{opening:?}: {towards:?} {counted:?}");
        assert!(apart(&towards, &even) > 4.9, "{opening:?}: the planted fault passed");
    }
}

/// Light samples from near and far have the same mean as uniform points weighted by how much they face the receiver. The tolerance is 4.9
/// standard errors (N = 200,000, seed 8, α = 1e-6 each). Points that shine through the body, the planted fault, differ in front of a face.
#[test]
fn light_samples_bring_what_the_faces_show() {
    const N: u64 = 200_000;
    let intensity_cd = |direction: DVec3| 1000.0 * (1.0 - 0.5 * direction.normalize().z);
    for opening in SOLIDS {
        let aperture = Aperture::new(&opening, DVec3::ZERO, &FRAME).expect("an extent");
        let mut stream = Stream::new(8, Purpose::Pilot, 0, 0);
        for (point_m, normal) in [
            (DVec3::new(0.0, 0.0, -0.6), DVec3::Z),
            (DVec3::new(1.0, 0.4, -0.1), DVec3::NEG_X),
            (DVec3::new(2.0, -3.0, -4.0), DVec3::new(-0.6, 0.0, 0.8)),
        ] {
            let mut mean = |score: &dyn Fn(&mut Stream) -> f64| {
                let (mut sum, mut squares) = (0.0, 0.0);
                for index in 0..N {
                    stream.seek(index);
                    let lx = score(&mut stream);
                    sum += lx;
                    squares += lx * lx;
                }
                let mean = sum / N as f64;
                (mean, (squares / N as f64 - mean * mean) / N as f64)
            };
            let lx_from = |at: &OpeningPoint, share: f64| {
                let offset_m = at.position_m - point_m;
                let height_m = offset_m.dot(normal).max(0.0);
                share * intensity_cd(-offset_m) * height_m / offset_m.length().powi(3)
            };
            let sampled = mean(&|stream| {
                aperture.light_sample(point_m, normal, intensity_cd, stream).map_or(0.0, |sample| sample.0)
            });
            let counted = mean(&|stream| {
                let at = aperture.draw(stream);
                lx_from(&at, aperture.share_towards(&at, (point_m - at.position_m).normalize()))
            });
            let through = mean(&|stream| lx_from(&aperture.draw(stream), 1.0));
            let apart = |one: (f64, f64), other: (f64, f64)| (one.0 - other.0).abs() / (one.1 + other.1).sqrt();
            assert!(apart(sampled, counted) < 4.9, "{opening:?} {point_m}: {sampled:?} {counted:?}");
            let is_near = point_m.length() < 1.0;
            assert!(!is_near || apart(sampled, through) > 4.9, "{opening:?} {point_m}: the planted fault passed");
        }
    }
}
