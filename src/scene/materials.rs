//! Materials in the scene file: types and keys, how they are read, and the shares of light that a reflection model gives.

use super::error::SceneError;
use super::keys::{
    Form, Key, NumberRange, ObjectKind, ObjectKinds, SHARE, TYPE, ValueShape, form, forms_of, from_to, needed, optional,
};
use super::reader::{Fields, Node};
use crate::base::pane::{glazed_shares, internal_transmittance_of, pane_shares};

/// A material type: its name and keys in files, and how its reflection model is read.
type MaterialType = ObjectKind<fn(&Fields) -> Result<BsdfParameters, SceneError>>;

/// The material types, in the order of their numbers in the file formats.
const MATERIAL_TYPES: [MaterialType; 6] = [
    MaterialType { form: DIFFUSE, read: read_diffuse },
    MaterialType { form: PHONG, read: read_phong },
    MaterialType { form: MIRROR, read: read_mirror },
    MaterialType { form: GLASS, read: read_glass },
    MaterialType { form: TRANSLUCENT, read: read_translucent },
    MaterialType { form: BLINN, read: read_blinn },
];

/// Keys of several types. With the largest exponent, the width of a lobe is some 0.06°, practically that of a mirror.
const REFLECTANCE: Key = needed("reflectance", SHARE, "0.5", "Share of light that is reflected.");
const DIFFUSELY: Key = needed("diffuse_reflectance", SHARE, "0.5", "Share that is reflected diffusely.");
const SPECULARLY: Key = needed(
    "specular_reflectance",
    SHARE,
    "0.5",
    "Share that is reflected about the mirror direction; both sum to at most 1.",
);
const EXPONENTS: ValueShape = from_to(0.0, 1e6);

const DIFFUSE: Form = form("diffuse", "Lambert's law.", &[&[TYPE, REFLECTANCE]]);
const MIRROR: Form = form("mirror", "A perfect mirror.", &[&[TYPE, REFLECTANCE]]);
#[rustfmt::skip]
const PHONG: Form = form("phong", "A diffuse part and a glossy lobe.", &[&[
    TYPE,
    DIFFUSELY,
    SPECULARLY,
    needed("exponent", EXPONENTS, "60", "The lobe's exponent."),
]]);
#[rustfmt::skip]
const BLINN: Form = form("blinn", "A diffuse part and a glossy lobe about the half vector, as of microfacets.", &[&[
    TYPE,
    DIFFUSELY,
    SPECULARLY,
    needed("exponent", EXPONENTS, "60",
        "Exponent of the half vector's cosine; about four times the exponent of a phong lobe of the same width."),
]]);
/// Clear materials have no more than about 4 as refractive index for visible light.
#[rustfmt::skip]
const GLASS: Form = form("glass", "A thin pane, one sheet for both faces.", &[&[
    TYPE,
    needed("refractive_index", from_to(1.0, 10.0), "1.52", "Refractive index relative to air."),
    optional("internal_transmittance", SHARE, "Transmittance of the glass itself at normal incidence."),
    optional("visible_transmittance", SHARE,
        "Instead, transmittance of the whole pane at normal incidence, including the reflections at its faces."),
    optional("glazed_share", SHARE, "Share of the area that is glass; the rest is black frames. 1 by default."),
]]);
#[rustfmt::skip]
const TRANSLUCENT: Form = form("translucent", "Scatters to both sides.", &[&[
    TYPE,
    DIFFUSELY,
    needed("diffuse_transmittance", SHARE, "0.5", "Share that is transmitted diffusely; both sum to at most 1."),
]]);

/// The kinds of materials.
pub(super) const KINDS: ObjectKinds =
    ObjectKinds { name: "Material", doc: "Material.", forms: &forms_of(&MATERIAL_TYPES) };

/// Reflection and transmission of a surface.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Reflection model.
    pub bsdf: BsdfParameters,
}

/// A reflection model with its constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BsdfParameters {
    /// Lambert's law: luminance ρE/π in every direction.
    Diffuse {
        /// Hemispherical reflectance ρ, 0 to 1.
        reflectance: f64,
    },
    /// A diffuse part and a reciprocal lobe about the mirror direction (docs/methods.md, section 9). The reflectance at every angle is
    /// the sum of both shares.
    Phong {
        /// Share that is reflected diffusely, 0 to 1.
        diffuse_reflectance: f64,
        /// Share that is reflected about the mirror direction, 0 to 1.
        specular_reflectance: f64,
        /// The lobe's exponent, 0 or more.
        exponent: f64,
    },
    /// A diffuse part and a reciprocal lobe about the half vector (docs/methods.md, section 9). The reflectance at every angle is the sum
    /// of both shares.
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
    /// A thin pane, one sheet for both faces. Light passes it without a change of direction.
    Glass {
        /// Refractive index relative to air, 1 or more.
        refractive_index: f64,
        /// Transmittance of the glass itself at normal incidence, 0 to 1.
        internal_transmittance: f64,
        /// Share of the area that is glass, 0 to 1. The rest is black and spread evenly.
        glazed_share: f64,
    },
    /// Scatters diffusely to both sides.
    Translucent {
        /// Share that is reflected, 0 to 1.
        diffuse_reflectance: f64,
        /// Share that is let through, 0 to 1.
        diffuse_transmittance: f64,
    },
}

/// Shares of light at normal incidence by where it goes. Only glass has other shares at other angles.
#[derive(Default)]
struct SurfaceShares {
    /// Reflected diffusely, with the same luminance in all directions.
    diffuse: f64,
    /// Reflected in a lobe about a direction.
    lobe: f64,
    /// Reflected as by a mirror.
    mirrored: f64,
    /// Transmitted diffusely, with the same luminance in all directions.
    diffused_through: f64,
    /// Reflected and transmitted share of a pane. They differ at other angles.
    pane: Option<[f64; 2]>,
    /// Whether the material is a sheet with two equal sides.
    is_sheet: bool,
}

impl BsdfParameters {
    /// Number of its type, from 0, in the order of the file formats.
    pub fn number(&self) -> u8 {
        match self {
            BsdfParameters::Diffuse { .. } => 0,
            BsdfParameters::Phong { .. } => 1,
            BsdfParameters::Mirror { .. } => 2,
            BsdfParameters::Glass { .. } => 3,
            BsdfParameters::Translucent { .. } => 4,
            BsdfParameters::Blinn { .. } => 5,
        }
    }

    /// Name of its type, as in scene files.
    pub fn name(&self) -> &'static str {
        MATERIAL_TYPES[usize::from(self.number())].form.name
    }

    /// Shares of light from which all other methods on shares follow.
    fn shares(&self) -> SurfaceShares {
        match *self {
            BsdfParameters::Diffuse { reflectance } => {
                SurfaceShares { diffuse: reflectance, ..SurfaceShares::default() }
            }
            BsdfParameters::Phong { diffuse_reflectance, specular_reflectance, .. }
            | BsdfParameters::Blinn { diffuse_reflectance, specular_reflectance, .. } => {
                SurfaceShares { diffuse: diffuse_reflectance, lobe: specular_reflectance, ..SurfaceShares::default() }
            }
            BsdfParameters::Mirror { reflectance } => {
                SurfaceShares { mirrored: reflectance, ..SurfaceShares::default() }
            }
            BsdfParameters::Glass { refractive_index, internal_transmittance, glazed_share } => SurfaceShares {
                pane: Some(glazed_shares(glazed_share, refractive_index, internal_transmittance, 1.0)),
                is_sheet: true,
                ..SurfaceShares::default()
            },
            BsdfParameters::Translucent { diffuse_reflectance, diffuse_transmittance } => SurfaceShares {
                diffuse: diffuse_reflectance,
                diffused_through: diffuse_transmittance,
                is_sheet: true,
                ..SurfaceShares::default()
            },
        }
    }

    /// Share that leaves the lit side diffusely.
    pub fn diffuse_reflectance(&self) -> f64 {
        self.shares().diffuse
    }

    /// Share that leaves the other side diffusely.
    pub fn diffuse_transmittance(&self) -> f64 {
        self.shares().diffused_through
    }

    /// Total reflectance, if it is the same at every angle and the surface absorbs the rest; otherwise `None`.
    pub fn reflectance_at_every_angle(&self) -> Option<f64> {
        let shares = self.shares();
        (!shares.is_sheet).then_some(shares.diffuse + shares.lobe + shares.mirrored)
    }

    /// Reflected and transmitted share at normal incidence. Except for glass, these hold at every angle.
    pub fn shares_at_normal_incidence(&self) -> [f64; 2] {
        let shares = self.shares();
        shares.pane.unwrap_or([shares.diffuse + shares.lobe + shares.mirrored, shares.diffused_through])
    }

    /// Whether part of the light is scattered about a direction, neither diffusely nor into single directions.
    pub fn has_lobe(&self) -> bool {
        self.shares().lobe > 0.0
    }

    /// Whether the material is a sheet with two equal sides.
    pub fn is_two_sided(&self) -> bool {
        self.shares().is_sheet
    }

    /// Whether light can pass to the other side.
    pub fn lets_through(&self) -> bool {
        let [_, let_through] = self.shares_at_normal_incidence();
        let_through > 0.0
    }

    /// Share of the light that leaves the surface again, reflected or transmitted. For glass: the transmittance of a pane without
    /// reflections.
    pub fn returned_share(&self) -> f64 {
        if let BsdfParameters::Glass { internal_transmittance, glazed_share, .. } = *self {
            return glazed_share * internal_transmittance;
        }
        let [reflected, let_through] = self.shares_at_normal_incidence();
        reflected + let_through
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
        materials.push(Material { name: entry.name.to_string(), bsdf: read_bsdf(&entry.value)? });
    }
    Ok(materials)
}

fn read_bsdf(node: &Node) -> Result<BsdfParameters, SceneError> {
    let MaterialType { form, read } = &MATERIAL_TYPES[node.fields("a material")?.kind(&KINDS)?];
    read(&node.object(&format!("a {} material", form.name), form)?)
}

fn read_diffuse(fields: &Fields) -> Result<BsdfParameters, SceneError> {
    Ok(BsdfParameters::Diffuse { reflectance: share(fields, "reflectance")? })
}

fn read_mirror(fields: &Fields) -> Result<BsdfParameters, SceneError> {
    Ok(BsdfParameters::Mirror { reflectance: share(fields, "reflectance")? })
}

fn read_phong(fields: &Fields) -> Result<BsdfParameters, SceneError> {
    let ([diffuse_reflectance, specular_reflectance], exponent) = glossy(fields)?;
    Ok(BsdfParameters::Phong { diffuse_reflectance, specular_reflectance, exponent })
}

fn read_blinn(fields: &Fields) -> Result<BsdfParameters, SceneError> {
    let ([diffuse_reflectance, specular_reflectance], exponent) = glossy(fields)?;
    Ok(BsdfParameters::Blinn { diffuse_reflectance, specular_reflectance, exponent })
}

fn read_glass(fields: &Fields) -> Result<BsdfParameters, SceneError> {
    let node = fields.need("refractive_index")?;
    let refractive_index = node.number()?;
    let NumberRange { least, most, .. } = node.range();
    if refractive_index < least {
        let remedy = "give the glass's index relative to air, such as 1.52";
        return Err(node.refuse("the refractive index is below 1", "a number of at least 1", remedy));
    }
    if refractive_index > most {
        let expected = format!("a number from {least} to {most}; diamond has 2.42, germanium 4");
        let remedy = "give the glass's index relative to air, such as 1.52";
        return Err(node.refuse("the refractive index is too high for glass", expected, remedy));
    }
    let internal_transmittance = match fields.one_of(["internal_transmittance", "visible_transmittance"])? {
        (0, node) => node.amount("internal transmittance")?,
        (_, node) => {
            let inside = internal_transmittance_of(refractive_index, node.amount("visible transmittance")?);
            if inside > 1.0 {
                let [_, most] = pane_shares(refractive_index, 1.0, 1.0);
                let expected = format!("at most {most:.3}: its two faces reflect the rest");
                let remedy = "lower it, or give the glass's own refractive index";
                return Err(node.refuse("a pane of this refractive index transmits less", expected, remedy));
            }
            inside
        }
    };
    let glazed_share = fields.get("glazed_share").map_or(Ok(1.0), |node| node.amount("glazed share"))?;
    Ok(BsdfParameters::Glass { refractive_index, internal_transmittance, glazed_share })
}

fn read_translucent(fields: &Fields) -> Result<BsdfParameters, SceneError> {
    let [diffuse_reflectance, diffuse_transmittance] =
        two_shares(fields, "diffuse_reflectance", "diffuse_transmittance")?;
    Ok(BsdfParameters::Translucent { diffuse_reflectance, diffuse_transmittance })
}

/// Diffuse and specular reflectance, and the exponent of a lobe.
fn glossy(fields: &Fields) -> Result<([f64; 2], f64), SceneError> {
    let shares = two_shares(fields, "diffuse_reflectance", "specular_reflectance")?;
    let node = fields.need("exponent")?;
    let (exponent, most) = (node.amount("the exponent")?, node.range().most);
    if exponent > most {
        let remedy = "use a mirror for a lobe so narrow";
        return Err(node.refuse("the exponent is too large", format!("at most {most}"), remedy));
    }
    Ok((shares, exponent))
}

fn share(fields: &Fields, key: &str) -> Result<f64, SceneError> {
    fields.need(key)?.amount(&key.replace('_', " "))
}

fn two_shares(fields: &Fields, first: &str, second: &str) -> Result<[f64; 2], SceneError> {
    /// Two decimal fractions that sum to 1 on paper may sum to this much in doubles.
    const SLIGHTLY_OVER_ONE: f64 = 1.0 + 1e-12;
    let shares = [share(fields, first)?, share(fields, second)?];
    let sum = shares[0] + shares[1];
    if sum > SLIGHTLY_OVER_ONE {
        let node = fields.need(second)?;
        return Err(node.refuse_as(
            format!("\"{first}\" and \"{second}\" sum to more than 1"),
            format!("{sum} in all"),
            "a sum of at most 1: a surface returns no more than it receives",
            "lower one of the two",
        ));
    }
    Ok(shares)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of a type is the place of its row.
    #[test]
    fn every_type_has_the_name_of_its_row() {
        let (diffuse_reflectance, specular_reflectance, exponent) = (0.4, 0.3, 20.0);
        let types = [
            (BsdfParameters::Diffuse { reflectance: 0.5 }, "diffuse"),
            (BsdfParameters::Phong { diffuse_reflectance, specular_reflectance, exponent }, "phong"),
            (BsdfParameters::Mirror { reflectance: 0.9 }, "mirror"),
            (BsdfParameters::Glass { refractive_index: 1.5, internal_transmittance: 0.9, glazed_share: 1.0 }, "glass"),
            (BsdfParameters::Translucent { diffuse_reflectance, diffuse_transmittance: 0.3 }, "translucent"),
            (BsdfParameters::Blinn { diffuse_reflectance, specular_reflectance, exponent }, "blinn"),
        ];
        assert_eq!(types.len(), MATERIAL_TYPES.len());
        for (bsdf, name) in types {
            assert_eq!(bsdf.name(), name);
        }
    }
}
