//! Formulas and numbers that do not depend on scenes: special functions, quadrature, solid angles, exact sums.

pub mod ball;
pub mod form_factors;
pub mod glare;
pub mod half_samples;
pub mod harmonics;
pub mod linked_sets;
pub mod memory;
pub mod pane;
pub mod pareto;
pub mod perez;
pub mod polygon;
pub mod position_index;
pub mod quadrature;
pub mod scattered;
pub mod sky;
pub mod sky_patches;
pub mod solar_position;
pub mod solid_angle;
pub mod special;
pub mod standard_rooms;
pub mod sum;
pub mod sun;
