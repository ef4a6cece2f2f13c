//! Materials as the scene file writes them: types and keys, their schema, how they are read, and what a law says of its shares.

use schemars::JsonSchema;

use super::error::SceneError;
use super::reader::{Fields, Node};
use crate::base::pane::pane_shares;

/// The material types, as files name them.
pub(super) const TYPES: [&str; 6] = ["diffuse", "phong", "mirror", "glass", "translucent", "blinn"];

/// Keys of every material type.
pub(super) const KEYS: [&[&str]; 6] = [
    &["type", "reflectance"],
    &["type", "diffuse_reflectance", "specular_reflectance", "exponent"],
    &["type", "reflectance"],
    &["type", "refractive_index", "internal_transmittance"],
    &["type", "diffuse_reflectance", "diffuse_transmittance"],
    &["type", "diffuse_reflectance", "specular_reflectance", "exponent"],
];

/// Largest exponent of a lobe: its width of some 0.06° is that of a mirror.
const LARGEST_EXPONENT: f64 = 1e6;
/// Largest refractive index: no clear material has one of more than some 4 for visible light.
const LARGEST_REFRACTIVE_INDEX: f64 = 10.0;

/// Material.
#[derive(JsonSchema)]
#[schemars(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) enum MaterialKind {
    /// Lambert's law.
    Diffuse {
        /// Share of light that is reflected.
        #[schemars(range(min = 0.0, max = 1.0))]
        reflectance: f64,
    },
    /// A diffuse part and a glossy lobe.
    Phong {
        /// Share that is reflected diffusely.
        #[schemars(range(min = 0.0, max = 1.0))]
        diffuse_reflectance: f64,
        /// Share that is reflected about the mirror direction; both sum to at most 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        specular_reflectance: f64,
        /// The lobe's exponent.
        #[schemars(range(min = 0.0, max = 1e6))]
        exponent: f64,
    },
    /// A diffuse part and a glossy lobe about the half vector, as microfacets make it.
    Blinn {
        /// Share that is reflected diffusely.
        #[schemars(range(min = 0.0, max = 1.0))]
        diffuse_reflectance: f64,
        /// Share that is reflected about the mirror direction; both sum to at most 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        specular_reflectance: f64,
        /// Exponent of the half vector's cosine; about four times that of a phong lobe as wide.
        #[schemars(range(min = 0.0, max = 1e6))]
        exponent: f64,
    },
    /// A perfect mirror.
    Mirror {
        /// Share of light that is reflected.
        #[schemars(range(min = 0.0, max = 1.0))]
        reflectance: f64,
    },
    /// A thin pane, one sheet for both faces.
    Glass {
        /// Refractive index relative to air.
        #[schemars(range(min = 1.0, max = 10.0))]
        refractive_index: f64,
        /// Transmittance of the glass itself at normal incidence.
        #[schemars(range(min = 0.0, max = 1.0))]
        internal_transmittance: f64,
    },
    /// Scatters to both sides.
    Translucent {
        /// Share that is reflected diffusely.
        #[schemars(range(min = 0.0, max = 1.0))]
        diffuse_reflectance: f64,
        /// Share that is let through diffusely; both sum to at most 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        diffuse_transmittance: f64,
    },
}

/// What a surface does with light.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Reflection law.
    pub law: ReflectionLaw,
}

/// A reflection law with its constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReflectionLaw {
    /// Lambert's law: luminance ρE/π in every direction.
    Diffuse {
        /// Hemispherical reflectance ρ, 0 to 1.
        reflectance: f64,
    },
    /// A diffuse part and a reciprocal lobe about the mirror direction (docs/methods.md, section 9); its reflectance is
    /// the sum of both shares at every angle.
    Phong {
        /// Share that is reflected diffusely, 0 to 1.
        diffuse_reflectance: f64,
        /// Share that is reflected about the mirror direction, 0 to 1.
        specular_reflectance: f64,
        /// The lobe's exponent, 0 or more.
        exponent: f64,
    },
    /// A diffuse part and a reciprocal lobe about the half vector (docs/methods.md, section 9); its reflectance is the sum of
    /// both shares at every angle.
    Blinn {
        /// Share that is reflected diffusely, 0 to 1.
        diffuse_reflectance: f64,
        /// Share that is reflected about the mirror direction, 0 to 1.
        specular_reflectance: f64,
        /// Exponent of the half vector's cosine, 0 or more.
        exponent: f64,
    },
    /// A perfectly flat mirror.
    Mirror {
        /// Share that is reflected, 0 to 1, at every angle.
        reflectance: f64,
    },
    /// A thin pane, one sheet for both faces: directions stay as they are.
    Glass {
        /// Refractive index relative to air, 1 or more.
        refractive_index: f64,
        /// Transmittance of the glass itself at normal incidence, 0 to 1.
        internal_transmittance: f64,
    },
    /// Scatters diffusely to both sides.
    Translucent {
        /// Share that is reflected, 0 to 1.
        diffuse_reflectance: f64,
        /// Share that is let through, 0 to 1.
        diffuse_transmittance: f64,
    },
}

impl ReflectionLaw {
    /// Name of its type, as scene files have it.
    pub fn name(&self) -> &'static str {
        match self {
            ReflectionLaw::Diffuse { .. } => "diffuse",
            ReflectionLaw::Phong { .. } => "phong",
            ReflectionLaw::Blinn { .. } => "blinn",
            ReflectionLaw::Mirror { .. } => "mirror",
            ReflectionLaw::Glass { .. } => "glass",
            ReflectionLaw::Translucent { .. } => "translucent",
        }
    }

    /// Number of its type, from 0 in the order in which the formats list them.
    pub fn number(&self) -> u8 {
        match self {
            ReflectionLaw::Diffuse { .. } => 0,
            ReflectionLaw::Phong { .. } => 1,
            ReflectionLaw::Mirror { .. } => 2,
            ReflectionLaw::Glass { .. } => 3,
            ReflectionLaw::Translucent { .. } => 4,
            ReflectionLaw::Blinn { .. } => 5,
        }
    }

    /// Share that leaves the lit side in every direction alike.
    pub fn diffuse_reflectance(&self) -> f64 {
        match *self {
            ReflectionLaw::Diffuse { reflectance } => reflectance,
            ReflectionLaw::Phong { diffuse_reflectance, .. }
            | ReflectionLaw::Blinn { diffuse_reflectance, .. }
            | ReflectionLaw::Translucent { diffuse_reflectance, .. } => diffuse_reflectance,
            ReflectionLaw::Mirror { .. } | ReflectionLaw::Glass { .. } => 0.0,
        }
    }

    /// Share that leaves the other side in every direction alike.
    pub fn diffuse_transmittance(&self) -> f64 {
        match *self {
            ReflectionLaw::Translucent { diffuse_transmittance, .. } => diffuse_transmittance,
            _ => 0.0,
        }
    }

    /// Total reflectance, where it is the same at every angle and all that is not reflected is absorbed.
    pub fn reflectance_at_every_angle(&self) -> Option<f64> {
        match *self {
            ReflectionLaw::Diffuse { reflectance } | ReflectionLaw::Mirror { reflectance } => Some(reflectance),
            ReflectionLaw::Phong { diffuse_reflectance, specular_reflectance, .. }
            | ReflectionLaw::Blinn { diffuse_reflectance, specular_reflectance, .. } => {
                Some(diffuse_reflectance + specular_reflectance)
            }
            ReflectionLaw::Glass { .. } | ReflectionLaw::Translucent { .. } => None,
        }
    }

    /// Shares of light along the normal that are reflected and let through; of all laws but glass those of every angle.
    pub fn shares_at_normal_incidence(&self) -> [f64; 2] {
        match *self {
            ReflectionLaw::Diffuse { reflectance } | ReflectionLaw::Mirror { reflectance } => [reflectance, 0.0],
            ReflectionLaw::Phong { diffuse_reflectance, specular_reflectance, .. }
            | ReflectionLaw::Blinn { diffuse_reflectance, specular_reflectance, .. } => {
                [diffuse_reflectance + specular_reflectance, 0.0]
            }
            ReflectionLaw::Glass { refractive_index, internal_transmittance } => {
                pane_shares(refractive_index, internal_transmittance, 1.0)
            }
            ReflectionLaw::Translucent { diffuse_reflectance, diffuse_transmittance } => {
                [diffuse_reflectance, diffuse_transmittance]
            }
        }
    }

    /// Whether part of the light is scattered about a direction, neither into all alike nor into single ones.
    pub fn has_lobe(&self) -> bool {
        matches!(*self, ReflectionLaw::Phong { specular_reflectance, .. } | ReflectionLaw::Blinn { specular_reflectance, .. }
            if specular_reflectance > 0.0)
    }

    /// Whether a sheet of it has two like sides by nature.
    pub fn is_two_sided(&self) -> bool {
        matches!(self, ReflectionLaw::Glass { .. } | ReflectionLaw::Translucent { .. })
    }

    /// Whether light can pass to the other side.
    pub fn lets_through(&self) -> bool {
        match *self {
            ReflectionLaw::Glass { internal_transmittance, .. } => internal_transmittance > 0.0,
            _ => self.diffuse_transmittance() > 0.0,
        }
    }

    /// Share of the light that leaves again, reflected or let through; of glass what a pane without reflection lets through.
    pub fn returned_share(&self) -> f64 {
        match *self {
            ReflectionLaw::Diffuse { reflectance } | ReflectionLaw::Mirror { reflectance } => reflectance,
            ReflectionLaw::Phong { diffuse_reflectance, specular_reflectance, .. }
            | ReflectionLaw::Blinn { diffuse_reflectance, specular_reflectance, .. } => {
                diffuse_reflectance + specular_reflectance
            }
            ReflectionLaw::Glass { internal_transmittance, .. } => internal_transmittance,
            ReflectionLaw::Translucent { diffuse_reflectance, diffuse_transmittance } => {
                diffuse_reflectance + diffuse_transmittance
            }
        }
    }
}

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
        lobed @ ("phong" | "blinn") => {
            let (diffuse_reflectance, specular_reflectance) =
                two_shares(&fields, "diffuse_reflectance", "specular_reflectance")?;
            let node = fields.need("exponent", "60")?;
            let exponent = node.at_least_zero("the exponent")?;
            if exponent > LARGEST_EXPONENT {
                let remedy = "use a mirror for a lobe that narrow";
                return Err(node.refuse("the exponent is too large", format!("at most {LARGEST_EXPONENT}"), remedy));
            }
            Ok(match lobed {
                "phong" => ReflectionLaw::Phong { diffuse_reflectance, specular_reflectance, exponent },
                _ => ReflectionLaw::Blinn { diffuse_reflectance, specular_reflectance, exponent },
            })
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
