//! Tests of all BSDFs: draws against the BRDF, the BRDF against the total, and reciprocity.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{Blinn, Bsdf, Glossy, LobeKind, Pair, Phong, Reflection, mirrored};
use crate::sampling::chi_square::chi_square_p;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::BsdfParameters;

/// Probability that one test rejects a correct sampler.
const ALPHA: f64 = 1e-4;
const DRAWS: u64 = 1_000_000;
const SEED: u64 = 11;
/// Bins over cos²θ (which a Lambertian surface fills evenly) and the azimuth.
const BINS: [usize; 2] = [8, 12];
/// Midpoints along each side of a bin.
const MIDPOINTS: usize = 48;

fn phong(diffuse_reflectance: f64, specular_reflectance: f64, exponent: f64) -> BsdfParameters {
    BsdfParameters::Phong { diffuse_reflectance, specular_reflectance, exponent }
}

fn blinn(diffuse_reflectance: f64, specular_reflectance: f64, exponent: f64) -> BsdfParameters {
    BsdfParameters::Blinn { diffuse_reflectance, specular_reflectance, exponent }
}

/// Returns a direction away from the surface with the normal z, at an angle and an azimuth in degrees.
fn at(theta_deg: f64, phi_deg: f64) -> DVec3 {
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    let (sin_phi, cos_phi) = phi_deg.to_radians().sin_cos();
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Returns the direction at (cos²θ, turns) on the upper or the lower side.
fn placed(square: f64, turns: f64, upper: bool) -> DVec3 {
    let (sin, cos) = ((1.0 - square).sqrt(), square.sqrt());
    DVec3::new(sin * (TAU * turns).cos(), sin * (TAU * turns).sin(), if upper { cos } else { -cos })
}

/// ∫ f cos θ dω over each bin of both sides: with q = cos²θ, cos θ dω = ½ dq dφ.
fn masses(bsdf: &Bsdf, towards: DVec3) -> Vec<f64> {
    let mut masses = Vec::new();
    for upper in [true, false] {
        for bin in 0..BINS[0] * BINS[1] {
            let within =
                |k: usize, bin: usize, bins: usize| (bin as f64 + (k as f64 + 0.5) / MIDPOINTS as f64) / bins as f64;
            let mut sum = 0.0;
            for k in 0..MIDPOINTS * MIDPOINTS {
                let square = within(k / MIDPOINTS, bin / BINS[1], BINS[0]);
                let turns = within(k % MIDPOINTS, bin % BINS[1], BINS[1]);
                let pair = Pair { normal: DVec3::Z, towards, leaving: placed(square, turns, upper) };
                sum += bsdf.eval_per_sr(&pair);
            }
            masses.push(sum * PI / (BINS[0] * BINS[1] * MIDPOINTS * MIDPOINTS) as f64);
        }
    }
    masses
}

/// Counts the draws that ended in each bin. The last entry counts the absorbed draws.
fn counts(bsdf: &Bsdf, towards: DVec3) -> Vec<f64> {
    let half = BINS[0] * BINS[1];
    let mut counts = vec![0.0; 2 * half + 1];
    let mut stream = Stream::new(SEED, Purpose::Pilot, 0, 0);
    for index in 0..DRAWS {
        stream.seek(index);
        let Some(scattered) = bsdf.sample(-towards, DVec3::Z, &mut stream) else {
            counts[2 * half] += 1.0;
            continue;
        };
        let direction = scattered.direction;
        assert!((direction.length() - 1.0).abs() < 1e-9, "{direction} is no unit vector");
        assert_eq!(direction.z < 0.0, scattered.lobe.leads_through(), "{direction} {:?}", scattered.lobe);
        let turns = (direction.y.atan2(direction.x) / TAU).rem_euclid(1.0);
        let bin = |x: f64, bins: usize| ((x * bins as f64) as usize).min(bins - 1);
        let place = bin(direction.z * direction.z, BINS[0]) * BINS[1] + bin(turns, BINS[1]);
        counts[place + if direction.z < 0.0 { half } else { 0 }] += 1.0;
    }
    counts
}

/// Returns the p-value of counts against masses, with absorption as a last bin.
fn p_of_draws(counts: &[f64], masses: &[f64]) -> f64 {
    let absorbed = (1.0 - masses.iter().sum::<f64>()).max(0.0);
    let expected: Vec<f64> = masses.iter().chain([&absorbed]).map(|mass| mass * DRAWS as f64).collect();
    chi_square_p(counts, &expected)
}

#[test]
fn draws_follow_the_laws_and_a_fault_of_two_percent_is_rejected() {
    let cases = [
        (BsdfParameters::Diffuse { reflectance: 0.7 }, BsdfParameters::Diffuse { reflectance: 0.714 }),
        (phong(0.2, 0.6, 0.0), phong(0.2, 0.612, 0.0)),
        (phong(0.3, 0.5, 5.0), phong(0.3, 0.51, 5.1)),
        (phong(0.0, 1.0, 60.0), phong(0.0, 1.0, 61.2)),
        (blinn(0.2, 0.6, 0.0), blinn(0.2, 0.612, 0.0)),
        (blinn(0.3, 0.5, 20.0), blinn(0.3, 0.51, 20.4)),
        (blinn(0.0, 1.0, 240.0), blinn(0.0, 1.0, 244.8)),
        (
            BsdfParameters::Translucent { diffuse_reflectance: 0.4, diffuse_transmittance: 0.35 },
            BsdfParameters::Translucent { diffuse_reflectance: 0.4, diffuse_transmittance: 0.357 },
        ),
    ];
    for (bsdf, faulty) in cases {
        for theta_deg in [20.0, 75.0] {
            let towards = at(theta_deg, 40.0);
            let drawn = counts(&Bsdf::new(&bsdf), towards);
            let right = p_of_draws(&drawn, &masses(&Bsdf::new(&bsdf), towards));
            assert!(right > ALPHA, "{bsdf:?} at {theta_deg}: p = {right}");
            let wrong = p_of_draws(&drawn, &masses(&Bsdf::new(&faulty), towards));
            assert!(wrong < ALPHA, "{bsdf:?} at {theta_deg}: a planted fault passed, p = {wrong}");
        }
    }
}

#[test]
fn densities_integrate_to_one() {
    for bsdf in [
        BsdfParameters::Diffuse { reflectance: 0.3 },
        phong(0.3, 0.5, 5.0),
        phong(0.1, 0.2, 60.0),
        blinn(0.3, 0.5, 20.0),
        blinn(0.1, 0.2, 240.0),
        BsdfParameters::Translucent { diffuse_reflectance: 0.1, diffuse_transmittance: 0.6 },
    ] {
        let bsdf = Bsdf::new(&bsdf);
        let towards = at(50.0, 10.0);
        const STEPS: usize = 400;
        let mut sum = 0.0;
        for upper in [true, false] {
            for k in 0..STEPS * STEPS {
                let share = |k: usize| (k as f64 + 0.5) / STEPS as f64;
                let leaving = placed(share(k / STEPS), share(k % STEPS), upper);
                let pair = Pair { normal: DVec3::Z, towards, leaving };
                sum += bsdf.pdf_per_sr(&pair) * PI / leaving.z.abs();
            }
        }
        let integral = sum / (STEPS * STEPS) as f64;
        assert!((integral - 1.0).abs() < 1e-3, "{integral}");
    }
}

/// Returns ∫ f cos θ_o dω of a BSDF with a lobe. The lobe is integrated over u = cosⁿ⁺¹α and the azimuth around an axis, the rest over the
/// cosine. `leaving_of` returns the direction in which light leaves, and the ratio of solid angles there and around the axis.
fn directional_reflectance(
    bsdf: &impl Reflection,
    exponent: f64,
    towards: DVec3,
    axis: DVec3,
    leaving_of: impl Fn(DVec3) -> (DVec3, f64),
) -> f64 {
    const ALONG: usize = 200;
    const AROUND: usize = 1024;
    let (t, b) = axis.any_orthonormal_pair();
    let mut lobe = 0.0;
    for i in 0..ALONG {
        // Graded towards the tail, where cos α changes fast.
        let x = (i as f64 + 0.5) / ALONG as f64;
        let (u, du) = (x * x, 2.0 * x / ALONG as f64);
        let cos_alpha = u.powf(1.0 / (exponent + 1.0));
        let sin_alpha = (1.0 - cos_alpha * cos_alpha).sqrt();
        for j in 0..AROUND {
            let (sin, cos) = (TAU * (j as f64 + 0.5) / AROUND as f64).sin_cos();
            let (leaving, ratio) = leaving_of(axis * cos_alpha + (t * cos + b * sin) * sin_alpha);
            let value = ratio * bsdf.lobe_per_sr(&Pair { normal: DVec3::Z, towards, leaving });
            lobe += value * leaving.z.max(0.0) * du * TAU / AROUND as f64 / ((exponent + 1.0) * u / cos_alpha);
        }
    }
    const STEPS: usize = 20_000;
    let spread: f64 = (0..STEPS)
        .map(|k| {
            let x = (k as f64 + 0.5) / STEPS as f64;
            let (cos, dcos) = (x.powi(3), 3.0 * x * x / STEPS as f64);
            let leaving = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            TAU * cos * dcos * bsdf.spread_per_sr(&Pair { normal: DVec3::Z, towards, leaving })
        })
        .sum();
    lobe + spread
}

#[test]
fn gloss_loses_nothing_at_any_angle_and_exponent() {
    for exponent in [0.0, 0.5, 3.0, 60.0, 1000.0, 1e5] {
        let bsdf = Glossy::new(0.15, 0.8, Phong { exponent });
        for theta_deg in [0.0, 30.0, 60.0, 80.0, 88.0, 89.9] {
            let towards = at(theta_deg, 25.0);
            let axis = mirrored(-towards, DVec3::Z);
            let reflectance = directional_reflectance(&bsdf, exponent, towards, axis, |leaving| (leaving, 1.0));
            assert!((reflectance - 0.95).abs() < 1e-3, "n = {exponent}, {theta_deg} degrees: {reflectance}");
            let bsdf = Glossy::new(0.15, 0.8, Blinn { exponent });
            let leaving_of = |half: DVec3| (mirrored(-towards, half), 4.0 * towards.dot(half).max(0.0));
            let reflectance = directional_reflectance(&bsdf, exponent, towards, DVec3::Z, leaving_of);
            assert!((reflectance - 0.95).abs() < 1e-3, "Blinn, n = {exponent}, {theta_deg} degrees: {reflectance}");
        }
    }
    // Without the second term the lobe with n = 60 loses light. The test must see this fault.
    let plain = Glossy::new(0.0, 0.8, Phong { exponent: 60.0 });
    let pair = |leaving| Pair { normal: DVec3::Z, towards: at(80.0, 0.0), leaving };
    assert!(plain.spread_per_sr(&pair(at(80.0, 90.0))) > 0.01);
    assert!(Glossy::new(0.0, 0.8, Blinn { exponent: 240.0 }).spread_per_sr(&pair(at(80.0, 90.0))) > 0.01);
}

#[test]
fn exchanging_the_directions_changes_nothing() {
    for bsdf in [
        BsdfParameters::Diffuse { reflectance: 0.7 },
        phong(0.1, 0.8, 0.0),
        phong(0.1, 0.8, 17.3),
        phong(0.3, 0.6, 1e5),
        blinn(0.1, 0.8, 0.0),
        blinn(0.1, 0.8, 17.3),
        blinn(0.3, 0.6, 1e5),
        BsdfParameters::Translucent { diffuse_reflectance: 0.4, diffuse_transmittance: 0.35 },
    ] {
        let bsdf = Bsdf::new(&bsdf);
        for (one, other) in [
            (at(20.0, 0.0), at(21.0, 181.0)),
            (at(60.0, 30.0), at(59.9, 210.05)),
            (at(85.0, 0.0), at(10.0, 77.0)),
            (at(89.9, 0.0), at(89.0, 180.5)),
        ] {
            let there = bsdf.eval_per_sr(&Pair { normal: DVec3::Z, towards: one, leaving: other });
            let back = bsdf.eval_per_sr(&Pair { normal: DVec3::Z, towards: other, leaving: one });
            // The mirror direction is rounded differently in the two orders: n times 1e-15.
            assert!((there - back).abs() <= 1e-9 * there, "{bsdf:?}: {there} {back}");
        }
    }
}

#[test]
fn mirrors_and_panes_keep_their_shares_and_directions() {
    // 4.9 standard errors, α = 1e-6, N = 400,000, and a fault of 2% must be rejected.
    const N: u64 = 400_000;
    let direction = DVec3::new(0.6, 0.3, -0.2).normalize();
    let cos_in = -direction.z;
    for bsdf in [
        BsdfParameters::Mirror { reflectance: 0.9 },
        BsdfParameters::Glass { refractive_index: 1.52, internal_transmittance: 0.9, glazed_share: 1.0 },
        BsdfParameters::Glass { refractive_index: 1.52, internal_transmittance: 0.9, glazed_share: 0.7 },
    ] {
        let bsdf = Bsdf::new(&bsdf);
        let mut stream = Stream::new(SEED, Purpose::Pilot, 0, 0);
        let (mut mirrored, mut passed) = (0.0, 0.0);
        for index in 0..N {
            stream.seek(index);
            match bsdf.sample(direction, DVec3::Z, &mut stream) {
                Some(scattered) if scattered.lobe == LobeKind::Mirrored => {
                    assert!(scattered.direction.distance(direction * DVec3::new(1.0, 1.0, -1.0)) < 1e-15);
                    mirrored += 1.0;
                }
                Some(scattered) => {
                    assert_eq!((scattered.lobe, scattered.direction), (LobeKind::Passed, direction));
                    passed += 1.0;
                }
                None => {}
            }
        }
        let shares = [bsdf.mirror_share(cos_in), bsdf.total(cos_in) - bsdf.mirror_share(cos_in)];
        for (count, share) in [(mirrored, shares[0]), (passed, shares[1])] {
            let allowed = 4.9 * (share * (1.0 - share) / N as f64).sqrt();
            assert!((count / N as f64 - share).abs() <= allowed + 1e-12, "{bsdf:?}: {count} {share}");
            let faulty = (1.02 * share - share).abs() > allowed;
            assert!(faulty || share == 0.0, "a planted fault would pass");
        }
        let pair = Pair { normal: DVec3::Z, towards: -direction, leaving: at(30.0, 0.0) };
        assert_eq!((bsdf.eval_per_sr(&pair), bsdf.pdf_per_sr(&pair)), (0.0, 0.0));
    }
}
