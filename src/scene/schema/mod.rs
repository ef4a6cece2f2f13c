//! The JSON Schema of the scene file.
//!
//! These types describe the file for [`scene_schema`] alone; the reader walks the file by itself, so that it knows the
//! places of faults. A test keeps both to the same keys.

mod geometry;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

use geometry::GeometryKind;

use super::emission::LuminaireKind;
use super::luminaire_keys::Vector;
use super::materials::MaterialKind;
use super::quantity::QuantityName;

/// JSON Schema (draft 2020-12) of the scene file, with the kinds that are accepted as files but not computed yet.
pub fn scene_schema() -> Value {
    let mut schema = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<SceneFile>().to_value();
    without_null(&mut schema);
    schema
}

/// A key that may be left out is still no key that may be null.
fn without_null(schema: &mut Value) {
    match schema {
        Value::Array(values) => values.iter_mut().for_each(without_null),
        Value::Object(keys) => {
            keys.values_mut().for_each(without_null);
            if let Some(Value::Array(types)) = keys.get_mut("type") {
                types.retain(|name| name != "null");
                if let [only] = types.as_slice() {
                    let only = only.clone();
                    keys.insert("type".into(), only);
                }
            }
            let choices = keys.get_mut("anyOf").and_then(Value::as_array_mut);
            if let Some(choices) = choices.filter(|choices| choices.iter().any(|choice| choice["type"] == "null")) {
                choices.retain(|choice| choice["type"] != "null");
                if let [Value::Object(only)] = choices.as_slice() {
                    let only = only.clone();
                    keys.remove("anyOf");
                    keys.extend(only);
                }
            }
        }
        _ => {}
    }
}

/// A lighting scene for luxmc. Lengths are in `length_unit`; photometric quantities in lm, cd and lm/m². File names are relative to the scene file.
#[derive(JsonSchema)]
#[schemars(title = "luxmc scene", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct SceneFile {
    /// Version of the file format.
    #[schemars(extend("const" = 1))]
    version: u32,
    /// Title of the scene in results.
    title: Option<String>,
    /// Client, author and date, for the report's first page.
    project: Option<ProjectFile>,
    /// Data for the yearly lighting energy (LENI) by the quick method of EN 15193.
    energy: Option<EnergyFile>,
    /// Unit of all lengths, also of those in OBJ and points files.
    length_unit: Option<LengthUnitName>,
    /// Materials by name.
    materials: BTreeMap<String, MaterialKind>,
    /// Surfaces; their names are unique.
    #[schemars(length(min = 1))]
    geometry: Vec<GeometryKind>,
    /// Light sources; their names are unique.
    #[schemars(length(min = 1))]
    luminaires: Vec<LuminaireKind>,
    /// Points for which results are computed; their names are unique.
    receivers: Option<Vec<ReceiverKind>>,
}

/// Client, author and date of the work.
#[derive(JsonSchema)]
#[schemars(rename = "Project", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct ProjectFile {
    /// Client.
    client: Option<String>,
    /// Author.
    author: Option<String>,
    /// Date.
    date: Option<String>,
    /// Further text for the client.
    notes: Option<String>,
}

/// Data for LENI besides the power of the luminaires.
#[derive(JsonSchema)]
#[schemars(rename = "Energy", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct EnergyFile {
    /// Hours of use per year during daylight; 2250, typical of offices, by default.
    #[schemars(range(min = 0.0, max = 8784.0))]
    day_hours: Option<f64>,
    /// Hours of use per year without daylight; 250, typical of offices, by default.
    #[schemars(range(min = 0.0, max = 8784.0))]
    night_hours: Option<f64>,
    /// Share of the power that remains with control for constant illuminance; 1 by default.
    #[schemars(range(min = 0.0, max = 1.0))]
    constant_illuminance_factor: Option<f64>,
    /// Share of the hours that remains with control by presence; 1 by default.
    #[schemars(range(min = 0.0, max = 1.0))]
    occupancy_factor: Option<f64>,
    /// Share of the daylight hours that remains with control by daylight; 1 by default.
    #[schemars(range(min = 0.0, max = 1.0))]
    daylight_factor: Option<f64>,
    /// Yearly energy of controls on standby and of battery charging in kWh per m²; 0 by default.
    #[schemars(range(min = 0.0))]
    standby_kwh_m2: Option<f64>,
    /// Reference area in m²; the floor's by default.
    #[schemars(extend("exclusiveMinimum" = 0))]
    area_m2: Option<f64>,
}

/// Length unit.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
#[expect(dead_code, reason = "only its shape is used")]
enum LengthUnitName {
    M,
    Mm,
    Cm,
    In,
    Ft,
}

/// Spacing of a grid's points.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its shape is used")]
enum Spacing {
    /// A rule.
    Rule(SpacingRule),
    /// A distance.
    Distance(#[schemars(extend("exclusiveMinimum" = 0))] f64),
}

/// A rule for a grid's points.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
enum SpacingRule {
    /// p = 0.2·5^(log₁₀ d) m, at most 10 m.
    #[schemars(rename = "EN 12464-1")]
    En12464,
}

/// Where the background luminance of a glare rating is determined.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
#[expect(dead_code, reason = "only its shape is used")]
enum BackgroundName {
    Observer,
    Tabular,
}

/// Directions of view turned evenly about an axis, counter-clockwise seen from its tip.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct Fan {
    /// The direction at 0°.
    direction: Vector,
    /// Axis of the fan (default [0, 0, 1]).
    axis: Option<Vector>,
    /// Angle of the first direction.
    from_deg: f64,
    /// Angle of the last direction.
    to_deg: f64,
    /// Number of directions.
    #[schemars(range(min = 1))]
    count: u32,
}

/// A picture on a flat screen: one direction through the middle of each cell, row by row from the upper left.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct View {
    /// Direction of the middle of the picture.
    direction: Vector,
    /// Upward direction in the picture (default [0, 0, 1]).
    up: Option<Vector>,
    /// Full angles of view in degrees, across and upright, at most 170.
    field_deg: [f64; 2],
    /// Cells in a row.
    #[schemars(range(min = 1))]
    columns: u32,
    /// Rows.
    #[schemars(range(min = 1))]
    rows: u32,
}

/// Requirements of receivers: numbers, or an entry of EN 12464-1; numbers given together with an entry replace those of the entry. `ugr`
/// applies to observers, the others to grids and points.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct Requirements {
    /// Least average, in lx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    average_lx: Option<f64>,
    /// Least minimum, in lx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    minimum_lx: Option<f64>,
    /// Greatest maximum, in lx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    maximum_lx: Option<f64>,
    /// Least uniformity U0, minimum over average.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    uniformity: Option<f64>,
    /// Least uniformity Ud, minimum over maximum.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    uniformity_ud: Option<f64>,
    /// Required minimum of the direct illuminance times `flux_factor`, in lx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    direct_minimum_lx: Option<f64>,
    /// Required minimum over maximum of the direct illuminance.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    direct_uniformity_ud: Option<f64>,
    /// Greatest glare rating of any observer.
    #[schemars(range(min = 10.0, max = 40.0))]
    ugr: Option<f64>,
    /// Reference of an entry of EN 12464-1, such as "34.2" (2021) or "5.26.2" (2011). Numbers beside it replace those of the entry.
    en_12464_1: Option<String>,
    /// Class of EN 12193 of ball games in halls: "I", "II" or "III".
    en_12193: Option<String>,
    /// Emergency lighting by EN 1838: "escape route" or "open area"; direct light only.
    en_1838: Option<String>,
    /// Share of the luminous flux that remains on batteries, for requirements on direct light; 1 by default.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    flux_factor: Option<f64>,
    /// Part of the room to which the entry of EN 12464-1 applies; the task area by default.
    area: Option<AreaName>,
    /// Whether the entry's modified average is required; false by default.
    modified: Option<bool>,
}

/// Requirements of a room.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct RoomRequirements {
    /// Reference of an entry of EN 12464-1, such as "34.2" (2021) or "5.26.2" (2011).
    en_12464_1: String,
    /// Whether the entry's modified average is required; false by default.
    modified: Option<bool>,
}

/// Part of a room to which an entry of EN 12464-1 applies.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
#[expect(dead_code, reason = "only its shape is used")]
enum AreaName {
    Task,
    Surroundings,
    Background,
    Walls,
    Ceiling,
}

/// Receivers around a task area by the rule of EN 12464-1: in a band, and in a wider one around that.
#[derive(JsonSchema)]
#[schemars(rename = "Surroundings", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct SurroundingsFile {
    /// The floor that bounds the room: a geometry or a part of one; by default the surface on which the grid lies.
    within: Option<String>,
    /// Width of the immediate surroundings; 0.5 m by default, 0 for none.
    #[schemars(range(min = 0.0))]
    band: Option<f64>,
    /// Width of the background; 3 m by default, 0 for none.
    #[schemars(range(min = 0.0))]
    background: Option<f64>,
}

/// A grid given by its corner: points at origin + (c/(columns−1))·u + (r/(rows−1))·v.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
struct ByCorners {
    /// First point.
    origin: Vector,
    /// Vector from the first to the last column.
    u: Vector,
    /// Vector from the first to the last row.
    v: Vector,
    /// Points in a row.
    #[schemars(range(min = 1))]
    columns: u32,
    /// Rows.
    #[schemars(range(min = 1))]
    rows: u32,
}

/// A grid over a surface.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
struct OverASurface {
    /// A geometry or a part of one.
    surface: String,
    /// Width of the strip along the boundary that is left out.
    #[schemars(range(min = 0.0))]
    margin: Option<f64>,
    /// The rule "EN 12464-1" (default), or a distance.
    spacing: Option<Spacing>,
}

/// Quantity and requirements of points.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
struct Measuring {
    /// Illuminance that is computed: on the grid's (or points') own plane (default), horizontal, vertical, cylindrical or semi-cylindrical.
    quantity: Option<QuantityName>,
    /// Horizontal direction that the plane of vertical, or the half cylinder of semi-cylindrical, illuminance faces.
    direction: Option<Vector>,
    /// Requirements of the receivers.
    requirements: Option<Requirements>,
}

/// Lines of sight, background and requirements of observers.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
struct Observing {
    /// Lines of sight; by default eight horizontal ones all around.
    #[schemars(length(min = 1))]
    view_directions: Option<Vec<Vector>>,
    /// Where the background luminance is determined.
    background: Option<BackgroundName>,
    /// Requirements of the ratings.
    requirements: Option<Requirements>,
}

/// Receivers.
#[derive(JsonSchema)]
#[schemars(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
enum ReceiverKind {
    /// A grid given by its corner: points at origin + (c/(columns−1))·u + (r/(rows−1))·v; its normal is u × v.
    Grid {
        /// Name of the receivers.
        name: String,
        #[schemars(flatten)]
        corners: ByCorners,
        #[schemars(flatten)]
        measuring: Measuring,
        /// Receivers around the task area, by the rule of EN 12464-1.
        surroundings: Option<SurroundingsFile>,
    },
    /// A grid on a flat rectangular surface: points at the centres of its cells, facing the same way as its front.
    #[schemars(rename = "grid")]
    SurfaceGrid {
        /// Name of the receivers.
        name: String,
        /// Distance from the front of the surface.
        #[schemars(range(min = 0.0))]
        height: Option<f64>,
        #[schemars(flatten)]
        over: OverASurface,
        #[schemars(flatten)]
        measuring: Measuring,
        /// Receivers around the task area, by the rule of EN 12464-1.
        surroundings: Option<SurroundingsFile>,
    },
    /// Points from a CSV file with the header x,y,z,nx,ny,nz and optionally area, or points given here.
    #[schemars(extend("oneOf" = [{"required": ["file"]}, {"required": ["points"]}]))]
    Points {
        /// Name of the receivers.
        name: String,
        /// The CSV file.
        file: Option<String>,
        /// Points instead of a file: [x, y, z, nx, ny, nz], or with an area as seventh number in all.
        #[schemars(length(min = 1))]
        points: Option<Vec<Vec<f64>>>,
        #[schemars(flatten)]
        measuring: Measuring,
    },
    /// Luminance seen from a point, in one of: given directions, a fan of them, a picture, the elements of a surface.
    Luminance {
        /// Name of the receivers.
        name: String,
        /// Position of the eye.
        position: Vector,
        /// Directions of view.
        #[schemars(length(min = 1))]
        directions: Option<Vec<Vector>>,
        /// Directions in a fan about an axis.
        fan: Option<Fan>,
        /// A picture on a flat screen.
        view: Option<View>,
        /// A geometry or a part of one: the luminance of each of its elements towards the eye.
        surface: Option<String>,
    },
    /// Unified glare rating of an observer (CIE 117).
    Ugr {
        /// Name of the receiver.
        name: String,
        /// Position of the eye.
        position: Vector,
        /// Line of sight.
        view_direction: Vector,
        /// Where the background luminance is determined: at the eye ("observer", default), or as a mean over the walls between eye and
        /// luminaires ("tabular", as in UGR tables).
        background: Option<BackgroundName>,
        /// Requirements of the ratings.
        requirements: Option<Requirements>,
    },
    /// A whole room for an entry of EN 12464-1: task area, cylinders at the height of people's heads, walls, ceiling and observers.
    Room {
        /// Name of the room; the names of its receiver sets begin with it.
        name: String,
        /// The room: a box that faces inward, or a mesh whose parts are rectangles.
        surface: String,
        /// Height of the task area over the floor; 0.8 m by default.
        #[schemars(range(min = 0.0))]
        height: Option<f64>,
        /// Height of people's eyes over the floor; 1.2 m by default.
        #[schemars(range(min = 0.0))]
        eye_height: Option<f64>,
        /// Width of a strip along the walls that is left out of the task area; 0.5 m by default.
        #[schemars(range(min = 0.0))]
        margin: Option<f64>,
        /// The entry of EN 12464-1.
        requirements: RoomRequirements,
    },
    /// Unified glare ratings of observers over a parallelogram, each looking in all directions of view.
    #[schemars(rename = "ugr_grid")]
    UgrGrid {
        /// Name of the receivers.
        name: String,
        #[schemars(flatten)]
        corners: ByCorners,
        #[schemars(flatten)]
        observing: Observing,
    },
    /// Unified glare ratings of observers over a flat rectangular surface, each looking in all directions of view.
    #[schemars(rename = "ugr_grid")]
    UgrGridOverSurface {
        /// Name of the receivers.
        name: String,
        /// Distance of the eyes from the front of the surface; 1.2 m by default.
        #[schemars(range(min = 0.0))]
        height: Option<f64>,
        #[schemars(flatten)]
        over: OverASurface,
        #[schemars(flatten)]
        observing: Observing,
    },
    /// Far-field intensity distribution of all light that leaves the scene, in C planes, as a table and as photometric files.
    Intensity {
        /// Name of the receiver.
        name: String,
        /// Direction of γ = 0; [0, 0, -1] by default.
        aim: Option<Vector>,
        /// Rotation of C0 towards C90 about this direction, in degrees.
        rotation_deg: Option<f64>,
        /// Number of C planes, evenly spaced (default 24); a single one is the mean over all.
        #[schemars(range(min = 1, max = 720))]
        c_planes: Option<u32>,
        /// Step of γ in degrees (default 5): 180 divided by a whole number.
        #[schemars(range(min = 0.5, max = 45.0))]
        gamma_step_deg: Option<f64>,
        /// Luminous opening that the files name: extents along C0–C180, along C90–C270, and its height; a point by default.
        #[schemars(length(min = 3, max = 3))]
        luminous_opening: Option<Vec<f64>>,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Keys of the alternatives of a definition, by the value of `type`.
    fn keys_of(schema: &Value, definition: &str) -> BTreeMap<String, BTreeSet<String>> {
        let mut keys: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for variant in schema["$defs"][definition]["oneOf"].as_array().expect("alternatives") {
            assert_eq!(variant["additionalProperties"], false, "{definition}");
            let properties = variant["properties"].as_object().expect("properties");
            let kind = variant["properties"]["type"]["const"].as_str().expect("a type").to_string();
            keys.entry(kind).or_default().extend(properties.keys().cloned());
        }
        keys
    }

    #[test]
    fn the_schema_and_the_reader_know_the_same_keys() {
        let schema = scene_schema();
        type Keys = fn(usize) -> Vec<&'static str>;
        for (definition, types, keys) in [
            ("MaterialKind", &crate::scene::materials::TYPES[..], crate::scene::materials::keys as Keys),
            ("GeometryKind", &crate::scene::surfaces::TYPES, crate::scene::surfaces::keys),
            ("LuminaireKind", &crate::scene::emission::TYPES, crate::scene::luminaires::keys),
            ("ReceiverKind", &crate::scene::receivers::TYPES, crate::scene::receivers::keys),
        ] {
            let of_kind = |kind| keys(kind).into_iter().map(str::to_owned).collect();
            let read: BTreeMap<String, BTreeSet<String>> =
                types.iter().enumerate().map(|(kind, name)| (name.to_string(), of_kind(kind))).collect();
            assert_eq!(keys_of(&schema, definition), read);
        }
        for (pointer, keys) in [
            ("/properties", &crate::scene::file::KEYS[..]),
            ("/$defs/Project/properties", &crate::scene::project::KEYS),
            ("/$defs/Energy/properties", &crate::scene::energy::KEYS),
            ("/$defs/Transform/properties", &crate::scene::placing::KEYS),
            ("/$defs/BoxMaterials/properties", &crate::scene::surfaces::BOX_MATERIALS),
            ("/$defs/Fan/properties", &crate::scene::observers::FAN_KEYS),
            ("/$defs/View/properties", &crate::scene::observers::VIEW_KEYS),
            ("/$defs/Requirements/properties", &crate::scene::standard::KEYS),
            ("/$defs/RoomRequirements/properties", &crate::scene::requirements::ROOM_KEYS),
            ("/$defs/Surroundings/properties", &crate::scene::surroundings::KEYS),
        ] {
            let described: BTreeSet<&str> =
                schema.pointer(pointer).expect(pointer).as_object().expect("keys").keys().map(String::as_str).collect();
            assert_eq!(described, keys.iter().copied().collect(), "{pointer}");
        }
    }

    #[test]
    fn the_schema_and_the_reader_know_the_same_choices() {
        let schema = scene_schema().to_string();
        for names in [
            &crate::scene::units::UNIT_NAMES[..],
            &crate::scene::surfaces::FACINGS,
            &crate::scene::emission::DISTRIBUTIONS,
            &crate::scene::luminaire_reading::SIDES,
            &crate::scene::sky::DISTRIBUTIONS,
            &crate::scene::standard::AREAS.map(crate::scene::Area::name),
        ] {
            assert!(schema.contains(&format!("\"enum\":{}", serde_json::json!(names))), "{names:?}");
        }
        assert!(schema.contains(crate::scene::receivers::SPACING_RULES[0]));
    }

    #[test]
    fn nothing_may_be_null() {
        assert!(!scene_schema().to_string().contains("null"));
    }
}
