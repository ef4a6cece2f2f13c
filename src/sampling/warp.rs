//! Warps: uniform variates turned into directions and points.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Two unit vectors that make a right-handed frame with a unit normal (after Duff et al., 2017, "Building an
/// orthonormal basis, revisited": no branch, no loss of digits near −z).
#[inline]
pub fn tangents(normal: DVec3) -> [DVec3; 2] {
    let sign = 1.0f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

/// A direction about a normal with density cos θ / π per sr.
#[inline]
pub fn cosine_hemisphere(normal: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    let radius = u.sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    let [t, b] = tangents(normal);
    // 1 − u never reaches 0, since u stays below 1: the direction always leaves the surface.
    t * (radius * cos) + b * (radius * sin) + normal * (1.0 - u).sqrt()
}

/// A direction with density 1 / 4π per sr.
#[inline]
pub fn uniform_sphere([u, v]: [f64; 2]) -> DVec3 {
    let z = 1.0 - 2.0 * u;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    DVec3::new(radius * cos, radius * sin, z)
}

/// A direction uniform in the cone of half-angle arccos `cos_max` about an axis; density 1 / (2π(1 − cos_max)).
///
/// `one_minus_cos_max` is passed, not cos_max, so that narrow cones keep their digits.
#[inline]
pub fn uniform_cone(axis: DVec3, one_minus_cos_max: f64, [u, v]: [f64; 2]) -> DVec3 {
    let drop = u * one_minus_cos_max;
    let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    let [t, b] = tangents(axis);
    t * (radius * cos) + b * (radius * sin) + axis * (1.0 - drop)
}

/// Barycentric coordinates (weights of the second and third corner) of a point uniform in a triangle.
#[inline]
pub fn uniform_triangle([u, v]: [f64; 2]) -> [f64; 2] {
    let root = u.sqrt();
    [root * (1.0 - v), root * v]
}

/// Density of [`cosine_hemisphere`] per sr.
#[inline]
pub fn cosine_hemisphere_pdf_per_sr(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) / PI
}
