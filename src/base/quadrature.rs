//! Numerical integration: fixed Gauss–Legendre rules, adaptive Gauss–Kronrod, and tanh-sinh for singular endpoints.

use std::num::NonZeroUsize;

use super::sum::CompensatedSum;

/// 1/φ: the fractional parts of its multiples cover [0, 1) evenly, however many they are.
pub const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A Gauss–Legendre rule on −1 to 1.
#[derive(Clone, Debug)]
pub struct GaussLegendre {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl GaussLegendre {
    /// Makes the rule with `count` nodes (at least 1), in rising order. It is exact for polynomials of degree 2·count − 1.
    ///
    /// Accuracy: nodes and weights to about 1e-16.
    pub fn new(count: usize) -> GaussLegendre {
        let count = NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN);
        let rule = gauss_quad::legendre::GaussLegendre::new(count);
        let mut pairs: Vec<(f64, f64)> = rule.nodes().copied().zip(rule.weights().copied()).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (nodes, weights) = pairs.into_iter().unzip();
        GaussLegendre { nodes, weights }
    }

    /// Returns the nodes on −1 to 1, rising.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// Returns the weights; their sum is 2.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Returns nodes and weights moved to the interval from `a` to `b`.
    pub fn on(&self, a: f64, b: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        self.nodes.iter().zip(&self.weights).map(move |(x, w)| (middle + half * x, half * w))
    }

    /// Returns the integral of `f` from `a` to `b` by this rule.
    pub fn integrate(&self, a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
        self.on(a, b).map(|(x, w)| w * f(x)).sum()
    }
}

/// When an adaptive integration may stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Error allowed, in the integral's unit.
    pub absolute: f64,
    /// Error allowed, as a fraction of the integral.
    pub relative: f64,
    /// The most evaluations of the integrand.
    pub evaluations: usize,
}

impl Tolerance {
    /// Makes a relative tolerance, with at most 100,000 evaluations.
    pub fn relative(relative: f64) -> Tolerance {
        Tolerance { absolute: 0.0, relative, evaluations: 100_000 }
    }

    fn allows(&self, error: f64, value: f64) -> bool {
        error <= self.absolute.max(self.relative * value.abs())
    }
}

/// An integral's value and what is known about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integral {
    /// The value.
    pub value: f64,
    /// Estimate of the error, cautious for smooth integrands.
    pub estimated_error: f64,
    /// How often the integrand was evaluated.
    pub evaluations: usize,
    /// Whether the tolerance was met.
    pub converged: bool,
}

/// Nodes of the 15-point Kronrod rule, the middle node last. Those with an odd index are the nodes of the 7-point Gauss rule.
const KRONROD_NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];
const KRONROD_WEIGHTS: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_56,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_82,
];
const GAUSS_WEIGHTS: [f64; 4] =
    [0.129_484_966_168_869_7, 0.279_705_391_489_276_64, 0.381_830_050_505_118_9, 0.417_959_183_673_469_4];

/// Pieces below this fraction of the interval are not halved. Otherwise a pole without an integral would be followed down to the smallest
/// numbers and mistaken for an integrable one. For 1/√x, a piece of this width holds 1e-15 of the integral.
const NARROWEST_PIECE: f64 = 1e-30;

/// A piece of the interval with its own value and error.
struct IntervalPiece {
    from: f64,
    to: f64,
    value: f64,
    error: f64,
}

/// Returns the integral of `f` from `a` to `b` (both finite). It bisects where the 7-point Gauss and the 15-point Kronrod rule differ most.
///
/// It suits kinks, jumps, peaks and weak singularities at unknown positions. It never evaluates the endpoints. The estimated error is the
/// plain difference of the two rules. For smooth integrands it is far larger than the Kronrod rule's own error, but it is not a bound.
///
/// ```
/// use luxmc::base::quadrature::{Tolerance, integrate_adaptive};
///
/// let kink = integrate_adaptive(|x: f64| (x - 0.3).abs(), 0.0, 1.0, Tolerance::relative(1e-12));
/// assert!((kink.value - 0.29).abs() < 1e-12 && kink.converged);
/// ```
pub fn integrate_adaptive(mut f: impl FnMut(f64) -> f64, a: f64, b: f64, tolerance: Tolerance) -> Integral {
    let mut evaluations = 0;
    let mut piece = |from: f64, to: f64, evaluations: &mut usize| {
        *evaluations += 15;
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let centre = f(middle);
        let (mut kronrod, mut gauss) = (KRONROD_WEIGHTS[7] * centre, GAUSS_WEIGHTS[3] * centre);
        for i in 0..7 {
            let pair = f(middle - half * KRONROD_NODES[i]) + f(middle + half * KRONROD_NODES[i]);
            kronrod += KRONROD_WEIGHTS[i] * pair;
            if i % 2 == 1 {
                gauss += GAUSS_WEIGHTS[i / 2] * pair;
            }
        }
        IntervalPiece { from, to, value: kronrod * half, error: ((kronrod - gauss) * half).abs() }
    };
    let mut pieces = vec![piece(a, b, &mut evaluations)];
    loop {
        let value = pieces.iter().map(|p| p.value).collect::<CompensatedSum>().value();
        let error = pieces.iter().map(|p| p.error).sum::<f64>();
        let converged = tolerance.allows(error, value);
        if converged || evaluations + 30 > tolerance.evaluations || error.is_nan() {
            return Integral { value, estimated_error: error, evaluations, converged };
        }
        // Halves all pieces whose error is within a factor of the worst one at once, which keeps the number of passes small.
        let worst = pieces.iter().map(|p| p.error).fold(0.0, f64::max);
        let mut next = Vec::with_capacity(2 * pieces.len());
        let mut halved = false;
        for p in pieces {
            let middle = 0.5 * (p.from + p.to);
            let can_halve = middle > p.from.min(p.to)
                && middle < p.from.max(p.to)
                && (p.to - p.from).abs() > NARROWEST_PIECE * (b - a).abs();
            if p.error < 0.1 * worst || !can_halve || evaluations + 30 > tolerance.evaluations {
                next.push(p);
                continue;
            }
            next.push(piece(p.from, middle, &mut evaluations));
            next.push(piece(middle, p.to, &mut evaluations));
            halved = true;
        }
        pieces = next;
        if !halved {
            let value = pieces.iter().map(|p| p.value).collect::<CompensatedSum>().value();
            let error = pieces.iter().map(|p| p.error).sum::<f64>();
            return Integral { value, estimated_error: error, evaluations, converged: tolerance.allows(error, value) };
        }
    }
}

/// Returns the integral of `f` from `a` to `b` (both finite) by the tanh-sinh rule. The integrand must be analytic inside. It may have any
/// integrable singularities at the ends (logarithms, powers above −1).
///
/// `f` gets the abscissa and its distance from the nearer end. The distance is exact even where the abscissa rounds to the end. The
/// estimated error is the difference between the last two levels; each level halves the step.
/// Source: H. Takahasi, M. Mori, "Double exponential formulas for numerical integration", 1974.
///
/// ```
/// use luxmc::base::quadrature::{Tolerance, integrate_tanh_sinh};
///
/// let log = integrate_tanh_sinh(|x: f64, _| -x.ln(), 0.0, 1.0, Tolerance::relative(1e-13));
/// assert!((log.value - 1.0).abs() < 1e-14 && log.converged);
/// ```
pub fn integrate_tanh_sinh(mut f: impl FnMut(f64, f64) -> f64, a: f64, b: f64, tolerance: Tolerance) -> Integral {
    // At t = 6.1 the distance from the end, 2 exp(−π sinh t), is about the smallest normal number.
    const REACH: f64 = 6.1;
    const MOST_LEVELS: u32 = 14;
    let half = 0.5 * (b - a);
    let mut evaluations = 0;
    let mut at = |t: f64| {
        let s = std::f64::consts::FRAC_PI_2 * t.abs().sinh();
        // Distance from the nearer end as a fraction of the half-length, 2/(1 + e^{2s}), and the slope of the mapping.
        let gap = 2.0 / (1.0 + (2.0 * s).exp());
        let weight = std::f64::consts::FRAC_PI_2 * t.cosh() * gap * (2.0 - gap);
        let distance = half * gap;
        if distance == 0.0 || weight == 0.0 {
            return 0.0;
        }
        evaluations += 1;
        weight * if t < 0.0 { f(a + distance, distance) } else { f(b - distance, distance) }
    };
    let mut sum = CompensatedSum::new();
    sum.add(at(0.0));
    let mut step = 1.0;
    for k in 1..=(REACH / step) as i32 {
        sum.add(at(step * k as f64));
        sum.add(at(-step * k as f64));
    }
    let mut value = sum.value() * step * half;
    let mut error = f64::INFINITY;
    for level in 1..=MOST_LEVELS {
        step *= 0.5;
        let mut k = 1.0;
        while k * step <= REACH {
            sum.add(at(step * k));
            sum.add(at(-step * k));
            k += 2.0;
        }
        let before = value;
        value = sum.value() * step * half;
        error = (value - before).abs();
        // The first levels may agree by chance.
        if level >= 3 && tolerance.allows(error, value) {
            return Integral { value, estimated_error: error, evaluations, converged: true };
        }
        if (12.2 / step) as usize > tolerance.evaluations || value.is_nan() {
            break;
        }
    }
    Integral { value, estimated_error: error, evaluations, converged: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_is_exact_for_its_polynomials() {
        for count in [1, 2, 5, 12, 16, 40] {
            let rule = GaussLegendre::new(count);
            let power = 2 * count as i32 - 2;
            let exact = 2.0 / (power as f64 + 1.0);
            assert!((rule.integrate(-1.0, 1.0, |x| x.powi(power)) / exact - 1.0).abs() < 4e-15);
            assert!(rule.nodes().windows(2).all(|w| w[0] < w[1]));
            assert!((rule.integrate(1.0, 3.0, |x| x) - 4.0).abs() < 4e-15);
        }
    }

    #[test]
    fn kronrod_is_exact_to_degree_22() {
        for power in 0..=22 {
            let exact = (2f64.powi(power + 1) - 1.0) / (power as f64 + 1.0);
            let once = Tolerance { absolute: f64::INFINITY, relative: 0.0, evaluations: 15 };
            let value = integrate_adaptive(|x| x.powi(power), 1.0, 2.0, once).value;
            assert!((value / exact - 1.0).abs() < 1e-15, "{power}: {value} {exact}");
        }
    }

    #[test]
    fn adaptive_finds_kinks_peaks_and_singularities() {
        let tolerance = Tolerance::relative(1e-11);
        type Case = (fn(f64) -> f64, f64, f64);
        let cases: [Case; 4] = [
            (|x| (x - 0.3).abs(), 0.0, 0.29),
            (|x| -x.ln(), 0.0, 1.0),
            (|x| 1e-4 / ((x - 0.7).powi(2) + 1e-8), 0.0, (0.3e4f64).atan() + (0.7e4f64).atan()),
            (|x| 0.5 / x.sqrt(), 0.0, 1.0),
        ];
        for (f, from, exact) in cases {
            let integral = integrate_adaptive(f, from, 1.0, tolerance);
            assert!((integral.value / exact - 1.0).abs() < 1e-11, "{integral:?} against {exact}");
            assert!((integral.value - exact).abs() <= integral.estimated_error + 1e-15);
        }
    }

    #[test]
    fn a_divergent_integral_is_not_called_converged() {
        assert!(!integrate_adaptive(|x| 1.0 / x, 0.0, 1.0, Tolerance::relative(1e-9)).converged);
        assert!(!integrate_adaptive(|_| f64::NAN, 0.0, 1.0, Tolerance::relative(1e-9)).converged);
        assert!(!integrate_tanh_sinh(|_, _| f64::NAN, 0.0, 1.0, Tolerance::relative(1e-9)).converged);
    }

    #[test]
    fn tanh_sinh_takes_singular_ends() {
        let tolerance = Tolerance::relative(1e-13);
        let square_root = integrate_tanh_sinh(|x, d| 0.5 / if x < 0.5 { d } else { x }.sqrt(), 0.0, 1.0, tolerance);
        assert!((square_root.value - 1.0).abs() < 1e-14, "{square_root:?}");
        // ∫ ln²x dx = 2; ∫ eˣ dx over −1 to 2.
        let log2 = integrate_tanh_sinh(|x, _| x.ln().powi(2), 0.0, 1.0, tolerance);
        assert!((log2.value / 2.0 - 1.0).abs() < 1e-14, "{log2:?}");
        let smooth = integrate_tanh_sinh(|x, _| x.exp(), -1.0, 2.0, tolerance);
        assert!((smooth.value / (2f64.exp() - (-1f64).exp()) - 1.0).abs() < 1e-14, "{smooth:?}");
    }
}
