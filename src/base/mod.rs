//! Formulas and numbers that know nothing of scenes: special functions, quadrature, solid angles, exact sums.
