//! Luminance of skies as a function of direction, and the illuminance that skies give planes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::perez::SkyClass;
use super::quadrature::GaussLegendre;

/// Gradation a, b and indicatrix c, d, e of the fifteen general skies, in the order of their types.
///
/// Source: ISO 15469:2004 (CIE S 011/E:2003), table 1.
const GENERAL: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.0],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.80, 0.0, -1.0, 0.0],
    [1.1, -0.80, 2.0, -1.5, 0.15],
    [0.0, -1.00, 0.0, -1.0, 0.0],
    [0.0, -1.00, 2.0, -1.5, 0.15],
    [0.0, -1.00, 5.0, -2.5, 0.30],
    [0.0, -1.00, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];
/// Nodes in the sine of the elevation, and steps around the horizon, of integrals over general skies. With twice as many of both, the
/// results of type 15 change by less than 1e-4.
const NODES: usize = 96;
const STEPS_AROUND: u32 = 360;

/// Least cosine from the zenith at which the all-weather sky's gradation is evaluated: half a degree above the horizon.
const LEAST_COSINE: f64 = 0.01;
/// Steps of the angle from the sun that find the largest luminance of all-weather skies, and a factor that allows for more between the
/// steps.
const ANGLES: u32 = 4096;
const BETWEEN: f64 = 1.001;

/// Distribution of luminance over a sky, relative to that of its zenith. The z axis points up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SkyPattern {
    /// The same everywhere.
    Uniform,
    /// L = L_z (1 + 2 sin γ)/3: the traditional overcast sky (Moon and Spencer, 1942; type 16 of ISO 15469).
    Overcast,
    /// One of the fifteen general skies.
    General {
        /// a, b, c, d, e.
        coefficients: [f64; 5],
        /// Unit direction of the sun.
        sun: DVec3,
    },
    /// An all-weather sky of Perez: (1 + a exp(b/cos ζ)) (1 + c exp(d χ) + e cos² χ), 0 where that is negative.
    AllWeather {
        /// a, b, c, d, e.
        coefficients: [f64; 5],
        /// Unit direction of the sun.
        sun: DVec3,
    },
}

impl SkyPattern {
    /// Returns the general sky of a type from 1 to 15, with the sun in a unit direction.
    ///
    /// ```
    /// use glam::DVec3;
    /// use luxmc::base::sky::SkyPattern;
    ///
    /// // Type 5 is uniform.
    /// let sky = SkyPattern::general(5, DVec3::Z);
    /// assert!((sky.relative_luminance(DVec3::new(0.6, 0.0, 0.8)) - 1.0).abs() < 1e-15);
    /// ```
    pub fn general(kind: usize, sun: DVec3) -> SkyPattern {
        SkyPattern::General { coefficients: GENERAL[(kind - 1).min(GENERAL.len() - 1)], sun }
    }

    /// Returns the all-weather sky of a class, with the sun in a unit direction; `None` where the model's zenith is dark.
    pub fn all_weather(class: &SkyClass, sun: DVec3) -> Option<SkyPattern> {
        let coefficients = class.coefficients();
        let is_lit = all_weather(&coefficients, 1.0, sun.z) > 0.0;
        is_lit.then_some(SkyPattern::AllWeather { coefficients, sun })
    }

    /// Returns the luminance in a unit direction above the horizon, divided by that of the zenith.
    pub fn relative_luminance(&self, towards: DVec3) -> f64 {
        match self {
            SkyPattern::Uniform => 1.0,
            SkyPattern::Overcast => (1.0 + 2.0 * towards.z.max(0.0)) / 3.0,
            SkyPattern::General { coefficients, sun } => {
                let from_sun = |cosine: f64| indicatrix(coefficients, cosine.clamp(-1.0, 1.0));
                from_sun(sun.dot(towards)) * gradation(coefficients, towards.z)
                    / (from_sun(sun.z) * gradation(coefficients, 1.0))
            }
            SkyPattern::AllWeather { coefficients, sun } => {
                all_weather(coefficients, towards.z, sun.dot(towards)) / all_weather(coefficients, 1.0, sun.z)
            }
        }
    }

    /// Returns an upper bound of the relative luminance over all directions.
    fn largest(&self) -> f64 {
        match self {
            SkyPattern::Uniform | SkyPattern::Overcast => 1.0,
            SkyPattern::General { coefficients, sun } => {
                let largest = indicatrix(coefficients, 1.0) * gradation(coefficients, 1.0).max(1.0);
                largest / (indicatrix(coefficients, sun.z) * gradation(coefficients, 1.0))
            }
            SkyPattern::AllWeather { coefficients, sun } => {
                // The gradation is largest either in the zenith or at the horizon.
                let about_sun = (0..=ANGLES).map(|step| {
                    let cosine = (PI * f64::from(step) / f64::from(ANGLES)).cos();
                    all_weather(coefficients, 1.0, cosine).max(all_weather(coefficients, LEAST_COSINE, cosine))
                });
                BETWEEN * about_sun.fold(0.0, f64::max) / all_weather(coefficients, 1.0, sun.z)
            }
        }
    }
}

/// Returns φ(Z) = 1 + a exp(b/cos Z).
fn gradation([a, b, ..]: &[f64; 5], cos_zenith_angle: f64) -> f64 {
    if cos_zenith_angle <= 0.0 { 1.0 } else { 1.0 + a * (b / cos_zenith_angle).exp() }
}

/// Returns f(χ) = 1 + c (exp dχ − exp(dπ/2)) + e cos² χ.
fn indicatrix([_, _, c, d, e]: &[f64; 5], cosine: f64) -> f64 {
    1.0 + c * ((d * cosine.acos()).exp() - (d * FRAC_PI_2).exp()) + e * cosine * cosine
}

/// Returns (1 + a exp(b/cos ζ)) (1 + c exp(d χ) + e cos² χ) from the cosines of the angles from the zenith and from the sun.
fn all_weather([a, b, c, d, e]: &[f64; 5], from_zenith: f64, from_sun: f64) -> f64 {
    let cosine = from_sun.clamp(-1.0, 1.0);
    let gradation = 1.0 + a * (b / from_zenith.max(LEAST_COSINE)).exp();
    let indicatrix = 1.0 + c * (d * cosine.acos()).exp() + e * cosine * cosine;
    gradation.max(0.0) * indicatrix.max(0.0)
}

/// A sky over a ground that reflects it diffusely.
#[derive(Clone, Copy, Debug)]
pub struct Sky {
    pattern: SkyPattern,
    ground_reflectance: f64,
    zenith_cd_m2: f64,
    ground_cd_m2: f64,
    horizontal_lx: f64,
    total_cd_sr_m2: f64,
    largest_cd_m2: f64,
}

impl Sky {
    /// Makes a sky from the luminance of its zenith in cd/m², over a ground with a reflectance.
    pub fn of_zenith(pattern: SkyPattern, zenith_cd_m2: f64, ground_reflectance: f64) -> Sky {
        let mut sky = Sky {
            pattern,
            ground_reflectance,
            zenith_cd_m2,
            ground_cd_m2: 0.0,
            horizontal_lx: 0.0,
            total_cd_sr_m2: 0.0,
            largest_cd_m2: 0.0,
        };
        sky.horizontal_lx = sky.illuminance_lx(DVec3::Z);
        sky.ground_cd_m2 = ground_reflectance * sky.horizontal_lx / PI;
        let above = match pattern {
            SkyPattern::Uniform => TAU,
            SkyPattern::Overcast => 4.0 * PI / 3.0,
            SkyPattern::General { .. } | SkyPattern::AllWeather { .. } => {
                over_hemisphere(|towards| pattern.relative_luminance(towards))
            }
        };
        sky.total_cd_sr_m2 = above * zenith_cd_m2 + TAU * sky.ground_cd_m2;
        sky.largest_cd_m2 = (zenith_cd_m2 * pattern.largest()).max(sky.ground_cd_m2);
        sky
    }

    /// Makes a sky from the illuminance in lx that the sky alone gives an open horizontal plane.
    pub fn of_horizontal(pattern: SkyPattern, horizontal_lx: f64, ground_reflectance: f64) -> Sky {
        let unit_lx = Sky::of_zenith(pattern, 1.0, 0.0).horizontal_lx;
        Sky::of_zenith(pattern, horizontal_lx / unit_lx, ground_reflectance)
    }

    /// Returns the same sky, brighter by this factor.
    pub fn scaled(&self, factor: f64) -> Sky {
        Sky {
            zenith_cd_m2: factor * self.zenith_cd_m2,
            ground_cd_m2: factor * self.ground_cd_m2,
            horizontal_lx: factor * self.horizontal_lx,
            total_cd_sr_m2: factor * self.total_cd_sr_m2,
            largest_cd_m2: factor * self.largest_cd_m2,
            ..*self
        }
    }

    /// Returns the luminance in cd/m² in a unit direction. Below the horizon it is the luminance of the ground.
    #[inline]
    pub fn luminance_cd_m2(&self, towards: DVec3) -> f64 {
        if towards.z > 0.0 { self.zenith_cd_m2 * self.pattern.relative_luminance(towards) } else { self.ground_cd_m2 }
    }

    /// Returns the reflectance of the ground.
    pub fn ground_reflectance(&self) -> f64 {
        self.ground_reflectance
    }

    /// Returns the luminance of the zenith in cd/m².
    pub fn zenith_cd_m2(&self) -> f64 {
        self.zenith_cd_m2
    }

    /// Returns an upper bound of the luminance in cd/m² over all directions.
    pub fn largest_cd_m2(&self) -> f64 {
        self.largest_cd_m2
    }

    /// Returns the illuminance in lx that the sky alone gives an open horizontal plane.
    pub fn horizontal_lx(&self) -> f64 {
        self.horizontal_lx
    }

    /// Returns ∫ L dω over all directions, the ground included, in cd·sr/m².
    pub fn total_cd_sr_m2(&self) -> f64 {
        self.total_cd_sr_m2
    }

    /// Returns the illuminance in lx on a plane with a unit normal, where only the ground hides the sky.
    ///
    /// Source: docs/methods.md (28). Accuracy: uniform and overcast skies have closed forms; the others are integrated to about 1e-4.
    pub fn illuminance_lx(&self, normal: DVec3) -> f64 {
        let cosine = normal.z.clamp(-1.0, 1.0);
        let from_ground_lx = PI * self.ground_cd_m2 * 0.5 * (1.0 - cosine);
        // ∫ cos θ dω over the directions above both the horizon and the plane.
        let of_uniform = 0.5 * PI * (1.0 + cosine);
        let relative = match self.pattern {
            SkyPattern::Uniform => of_uniform,
            SkyPattern::Overcast => {
                // ∫ sin γ cos θ dω over the same directions.
                let tilt = cosine.acos();
                let of_sine = 2.0 / 3.0 * (tilt.sin() + (PI - tilt) * cosine);
                (of_uniform + 2.0 * of_sine) / 3.0
            }
            SkyPattern::General { .. } | SkyPattern::AllWeather { .. } => {
                over_hemisphere(|towards| self.pattern.relative_luminance(towards) * normal.dot(towards).max(0.0))
            }
        };
        self.zenith_cd_m2 * relative + from_ground_lx
    }
}

/// Returns ∫ f dω over the directions above the horizon, for integrands that may change fast near the sun.
fn over_hemisphere(f: impl Fn(DVec3) -> f64) -> f64 {
    let rule = GaussLegendre::new(NODES);
    rule.integrate(0.0, 1.0, |sine| {
        let cosine = (1.0 - sine * sine).sqrt();
        let around = (0..STEPS_AROUND).map(|step| {
            let (y, x) = (TAU * (f64::from(step) + 0.5) / f64::from(STEPS_AROUND)).sin_cos();
            f(DVec3::new(cosine * x, cosine * y, sine))
        });
        around.sum::<f64>() * TAU / f64::from(STEPS_AROUND)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(one: f64, other: f64, relative: f64) -> bool {
        (one / other - 1.0).abs() < relative
    }

    /// Compares the closed forms with the rule that integrates general skies. A coefficient 1% off, the planted fault, is detected.
    #[test]
    fn the_closed_forms_are_the_integrals() {
        for pattern in [SkyPattern::Uniform, SkyPattern::Overcast] {
            let sky = Sky::of_zenith(pattern, 1000.0, 0.3);
            for normal in [DVec3::Z, DVec3::X, DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.6, -0.8)] {
                let both = |towards: DVec3| {
                    sky.luminance_cd_m2(towards) * normal.dot(towards).max(0.0)
                        + sky.luminance_cd_m2(-towards) * normal.dot(-towards).max(0.0)
                };
                let integral_lx = over_hemisphere(both);
                assert!(close(sky.illuminance_lx(normal), integral_lx, 2e-4), "{pattern:?} {normal}");
                assert!(!close(1.01 * sky.illuminance_lx(normal), integral_lx, 2e-4), "the planted fault passed");
            }
            let total = over_hemisphere(|towards| sky.luminance_cd_m2(towards) + sky.luminance_cd_m2(-towards));
            assert!(close(sky.total_cd_sr_m2(), total, 1e-9), "{pattern:?}");
        }
        let overcast = Sky::of_horizontal(SkyPattern::Overcast, 10_000.0, 0.0);
        assert!(close(overcast.zenith_cd_m2(), 10_000.0 * 9.0 / (7.0 * PI), 1e-12));
    }

    /// Compares luminances with gendaylit's skies: its scale times 179 lm/W times the formula, in the zenith and 30° off it towards and
    /// away from the sun. The skies come from the given illuminances. A sun 10° lower, the planted fault, is detected. The two integrals,
    /// the date and the rounding of ε and Δ leave 5%. No luminance exceeds its bound.
    #[test]
    fn all_weather_skies_are_as_bright_as_those_of_gendaylit() {
        for (elevation_deg, direct_lx, diffuse_lx, scale, [a, b, c, d, e]) in [
            (60.0f64, 90_000.0, 12_000.0, 30.81, [-0.990254, -0.207837, 22.226262, -6.025351, 1.319873]),
            (40.0, 60_000.0, 18_000.0, 40.02, [-1.039977, -0.297291, 13.053954, -3.454966, 0.267233]),
            (20.0, 0.0, 8_000.0, 8.510, [0.756537, -0.610142, 0.513837, -0.430850, -0.027375]),
        ] {
            let sun_at = |elevation_deg: f64| {
                let (height, flat) = elevation_deg.to_radians().sin_cos();
                DVec3::new(flat, 0.0, height)
            };
            let sky_at = |elevation_deg: f64| {
                let class = SkyClass::of_illuminance(elevation_deg, direct_lx, diffuse_lx);
                let pattern = SkyPattern::all_weather(&class, sun_at(elevation_deg)).expect("a lit zenith");
                Sky::of_horizontal(pattern, diffuse_lx, 0.0)
            };
            let agrees = |sky: &Sky| {
                [0.0f64, 0.5, -0.5].iter().all(|sine| {
                    let towards = DVec3::new(*sine, 0.0, (1.0 - sine * sine).sqrt());
                    let angle = sun_at(elevation_deg).dot(towards).acos();
                    let formula =
                        (1.0 + a * (b / towards.z).exp()) * (1.0 + c * (d * angle).exp() + e * angle.cos().powi(2));
                    close(sky.luminance_cd_m2(towards), 179.0 * scale * formula, 0.05)
                })
            };
            let sky = sky_at(elevation_deg);
            assert!(agrees(&sky), "{elevation_deg}°: {} cd/m²", sky.zenith_cd_m2());
            assert!(elevation_deg < 40.0 || !agrees(&sky_at(elevation_deg - 10.0)), "the planted fault passed");
            let all =
                over_hemisphere(|towards| f64::from(u8::from(sky.luminance_cd_m2(towards) > sky.largest_cd_m2())));
            assert_eq!(all, 0.0);
            assert!(sky.luminance_cd_m2(sun_at(elevation_deg)) <= sky.largest_cd_m2());
        }
    }

    /// Every general sky has the relative luminance 1 in its zenith, never exceeds its bound, and changes by at most 1e-4 with twice the
    /// nodes.
    #[test]
    fn general_skies_are_normalised_and_bounded() {
        for kind in 1..=15 {
            let sun = DVec3::new(0.6, 0.0, 0.8);
            let pattern = SkyPattern::general(kind, sun);
            assert!(close(pattern.relative_luminance(DVec3::Z), 1.0, 1e-12));
            let (mut largest, mut fine_lx) = (0.0f64, 0.0);
            let rule = GaussLegendre::new(2 * NODES);
            for (sine, weight) in rule.on(0.0, 1.0) {
                for step in 0..2 * STEPS_AROUND {
                    let (y, x) = (TAU * f64::from(step) / f64::from(2 * STEPS_AROUND)).sin_cos();
                    let cosine = (1.0 - sine * sine).sqrt();
                    let relative = pattern.relative_luminance(DVec3::new(cosine * x, cosine * y, sine));
                    largest = largest.max(relative);
                    fine_lx += weight * sine * relative * TAU / f64::from(2 * STEPS_AROUND);
                }
            }
            assert!(largest <= pattern.largest() && pattern.relative_luminance(sun) <= pattern.largest(), "{kind}");
            let sky = Sky::of_zenith(pattern, 1.0, 0.0);
            assert!(close(sky.horizontal_lx(), fine_lx, 1e-4), "type {kind}: {} {fine_lx}", sky.horizontal_lx());
        }
        // Type 12, the clear sky of low turbidity, 45° high at a right angle from the sun, computed by hand.
        let clear = SkyPattern::general(12, DVec3::new(1.0, 0.0, 1.0).normalize());
        let [half, quarter] = [0.5f64, 0.25].map(|turn| 1.0 + 10.0 * ((-3.0 * PI * turn).exp() - (-1.5 * PI).exp()));
        let expected = half / (quarter + 0.45 * 0.5) * (1.0 - (-0.32 * 2f64.sqrt()).exp()) / (1.0 - (-0.32f64).exp());
        assert!(close(clear.relative_luminance(DVec3::new(-1.0, 0.0, 1.0).normalize()), expected, 1e-12));
    }
}
