//! Bessel functions to nearly full double precision.
//!
//! The real functions come from well-tested crates under one set of names, because each crate is good for only some of them. Against
//! 40-digit values (`validation/special_functions`), libm's J and Y and spec_math's K lose a few units in the last place. K of a complex
//! argument is this project's own code.

use std::f64::consts::FRAC_PI_2;

use num_complex::Complex;

/// Euler's constant γ.
pub const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// J₀(x), for every finite x. Accuracy: 1e-14 of the envelope min(1, √(2/πx)) up to x = 1e5.
#[inline]
pub fn bessel_j0(x: f64) -> f64 {
    libm::j0(x)
}

/// J₁(x), for every finite x. Accuracy: 1e-14 of the envelope min(x/2, √(2/πx)) up to x = 1e5.
#[inline]
pub fn bessel_j1(x: f64) -> f64 {
    libm::j1(x)
}

/// Y₀(x), x > 0 (−∞ at 0, NaN below). Accuracy: 1e-14 of the envelope √(J₀² + Y₀²) up to x = 1e5.
#[inline]
pub fn bessel_y0(x: f64) -> f64 {
    libm::y0(x)
}

/// Y₁(x), x > 0 (−∞ at 0, NaN below). Accuracy: 1e-14 of the envelope √(J₁² + Y₁²) up to x = 1e5.
#[inline]
pub fn bessel_y1(x: f64) -> f64 {
    libm::y1(x)
}

/// K₀(x), x > 0 (∞ at 0). Accuracy: 5e-15 relative, until it underflows past x = 700.
#[inline]
pub fn bessel_k0(x: f64) -> f64 {
    spec_math::cephes64::k0(x)
}

/// K₁(x), x > 0 (∞ at 0). Accuracy: 5e-15 relative, until it underflows past x = 700.
#[inline]
pub fn bessel_k1(x: f64) -> f64 {
    spec_math::cephes64::k1(x)
}

/// eˣ K₀(x), x > 0 (∞ at 0). Accuracy: 5e-15 relative.
#[inline]
pub fn bessel_k0_scaled(x: f64) -> f64 {
    spec_math::cephes64::k0e(x)
}

/// eˣ K₁(x), x > 0 (∞ at 0). Accuracy: 5e-15 relative.
#[inline]
pub fn bessel_k1_scaled(x: f64) -> f64 {
    spec_math::cephes64::k1e(x)
}

/// Below this size of the argument the power series are used, above it the continued fraction. At this size the series has lost less than
/// one digit and the fraction needs about 60 steps.
const SERIES_BELOW: f64 = 2.0;

/// Above this size Hankel's expansion reaches full accuracy: its smallest term is about e^(−2|z|) = 2e-16.
const EXPANSION_ABOVE: f64 = 18.0;

/// Returns eᶻ K₀(z) and eᶻ K₁(z) of a complex argument with Re z ≥ 0, z ≠ 0.
///
/// Accuracy: 1e-14 of each value's size. For |z| below 2 on the imaginary and on the real axis, the real part and the imaginary part each
/// have this accuracy separately.
/// Source: the power series (Abramowitz and Stegun 1964, 9.6.10–13); N. M. Temme, "On the numerical evaluation of the modified Bessel
/// function of the third kind", 1975.
pub fn bessel_k01_scaled(z: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    if z.norm_sqr() < SERIES_BELOW * SERIES_BELOW {
        let scale = z.exp();
        let (k0, z_k1_minus_one) = small_k01(z);
        return (k0 * scale, (z_k1_minus_one + 1.0) / z * scale);
    }
    if z.norm_sqr() > EXPANSION_ABOVE * EXPANSION_ABOVE {
        return (expanded_k_scaled(z, 0.0), expanded_k_scaled(z, 4.0));
    }
    temme_k01_scaled(z)
}

/// Returns eᶻ K₀(z) alone, in less time.
///
/// Range, accuracy, source: those of [`bessel_k01_scaled`].
pub fn complex_bessel_k0_scaled(z: Complex<f64>) -> Complex<f64> {
    if z.norm_sqr() > EXPANSION_ABOVE * EXPANSION_ABOVE {
        return expanded_k_scaled(z, 0.0);
    }
    bessel_k01_scaled(z).0
}

/// Returns eᶻ K_ν(z) by Hankel's expansion for large |z|, with `mu` = 4ν².
fn expanded_k_scaled(z: Complex<f64>, mu: f64) -> Complex<f64> {
    const MOST_TERMS: usize = 40;
    let step = Complex::new(0.125, 0.0) / z;
    let mut term = Complex::new(1.0, 0.0);
    let mut sum = term;
    for n in 1..MOST_TERMS {
        let odd = (2 * n - 1) as f64;
        term *= step * ((mu - odd * odd) / n as f64);
        sum += term;
        if term.norm_sqr() < (0.1 * f64::EPSILON).powi(2) {
            break;
        }
    }
    (Complex::new(FRAC_PI_2, 0.0) / z).sqrt() * sum
}

/// Returns z K₁(z) and 1 − z K₁(z) of a complex argument with Re z ≥ 0, each without cancellation. As z → 0 the first goes to 1 and the
/// second as −(z²/2) ln(z/2).
///
/// Accuracy: 1e-14 of each value's size (for the second where |z| < 2 or zK₁ is not near 1). For |z| < 2 on the real and on the imaginary
/// axis, the real part and the imaginary part each have this accuracy.
pub fn z_bessel_k1_and_deficit(z: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let one = Complex::new(1.0, 0.0);
    if z.norm_sqr() == 0.0 {
        return (one, Complex::new(0.0, 0.0));
    }
    if z.norm_sqr() < SERIES_BELOW * SERIES_BELOW {
        let less_one = small_k01(z).1;
        return (one + less_one, -less_one);
    }
    let value = z * temme_k01_scaled(z).1 * (-z).exp();
    (value, one - value)
}

/// Returns K₀(z) and z K₁(z) − 1 by their power series: K₀ = Σ (q^m/m!²)(ψ(m+1) − ln(z/2)) and z K₁ − 1 = Σ (2 q^{m+1}/(m!(m+1)!)) (ln(z/2)
/// − (ψ(m+1) + ψ(m+2))/2), q = z²/4.
fn small_k01(z: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    // Twenty terms: at |z| = 2 the last is below 1/20!² = 2e-37.
    const TERMS: usize = 20;
    let q = z * z * 0.25;
    let log = Complex::new((z.norm() * 0.5).ln(), z.im.atan2(z.re));
    let mut psi = -EULER_GAMMA;
    let mut power = Complex::new(1.0, 0.0);
    let mut k0 = Complex::new(0.0, 0.0);
    let mut rest = Complex::new(0.0, 0.0);
    for m in 0..TERMS {
        let next = 1.0 / (m as f64 + 1.0);
        k0 += power * (-log + psi);
        // power = q^m/m!², so that q^{m+1}/(m!(m+1)!) = power · q/(m+1).
        power *= q;
        rest += power * (2.0 * next) * (log - psi - 0.5 * next);
        power *= next * next;
        psi += next;
        if power.norm_sqr() < f64::EPSILON * f64::EPSILON * 1e-6 * rest.norm_sqr() {
            break;
        }
    }
    (k0, rest)
}

/// Returns eᶻ K₀(z), eᶻ K₁(z) by Steed's continued fraction with Temme's sum.
fn temme_k01_scaled(z: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    // More steps than any |z| ≥ 2 with Re z ≥ 0 needs.
    const MOST_STEPS: usize = 500;
    const QUARTER: f64 = 0.25;
    let one = Complex::new(1.0, 0.0);
    let mut b = (z + 1.0) * 2.0;
    let mut d = one / b;
    let (mut h, mut step) = (d, d);
    let (mut q_before, mut q) = (Complex::new(0.0, 0.0), one);
    let mut c = QUARTER;
    let mut a = -QUARTER;
    let mut q_sum = Complex::new(QUARTER, 0.0);
    let mut sum = one + q_sum * step;
    for i in 2..MOST_STEPS {
        a -= 2.0 * (i as f64 - 1.0);
        c *= -a / i as f64;
        let q_next = (q_before - b * q) / a;
        (q_before, q) = (q, q_next);
        q_sum += q * c;
        b += 2.0;
        d = one / (b + d * a);
        step *= b * d - 1.0;
        h += step;
        let term = q_sum * step;
        sum += term;
        if term.norm_sqr() < (0.1 * f64::EPSILON).powi(2) * sum.norm_sqr() {
            break;
        }
    }
    let k0 = (Complex::new(FRAC_PI_2, 0.0) / z).sqrt() / sum;
    (k0, k0 * (z + 0.5 - h * QUARTER) / z)
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE: &str =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/validation/special_functions/reference.csv"));

    /// Returns the envelope √(J₀² + Y₀²) ~ √(2/πx) of the oscillating Bessel functions at large x. Errors are measured relative to it.
    fn bessel_envelope(x: f64) -> f64 {
        (2.0 / (std::f64::consts::PI * x)).sqrt()
    }

    fn worst(name: &str, error: impl Fn(Complex<f64>, Complex<f64>) -> f64) -> f64 {
        let mut count = 0;
        let mut worst = (0.0, Complex::new(0.0, 0.0));
        for line in REFERENCE.lines().skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            if fields[0] != name {
                continue;
            }
            let number = |i: usize| fields[i].parse::<f64>().expect("a number");
            let z = Complex::new(number(1), number(2));
            let e = error(z, Complex::new(number(3), number(4)));
            assert!(e.is_finite(), "{name}({z})");
            if e > worst.0 {
                worst = (e, z);
            }
            count += 1;
        }
        assert!(count >= 60, "{name}: only {count} rows");
        worst.0
    }

    #[test]
    fn real_functions_hold_their_accuracy_against_40_digits() {
        // Near their zeros the errors of the oscillating functions are measured relative to their envelope.
        let oscillating = |f: fn(f64) -> f64| {
            move |z: Complex<f64>, v: Complex<f64>| {
                let scale = if z.re < 1.0 { v.re.abs() } else { bessel_envelope(z.re) };
                (f(z.re) - v.re).abs() / scale
            }
        };
        let relative = |f: fn(f64) -> f64| {
            move |z: Complex<f64>, v: Complex<f64>| {
                if z.im != 0.0 { 0.0 } else { (f(z.re) / v.re - 1.0).abs() }
            }
        };
        assert!(worst("J0", oscillating(bessel_j0)) < 1e-14);
        assert!(worst("J1", oscillating(bessel_j1)) < 1e-14);
        assert!(worst("Y1", oscillating(bessel_y1)) < 1e-14);
        assert!(worst("K0", relative(bessel_k0)) < 5e-15);
        assert!(worst("K1", relative(bessel_k1)) < 5e-15);
        assert!(worst("K0e", relative(bessel_k0_scaled)) < 5e-15);
        assert!(worst("K1e", relative(bessel_k1_scaled)) < 5e-15);
        // Y₀ has a zero at 0.8936, so below 1 its scale is at least that of the first lobe.
        let y0 = |z: Complex<f64>, v: Complex<f64>| {
            (bessel_y0(z.re) - v.re).abs() / v.re.abs().max(bessel_envelope(z.re.max(1.0)))
        };
        assert!(worst("Y0", y0) < 1e-14);
    }

    #[test]
    fn complex_functions_hold_their_accuracy_against_40_digits() {
        assert!(worst("K0e", |z, v| (bessel_k01_scaled(z).0 - v).norm() / v.norm()) < 1e-14);
        assert!(worst("K1e", |z, v| (bessel_k01_scaled(z).1 - v).norm() / v.norm()) < 1e-14);
    }

    #[test]
    fn one_minus_z_k1_keeps_its_digits_near_zero() {
        // z K1(z) − 1 at z = 1e-4: (z²/2)(ln(z/2) + γ − ½) (1 + O(z²/8·…)), next term (z⁴/16)(ln(z/2) + γ − 5/4).
        let z: f64 = 1e-4;
        let log = (z / 2.0).ln() + EULER_GAMMA;
        let exact = z * z / 2.0 * (log - 0.5) + z.powi(4) / 16.0 * (log - 1.25);
        let value = -z_bessel_k1_and_deficit(Complex::new(z, 0.0)).1;
        assert!((value.re / exact - 1.0).abs() < 1e-15 && value.im == 0.0);
        // On the imaginary axis κ(it) = −(πt/2)(Y₁ + iJ₁), so the imaginary part is −(πt/2) J₁(t).
        for t in [1e-9, 1e-4, 0.3, 1.0, 1.9] {
            let value = z_bessel_k1_and_deficit(Complex::new(0.0, t)).0;
            assert!((value.im / (-FRAC_PI_2 * t * bessel_j1(t)) - 1.0).abs() < 4e-15, "{t}");
        }
        let zero = Complex::new(0.0, 0.0);
        assert_eq!(z_bessel_k1_and_deficit(zero), (zero + 1.0, zero));
    }
}
