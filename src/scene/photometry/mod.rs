//! Photometric files: IES LM-63 and EULUMDAT, read into one form.

mod stub;
mod web;

pub use stub::{PhotometricError, PhotometricFile, read_photometric_file};
pub use web::IntensityWeb;
