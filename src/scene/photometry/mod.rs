//! Photometric files: IES LM-63 and EULUMDAT, read into one form.

mod web;

pub use web::IntensityWeb;
