//! The all-weather sky: the parameters of its luminance, from how much light comes from the sun and how much from the sky.
//!
//! Source: R. Perez, R. Seals and J. Michalsky, All-weather model for sky luminance distribution, Solar Energy 50 (1993) 235–245; luminous
//! efficacies by R. Perez, P. Ineichen, R. Seals, J. Michalsky and R. Stewart, Solar Energy 44 (1990) 271–289.

use std::f64::consts::FRAC_PI_2;

/// Lower limits of the clearness of all eight categories but the first.
const CATEGORIES: [f64; 7] = [1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2];
/// For each category and each of a, b, c, d and e: x₁, x₂, x₃ and x₄ of x₁ + x₂ Z + Δ (x₃ + x₄ Z).
const COEFFICIENTS: [[[f64; 4]; 5]; 8] = [
    [
        [1.3525, -0.2576, -0.2690, -1.4366],
        [-0.7670, 0.0007, 1.2734, -0.1233],
        [2.8000, 0.6004, 1.2375, 1.0000],
        [1.8734, 0.6297, 0.9738, 0.2809],
        [0.0356, -0.1246, -0.5718, 0.9938],
    ],
    [
        [-1.2219, -0.7730, 1.4148, 1.1016],
        [-0.2054, 0.0367, -3.9128, 0.9156],
        [6.9750, 0.1774, 6.4477, -0.1239],
        [-1.5798, -0.5081, -1.7812, 0.1080],
        [0.2624, 0.0672, -0.2190, -0.4285],
    ],
    [
        [-1.1000, -0.2515, 0.8952, 0.0156],
        [0.2782, -0.1812, -4.5000, 1.1766],
        [24.7219, -13.0812, -37.7000, 34.8438],
        [-5.0000, 1.5218, 3.9229, -2.6204],
        [-0.0156, 0.1597, 0.4199, -0.5562],
    ],
    [
        [-0.5484, -0.6654, -0.2672, 0.7117],
        [0.7234, -0.6219, -5.6812, 2.6297],
        [33.3389, -18.3000, -62.2500, 52.0781],
        [-3.5000, 0.0016, 1.1477, 0.1062],
        [0.4659, -0.3296, -0.0876, -0.0329],
    ],
    [
        [-0.6000, -0.3566, -2.5000, 2.3250],
        [0.2937, 0.0496, -5.6812, 1.8415],
        [21.0000, -4.7656, -21.5906, 7.2492],
        [-3.5000, -0.1554, 1.4062, 0.3988],
        [0.0032, 0.0766, -0.0656, -0.1294],
    ],
    [
        [-1.0156, -0.3670, 1.0078, 1.4051],
        [0.2875, -0.5328, -3.8500, 3.3750],
        [14.0000, -0.9999, -7.1406, 7.5469],
        [-3.4000, -0.1078, -1.0750, 1.5702],
        [-0.0672, 0.4016, 0.3017, -0.4844],
    ],
    [
        [-1.0000, 0.0211, 0.5025, -0.5119],
        [-0.3000, 0.1922, 0.7023, -1.6317],
        [19.0000, -5.0000, 1.2438, -1.9094],
        [-4.0000, 0.0250, 0.3844, 0.2656],
        [1.0468, -0.3788, -2.4517, 1.4656],
    ],
    [
        [-1.0500, 0.0289, 0.4260, 0.3590],
        [-0.3250, 0.1156, 0.7781, 0.0025],
        [31.0625, -14.5000, -46.1148, 55.3750],
        [-7.2312, 0.4050, 13.3500, 0.6234],
        [1.5000, -0.6426, 1.8564, 0.5636],
    ],
];
/// Luminous efficacy of diffuse light in lm/W: a + b W + c cos Z + d ln Δ.
const OF_DIFFUSE: [[f64; 4]; 8] = [
    [97.24, -0.46, 12.00, -8.91],
    [107.22, 1.15, 0.59, -3.95],
    [104.97, 2.96, -5.53, -8.77],
    [102.39, 5.59, -13.95, -13.90],
    [100.71, 5.94, -22.75, -23.74],
    [106.42, 3.83, -36.15, -28.83],
    [141.88, 1.90, -53.24, -14.03],
    [152.23, 0.35, -45.27, -7.98],
];
/// Luminous efficacy of the sun's light in lm/W: a + b W + c exp(5.73 Z − 5) + d Δ.
const OF_DIRECT: [[f64; 4]; 8] = [
    [57.20, -4.55, -2.98, 117.12],
    [98.99, -3.46, -1.21, 12.38],
    [109.83, -4.90, -1.71, -8.81],
    [110.34, -5.84, -1.99, -4.56],
    [106.36, -3.97, -1.75, -6.16],
    [107.19, -1.25, -1.51, -26.73],
    [105.75, 0.77, -1.26, -34.44],
    [101.18, 1.58, -1.10, -8.29],
];
/// Precipitable water W in cm.
const WATER_CM: f64 = 2.0;
/// Irradiance outside the atmosphere in W/m², at the mean distance of the sun.
const SOLAR_CONSTANT_W_M2: f64 = 1367.0;
/// Ranges of clearness and brightness in which the model was fitted.
const CLEARNESS: [f64; 2] = [1.0, 12.01];
const BRIGHTNESS: [f64; 2] = [0.01, 0.6];
/// Least brightness of the middle categories. Below it their coefficient c becomes negative.
const LEAST_BETWEEN: f64 = 0.2;
/// Least efficacy of a low sun's light in lm/W. The formula falls below 0 there.
const LEAST_LM_W: f64 = 20.0;
/// Iterations that find irradiances from illuminances. Each halves the remaining error.
const HALVINGS: usize = 60;

/// The parameters that distinguish one sky from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyClass {
    /// Angle of the sun from the zenith in radians.
    zenith_angle_rad: f64,
    /// Clearness ε.
    pub clearness: f64,
    /// Brightness Δ.
    pub brightness: f64,
}

impl SkyClass {
    /// Makes the class from the sun's direct irradiance on a plane across its rays and the sky's diffuse irradiance on a horizontal plane,
    /// in W/m².
    pub fn of_irradiance(sun_elevation_deg: f64, direct_w_m2: f64, diffuse_w_m2: f64) -> SkyClass {
        let zenith_angle_rad = FRAC_PI_2 - sun_elevation_deg.to_radians();
        let cube = 1.041 * zenith_angle_rad.powi(3);
        let clearness = ((diffuse_w_m2 + direct_w_m2) / diffuse_w_m2 + cube) / (1.0 + cube);
        // Relative air mass according to Kasten (1966).
        let air_mass = 1.0 / (zenith_angle_rad.cos() + 0.15 * (sun_elevation_deg + 3.885).powf(-1.253));
        let brightness = air_mass * diffuse_w_m2 / SOLAR_CONSTANT_W_M2;
        SkyClass {
            zenith_angle_rad,
            clearness: clearness.clamp(CLEARNESS[0], CLEARNESS[1]),
            brightness: brightness.clamp(BRIGHTNESS[0], BRIGHTNESS[1]),
        }
    }

    /// Makes the class from illuminances in lx. It first finds the irradiances that cause them.
    pub fn of_illuminance(sun_elevation_deg: f64, direct_lx: f64, diffuse_lx: f64) -> SkyClass {
        let mut efficacies_lm_w = [100.0, 120.0];
        let class = |[direct_lm_w, diffuse_lm_w]: [f64; 2]| {
            SkyClass::of_irradiance(sun_elevation_deg, direct_lx / direct_lm_w, diffuse_lx / diffuse_lm_w)
        };
        for _ in 0..HALVINGS {
            let found_lm_w = class(efficacies_lm_w).efficacies_lm_w();
            efficacies_lm_w = [0, 1].map(|part| 0.5 * (efficacies_lm_w[part] + found_lm_w[part]));
        }
        class(efficacies_lm_w)
    }

    fn category(&self) -> usize {
        CATEGORIES.partition_point(|least| *least <= self.clearness)
    }

    /// Returns the luminous efficacies of the sun's and the sky's light in lm/W.
    pub fn efficacies_lm_w(&self) -> [f64; 2] {
        let [a, b, c, d] = OF_DIRECT[self.category()];
        let direct = a + b * WATER_CM + c * (5.73 * self.zenith_angle_rad - 5.0).exp() + d * self.brightness;
        let [a, b, c, d] = OF_DIFFUSE[self.category()];
        let diffuse = a + b * WATER_CM + c * self.zenith_angle_rad.cos() + d * self.brightness.ln();
        [direct, diffuse].map(|lm_w| lm_w.max(LEAST_LM_W))
    }

    /// Returns a, b, c, d and e of (1 + a exp(b/cos ζ)) (1 + c exp(d χ) + e cos² χ).
    pub fn coefficients(&self) -> [f64; 5] {
        let (category, z) = (self.category(), self.zenith_angle_rad);
        let is_between = (CATEGORIES[0]..CATEGORIES[4]).contains(&self.clearness);
        let delta = if is_between { self.brightness.max(LEAST_BETWEEN) } else { self.brightness };
        let mut found =
            COEFFICIENTS[category].map(|[one, two, three, four]| one + two * z + delta * (three + four * z));
        if category == 0 {
            let [_, _, c, d, _] = COEFFICIENTS[0];
            found[2] = (delta * (c[0] + c[1] * z)).powf(c[2]).exp() - c[3];
            found[3] = -(delta * (d[0] + d[1] * z)).exp() + d[2] + delta * d[3];
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values from Radiance's gendaylit for skies of all eight categories: the sun's elevation in degrees, clearness ε, brightness Δ, then
    /// a to e.
    const GENDAYLIT: [[f64; 8]; 10] = [
        [30.0, 1.3796, 0.2535, -1.132278, -0.740020, 10.716122, -3.107520, 0.110428],
        [60.0, 2.0875, 0.2283, -1.079536, -0.757202, 14.442220, -3.212666, 0.012863],
        [55.0, 5.3519, 0.1120, -0.965845, -0.215582, 15.954347, -3.923481, 0.641021],
        [40.0, 3.3643, 0.1646, -0.968163, -0.326375, 13.036123, -3.445475, 0.263343],
        [40.0, 3.9488, 0.1325, -1.039977, -0.297291, 13.053954, -3.454966, 0.267233],
        [20.0, 1.0, 0.1389, 0.756537, -0.610142, 0.513837, -0.430850, -0.027375],
        [60.0, 9.4813, 0.0727, -0.990254, -0.207837, 22.226262, -6.025351, 1.319873],
        [10.0, 4.0264, 0.1447, -1.098292, -0.331635, 13.095428, -3.388819, 0.439325],
        [50.0, 1.7384, 0.2304, -0.960034, -0.596549, 14.598650, -3.217428, 0.210326],
        [35.0, 1.1629, 0.2119, -1.440024, -0.813089, 8.486435, -2.423030, 0.193333],
    ];

    /// The tolerance is the rounding of ε and Δ to four digits. A brightness 2% off, the planted fault, is detected.
    #[test]
    fn coefficients_are_those_of_gendaylit() {
        for [elevation_deg, clearness, brightness, expected @ ..] in GENDAYLIT {
            let agrees = |brightness: f64| {
                let zenith_angle_rad = FRAC_PI_2 - elevation_deg.to_radians();
                let found = SkyClass { zenith_angle_rad, clearness, brightness }.coefficients();
                found
                    .iter()
                    .zip(expected)
                    .all(|(found, expected)| (found - expected).abs() < 1e-3 * expected.abs().max(1.0))
            };
            assert!(agrees(brightness), "{elevation_deg}° {clearness}");
            assert!(!agrees(1.02 * brightness), "the planted fault passed");
        }
    }

    /// gendaylit's classes on 1 January, when the sun is near and 1.035 times as bright as on average: from irradiances of 600 and 150 W/m²
    /// and of 250 and 250 W/m², and from illuminances.
    #[test]
    fn classes_are_those_of_gendaylit() {
        let near = 1.0351;
        for (class, clearness, brightness, tolerance) in [
            (SkyClass::of_irradiance(40.0, 600.0, 150.0), 3.3643, 0.1646, 5e-4),
            (SkyClass::of_irradiance(50.0, 250.0, 250.0), 1.7384, 0.2304, 5e-4),
            (SkyClass::of_illuminance(40.0, 60_000.0, 18_000.0), 3.9488, 0.1325, 0.02),
            (SkyClass::of_illuminance(60.0, 90_000.0, 12_000.0), 9.4813, 0.0727, 0.02),
            (SkyClass::of_illuminance(20.0, 0.0, 8_000.0), 1.0, 0.1389, 0.02),
            (SkyClass::of_illuminance(35.0, 5_000.0, 20_000.0), 1.1629, 0.2119, 0.02),
        ] {
            assert!((class.clearness / clearness - 1.0).abs() < tolerance, "{class:?}, {clearness}");
            assert!((class.brightness / (near * brightness) - 1.0).abs() < tolerance, "{class:?}, {brightness}");
        }
    }
}
