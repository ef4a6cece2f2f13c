//! The luminous intensity distribution of a luminaire: a table in (C, γ), bilinear between its entries.

/// Luminous intensity in cd over the whole sphere, bilinear in the angles C and γ.
///
/// Planes run from C = 0° to C = 360° (the last repeats the first), γ from 0° (the luminaire's axis) to 180°;
/// a hemisphere that the file leaves out is 0 cd.
#[derive(Clone, Debug, PartialEq)]
pub struct IntensityWeb {
    /// C angles in degrees, strictly increasing, first 0 and last 360.
    pub c_deg: Vec<f64>,
    /// γ angles in degrees, strictly increasing.
    pub gamma_deg: Vec<f64>,
    /// Intensity in cd: `intensity_cd[plane * gamma_deg.len() + i]`.
    pub intensity_cd: Vec<f64>,
}
