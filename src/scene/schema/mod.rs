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
    /// What the scene is called in results.
    title: Option<String>,
    /// Whose work it is, for the report's first page.
    project: Option<ProjectFile>,
    /// What the energy of a year's lighting is computed from, by the quick method of EN 15193.
    energy: Option<EnergyFile>,
    /// Unit of all lengths, OBJ and points files included.
    length_unit: Option<LengthUnitName>,
    /// Materials by name.
    materials: BTreeMap<String, MaterialKind>,
    /// Surfaces; their names are unique.
    #[schemars(length(min = 1))]
    geometry: Vec<GeometryKind>,
    /// Light sources; their names are unique.
    #[schemars(length(min = 1))]
    luminaires: Vec<LuminaireKind>,
    /// Points at which results are asked for; their names are unique.
    receivers: Option<Vec<ReceiverKind>>,
}

/// Whose work a scene is.
#[derive(JsonSchema)]
#[schemars(rename = "Project", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct ProjectFile {
    /// For whom.
    client: Option<String>,
    /// By whom.
    author: Option<String>,
    /// When.
    date: Option<String>,
    /// What else the client is to read.
    notes: Option<String>,
}

/// What LENI is computed from besides the luminaires' power.
#[derive(JsonSchema)]
#[schemars(rename = "Energy", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct EnergyFile {
    /// Hours of use in a year by daylight; 2250, typical of offices, by default.
    #[schemars(range(min = 0.0, max = 8784.0))]
    day_hours: Option<f64>,
    /// Hours of use in a year without daylight; 250, typical of offices, by default.
    #[schemars(range(min = 0.0, max = 8784.0))]
    night_hours: Option<f64>,
    /// What control for constant illuminance leaves of the power; 1 by default.
    #[schemars(range(min = 0.0, max = 1.0))]
    constant_illuminance_factor: Option<f64>,
    /// What control by presence leaves of the hours; 1 by default.
    #[schemars(range(min = 0.0, max = 1.0))]
    occupancy_factor: Option<f64>,
    /// What control by daylight leaves of the hours by day; 1 by default.
    #[schemars(range(min = 0.0, max = 1.0))]
    daylight_factor: Option<f64>,
    /// What controls on standby and the charging of batteries take in a year, in kWh for each m²; 0 by default.
    #[schemars(range(min = 0.0))]
    standby_kwh_m2: Option<f64>,
    /// Area in m² that counts; the floor's by default.
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

/// How far apart a grid's points are.
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

/// Where the background luminance of a glare rating is taken.
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
    /// What it turns about (default [0, 0, 1]).
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
    /// Where the middle of the picture lies.
    direction: Vector,
    /// What is up in the picture (default [0, 0, 1]).
    up: Option<Vector>,
    /// Full angles of view, across and upright, at most 170.
    field_deg: [f64; 2],
    /// Cells in a row.
    #[schemars(range(min = 1))]
    columns: u32,
    /// Rows.
    #[schemars(range(min = 1))]
    rows: u32,
}

/// What receivers are to keep: numbers, or an entry of EN 12464-1, in whose place numbers beside it go. `ugr` of observers, the others of
/// grids and points.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct Requirements {
    /// Average at least, in lx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    average_lx: Option<f64>,
    /// Minimum at least, in lx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    minimum_lx: Option<f64>,
    /// Maximum at most, in lx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    maximum_lx: Option<f64>,
    /// U0, minimum over average, at least.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    uniformity: Option<f64>,
    /// Ud, minimum over maximum, at least.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    uniformity_ud: Option<f64>,
    /// Least direct illuminance at least, in lx, times `flux_factor`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    direct_minimum_lx: Option<f64>,
    /// Least over greatest direct illuminance, at least.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    direct_uniformity_ud: Option<f64>,
    /// Glare rating of the worst observer, at most.
    #[schemars(range(min = 10.0, max = 40.0))]
    ugr: Option<f64>,
    /// Reference of an entry of EN 12464-1, such as "34.2" (2021) or "5.26.2" (2011). Numbers beside it take the place of its own.
    en_12464_1: Option<String>,
    /// Class of EN 12193 of ball games in halls: "I", "II" or "III".
    en_12193: Option<String>,
    /// Emergency lighting by EN 1838: "escape route" or "open area"; of direct light alone.
    en_1838: Option<String>,
    /// What is left of the luminous flux on batteries, for what is asked of direct light; 1 by default.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    flux_factor: Option<f64>,
    /// What of the room the entry of EN 12464-1 is asked about; the task area by default.
    area: Option<AreaName>,
    /// Whether the entry's modified average is asked for; not by default.
    modified: Option<bool>,
}

/// What a room is to keep.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct RoomRequirements {
    /// Reference of an entry of EN 12464-1, such as "34.2" (2021) or "5.26.2" (2011).
    en_12464_1: String,
    /// Whether the entry's modified average is asked for; not by default.
    modified: Option<bool>,
}

/// What of a room an entry of EN 12464-1 is asked about.
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

/// What is made about a task area by the rule of EN 12464-1: receivers in a band, and in a wider one about that.
#[derive(JsonSchema)]
#[schemars(rename = "Surroundings", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
struct SurroundingsFile {
    /// The floor that bounds the room: a geometry or a part of one; the surface that the grid lies on by default.
    within: Option<String>,
    /// Width of the immediate surroundings; 0.5 m by default, none with 0.
    #[schemars(range(min = 0.0))]
    band: Option<f64>,
    /// Width of the background; 3 m by default, none with 0.
    #[schemars(range(min = 0.0))]
    background: Option<f64>,
}

/// A grid by its corner: places at origin + (c/(columns−1))·u + (r/(rows−1))·v.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
struct ByCorners {
    /// First place.
    origin: Vector,
    /// From the first to the last column.
    u: Vector,
    /// From the first to the last row.
    v: Vector,
    /// Places in a row.
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
    /// Strip along the boundary that is left out.
    #[schemars(range(min = 0.0))]
    margin: Option<f64>,
    /// The rule "EN 12464-1" (default), or a distance.
    spacing: Option<Spacing>,
}

/// What is asked for at points.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
struct Measuring {
    /// What is asked for: on the grid's (or points') own plane (default), horizontal, vertical or cylindrical.
    quantity: Option<QuantityName>,
    /// Where vertical or semi-cylindrical illuminance looks to: a horizontal direction.
    direction: Option<Vector>,
    /// What the receivers are to keep.
    requirements: Option<Requirements>,
}

/// What is asked of observers.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
struct Observing {
    /// Lines of sight; without them eight about the vertical.
    #[schemars(length(min = 1))]
    view_directions: Option<Vec<Vector>>,
    /// Where the background luminance is taken.
    background: Option<BackgroundName>,
    /// What the ratings are to keep.
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
        /// Receivers about the task area, by rule.
        surroundings: Option<SurroundingsFile>,
    },
    /// A grid on a flat rectangular surface: points at the centres of its cells, facing as its front does.
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
        /// Receivers about the task area, by rule.
        surroundings: Option<SurroundingsFile>,
    },
    /// Points from a CSV file with the header x,y,z,nx,ny,nz and optionally area, or points that stand here.
    #[schemars(extend("oneOf" = [{"required": ["file"]}, {"required": ["points"]}]))]
    Points {
        /// Name of the receivers.
        name: String,
        /// The CSV file.
        file: Option<String>,
        /// Points instead of a file: [x, y, z, nx, ny, nz], or with an area behind them in all.
        #[schemars(length(min = 1))]
        points: Option<Vec<Vec<f64>>>,
        #[schemars(flatten)]
        measuring: Measuring,
    },
    /// Luminance seen from a point, in one of: given directions, a fan of them, a picture, the elements of a surface.
    Luminance {
        /// Name of the receivers.
        name: String,
        /// The eye.
        position: Vector,
        /// Directions of view.
        #[schemars(length(min = 1))]
        directions: Option<Vec<Vector>>,
        /// Directions turned about an axis.
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
        /// The eye.
        position: Vector,
        /// Line of sight.
        view_direction: Vector,
        /// Where the background luminance is taken: at the eye ("observer", default), or on the walls between eye and
        /// luminaires in the mean ("tabular", as UGR tables have it).
        background: Option<BackgroundName>,
        /// What the ratings are to keep.
        requirements: Option<Requirements>,
    },
    /// A whole room for an entry of EN 12464-1: task area, cylinders at the height of people's heads, walls, ceiling and observers.
    Room {
        /// Name of the room; its sets are called after it.
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
        /// The entry.
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
        /// Distance of the eyes from the front of the surface; 1.2 m without it.
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
        /// Direction of γ = 0; [0, 0, -1] without it.
        aim: Option<Vector>,
        /// Turn from C0 towards C90 about it.
        rotation_deg: Option<f64>,
        /// C planes, evenly turned (default 24); a single one stands for the mean over all.
        #[schemars(range(min = 1, max = 720))]
        c_planes: Option<u32>,
        /// Step of γ in degrees (default 5), a whole part of 180.
        #[schemars(range(min = 0.5, max = 45.0))]
        gamma_step_deg: Option<f64>,
        /// Luminous opening that the files name: extents along C0–C180, along C90–C270, and its height; a point without it.
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
