//! STUB, to be deleted when the readers of photometric files land: it has their signatures and refuses every file.

use std::path::Path;

use super::IntensityWeb;

/// A photometric file.
#[derive(Clone, Debug)]
pub struct PhotometricFile {
    /// The distribution in cd, with all factors of the file.
    pub web: IntensityWeb,
    /// Electric power in W.
    pub power_w: Option<f64>,
    /// What the reader of the file should know.
    pub warnings: Vec<String>,
}

/// Why a photometric file is refused.
#[derive(Debug, thiserror::Error)]
#[error("photometric files are not read yet")]
pub struct PhotometricError;

/// Refuses every file.
///
/// # Errors
///
/// Always.
pub fn read_photometric_file(_path: &Path) -> Result<PhotometricFile, PhotometricError> {
    Err(PhotometricError)
}

impl IntensityWeb {
    /// Luminous flux in lm.
    pub fn luminous_flux_lm(&self) -> f64 {
        0.0
    }
}
