//! Integrals of a linear function times the sine: the flux in one zone of an intensity table.

/// Half width in rad below which `sin s − s cos s` is summed as a series. Above it, cancellation costs less than two digits.
const SERIES_BELOW_RAD: f64 = 0.25;

/// Most steps of the search. Bisection alone needs some 53; Newton's method ends after two or three.
const MAXIMUM_STEPS: usize = 64;
/// Relative size of Newton's last step. The remaining error is its square: the rounding of an f64 angle.
const LAST_STEP: f64 = 1e-8;

/// Integrals of the sine over a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SineMoments {
    /// ∫ sin θ dθ.
    pub whole: f64,
    /// ∫ t sin θ dθ, with t rising from 0 to 1 over the zone.
    pub ramp: f64,
    /// The sine at the zone's end.
    pub end_sine: f64,
}

/// Integrals over the zone from `from_rad` to `from_rad + width_rad`, 0 ≤ θ ≤ π.
///
/// Both are taken about the middle m of the zone with half width s. There they are 2 sin m sin s and sin m sin s + cos m (sin s − s cos
/// s)/s, so thin zones lose no digits.
/// Accuracy: some 1e-15 of `whole`.
pub(crate) fn sine_moments(from_rad: f64, width_rad: f64) -> SineMoments {
    if width_rad <= 0.0 {
        return SineMoments { whole: 0.0, ramp: 0.0, end_sine: from_rad.sin() };
    }
    let half = 0.5 * width_rad;
    let (sin_middle, cos_middle) = (from_rad + half).sin_cos();
    let (sin_half, cos_half) = half.sin_cos();
    let skew = match half < SERIES_BELOW_RAD {
        true => skew_series(half),
        false => (sin_half - half * cos_half) / half,
    };
    let even = sin_middle * sin_half;
    SineMoments {
        whole: 2.0 * even,
        ramp: even + cos_middle * skew,
        end_sine: sin_middle * cos_half + cos_middle * sin_half,
    }
}

/// (sin s − s cos s)/s = s²/3 − s⁴/30 + s⁶/840 − s⁸/45360 + …; the first omitted term is below 1e-17 at s = 0.25.
fn skew_series(half: f64) -> f64 {
    let square = half * half;
    let tail = 1.0 / 840.0 - square * (1.0 / 45_360.0 - square * (1.0 / 3_991_680.0 - square / 518_918_400.0));
    square * (1.0 / 3.0 - square * (1.0 / 30.0 - square * tail))
}

/// A zone of a plane: its ends and the intensities there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Zone {
    /// Angle in rad at which it begins.
    pub from_rad: f64,
    /// Its width in rad.
    pub width_rad: f64,
    /// Sines of the angles at its ends.
    pub sines: [f64; 2],
    /// Intensities in cd at its ends, linear between.
    pub intensities_cd: [f64; 2],
}

impl Zone {
    /// Returns the offset in rad from the zone's beginning up to which it holds `target_lm_rad` of its `mass_lm_rad`.
    ///
    /// It uses Newton's method within a shrinking bracket. A step below 1e-8 of the offset is the last one. The remaining error is some
    /// 1e-15 of the offset. The worst case is 1e-8 of the width, at the far end where intensity or sine vanish.
    pub fn offset_rad_holding(&self, target_lm_rad: f64, mass_lm_rad: f64) -> f64 {
        if mass_lm_rad <= 0.0 {
            return 0.0;
        }
        let [from_cd, to_cd] = self.intensities_cd;
        let slope = (to_cd - from_cd) / self.width_rad;
        let share = (target_lm_rad / mass_lm_rad).clamp(0.0, 1.0);
        let (mut low, mut high) = (0.0, self.width_rad);
        let mut offset = self.width_rad * invert_linear(from_cd * self.sines[0], to_cd * self.sines[1], share);
        for _ in 0..MAXIMUM_STEPS {
            let moments = sine_moments(self.from_rad, offset);
            let excess = from_cd * moments.whole + slope * offset * moments.ramp - target_lm_rad;
            if excess > 0.0 {
                high = offset;
            } else {
                low = offset;
            }
            let newton = offset - excess / ((from_cd + slope * offset) * moments.end_sine);
            if (newton - offset).abs() <= LAST_STEP * offset {
                return newton.clamp(low, high);
            }
            offset = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        offset
    }
}

/// Position on 0 to 1 at which a linear density from `from` to `to` reaches `share` of its integral.
pub(crate) fn invert_linear(from: f64, to: f64, share: f64) -> f64 {
    let twice_mass = (from + to) * share;
    let root = (from * from + (to - from) * twice_mass).max(0.0).sqrt();
    if from + root > 0.0 { (twice_mass / (from + root)).clamp(0.0, 1.0) } else { share }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Independent calculation: 200,000 midpoints of the integrand itself.
    fn by_midpoints(from: f64, width: f64, ramp: bool) -> f64 {
        let n = 200_000;
        let weight = |t: f64| if ramp { t } else { 1.0 };
        let value = |i: usize| (i as f64 + 0.5) / n as f64;
        (0..n).map(|i| weight(value(i)) * (from + width * value(i)).sin()).sum::<f64>() * width / n as f64
    }

    #[test]
    fn moments_agree_with_midpoint_sums() {
        for (from, width) in
            [(0.0, 0.01), (0.0, std::f64::consts::PI), (1.0, 0.5), (1.0, 0.49), (3.0, 0.14), (1.5, 1e-4)]
        {
            let moments = sine_moments(from, width);
            let (whole, ramp) = (by_midpoints(from, width, false), by_midpoints(from, width, true));
            assert!((moments.whole - whole).abs() < 1e-10 * whole, "whole {from} {width}: {} {whole}", moments.whole);
            assert!((moments.ramp - ramp).abs() < 1e-10 * ramp, "ramp {from} {width}: {} {ramp}", moments.ramp);
        }
    }

    #[test]
    fn inversion_undoes_the_integral() {
        for (from, width, a, b) in
            [(0.0, 0.1, 5.0, 0.0), (0.0, 3.1, 1.0, 2.0), (1.2, 0.3, 0.0, 9.0), (2.0, 1.14, 1.0, 0.0)]
        {
            for offset in [1e-6, 0.1, 0.5, 0.9, 0.999].map(|t| t * width) {
                let moments = sine_moments(from, offset);
                let target = a * moments.whole + (b - a) * offset / width * moments.ramp;
                let sines = [from.sin(), (from + width).sin()];
                let zone = Zone { from_rad: from, width_rad: width, sines, intensities_cd: [a, b] };
                let whole = sine_moments(from, width);
                let found = zone.offset_rad_holding(target, a * whole.whole + (b - a) * whole.ramp);
                assert!((found - offset).abs() < 1e-9 * width, "{from} {width} {a} {b}: {found} for {offset}");
            }
        }
    }
}
