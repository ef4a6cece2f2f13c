//! Converts a Radiance scene: materials by their reflection, surfaces to meshes, lights to luminaires.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::error::SceneError;
use super::limits::{MOST_CORNERS, MOST_MESH_TRIANGLES};
use super::proposed::{Proposal, ProposedMaterial, UNKNOWN_REFLECTANCE};
use super::radiance::{self, Primitive};
use super::reader::{Source, shortened};

/// Luminous efficacy of white light in Radiance, in lm/W. Source: "Rendering with Radiance", 1998.
const EFFICACY_LM_W: f64 = 179.0;
/// Photometric weights of Radiance's red, green and blue. Source: the same.
const WEIGHTS: [f64; 3] = [0.265, 0.670, 0.065];
/// Default refractive index of Radiance's glass.
const GLASS_INDEX: f64 = 1.52;
/// Number of sides of a round surface. A prism of this many sides has 0.3 % less area than the cylinder.
const SIDES: u32 = 24;
/// Types of modifiers that are not materials: patterns and textures.
const PATTERNS: [&str; 9] = [
    "brightdata",
    "brightfunc",
    "brighttext",
    "colordata",
    "colorfunc",
    "colorpict",
    "colortext",
    "texdata",
    "texfunc",
];
/// Types that are not materials of surfaces.
const NO_MATERIALS: [&str; 3] = ["source", "instance", "mesh"];
/// Roughness below which a lobe gets the narrowest width of the scene file.
const SMOOTH: f64 = 2e-3;

/// A Radiance material as it is in the scene file.
#[derive(Clone, Debug)]
struct Converted {
    bsdf: Value,
    /// Exitance of lights in lm/m².
    exitance_lm_m2: f64,
    /// The original material, and what was changed.
    known: String,
}

/// Surfaces of one material.
#[derive(Default)]
struct Faces {
    vertices: Vec<[f64; 3]>,
    faces: Vec<Vec<usize>>,
}

impl Faces {
    fn add(&mut self, corners: impl IntoIterator<Item = DVec3>) {
        let first = self.vertices.len();
        self.vertices.extend(corners.into_iter().map(|corner| corner.to_array()));
        self.faces.push((first..self.vertices.len()).collect());
    }
}

/// Proposes a scene for the texts of Radiance files, which are read as one.
///
/// # Errors
///
/// Malformed text, surfaces of materials that are not defined, and files without a surface.
pub(super) fn propose(sources: &[Source]) -> Result<Proposal, SceneError> {
    let [first, ..] = sources else { return Ok(Proposal::default()) };
    let mut builder = RadianceScene::new(first);
    for source in sources {
        builder.source = source;
        let read = radiance::read(source)?;
        for command in &read.commands {
            builder
                .warnings
                .push(format!("this command was not run, and its output is missing: {}", shortened(command)));
        }
        for primitive in &read.primitives {
            builder.take(primitive)?;
        }
    }
    builder.finish()
}

struct RadianceScene<'s, 't> {
    source: &'s Source<'t>,
    materials: HashMap<&'t str, Converted>,
    /// Patterns and textures that modify a material, each with its own modifier.
    modifiers: HashMap<&'t str, &'t str>,
    meshes: BTreeMap<&'t str, Faces>,
    geometry: Vec<Value>,
    luminaires: Vec<Value>,
    used: BTreeMap<&'t str, usize>,
    passed_over: BTreeMap<&'t str, (usize, &'t str)>,
    patterned: Vec<&'t str>,
    names: HashMap<String, usize>,
    corners: usize,
    warnings: Vec<String>,
}

impl<'s, 't> RadianceScene<'s, 't> {
    fn new(source: &'s Source<'t>) -> RadianceScene<'s, 't> {
        RadianceScene {
            source,
            materials: HashMap::new(),
            modifiers: HashMap::new(),
            meshes: BTreeMap::new(),
            geometry: Vec::new(),
            luminaires: Vec::new(),
            used: BTreeMap::new(),
            passed_over: BTreeMap::new(),
            patterned: Vec::new(),
            names: HashMap::new(),
            corners: 0,
            warnings: Vec::new(),
        }
    }

    fn take(&mut self, primitive: &Primitive<'t>) -> Result<(), SceneError> {
        match primitive.kind {
            "polygon" | "sphere" | "bubble" | "cylinder" | "tube" | "cone" | "cup" | "ring" => self.surface(primitive),
            "alias" => {
                let old = primitive.strings[0];
                if let Some(material) = self.materials.get(old).cloned() {
                    self.materials.insert(primitive.name, material);
                } else {
                    self.modifiers.insert(primitive.name, old);
                }
                Ok(())
            }
            kind => {
                let Some(converted) = self.material(primitive)? else {
                    self.passed_over.entry(kind).or_insert((0, primitive.name)).0 += 1;
                    if PATTERNS.contains(&kind) {
                        self.modifiers.insert(primitive.name, primitive.modifier);
                    } else if !NO_MATERIALS.contains(&kind) {
                        self.materials.insert(primitive.name, unknown(kind));
                    }
                    return Ok(());
                };
                if primitive.modifier != "void" {
                    self.patterned.push(primitive.name);
                }
                self.materials.insert(primitive.name, converted);
                Ok(())
            }
        }
    }

    /// Returns the material of a surface. It follows the patterns and mixtures that modify it.
    fn material_of(&mut self, primitive: &Primitive<'t>) -> Result<&'t str, SceneError> {
        let mut name = primitive.modifier;
        // A cycle of modifiers ends once all have been visited.
        for _ in 0..=self.modifiers.len() {
            if self.materials.contains_key(name) {
                *self.used.entry(name).or_default() += 1;
                return Ok(name);
            }
            match self.modifiers.get(name) {
                Some(below) => name = below,
                None => break,
            }
        }
        let what = format!("the surface {:?} has no supported material", shortened(primitive.name));
        let got = format!("the modifier {:?}", shortened(primitive.modifier));
        let expected = "a material that is defined above: plastic, metal, trans, glass, mirror, light, illum, glow";
        let remedy = "name the file with the materials too, before this one";
        Err(self.source.refuse(primitive.place.clone(), "", what, got, expected, remedy))
    }

    fn refuse(&self, primitive: &Primitive, what: &str, expected: &str) -> SceneError {
        let got = format!("{} numbers in {:?}", primitive.reals.len(), shortened(primitive.name));
        let what = format!("{} that {what}", primitive.kind);
        self.source.refuse(primitive.place.clone(), "", what, got, expected, "correct its arguments")
    }

    /// Returns the `N` numbers of a primitive.
    fn reals<const N: usize>(&self, primitive: &Primitive) -> Result<[f64; N], SceneError> {
        let wrong = || self.refuse(primitive, "has the wrong number of values", &format!("{N} numbers"));
        primitive.reals.as_slice().try_into().map_err(|_| wrong())
    }

    fn material(&self, primitive: &Primitive<'t>) -> Result<Option<Converted>, SceneError> {
        let share = |value: f64| value.clamp(0.0, 1.0);
        let dark = |exitance_lm_m2: f64, known: String| Converted {
            bsdf: json!({ "type": "diffuse", "reflectance": 0.0 }),
            exitance_lm_m2,
            known,
        };
        let exitance = |red: f64, green: f64, blue: f64| PI * EFFICACY_LM_W * gray([red, green, blue]).max(0.0);
        Ok(Some(match primitive.kind {
            "plastic" | "metal" => {
                let [red, green, blue, specular, roughness] = self.reals(primitive)?;
                let (color, specular) = (share(gray([red, green, blue])), share(specular));
                let lobe = if primitive.kind == "metal" { color * specular } else { specular };
                let known = format!(
                    "{} of reflectance {color:.3}, specular {specular:.3}, roughness {roughness:.3}",
                    primitive.kind
                );
                Converted { bsdf: glossy(color * (1.0 - specular), lobe, roughness), exitance_lm_m2: 0.0, known }
            }
            "trans" => {
                let [red, green, blue, specular, _, transmitted, through] = self.reals(primitive)?;
                let (color, specular) = (share(gray([red, green, blue])), share(specular));
                let (transmitted, through) = (share(transmitted), share(through));
                let diffuse = color * (1.0 - specular);
                let lost = color * specular + diffuse * transmitted * through;
                let bsdf = json!({ "type": "translucent", "diffuse_reflectance": diffuse * (1.0 - transmitted),
                                  "diffuse_transmittance": diffuse * transmitted * (1.0 - through) });
                let known =
                    format!("trans; {lost:.3} that are reflected as by a mirror or pass straight through are left out");
                Converted { bsdf, exitance_lm_m2: 0.0, known }
            }
            "glass" => {
                let (index, rgb) = match primitive.reals.as_slice() {
                    [red, green, blue] => (GLASS_INDEX, [*red, *green, *blue]),
                    [red, green, blue, index] => (index.clamp(1.0, 10.0), [*red, *green, *blue]),
                    _ => return Err(self.refuse(primitive, "has the wrong number of values", "3 or 4 numbers")),
                };
                let transmittance = share(gray(rgb));
                let bsdf =
                    json!({ "type": "glass", "refractive_index": index, "internal_transmittance": transmittance });
                Converted { bsdf, exitance_lm_m2: 0.0, known: format!("glass of transmissivity {transmittance:.3}") }
            }
            "mirror" => {
                let [red, green, blue] = self.reals(primitive)?;
                let reflectance = share(gray([red, green, blue]));
                let bsdf = json!({ "type": "mirror", "reflectance": reflectance });
                Converted { bsdf, exitance_lm_m2: 0.0, known: format!("mirror of reflectance {reflectance:.3}") }
            }
            "light" => {
                let [red, green, blue] = self.reals(primitive)?;
                dark(exitance(red, green, blue), "light".to_owned())
            }
            "glow" => {
                let [red, green, blue, _] = self.reals(primitive)?;
                dark(exitance(red, green, blue), "glow, treated as a light".to_owned())
            }
            "illum" => {
                let [red, green, blue] = self.reals(primitive)?;
                let exitance_lm_m2 = exitance(red, green, blue);
                let behind = primitive.strings.first().and_then(|name| self.materials.get(name));
                let known =
                    "illum, a light; its reflection and transmission are those of its alternate material".to_owned();
                match behind {
                    Some(other) => Converted { bsdf: other.bsdf.clone(), exitance_lm_m2, known },
                    None => dark(exitance_lm_m2, "illum, a light without an alternate material".to_owned()),
                }
            }
            _ => return Ok(None),
        }))
    }

    fn surface(&mut self, primitive: &Primitive<'t>) -> Result<(), SceneError> {
        let material = self.material_of(primitive)?;
        let exitance_lm_m2 = self.materials[material].exitance_lm_m2;
        let point = |numbers: &[f64]| DVec3::new(numbers[0], numbers[1], numbers[2]);
        match primitive.kind {
            "polygon" => {
                let corners = primitive.reals.len() / 3;
                if !primitive.reals.len().is_multiple_of(3) || !(3..=MOST_CORNERS).contains(&corners) {
                    let expected = format!("three numbers for each of 3 to {MOST_CORNERS} corners");
                    return Err(self.refuse(primitive, "has the wrong number of values", &expected));
                }
                self.count(primitive, corners)?;
                let corners = primitive.reals.chunks_exact(3).map(point);
                self.meshes.entry(material).or_default().add(corners);
            }
            "sphere" | "bubble" => {
                let [x, y, z, radius] = self.reals(primitive)?;
                let inward = primitive.kind == "bubble";
                if radius <= 0.0 {
                    return Err(self.refuse(primitive, "has no radius above 0", "a radius above 0"));
                }
                if exitance_lm_m2 > 0.0 && inward {
                    self.warnings.push(format!("{}: a bubble that emits inward is skipped", shortened(primitive.name)));
                } else if exitance_lm_m2 > 0.0 {
                    let name = self.unique(primitive.name);
                    self.luminaires
                        .push(json!({ "name": name, "type": "sphere", "center": [x, y, z], "radius": radius,
                                                 "exitance_lm_m2": exitance_lm_m2 }));
                } else {
                    let name = self.unique(primitive.name);
                    self.geometry.push(json!({ "name": name, "type": "sphere", "center": [x, y, z], "radius": radius,
                        "facing": if inward { "inward" } else { "outward" }, "material": material, "two_sided": true }));
                }
            }
            "cylinder" | "tube" => {
                let numbers: [f64; 7] = self.reals(primitive)?;
                let ends = [point(&numbers[..3]), point(&numbers[3..6])];
                self.round(primitive, material, ends, ends[1] - ends[0], [numbers[6]; 2], primitive.kind == "tube")?;
            }
            "cone" | "cup" => {
                let numbers: [f64; 8] = self.reals(primitive)?;
                let ends = [point(&numbers[..3]), point(&numbers[3..6])];
                self.round(
                    primitive,
                    material,
                    ends,
                    ends[1] - ends[0],
                    [numbers[6], numbers[7]],
                    primitive.kind == "cup",
                )?;
            }
            _ => {
                let numbers: [f64; 8] = self.reals(primitive)?;
                let radii = [numbers[6].max(numbers[7]), numbers[6].min(numbers[7])];
                self.round(primitive, material, [point(&numbers[..3]); 2], point(&numbers[3..6]), radii, false)?;
            }
        }
        Ok(())
    }

    /// Adds a surface of revolution between two circles. Its front faces away from the axis, or along the axis if it is flat.
    fn round(
        &mut self,
        primitive: &Primitive<'t>,
        material: &'t str,
        [base, tip]: [DVec3; 2],
        axis: DVec3,
        radii: [f64; 2],
        inward: bool,
    ) -> Result<(), SceneError> {
        let axis = axis.try_normalize().filter(|axis| axis.is_finite());
        let Some(axis) = axis.filter(|_| radii.iter().all(|radius| *radius >= 0.0) && radii[0].max(radii[1]) > 0.0)
        else {
            return Err(self.refuse(
                primitive,
                "has no axis or no radius",
                "two ends that differ, and radii of at least 0",
            ));
        };
        self.count(primitive, 4 * SIDES as usize)?;
        let (u, v) = axis.any_orthonormal_pair();
        let (u, v) = if u.cross(v).dot(axis) < 0.0 { (v, u) } else { (u, v) };
        let on = |end: usize, side: u32| {
            let angle = 2.0 * PI * f64::from(side % SIDES) / f64::from(SIDES);
            [base, tip][end] + radii[end] * (angle.cos() * u + angle.sin() * v)
        };
        let mesh = self.meshes.entry(material).or_default();
        for side in 0..SIDES {
            let mut corners = vec![on(0, side), on(0, side + 1), on(1, side + 1), on(1, side)];
            if radii[1] == 0.0 {
                corners.truncate(3);
            } else if radii[0] == 0.0 {
                corners.remove(1);
            }
            if inward {
                corners.reverse();
            }
            mesh.add(corners);
        }
        Ok(())
    }

    fn count(&mut self, primitive: &Primitive, corners: usize) -> Result<(), SceneError> {
        self.corners += corners;
        if self.corners <= MOST_MESH_TRIANGLES {
            return Ok(());
        }
        Err(self.refuse(primitive, "is one too many", &format!("at most {MOST_MESH_TRIANGLES} corners in a file")))
    }

    /// Returns a name that nothing else has.
    fn unique(&mut self, name: &str) -> String {
        let count = self.names.entry(name.to_owned()).or_default();
        *count += 1;
        if *count == 1 { name.to_owned() } else { format!("{name} ({count})") }
    }

    fn finish(mut self) -> Result<Proposal, SceneError> {
        let mut materials = Map::new();
        let mut proposed = Vec::new();
        for (name, surfaces) in &self.used {
            let converted = &self.materials[name];
            materials.insert((*name).to_owned(), converted.bsdf.clone());
            let pattern = if self.patterned.contains(name) { "; its pattern is skipped" } else { "" };
            proposed.push(ProposedMaterial {
                name: (*name).to_owned(),
                surfaces: *surfaces,
                bsdf: converted.bsdf.clone(),
                known: format!("{}{pattern}", converted.known),
            });
        }
        for (material, mesh) in std::mem::take(&mut self.meshes) {
            let exitance_lm_m2 = self.materials[material].exitance_lm_m2;
            let name = self.unique(material);
            self.geometry.push(json!({ "name": name, "type": "mesh", "vertices": mesh.vertices, "faces": mesh.faces,
                                       "material": material, "two_sided": true }));
            if exitance_lm_m2 > 0.0 {
                self.luminaires
                    .push(json!({ "name": name, "type": "area", "surface": name, "exitance_lm_m2": exitance_lm_m2 }));
            }
        }
        for (kind, (count, first)) in &self.passed_over {
            self.warnings.push(format!("{count} of type {kind} were skipped, first {:?}", shortened(first)));
        }
        if self.geometry.is_empty() {
            let (what, got) = ("a Radiance file without a surface", format!("{} luminaires", self.luminaires.len()));
            let expected = "a polygon, sphere, cylinder, cone or ring with a material";
            return Err(SceneError::of_file(
                self.source.path,
                what.to_owned(),
                got,
                expected,
                "give the file with the surfaces",
            ));
        }
        Ok(Proposal {
            materials: proposed,
            bsdfs: materials,
            geometry: self.geometry,
            luminaires: self.luminaires,
            warnings: self.warnings,
            ..Proposal::default()
        })
    }
}

/// Returns a stand-in for a material of a type that is not read.
fn unknown(kind: &str) -> Converted {
    let known = format!("not known: materials of type {} are not supported", shortened(kind));
    Converted { bsdf: json!({ "type": "diffuse", "reflectance": UNKNOWN_REFLECTANCE }), exitance_lm_m2: 0.0, known }
}

/// The photometric mean of red, green and blue.
fn gray(rgb: [f64; 3]) -> f64 {
    rgb.iter().zip(WEIGHTS).map(|(value, weight)| value * weight).sum()
}

/// A diffuse part and a lobe. Ward's roughness α corresponds to the exponent 2/α² − 2 of Phong's lobe.
fn glossy(diffuse: f64, specular: f64, roughness: f64) -> Value {
    if specular <= 0.0 {
        return json!({ "type": "diffuse", "reflectance": diffuse });
    }
    if diffuse <= 0.0 && roughness < SMOOTH {
        return json!({ "type": "mirror", "reflectance": specular });
    }
    let roughness = roughness.clamp(SMOOTH, 1.0);
    let exponent = (2.0 / (roughness * roughness) - 2.0).max(0.0);
    json!({ "type": "phong", "diffuse_reflectance": diffuse, "specular_reflectance": specular, "exponent": exponent })
}
