//! Describes a photometric file: header, flux, light output ratio, symmetry, beam and field angles.

use serde_json::{Value, json};

use super::number_text::plain;
use crate::scene::photometry::{LateralSymmetry, Opening, PhotometricFile, PhotometricFormat, PhotometricType};

/// C planes in which beam and field angles are reported, in degrees.
const PLANES_C_DEG: [f64; 2] = [0.0, 90.0];

/// Describes a photometric file for a reader.
pub fn photometric_text(file: &PhotometricFile) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        if !value.is_empty() {
            text += &format!("{name:<20} {value}\n");
        }
    };
    line("format", format_name(file.format).to_owned());
    line("manufacturer", file.manufacturer.clone());
    line("luminaire", file.luminaire.clone());
    line("catalogue number", file.catalog_number.clone());
    line("lamp", file.lamp.clone());
    line("photometry", if file.absolute { "absolute" } else { "relative to the lamps' flux" }.to_owned());
    line("luminous flux", format!("{} lm (integrated)", plain(file.luminous_flux_lm(), 6)));
    line("declared flux", with_unit(file.declared_flux_lm, "lm"));
    line("light output ratio", with_unit(file.light_output_ratio.map(|ratio| 100.0 * ratio), "%"));
    if let Some([below_lm, above_lm]) = file.web.hemisphere_fluxes_lm() {
        line("below / above", format!("{} / {} lm", plain(below_lm, 5), plain(above_lm, 5)));
    }
    line("greatest intensity", format!("{} cd", plain(file.web.maximum_intensity_cd(), 5)));
    for c_deg in PLANES_C_DEG {
        let opposite_deg = c_deg + 180.0;
        let (beam, field) = (file.web.beam_angle_deg(c_deg), file.web.field_angle_deg(c_deg));
        let angles = format!("beam {}°, field {}°", plain(beam, 4), plain(field, 4));
        line(&format!("in C{c_deg:.0}-C{opposite_deg:.0}"), angles);
    }
    line("power", with_unit(file.power_w, "W"));
    line("symmetry", symmetry_name(file.symmetry).to_owned());
    line("goniometer", format!("type {}", type_name(file.photometric_type)));
    let table = &file.web;
    line("table", format!("{} planes x {} angles", table.c_deg.len(), table.gamma_deg.len()));
    line("opening", opening_text(&file.opening));
    for (name, value) in file.keywords.iter().filter(|(_, value)| !value.trim().is_empty()) {
        line(&format!("[{name}]"), value.clone());
    }
    for warning in &file.warnings {
        text += &format!("warning: {warning}\n");
    }
    text
}

fn with_unit(number: Option<f64>, unit: &str) -> String {
    number.map_or(String::new(), |number| format!("{} {unit}", plain(number, 5)))
}

/// Describes a photometric file for programs.
pub fn photometric_json(file: &PhotometricFile) -> Value {
    let angles: Vec<Value> = PLANES_C_DEG
        .iter()
        .map(|c_deg| {
            json!({
                "c_deg": c_deg,
                "beam_angle_deg": file.web.beam_angle_deg(*c_deg),
                "field_angle_deg": file.web.field_angle_deg(*c_deg),
            })
        })
        .collect();
    let keywords: Vec<Value> =
        file.keywords.iter().map(|(name, value)| json!({ "name": name, "value": value })).collect();
    json!({
        "format": format_name(file.format),
        "manufacturer": file.manufacturer,
        "luminaire": file.luminaire,
        "catalog_number": file.catalog_number,
        "lamp": file.lamp,
        "lamps": file.lamps,
        "lumens_per_lamp": file.lumens_per_lamp,
        "absolute": file.absolute,
        "luminous_flux_lm": file.luminous_flux_lm(),
        "declared_flux_lm": file.declared_flux_lm,
        "light_output_ratio": file.light_output_ratio,
        "hemisphere_fluxes_lm": file.web.hemisphere_fluxes_lm(),
        "maximum_intensity_cd": file.web.maximum_intensity_cd(),
        "angles": angles,
        "power_w": file.power_w,
        "symmetry": symmetry_name(file.symmetry),
        "photometric_type": type_name(file.photometric_type),
        "c_deg": file.web.c_deg,
        "gamma_deg": file.web.gamma_deg,
        "keywords": keywords,
        "warnings": file.warnings,
    })
}

fn format_name(format: PhotometricFormat) -> &'static str {
    match format {
        PhotometricFormat::Ies1986 => "IES LM-63-1986",
        PhotometricFormat::Ies1991 => "IES LM-63-1991",
        PhotometricFormat::Ies1995 => "IES LM-63-1995",
        PhotometricFormat::Ies2002 => "IES LM-63-2002",
        PhotometricFormat::Ies2019 => "IES LM-63-2019",
        PhotometricFormat::Eulumdat => "EULUMDAT",
    }
}

fn symmetry_name(symmetry: LateralSymmetry) -> &'static str {
    match symmetry {
        LateralSymmetry::Rotational => "about the axis",
        LateralSymmetry::Quadrant => "about C0-C180 and C90-C270",
        LateralSymmetry::AboutC0 => "about C0-C180",
        LateralSymmetry::AboutC90 => "about C90-C270",
        LateralSymmetry::None => "none",
    }
}

fn type_name(photometric_type: PhotometricType) -> &'static str {
    match photometric_type {
        PhotometricType::A => "A",
        PhotometricType::B => "B",
        PhotometricType::C => "C",
    }
}

fn opening_text(opening: &Opening) -> String {
    let sizes = |name: &str, sizes_m: &[f64]| {
        let sizes: Vec<String> = sizes_m.iter().map(|size_m| plain(*size_m, 4)).collect();
        format!("{name}, {} m", sizes.join(" x "))
    };
    match *opening {
        Opening::Point => "a point".to_owned(),
        Opening::Rectangle { c0_m, c90_m } => sizes("rectangle", &[c0_m, c90_m]),
        Opening::Box { c0_m, c90_m, height_m } => sizes("box", &[c0_m, c90_m, height_m]),
        Opening::Disk { diameter_m } => sizes("disk", &[diameter_m]),
        Opening::Ellipse { c0_m, c90_m, height_m } => sizes("ellipse", &[c0_m, c90_m, height_m]),
        Opening::VerticalCylinder { diameter_m, height_m } => sizes("vertical cylinder", &[diameter_m, height_m]),
        Opening::HorizontalCylinder { length_m, width_m, height_m, .. } => {
            sizes("horizontal cylinder", &[length_m, width_m, height_m])
        }
        Opening::Sphere { diameter_m } => sizes("sphere", &[diameter_m]),
        Opening::Ellipsoid { c0_m, c90_m, height_m } => sizes("ellipsoid", &[c0_m, c90_m, height_m]),
        Opening::UprightEllipse { width_m, height_m } => sizes("upright ellipse", &[width_m, height_m]),
    }
}
