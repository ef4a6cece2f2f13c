//! The facts of smooth bodies that were read.

use serde::Serialize;

use crate::scene::{Body, Scene};

/// A smooth body of spherical harmonics.
#[derive(Clone, Debug, Serialize)]
pub struct InspectedBody {
    /// Name of the geometry.
    pub name: String,
    /// Largest degree of its series.
    pub degree: usize,
    /// Number of harmonics, (degree + 1)².
    pub harmonics: usize,
    /// Area in m², by quadrature over the smooth body.
    pub area_m2: f64,
    /// Volume in m³.
    pub volume_m3: f64,
    /// Bounds of the radius in m, over all directions.
    pub radius_bounds_m: [f64; 2],
    /// Centre in m.
    pub center_m: [f64; 3],
}

/// Returns all smooth bodies of a scene.
pub(super) fn bodies_of(scene: &Scene) -> Vec<InspectedBody> {
    let inspected = |body: &Body| InspectedBody {
        name: scene.surface_of(body.triangles.start).geometry.clone(),
        degree: body.series.degree(),
        harmonics: body.series.coefficients().len(),
        area_m2: body.area_m2(),
        volume_m3: body.volume_m3(),
        radius_bounds_m: [body.bounds.low, body.bounds.high],
        center_m: body.center_m.to_array(),
    };
    scene.bodies.iter().map(|body| inspected(body)).collect()
}
