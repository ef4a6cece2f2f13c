//! Estimators: what a sample, a chain or a walk scores at an element or a receiver.

mod anchor_blocks;
pub mod basis;
pub mod cache;
pub mod coefficients;
pub mod contact;
pub mod control_variate;
pub mod direct;
pub mod element;
pub mod expected_light;
pub mod far_field;
pub mod gathering;
pub mod glare;
pub mod highlights;
pub mod images;
pub mod local;
pub mod luminance;
pub mod neighbours;
pub mod receiver;
pub mod reception;
pub mod roulette;
pub mod sight;
pub mod small_body;
pub mod sunlight;
pub mod walk;
#[cfg(test)]
pub mod walks_in_a_box;
