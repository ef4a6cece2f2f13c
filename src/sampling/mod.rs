//! How light is drawn: directions in proportion to what a source emits, each with its density and total.

pub mod web;
