//! Estimators: what a sample, a chain or a walk scores at an element or a receiver.

pub mod direct;
pub mod images;
pub mod reception;
pub mod walk;
