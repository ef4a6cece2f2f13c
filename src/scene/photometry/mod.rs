//! Photometric files: IES LM-63 and EULUMDAT, read into one form.

mod error;
mod eulumdat;
mod file;
mod ies;
mod ies_body;
mod planes;
mod read;
mod text;
mod web;
pub(crate) mod zones;

pub use error::PhotometricError;
pub(crate) use eulumdat::DIRECT_RATIOS;
pub use eulumdat::parse_eulumdat;
pub(super) use file::LARGEST_OPENING_M;
pub use file::{LampSet, LateralSymmetry, Opening, PhotometricFile, PhotometricFormat};
pub use ies::parse_ies;
pub use read::read_photometric_file;
pub use web::{IntensityWeb, PhotometricType, WebError};
