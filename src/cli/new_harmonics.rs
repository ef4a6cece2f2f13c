//! `luxmc new harmonics`: fits a smooth body to a mesh, and makes a scene with it that runs as it is.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::exit::Failure;
use super::text_table::text_table;
use crate::base::harmonics::LARGEST_DEGREE;
use crate::check::{HarmonicFit, fit_harmonics, scene_from_json};
use crate::scene::series_file;

/// Default degree: 64 harmonics.
pub const USUAL_DEGREE: usize = 7;

/// The files of a fitted body, and the report on its fit.
pub struct FittedBody {
    /// The scene file comes first.
    pub files: Vec<(String, Vec<u8>)>,
    /// Table of the fit.
    pub description: String,
}

/// Fits a body of a degree to a mesh.
///
/// # Errors
///
/// A degree that is too high, a mesh that cannot be read, and one that is not star-shaped.
pub fn fitted_body(mesh: &Path, degree: usize) -> Result<FittedBody, Failure> {
    if degree > LARGEST_DEGREE {
        return Err(Failure::Usage {
            what: "the degree is too high".to_owned(),
            got: format!("--degree {degree}"),
            expected: format!("0 to {LARGEST_DEGREE}"),
            remedy: "use a lower degree, or the mesh itself".to_owned(),
        });
    }
    let folder = mesh.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let name = mesh.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    // The lamp is there because a scene must have one.
    let text = json!({
        "version": 1,
        "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [{ "name": "mesh", "type": "mesh", "file": name, "material": "paint" }],
        "luminaires": [{ "name": "lamp", "type": "point", "position": [0, 0, 0], "luminous_flux_lm": 1 }],
    });
    let mut scene = scene_from_json(&text.to_string(), None, &folder)?;
    scene.luminaires.clear();
    let fit = fit_harmonics(&scene, degree).map_err(|error| Failure::Usage {
        what: error.to_string(),
        got: mesh.display().to_string(),
        expected: "a closed mesh that every ray from its centre of volume meets once".to_owned(),
        remedy: "cut the mesh into star-shaped parts, or use the mesh itself".to_owned(),
    })?;
    let stem = mesh.file_stem().map_or_else(|| "body".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let files = vec![
        (format!("{stem}.json"), scene_text(&fit, &format!("{stem}.csv")).into_bytes()),
        (format!("{stem}.csv"), series_file(&fit.series).into_bytes()),
    ];
    Ok(FittedBody { files, description: description(&fit, scene.triangles.len()) })
}

fn description(fit: &HarmonicFit, faces: usize) -> String {
    let of_radius = |length_m: f64| format!("{length_m:.6} m ({:.3} %)", 100.0 * length_m / fit.mean_radius_m);
    let rows = [
        ("faces of the mesh", faces.to_string()),
        ("harmonics", fit.series.coefficients().len().to_string()),
        ("mean radius", format!("{:.6} m", fit.mean_radius_m)),
        ("error of the radius, rms", of_radius(fit.rms_error_m)),
        ("error of the radius, largest", of_radius(fit.largest_error_m)),
        ("angle to the mesh's normals, rms", format!("{:.3}°", fit.rms_normal_error_deg)),
        ("directions", fit.directions.to_string()),
    ];
    text_table(&["what", "value"], &[0, 1], rows.map(|(what, value)| vec![what.to_owned(), value]))
}

/// A scene with the body above a floor, under a lamp.
fn scene_text(fit: &HarmonicFit, file: &str) -> String {
    let size = fit.mean_radius_m;
    let [x, y, z] = fit.center_m.to_array();
    let (low, reach) = (z - 2.0 * size - fit.largest_error_m, 4.0 * size);
    let scene = json!({
        "version": 1,
        "title": "A body of spherical harmonics",
        "materials": {
            "paint": { "type": "diffuse", "reflectance": 0.6 },
            "floor": { "type": "diffuse", "reflectance": 0.3 },
        },
        "geometry": [
            { "name": "body", "type": "spherical_harmonics", "center": [x, y, z], "file": file, "material": "paint", "report": true },
            { "name": "floor", "type": "rectangle", "origin": [x - reach, y - reach, low], "u": [2.0 * reach, 0, 0],
              "v": [0, 2.0 * reach, 0], "material": "floor", "max_element_edge": 0.5 * size },
        ],
        "luminaires": [
            { "name": "lamp", "type": "point", "position": [x + 2.0 * size, y - 2.0 * size, z + 4.0 * size], "luminous_flux_lm": 1000 },
        ],
    });
    format!("{scene:#}\n")
}
