//! An infinitely long diffuse cylinder with a line source along it.

use std::f64::consts::PI;

use super::error::{AnalyticError, require, require_length, require_light, require_reflectance};

/// Illuminance on the inside of an infinitely long cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderValue {
    /// Direct illuminance from the line, lx.
    pub direct_lx: f64,
    /// Illuminance after one or more reflections, lx.
    pub indirect_lx: f64,
}

impl CylinderValue {
    /// Sum of direct and indirect illuminance, lx.
    pub fn total_lx(&self) -> f64 {
        self.direct_lx + self.indirect_lx
    }
}

/// An infinitely long diffuse cylinder with a line of isotropic points parallel to its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitCylinder {
    /// Radius, m.
    pub radius_m: f64,
    /// Reflectance, 0 to below 1.
    pub reflectance: f64,
    /// Flux per metre of the line, lm/m.
    pub flux_per_length_lm_m: f64,
    /// Distance of the line from the axis over the radius, 0 to below 1.
    pub offset: f64,
}

/// The series ends at a term below this part of the sum. The terms also fall at least as 1/m².
const NOTHING: f64 = 1e-17;

/// The terms fall as tᵐ/m² or faster. After this many terms the rest is below 1e-14 even at t = 1.
const MOST_TERMS: usize = 10_000_000;

impl LitCylinder {
    /// Illuminance at `angle_rad`, measured around the axis from the direction in which the line is offset.
    ///
    /// Units: rad, lx. Accuracy: 1e-13 of the total for offsets to 0.999. The kernel |sin(φ/2)|/4 has the eigenvalues 1/(1 − 4m²).
    /// Each Fourier term of the direct light is therefore divided by 1 − ρ/(1 − 4m²).
    ///
    /// # Errors
    /// A radius that is not positive, a reflectance or offset outside [0, 1), negative flux.
    ///
    /// ```
    /// use luxmc::analytic::cylinder::LitCylinder;
    ///
    /// let cylinder = LitCylinder { radius_m: 1.0, reflectance: 0.5, flux_per_length_lm_m: 1000.0, offset: 0.5 };
    /// assert!((cylinder.at(0.0)?.total_lx() - 464.4157).abs() < 1e-4);
    /// # Ok::<(), luxmc::analytic::AnalyticError>(())
    /// ```
    pub fn at(&self, angle_rad: f64) -> Result<CylinderValue, AnalyticError> {
        let LitCylinder { radius_m, reflectance, flux_per_length_lm_m, offset } = *self;
        require_length("the cylinder's radius", radius_m)?;
        require_light("the line's flux per length", flux_per_length_lm_m)?;
        require_reflectance("the cylinder's reflectance", reflectance)?;
        require(
            reflectance < 1.0,
            "the cylinder's reflectance",
            reflectance,
            "less than 1",
            "let the cylinder absorb",
        )?;
        let inside = (0.0..1.0).contains(&offset);
        require(inside, "the line's offset", offset, "0 to below 1 radius", "put the line into the cylinder")?;
        require(angle_rad.is_finite(), "the angle", angle_rad, "a finite angle", "give the angle in radians")?;

        let mean_lx = flux_per_length_lm_m / (2.0 * PI * radius_m);
        let cosine = angle_rad.cos();
        let direct = (1.0 - offset * cosine) / ((1.0 - offset).powi(2) + 2.0 * offset * (1.0 - cosine));
        // Term m adds λρ/(1 − λρ) of the direct light's Fourier term m to the indirect light, with the eigenvalue λ.
        let mut indirect = reflectance / (1.0 - reflectance);
        let mut power = offset;
        for m in 1..MOST_TERMS {
            let m = m as f64;
            let eigenvalue = reflectance / (1.0 - 4.0 * m * m);
            let size = power * eigenvalue / (1.0 - eigenvalue);
            indirect += size * (m * angle_rad).cos();
            if size.abs() < NOTHING * indirect.abs() * (1.0 - offset) || power == 0.0 {
                break;
            }
            power *= offset;
        }
        Ok(CylinderValue { direct_lx: mean_lx * direct, indirect_lx: mean_lx * indirect })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_values_are_met() {
        let table = [
            (0.5, 0.5, [464.4157, 287.6917, 275.5635]),
            (0.5, 0.8, [935.5306, 765.8458, 757.8112]),
            (0.5, 0.95, [3319.9980, 3153.5044, 3147.2294]),
            (0.9, 0.5, [1722.1259, 250.6277, 260.3303]),
            (0.9, 0.8, [2185.1872, 730.0966, 745.7652]),
        ];
        for (offset, reflectance, values) in table {
            let cylinder = LitCylinder { radius_m: 1.0, reflectance, flux_per_length_lm_m: 1000.0, offset };
            for (degrees, exact) in [0.0f64, 90.0, 180.0].iter().zip(values) {
                let value = cylinder.at(degrees.to_radians()).expect("valid").total_lx();
                assert!((value - exact).abs() < 6e-5, "{cylinder:?} {degrees}: {value} {exact}");
            }
        }
    }

    #[test]
    fn the_flux_balances() {
        let cylinder = LitCylinder { radius_m: 2.0, reflectance: 0.7, flux_per_length_lm_m: 300.0, offset: 0.6 };
        let steps = 400;
        let mean =
            (0..steps).map(|i| cylinder.at(2.0 * PI * i as f64 / steps as f64).expect("valid").total_lx()).sum::<f64>()
                / steps as f64;
        assert!((mean * 4.0 * PI * 0.3 / 300.0 - 1.0).abs() < 1e-13);
    }

    #[test]
    fn what_has_no_answer_is_refused() {
        let good = LitCylinder { radius_m: 1.0, reflectance: 0.5, flux_per_length_lm_m: 1.0, offset: 0.0 };
        assert!(LitCylinder { reflectance: 1.0, ..good }.at(0.0).is_err());
        assert!(LitCylinder { offset: 1.0, ..good }.at(0.0).is_err());
        assert!(LitCylinder { radius_m: -1.0, ..good }.at(0.0).is_err());
        assert!(good.at(f64::NAN).is_err());
    }
}
