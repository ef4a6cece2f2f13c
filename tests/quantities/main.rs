//! Quantities of receivers: cylinders, luminance, glare, direct light alone.

#[path = "../common/mod.rs"]
mod common;

mod cylinders;
mod emergency;
mod glare;
mod luminance;
mod luminance_in_mirrors;
mod luminance_of_elements;
