//! Reads `materials`.

use super::error::SceneError;
use super::model::{Material, ReflectionLaw};
use super::reader::{Fields, Node};

/// The material types, as files name them.
pub(super) const TYPES: [&str; 5] = ["diffuse", "phong", "mirror", "glass", "translucent"];

/// Keys of every material type.
pub(super) const KEYS: [&[&str]; 5] = [
    &["type", "reflectance"],
    &["type", "diffuse_reflectance", "specular_reflectance", "exponent"],
    &["type", "reflectance"],
    &["type", "refractive_index", "internal_transmittance"],
    &["type", "diffuse_reflectance", "diffuse_transmittance"],
];

/// Largest exponent of a phong lobe: its width of some 0.06° is that of a mirror.
const LARGEST_EXPONENT: f64 = 1e6;
/// Largest refractive index: no clear material has one of more than some 4 for visible light.
const LARGEST_REFRACTIVE_INDEX: f64 = 10.0;

/// Reads all materials.
pub(super) fn read(node: &Node) -> Result<Vec<Material>, SceneError> {
    let fields = node.fields("materials")?;
    let mut materials = Vec::new();
    for entry in fields.entries() {
        if entry.name.trim().is_empty() {
            let what = "a material without a name".into();
            return Err(fields.refuse_key(&entry, what, "a name".into(), "give it a name".into()));
        }
        materials.push(Material { name: entry.name.to_string(), law: read_law(&entry.value)? });
    }
    Ok(materials)
}

fn read_law(node: &Node) -> Result<ReflectionLaw, SceneError> {
    let fields = node.fields("a material")?;
    let kind = fields.need("type", "\"diffuse\"")?.choice(&TYPES)?;
    let what = format!("a {} material", TYPES[kind]);
    let fields = node.fields(&what)?;
    fields.only(KEYS[kind])?;
    match TYPES[kind] {
        "diffuse" => Ok(ReflectionLaw::Diffuse { reflectance: share(&fields, "reflectance")? }),
        "phong" => {
            let (diffuse_reflectance, specular_reflectance) =
                two_shares(&fields, "diffuse_reflectance", "specular_reflectance")?;
            let node = fields.need("exponent", "60")?;
            let exponent = node.at_least_zero("the exponent")?;
            if exponent > LARGEST_EXPONENT {
                let remedy = "use a mirror for a lobe that narrow";
                return Err(node.refuse("the exponent is too large", format!("at most {LARGEST_EXPONENT}"), remedy));
            }
            Ok(ReflectionLaw::Phong { diffuse_reflectance, specular_reflectance, exponent })
        }
        "mirror" => Ok(ReflectionLaw::Mirror { reflectance: share(&fields, "reflectance")? }),
        "glass" => {
            let node = fields.need("refractive_index", "1.52")?;
            let refractive_index = node.number()?;
            if refractive_index < 1.0 {
                let remedy = "give the glass's index relative to air, such as 1.52";
                return Err(node.refuse("the refractive index is below 1", "a number of at least 1", remedy));
            }
            if refractive_index > LARGEST_REFRACTIVE_INDEX {
                let expected = format!("a number from 1 to {LARGEST_REFRACTIVE_INDEX}; diamond has 2.42, germanium 4");
                let remedy = "give the glass's index relative to air, such as 1.52";
                return Err(node.refuse("the refractive index is that of no glass", expected, remedy));
            }
            let internal_transmittance = share(&fields, "internal_transmittance")?;
            Ok(ReflectionLaw::Glass { refractive_index, internal_transmittance })
        }
        _ => {
            let (diffuse_reflectance, diffuse_transmittance) =
                two_shares(&fields, "diffuse_reflectance", "diffuse_transmittance")?;
            Ok(ReflectionLaw::Translucent { diffuse_reflectance, diffuse_transmittance })
        }
    }
}

fn share(fields: &Fields, key: &str) -> Result<f64, SceneError> {
    fields.need(key, "0.5")?.fraction(&key.replace('_', " "))
}

fn two_shares(fields: &Fields, first: &str, second: &str) -> Result<(f64, f64), SceneError> {
    /// Two decimal fractions that sum to 1 on paper may miss it by this much in doubles.
    const ROUNDING: f64 = 1e-12;
    let shares = (share(fields, first)?, share(fields, second)?);
    let sum = shares.0 + shares.1;
    if sum > 1.0 + ROUNDING {
        let node = fields.need(second, "0.5")?;
        return Err(node.refuse_as(
            format!("\"{first}\" and \"{second}\" sum above 1"),
            format!("{sum} in all"),
            "a sum of at most 1: a surface returns no more than it receives",
            "lower one of the two",
        ));
    }
    Ok(shares)
}
