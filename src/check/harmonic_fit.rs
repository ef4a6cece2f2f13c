//! A smooth body fitted to a closed mesh.

use std::f64::consts::PI;

use glam::DVec3;
use thiserror::Error;

use crate::base::harmonics::{HarmonicSeries, direction, harmonics_at};
use crate::base::quadrature::GaussLegendre;
use crate::geometry::Tracer;
use crate::scene::{Scene, Side};

/// Least number of rows of directions, and number of rows per degree.
const LEAST_ROWS: usize = 96;
const ROWS_A_DEGREE: usize = 6;

/// A body of spherical harmonics, compared with the mesh that it was fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicFit {
    /// Its radius in m as a function of direction.
    pub series: HarmonicSeries,
    /// Origin of the radius in m: the mesh's centre of volume.
    pub center_m: DVec3,
    /// Mean radius over all directions in m.
    pub mean_radius_m: f64,
    /// Root mean square of the differences between the radii, over all directions, in m.
    pub rms_error_m: f64,
    /// Largest difference between the radii in m.
    pub largest_error_m: f64,
    /// Root mean square of the angle between the normals, in degrees.
    pub rms_normal_error_deg: f64,
    /// Number of directions that were compared.
    pub directions: usize,
}

/// Why no body can be fitted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NoFit {
    /// A ray from the centre does not meet the mesh exactly once.
    #[error(
        "the mesh is not star-shaped: a ray from {center_m:.4} m in the direction {direction:.3} hits it {crossings} times"
    )]
    NotStarShaped {
        /// The mesh's centre of volume in m.
        center_m: DVec3,
        /// Unit vector.
        direction: DVec3,
        /// How often a ray meets the mesh.
        crossings: usize,
    },
}

/// Fits the radius over all directions by least squares. By orthogonality the coefficients are c_lm = ∫ r Y_lm dω.
///
/// Accuracy: the integral uses a Gauss–Legendre rule in cos θ and equal steps in φ, fine compared with the degree. Kinks of the mesh
/// between the directions are not seen.
///
/// # Errors
/// If some direction from the mesh's centre of volume does not meet the mesh exactly once.
pub fn fit_harmonics(scene: &Scene, degree: usize) -> Result<HarmonicFit, NoFit> {
    let tracer = Tracer::new(scene);
    let center_m = center_of_volume_m(scene);
    let origin = tracer.free_origin(center_m);
    let rows = LEAST_ROWS.max(ROWS_A_DEGREE * degree);
    let columns = 2 * rows;
    let rule = GaussLegendre::new(rows);
    let mut coefficients = vec![0.0; (degree + 1) * (degree + 1)];
    let mut met = Vec::with_capacity(rows * columns);
    for (z, weight) in rule.on(-1.0, 1.0) {
        for column in 0..columns {
            let towards = direction(z, 2.0 * PI * (column as f64 + 0.5) / columns as f64);
            let mut crossed = tracer.crossings(&origin, towards);
            // A ray through an edge meets both of its triangles.
            crossed.dedup_by(|one, other| (one.distance_m - other.distance_m).abs() < 1e-5 * one.distance_m);
            let [only] = crossed[..] else {
                return Err(NoFit::NotStarShaped { center_m, direction: towards, crossings: crossed.len() });
            };
            let front = scene.triangle_normal(only.triangle);
            let outward = if only.side == Side::Front { -front } else { front };
            let weight = weight * 2.0 * PI / columns as f64;
            for (sum, value) in coefficients.iter_mut().zip(harmonics_at(degree, towards)) {
                *sum += weight * only.distance_m * value;
            }
            met.push((weight / (4.0 * PI), towards, only.distance_m, outward));
        }
    }
    let series = HarmonicSeries::new(coefficients);
    let (mut square_m2, mut largest_error_m, mut square_rad2, mut mean_radius_m) = (0.0, 0.0f64, 0.0, 0.0);
    for (weight, towards, distance_m, outward) in &met {
        let (radius_m, slope_m) = series.value_and_slope(*towards);
        mean_radius_m += weight * distance_m;
        square_m2 += weight * (radius_m - distance_m).powi(2);
        largest_error_m = largest_error_m.max((radius_m - distance_m).abs());
        square_rad2 += weight * (radius_m * *towards - slope_m).angle_between(*outward).powi(2);
    }
    Ok(HarmonicFit {
        series,
        center_m,
        mean_radius_m,
        rms_error_m: square_m2.sqrt(),
        largest_error_m,
        rms_normal_error_deg: square_rad2.sqrt().to_degrees(),
        directions: met.len(),
    })
}

/// Returns the centre of the volume that a closed mesh encloses, in m.
fn center_of_volume_m(scene: &Scene) -> DVec3 {
    let middle_m = scene.vertices_m.iter().sum::<DVec3>() / scene.vertices_m.len().max(1) as f64;
    let (mut volume_m3, mut moment) = (0.0, DVec3::ZERO);
    for triangle in 0..scene.triangles.len() as u32 {
        let [a, b, c] = scene.corners_m(triangle).map(|corner| corner - middle_m);
        let of_six_m3 = a.dot(b.cross(c));
        volume_m3 += of_six_m3;
        moment += of_six_m3 * (a + b + c) / 4.0;
    }
    if volume_m3 == 0.0 { middle_m } else { middle_m + moment / volume_m3 }
}
