//! Reads `luminaires`: everything becomes maintained lumens and candelas.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::arrays;
use super::bodies::body_of;
use super::error::SceneError;
use super::limits::MOST_LUMINAIRES;
use super::model::{Emission, Luminaire, Product, SurfaceId};
use super::photometry::{IntensityWeb, Opening, read_photometric_file};
use super::reader::{Fields, Node};
use super::sky;
use super::sun;
use super::surfaces::Surfaces;
use super::unique_names::{Names, unique_name};
use super::units::LengthUnit;
use super::vectors::photometric_frame;

/// The luminaire types, as files name them.
pub(super) const TYPES: [&str; 6] = ["point", "sphere", "area", "photometric", "sky", "sun"];

/// Keys of each luminaire type alone.
const OWN_KEYS: [&[&str]; 6] = [
    &["position", "distribution", "aim", "intensity_cd", "luminous_flux_lm"],
    &["center", "radius", "exitance_lm_m2", "luminous_flux_lm"],
    &["surface", "side", "exitance_lm_m2", "luminous_flux_lm"],
    &["file", "position", "aim", "rotation_deg"],
    &sky::KEYS,
    &sun::KEYS,
];
/// Keys that every luminaire type has.
const COMMON_KEYS: [&str; 5] = ["name", "type", "dimming", "maintenance_factor", "power_w"];

/// Keys of a luminaire type: its place in [`TYPES`].
pub(super) fn keys(kind: usize) -> Vec<&'static str> {
    // A luminous surface stands where it stands, and so do sky and sun; all others come in arrays too.
    let array: &[&str] = if ["area", "sky", "sun"].contains(&TYPES[kind]) { &[] } else { &arrays::KEYS };
    [&COMMON_KEYS, OWN_KEYS[kind], array].concat()
}

/// Values of `distribution`.
pub(super) const DISTRIBUTIONS: [&str; 2] = ["isotropic", "lambertian"];
/// Values of `side`.
pub(super) const SIDES: [&str; 3] = ["front", "back", "both"];

/// Luminous fluxes in lm that are computed: a thousandth of a photon's an hour to more than the sun's. Fourth powers of the
/// illuminances that they bring, which checks sum up, stay well within 64-bit floats.
const FLUXES_LM: RangeInclusive<f64> = 1e-24..=1e30;

/// What luminaires refer to.
pub(super) struct Around<'a> {
    pub unit: LengthUnit,
    pub base_dir: &'a Path,
    pub surfaces: &'a Surfaces,
}

/// What the luminaires so far have given.
#[derive(Default)]
struct Known {
    /// Their names.
    names: Names,
    /// Photometric files: luminaires that name the same one share what it says.
    files: HashMap<PathBuf, Distribution>,
}

/// What a photometric file says of every luminaire that names it.
struct Distribution {
    product: Arc<Product>,
    web: Arc<IntensityWeb>,
    luminous_flux_lm: f64,
    opening: Opening,
    power_w: Option<f64>,
    warnings: Vec<String>,
}

/// Reads all luminaires.
pub(super) fn read(node: &Node, around: &Around, warnings: &mut Vec<String>) -> Result<Vec<Luminaire>, SceneError> {
    let items = node.items("luminaires")?;
    if items.is_empty() {
        let remedy = "add at least one, such as { \"name\": \"lamp\", \"type\": \"point\", \"position\": [4, 3, 2.5], \"intensity_cd\": 800 }";
        return Err(node.refuse("the scene has no luminaire", "at least one luminaire", remedy));
    }
    let mut known = Known::default();
    let mut maintained = false;
    let mut luminaires = Vec::with_capacity(items.len());
    for item in items {
        let fields = item.fields("a luminaire")?;
        maintained |= fields.get("maintenance_factor").is_some();
        let luminaire = read_one(&item, around, &mut known, warnings)?;
        match arrays::read(&fields, around.unit)? {
            Some(array) if luminaires.len() as u64 + array.len() > MOST_LUMINAIRES => {
                let expected = format!("at most {} luminaires in a scene with arrays", MOST_LUMINAIRES);
                return Err(item.refuse("the arrays have too many luminaires", expected, "ask for fewer"));
            }
            Some(array) => array.fill(&fields, &luminaire, &mut known.names, &mut luminaires)?,
            None => luminaires.push(luminaire),
        }
    }
    sky::only_one(node, &luminaires)?;
    sun::only_one(node, &luminaires)?;
    if luminaires.iter().all(|luminaire| luminaire.luminous_flux_lm == 0.0) {
        warnings.push(
            "no luminaire gives light, so that everything is dark: all have a flux, a dimming or a factor of 0"
                .to_owned(),
        );
    }
    if !maintained && !luminaires.iter().all(|luminaire| luminaire.emission.is_daylight()) {
        warnings.push("no luminaire has a maintenance_factor: results are those of a new installation".into());
    }
    Ok(luminaires)
}

fn read_one(
    node: &Node,
    around: &Around,
    known: &mut Known,
    warnings: &mut Vec<String>,
) -> Result<Luminaire, SceneError> {
    let kind = node.fields("a luminaire")?.need("type", "\"point\"")?.choice(&TYPES)?;
    let what = format!("{} {} luminaire", if TYPES[kind] == "area" { "an" } else { "a" }, TYPES[kind]);
    let fields = node.fields(&what)?;
    fields.only(&keys(kind))?;
    let name = unique_name(&fields, &mut known.names)?;
    let dimming = fields.get("dimming").map_or(Ok(1.0), |node| node.fraction("dimming"))?;
    let maintenance_factor =
        fields.get("maintenance_factor").map_or(Ok(1.0), |node| node.fraction("the maintenance factor"))?;
    let maintained = dimming * maintenance_factor;

    let mut power_w = fields.get("power_w").map(|node| node.at_least_zero("the electric power")).transpose()?;
    let mut product = None;
    let (luminous_flux_lm, emission) = match TYPES[kind] {
        "point" => read_point(&fields, &name, around.unit, maintained, warnings)?,
        "sphere" => read_sphere(&fields, around.unit, maintained)?,
        "area" => read_area(&fields, around.surfaces, maintained)?,
        "sky" => sky::read(&fields, maintained)?,
        "sun" => sun::read(&fields, maintained)?,
        _ => {
            let (flux_lm, emission, file) =
                read_photometric(&fields, &name, around, maintained, &mut known.files, warnings)?;
            power_w = power_w.or(file.power_w);
            product = Some(file.product.clone());
            (flux_lm, emission)
        }
    };
    if luminous_flux_lm != 0.0 && !FLUXES_LM.contains(&luminous_flux_lm) {
        let given =
            ["luminous_flux_lm", "intensity_cd", "exitance_lm_m2", "file"].into_iter().find_map(|key| fields.get(key));
        return Err(given.unwrap_or_else(|| node.clone()).refuse_as(
            format!("the luminous flux of {name:?} is out of all proportion"),
            format!("{luminous_flux_lm:e} lm in all, dimming and maintenance in it"),
            format!("0, or {:e} to {:e} lm", FLUXES_LM.start(), FLUXES_LM.end()),
            "check its numbers",
        ));
    }
    if luminous_flux_lm == 0.0 {
        warnings.push(format!("{name}: this luminaire gives no light"));
    }
    Ok(Luminaire { name, luminous_flux_lm, dimming, maintenance_factor, power_w, product, emission })
}

fn place_m(fields: &Fields, key: &str, unit: LengthUnit) -> Result<DVec3, SceneError> {
    Ok(unit.point_m(fields.need(key, "[4, 3, 2.5]")?.vector()?))
}

fn aim(fields: &Fields) -> Result<DVec3, SceneError> {
    fields.get("aim").map_or(Ok(-DVec3::Z), |node| node.direction())
}

fn read_point(
    fields: &Fields,
    name: &str,
    unit: LengthUnit,
    maintained: f64,
    warnings: &mut Vec<String>,
) -> Result<(f64, Emission), SceneError> {
    let position_m = place_m(fields, "position", unit)?;
    let distribution = fields.get("distribution").map_or(Ok(0), |node| node.choice(&DISTRIBUTIONS))?;
    let axis = aim(fields)?;

    // Φ = 4πI of an isotropic point, and ∫ I₀ cos γ dΩ = πI₀ of one that follows Lambert's law.
    let flux_over_intensity_sr = [4.0 * PI, PI][distribution];
    let (which, node) = fields.one_of(["intensity_cd", "luminous_flux_lm"])?;
    let given = maintained * node.at_least_zero(["the intensity", "the luminous flux"][which])?;
    let (luminous_flux_lm, intensity_cd) = match which {
        0 => (given * flux_over_intensity_sr, given),
        _ => (given, given / flux_over_intensity_sr),
    };
    if DISTRIBUTIONS[distribution] == "lambertian" {
        return Ok((luminous_flux_lm, Emission::Lambertian { position_m, axis, intensity_cd }));
    }
    if fields.get("aim").is_some() {
        warnings.push(format!("{name}: aim has no effect, because the luminaire is isotropic"));
    }
    Ok((luminous_flux_lm, Emission::Isotropic { position_m, intensity_cd }))
}

/// Flux and exitance of a uniformly emitting area.
fn flux_and_exitance(fields: &Fields, area_m2: f64, maintained: f64) -> Result<(f64, f64), SceneError> {
    let (which, node) = fields.one_of(["exitance_lm_m2", "luminous_flux_lm"])?;
    let given = maintained * node.at_least_zero(["the exitance", "the luminous flux"][which])?;
    Ok(match which {
        0 => (given * area_m2, given),
        _ => (given, given / area_m2),
    })
}

fn read_sphere(fields: &Fields, unit: LengthUnit, maintained: f64) -> Result<(f64, Emission), SceneError> {
    let center_m = place_m(fields, "center", unit)?;
    let radius_node = fields.need("radius", "0.15")?;
    let radius_m = unit.length_m(radius_node.above_zero("the radius")?);
    let area_m2 = 4.0 * PI * radius_m * radius_m;
    if !area_m2.is_normal() {
        return Err(radius_node.refuse(
            "the radius is out of all proportion",
            "a radius in length_unit",
            "check the number",
        ));
    }
    let (luminous_flux_lm, exitance_lm_m2) = flux_and_exitance(fields, area_m2, maintained)?;
    Ok((luminous_flux_lm, Emission::Sphere { center_m, radius_m, exitance_lm_m2 }))
}

fn read_area(fields: &Fields, surfaces: &Surfaces, maintained: f64) -> Result<(f64, Emission), SceneError> {
    let node = fields.need("surface", "\"panel\"")?;
    let emitting = surfaces.named(&node)?;
    let is_body = |id: &SurfaceId| body_of(&surfaces.bodies, surfaces.surfaces[*id as usize].triangles.start).is_some();
    if emitting.iter().any(is_body) {
        let expected = "a surface of flat triangles, or a luminaire of type sphere";
        return Err(node.refuse("a body of spherical harmonics cannot emit", expected, "take a mesh for what shines"));
    }
    let side = fields.get("side").map_or(Ok(0), |node| node.choice(&SIDES))?;
    let (front, back) = (SIDES[side] != "back", SIDES[side] != "front");
    let one_side_m2: f64 = emitting.iter().map(|id| surfaces.area_m2(*id)).sum();
    let area_m2 = if front && back { 2.0 * one_side_m2 } else { one_side_m2 };
    let (luminous_flux_lm, exitance_lm_m2) = flux_and_exitance(fields, area_m2, maintained)?;
    Ok((luminous_flux_lm, Emission::Area { surfaces: emitting, front, back, exitance_lm_m2 }))
}

fn read_photometric<'a>(
    fields: &Fields,
    name: &str,
    around: &Around,
    maintained: f64,
    files: &'a mut HashMap<PathBuf, Distribution>,
    warnings: &mut Vec<String>,
) -> Result<(f64, Emission, &'a Distribution), SceneError> {
    let position_m = place_m(fields, "position", around.unit)?;
    let aim = aim(fields)?;
    let rotation_deg = fields.get("rotation_deg").map_or(Ok(0.0), |node| node.number())?;
    let node = fields.need("file", "\"downlight.ies\"")?;
    let path = around.base_dir.join(node.name()?);
    let file = match files.entry(path) {
        Entry::Occupied(known) => known.into_mut(),
        Entry::Vacant(unknown) => {
            let file = read_distribution(unknown.key()).map_err(|error| error.named_by(node.as_namer()))?;
            unknown.insert(file)
        }
    };
    warnings.extend(file.warnings.iter().map(|warning| format!("{name}: {warning}")));
    let luminous_flux_lm = maintained * file.luminous_flux_lm;
    let frame = photometric_frame(aim, rotation_deg);
    let (web, opening) = (file.web.clone(), file.opening);
    let emission = Emission::Photometric { position_m, frame, web, opening, scale: maintained };
    Ok((luminous_flux_lm, emission, file))
}

fn read_distribution(path: &Path) -> Result<Distribution, SceneError> {
    let file = read_photometric_file(path).map_err(|error| {
        let expected = "a photometric file: IES LM-63 (.ies) or EULUMDAT (.ldt)";
        let what = "the photometric file cannot be read".to_string();
        let remedy = "check the file name, or get the file anew from the maker";
        SceneError::of_file(path, what, error.to_string(), expected, remedy)
    })?;
    let warnings = file.warnings.iter().map(|warning| format!("{}: {warning}", path.display())).collect();
    let luminous_flux_lm = file.web.luminous_flux_lm();
    let product = Product {
        file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        manufacturer: file.manufacturer,
        luminaire: file.luminaire,
        catalog_number: file.catalog_number,
    };
    Ok(Distribution {
        product: Arc::new(product),
        luminous_flux_lm,
        opening: file.opening,
        power_w: file.power_w,
        warnings,
        web: Arc::new(file.web),
    })
}
