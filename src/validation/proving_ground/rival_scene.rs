//! Writes a scene in the format of the rival program: little-endian 32-bit numbers, triangles with reflectances, luminaires,
//! receivers.
//!
//! The rival supports diffuse surfaces, isotropic points, and at most 64 Lambertian triangles that emit from their fronts. A
//! Lambertian point is converted to a triangle of 2 mm.

use glam::DVec3;

use crate::scene::{BsdfParameters, Emission, Luminaire, Scene};

/// Maximum number of emitting triangles of the rival.
const MOST_SHINING: usize = 64;
/// Side of the triangle that replaces a Lambertian point, in m.
const POINT_SIDE_M: f64 = 2e-3;

/// The scene as bytes, or the reason why the rival cannot represent it.
pub fn rival_scene(scene: &Scene) -> Result<Vec<u8>, String> {
    let mut reflectances = Vec::with_capacity(scene.triangles.len());
    for triangle in 0..scene.triangles.len() as u32 {
        let material = &scene.materials[scene.surface_of(triangle).material as usize];
        match material.bsdf {
            BsdfParameters::Diffuse { reflectance } => reflectances.push(reflectance),
            _ => return Err(format!("\"{}\" is not diffuse", material.name)),
        }
    }
    let mut points = Vec::new();
    let mut shining = Vec::new();
    for luminaire in &scene.luminaires {
        add_luminaire(scene, luminaire, &mut points, &mut shining)?;
    }
    if shining.len() > MOST_SHINING {
        return Err(format!("{} luminous triangles; it takes at most {MOST_SHINING}", shining.len()));
    }
    let receivers = || scene.receivers.iter().flat_map(|set| &set.points);

    let counts = [scene.vertices_m.len(), scene.triangles.len(), points.len(), shining.len(), receivers().count()];
    let mut bytes: Vec<u8> = counts.into_iter().flat_map(|count| (count as i32).to_le_bytes()).collect();
    let put = |bytes: &mut Vec<u8>, place: DVec3| {
        bytes.extend(place.as_vec3().to_array().into_iter().flat_map(|number| number.to_le_bytes()));
    };
    scene.vertices_m.iter().for_each(|vertex| put(&mut bytes, *vertex));
    bytes.extend(scene.triangles.iter().flatten().flat_map(|vertex| vertex.to_le_bytes()));
    reflectances.iter().for_each(|reflectance| put_number(&mut bytes, *reflectance));
    for (position_m, intensity_cd) in points {
        put(&mut bytes, position_m);
        put_number(&mut bytes, intensity_cd);
    }
    for ShiningTriangle { corners_m, exitance_lm_m2 } in shining {
        corners_m.into_iter().for_each(|corner| put(&mut bytes, corner));
        put_number(&mut bytes, exitance_lm_m2);
    }
    for point in receivers() {
        put(&mut bytes, point.position_m);
        put(&mut bytes, point.normal);
    }
    Ok(bytes)
}

fn put_number(bytes: &mut Vec<u8>, number: f64) {
    bytes.extend(DVec3::splat(number).as_vec3().x.to_le_bytes());
}

/// A triangle that emits from its front.
struct ShiningTriangle {
    corners_m: [DVec3; 3],
    exitance_lm_m2: f64,
}

fn add_luminaire(
    scene: &Scene,
    luminaire: &Luminaire,
    points: &mut Vec<(DVec3, f64)>,
    shining: &mut Vec<ShiningTriangle>,
) -> Result<(), String> {
    match &luminaire.emission {
        Emission::Isotropic { position_m, intensity_cd } => points.push((*position_m, *intensity_cd)),
        Emission::Lambertian { position_m, axis, .. } => {
            let (first, second) = axis.any_orthonormal_pair();
            let radius_m = POINT_SIDE_M / 3f64.sqrt();
            let corner = |third: f64| {
                let (sin, cos) = (std::f64::consts::TAU * third / 3.0).sin_cos();
                *position_m + radius_m * (cos * first + sin * second)
            };
            let corners_m = [corner(0.0), corner(1.0), corner(2.0)];
            // The rival computes with rounded corners. The area that converts flux to exitance uses the same rounding.
            let [a, b, c] = corners_m.map(|corner| corner.as_vec3().as_dvec3());
            let area_m2 = 0.5 * (b - a).cross(c - a).length();
            shining.push(ShiningTriangle { corners_m, exitance_lm_m2: luminaire.luminous_flux_lm / area_m2 });
        }
        Emission::Area { surfaces, front, back, exitance_lm_m2 } => {
            for triangle in surfaces.iter().flat_map(|surface| scene.surfaces[*surface as usize].triangles.clone()) {
                let [a, b, c] = scene.corners_m(triangle);
                let exitance_lm_m2 = *exitance_lm_m2;
                if *front {
                    shining.push(ShiningTriangle { corners_m: [a, b, c], exitance_lm_m2 });
                }
                if *back {
                    shining.push(ShiningTriangle { corners_m: [a, c, b], exitance_lm_m2 });
                }
            }
        }
        _ => {
            return Err(format!("\"{}\" is a luminaire of a type that it does not support", luminaire.name));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::rooms::kind_of;
    use super::super::scene_of;
    use super::*;

    #[test]
    fn files_are_as_long_as_their_counts_say() {
        let scene = scene_of(&kind_of("dim-and-bright").unwrap().room(0)).unwrap();
        let bytes = rival_scene(&scene).unwrap();
        let count = |index: usize| i32::from_le_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap()) as usize;
        let [vertices, triangles, points, shining, receivers] = std::array::from_fn(count);
        assert_eq!(triangles, scene.triangles.len());
        assert_eq!(points + shining, scene.luminaires.len() + 1, "a panel has two triangles");
        assert_eq!(bytes.len(), 20 + 12 * vertices + 16 * triangles + 16 * points + 40 * shining + 24 * receivers);
        let glossy = scene_of(&kind_of("glossy").unwrap().room(0)).unwrap();
        assert!(rival_scene(&glossy).unwrap_err().contains("not diffuse"));
    }
}
