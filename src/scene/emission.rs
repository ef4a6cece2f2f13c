//! The kinds of luminaires: the data of each kind, its type and keys in the file, and how it is read. This file also answers what other
//! rooms need from a luminaire: position, aim and name. A new kind is added in this file alone, its keys included, as far as this room goes.
//!
//! `emission/facts.rs` holds the questions that all kinds answer, and `luminaire_reading.rs` the keys and the reading that several kinds
//! share. `sampling/emitter/` describes how each kind emits.

mod facts;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use self::facts::EmissionFacts;
use super::error::SceneError;
use super::keys::{
    ABOVE_ZERO, FROM_ZERO, Form, NUMBER, ObjectKind, ObjectKinds, TEXT, ValueShape, form, forms_of, needed, optional,
};
use super::luminaire_reading::{
    AIM, ARRAY, COMMON, EXITANCE, EXITANCE_OR_FLUX, FLUX, LuminaireReading, SIDE, SURFACE, place,
};
use super::openings::Openings;
use super::photometric_luminaire::Product;
use super::photometry::{IntensityWeb, Opening};
use super::sky::{self, DaylightTargets};
use super::sun;
use super::vectors::photometric_frame;
use crate::base::sky::Sky;
use crate::base::sun::Sun;

/// A luminaire type: its name and keys in files, and how it is read.
type LuminaireType = ObjectKind<fn(&mut LuminaireReading) -> Result<Shining, SceneError>>;

/// The luminaire types. Luminous surfaces have a fixed position, and so do sky and sun: these form no arrays.
const LUMINAIRE_TYPES: [LuminaireType; 7] = [
    LuminaireType { form: POINT, read: |reading| reading.point() },
    LuminaireType { form: SPHERE, read: |reading| reading.sphere() },
    LuminaireType { form: AREA, read: |reading| reading.area() },
    LuminaireType { form: PHOTOMETRIC, read: |reading| reading.photometric() },
    LuminaireType { form: sky::FORM, read: |reading| reading.sky() },
    LuminaireType { form: sun::FORM, read: |reading| reading.sun() },
    LuminaireType { form: RING, read: |reading| reading.ring() },
];

/// Values of `distribution`.
const DISTRIBUTIONS: [&str; 2] = ["isotropic", "lambertian"];

#[rustfmt::skip]
const POINT: Form = form("point", "A point; either `intensity_cd` or `luminous_flux_lm`.", &[COMMON, &[
    place("position", "Position."),
    optional("distribution", ValueShape::Choice(&DISTRIBUTIONS), "Isotropic by default; lambertian is I₀ cos γ about `aim`."),
    AIM,
    optional("intensity_cd", FROM_ZERO, "Intensity on the axis in cd."),
    FLUX,
], ARRAY]).either(&[&["intensity_cd"], &["luminous_flux_lm"]]);

#[rustfmt::skip]
const SPHERE: Form = form("sphere", "A uniformly bright black ball; either `exitance_lm_m2` or `luminous_flux_lm`.", &[COMMON, &[
    place("center", "Centre."),
    needed("radius", ABOVE_ZERO, "0.15", "Radius."),
    EXITANCE,
    FLUX,
], ARRAY]).either(EXITANCE_OR_FLUX);

#[rustfmt::skip]
const AREA: Form = form("area", "A surface that emits diffusely; either `exitance_lm_m2` or `luminous_flux_lm`.", &[COMMON, &[
    SURFACE,
    SIDE,
    EXITANCE,
    optional("luminous_flux_lm", FROM_ZERO, "Luminous flux of all emitting sides together in lm."),
]]).either(EXITANCE_OR_FLUX);

#[rustfmt::skip]
const PHOTOMETRIC: Form = form("photometric", "A luminaire from an IES LM-63 or EULUMDAT file.", &[COMMON, &[
    needed("file", TEXT, "\"downlight.ies\"", "The file."),
    place("position", "Centre of the luminous opening."),
    AIM,
    optional("rotation_deg", NUMBER, "Turns C0 towards C90. At 0 a luminaire that aims straight down has C0 along +x and C90 along +y."),
], ARRAY]);

#[rustfmt::skip]
const RING: Form = form("ring",
    "A flat ring that emits diffusely to the side that `aim` points to; either `exitance_lm_m2` or `luminous_flux_lm`.", &[COMMON, &[
    place("center", "Centre."),
    optional("inner_radius", FROM_ZERO, "Radius of the hole; 0 by default, which makes a disk."),
    needed("outer_radius", ABOVE_ZERO, "0.3", "Radius of the rim."),
    AIM,
    EXITANCE,
    FLUX,
], ARRAY]).either(EXITANCE_OR_FLUX);

/// The kinds of luminaires.
pub(super) const KINDS: ObjectKinds =
    ObjectKinds { name: "Luminaire", doc: "Luminaire.", forms: &forms_of(&LUMINAIRE_TYPES) };

/// How and where a luminaire emits.
#[derive(Clone, Debug)]
pub enum Emission {
    /// A point with the same intensity in every direction.
    Isotropic {
        /// Position in m.
        position_m: DVec3,
        /// Maintained intensity in cd.
        intensity_cd: f64,
    },
    /// A point with I = I₀ cos γ about its axis. It emits nothing to the back.
    Lambertian {
        /// Position in m.
        position_m: DVec3,
        /// Unit vector of γ = 0.
        axis: DVec3,
        /// Maintained intensity on the axis in cd.
        intensity_cd: f64,
    },
    /// A measured distribution. Every part of the luminous opening emits it in the same way.
    Photometric {
        /// Centre of the luminous opening in m.
        position_m: DVec3,
        /// Unit vectors of C0 (γ = 90°), C90 (γ = 90°) and γ = 0.
        frame: [DVec3; 3],
        /// The distribution in cd as the file gives it (initial, undimmed).
        web: Arc<IntensityWeb>,
        /// The luminous opening. It does not block light.
        opening: Opening,
        /// Ratio of the maintained intensity to the web's intensity: dimming × maintenance factor.
        scale: f64,
    },
    /// Uniform diffuse emission of surfaces.
    Area {
        /// Numbers of the emitting surfaces.
        surfaces: Vec<u32>,
        /// Emits from the front.
        front: bool,
        /// Emits from the back.
        back: bool,
        /// Maintained exitance in lm/m².
        exitance_lm_m2: f64,
    },
    /// A uniformly bright black ball.
    Sphere {
        /// Centre in m.
        center_m: DVec3,
        /// Radius in m.
        radius_m: f64,
        /// Maintained exitance in lm/m².
        exitance_lm_m2: f64,
    },
    /// A flat ring that is uniformly bright on one side. It does not block light.
    Ring {
        /// Centre in m.
        center_m: DVec3,
        /// Unit vector of γ = 0.
        axis: DVec3,
        /// Inner and outer radius in m.
        radii_m: [f64; 2],
        /// Maintained exitance in lm/m².
        exitance_lm_m2: f64,
    },
    /// The sky and the ground below the horizon, at infinity.
    Sky {
        /// Maintained luminances.
        sky: Arc<Sky>,
        /// Where the light enters the scene.
        openings: Arc<Openings>,
        /// Targets for the daylight factors.
        targets: DaylightTargets,
    },
    /// The sun's disk, at infinity.
    Sun {
        /// Maintained luminance.
        sun: Arc<Sun>,
        /// Where the light enters the scene.
        openings: Arc<Openings>,
    },
}

impl Emission {
    /// Facts of each kind that others need. A kind does not have the facts that its arm leaves out.
    fn facts(&self) -> EmissionFacts<'_> {
        let none = EmissionFacts::default();
        match self {
            Emission::Isotropic { position_m, intensity_cd } => EmissionFacts {
                kind_name: "isotropic",
                words: "point, equal in all directions",
                place_m: Some(*position_m),
                intensity_cd: Some(*intensity_cd),
                ..none
            },
            Emission::Lambertian { position_m, axis, intensity_cd } => EmissionFacts {
                kind_name: "lambertian",
                words: "point, cosine distribution",
                place_m: Some(*position_m),
                aim: Some(*axis),
                intensity_cd: Some(*intensity_cd),
                ..none
            },
            Emission::Photometric { position_m, frame: [c0, _, axis], opening, .. } => EmissionFacts {
                kind_name: "photometric",
                words: "measured distribution",
                place_m: Some(*position_m),
                aim: Some(*axis),
                c0: Some(*c0),
                opening: Some(*opening),
                ..none
            },
            Emission::Area { surfaces, exitance_lm_m2, .. } => EmissionFacts {
                kind_name: "area",
                words: "luminous surface, diffuse",
                exitance_lm_m2: Some(*exitance_lm_m2),
                surfaces,
                ..none
            },
            Emission::Sphere { center_m, radius_m, exitance_lm_m2 } => EmissionFacts {
                kind_name: "sphere",
                words: "luminous sphere",
                place_m: Some(*center_m),
                radius_m: *radius_m,
                exitance_lm_m2: Some(*exitance_lm_m2),
                is_black_ball: true,
                ..none
            },
            Emission::Ring { center_m, axis, radii_m: [inner_m, outer_m], exitance_lm_m2 } => EmissionFacts {
                kind_name: "ring",
                words: "luminous ring, diffuse",
                place_m: Some(*center_m),
                radius_m: *outer_m,
                half_axes_m: Some(<[DVec3; 2]>::from(axis.any_orthonormal_pair()).map(|unit| *outer_m * unit)),
                hole: inner_m / outer_m,
                aim: Some(*axis),
                exitance_lm_m2: Some(*exitance_lm_m2),
                opening: Some(Opening::Disk { diameter_m: 2.0 * outer_m }),
                ..none
            },
            Emission::Sky { openings, .. } => {
                EmissionFacts { kind_name: "sky", words: "sky", openings: Some(openings), ..none }
            }
            Emission::Sun { sun, openings } => EmissionFacts {
                kind_name: "sun",
                words: "sun",
                aim: Some(-sun.towards()),
                openings: Some(openings),
                ..none
            },
        }
    }

    /// Closed lines in m that a plan draws in addition to the symbol.
    pub fn outlines_m(&self) -> Vec<Vec<DVec3>> {
        /// Number of corners that approximate a circle.
        const CORNERS: u32 = 72;
        let EmissionFacts { place_m: Some(center_m), half_axes_m: Some([u_m, v_m]), hole, .. } = self.facts() else {
            return Vec::new();
        };
        let corner = |k: u32| {
            let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(CORNERS)).sin_cos();
            cos * u_m + sin * v_m
        };
        let ellipse = |scale: f64| (0..CORNERS).map(|k| center_m + scale * corner(k)).collect();
        [hole, 1.0].into_iter().filter(|scale| *scale > 0.0).map(ellipse).collect()
    }

    /// Moves a luminaire that has a position. Luminous surfaces do not move.
    pub(super) fn shift(&mut self, offset_m: DVec3) {
        match self {
            Emission::Isotropic { position_m, .. }
            | Emission::Lambertian { position_m, .. }
            | Emission::Photometric { position_m, .. }
            | Emission::Sphere { center_m: position_m, .. }
            | Emission::Ring { center_m: position_m, .. } => *position_m += offset_m,
            Emission::Area { .. } | Emission::Sky { .. } | Emission::Sun { .. } => {}
        }
    }
}

/// Result of reading a luminaire.
pub(super) struct Shining {
    pub luminous_flux_lm: f64,
    pub emission: Emission,
    pub product: Option<Arc<Product>>,
    /// Electric power in W, from the photometric file.
    pub power_w: Option<f64>,
}

impl Shining {
    /// Makes a result without a photometric file: no product and no power.
    pub fn of(luminous_flux_lm: f64, emission: Emission) -> Shining {
        Shining { luminous_flux_lm, emission, product: None, power_w: None }
    }
}

impl LuminaireReading<'_> {
    /// Reads a luminaire of a type. `kind` is its index among the types.
    pub fn read(&mut self, kind: usize) -> Result<Shining, SceneError> {
        (LUMINAIRE_TYPES[kind].read)(self)
    }

    fn point(&mut self) -> Result<Shining, SceneError> {
        let position_m = self.place_m("position")?;
        let distribution = self.fields.get("distribution").map_or(Ok(0), |node| node.choice())?;
        let axis = self.aim()?;

        // Φ = 4πI for an isotropic point, and ∫ I₀ cos γ dΩ = πI₀ for a point that follows Lambert's law.
        let flux_over_intensity_sr = [4.0 * PI, PI][distribution];
        let (which, node) = self.fields.one_of(["intensity_cd", "luminous_flux_lm"])?;
        let given = self.maintained * node.amount(["the intensity", "the luminous flux"][which])?;
        let (luminous_flux_lm, intensity_cd) = match which {
            0 => (given * flux_over_intensity_sr, given),
            _ => (given, given / flux_over_intensity_sr),
        };
        if DISTRIBUTIONS[distribution] == "lambertian" {
            return Ok(Shining::of(luminous_flux_lm, Emission::Lambertian { position_m, axis, intensity_cd }));
        }
        if self.fields.get("aim").is_some() {
            self.warnings.push(format!("{}: aim has no effect, because the luminaire is isotropic", self.name));
        }
        Ok(Shining::of(luminous_flux_lm, Emission::Isotropic { position_m, intensity_cd }))
    }

    fn sphere(&mut self) -> Result<Shining, SceneError> {
        let center_m = self.place_m("center")?;
        let radius_node = self.fields.need("radius")?;
        let radius_m = self.around.unit.length_m(radius_node.amount("the radius")?);
        let area_m2 = 4.0 * PI * radius_m * radius_m;
        if !area_m2.is_normal() {
            return Err(radius_node.refuse(
                "the radius is far out of range",
                "a radius in length_unit",
                "check the number",
            ));
        }
        let (luminous_flux_lm, exitance_lm_m2) = self.flux_and_exitance(area_m2)?;
        Ok(Shining::of(luminous_flux_lm, Emission::Sphere { center_m, radius_m, exitance_lm_m2 }))
    }

    fn ring(&mut self) -> Result<Shining, SceneError> {
        let (center_m, axis) = (self.place_m("center")?, self.aim()?);
        let unit = self.around.unit;
        let inner = self.fields.get("inner_radius").map_or(Ok(0.0), |node| node.amount("the inner radius"))?;
        let node = self.fields.need("outer_radius")?;
        let radii_m = [unit.length_m(inner), unit.length_m(node.amount("the outer radius")?)];
        let area_m2 = PI * (radii_m[1] - radii_m[0]) * (radii_m[1] + radii_m[0]);
        if radii_m[0] >= radii_m[1] || !area_m2.is_normal() {
            return Err(node.refuse_as(
                "the ring has no area",
                format!("an inner radius of {} m and an outer radius of {} m", radii_m[0], radii_m[1]),
                "an outer radius above the inner one, in length_unit",
                "check both numbers",
            ));
        }
        let (luminous_flux_lm, exitance_lm_m2) = self.flux_and_exitance(area_m2)?;
        Ok(Shining::of(luminous_flux_lm, Emission::Ring { center_m, axis, radii_m, exitance_lm_m2 }))
    }

    fn area(&mut self) -> Result<Shining, SceneError> {
        let (surfaces, [front, back], area_m2) = self.emitting_surfaces()?;
        let (luminous_flux_lm, exitance_lm_m2) = self.flux_and_exitance(area_m2)?;
        Ok(Shining::of(luminous_flux_lm, Emission::Area { surfaces, front, back, exitance_lm_m2 }))
    }

    fn photometric(&mut self) -> Result<Shining, SceneError> {
        let position_m = self.place_m("position")?;
        let aim = self.aim()?;
        let rotation_deg = self.fields.get("rotation_deg").map_or(Ok(0.0), |node| node.number())?;
        let (frame, scale) = (photometric_frame(aim, rotation_deg), self.maintained);
        let file = self.distribution()?;
        let (web, opening) = (file.web.clone(), file.opening);
        Ok(Shining {
            luminous_flux_lm: scale * file.luminous_flux_lm,
            emission: Emission::Photometric { position_m, frame, web, opening, scale },
            product: Some(file.product.clone()),
            power_w: file.power_w,
        })
    }

    fn sky(&mut self) -> Result<Shining, SceneError> {
        let (luminous_flux_lm, sky, targets) = sky::read(self.fields, self.maintained)?;
        let emission = Emission::Sky { sky: Arc::new(sky), openings: Arc::default(), targets };
        Ok(Shining::of(luminous_flux_lm, emission))
    }

    fn sun(&mut self) -> Result<Shining, SceneError> {
        let (luminous_flux_lm, sun) = sun::read(self.fields, self.maintained)?;
        Ok(Shining::of(luminous_flux_lm, Emission::Sun { sun: Arc::new(sun), openings: Arc::default() }))
    }
}
