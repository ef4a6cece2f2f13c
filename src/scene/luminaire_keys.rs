//! Keys of luminaires, also those that several types share, for the scene file's schema.

use schemars::JsonSchema;

/// Three numbers: x, y, z.
pub(super) type Vector = [f64; 3];

/// How a point luminaire's intensity depends on direction.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
#[expect(dead_code, reason = "only its shape is used")]
enum Distribution {
    Isotropic,
    Lambertian,
}

/// Sides of a surface that emit.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
#[expect(dead_code, reason = "only its shape is used")]
enum EmittingSide {
    Front,
    Back,
    Both,
}

/// How a sky's luminance depends on direction.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
enum SkyDistribution {
    #[schemars(rename = "uniform")]
    Uniform,
    #[schemars(rename = "overcast")]
    Overcast,
    #[schemars(rename = "CIE 1")]
    Cie1,
    #[schemars(rename = "CIE 2")]
    Cie2,
    #[schemars(rename = "CIE 3")]
    Cie3,
    #[schemars(rename = "CIE 4")]
    Cie4,
    #[schemars(rename = "CIE 5")]
    Cie5,
    #[schemars(rename = "CIE 6")]
    Cie6,
    #[schemars(rename = "CIE 7")]
    Cie7,
    #[schemars(rename = "CIE 8")]
    Cie8,
    #[schemars(rename = "CIE 9")]
    Cie9,
    #[schemars(rename = "CIE 10")]
    Cie10,
    #[schemars(rename = "CIE 11")]
    Cie11,
    #[schemars(rename = "CIE 12")]
    Cie12,
    #[schemars(rename = "CIE 13")]
    Cie13,
    #[schemars(rename = "CIE 14")]
    Cie14,
    #[schemars(rename = "CIE 15")]
    Cie15,
    Perez,
}

/// Brightness of an extended luminaire: one of the two keys.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct Brightness {
    /// Exitance in lm/m².
    #[schemars(range(min = 0.0))]
    exitance_lm_m2: Option<f64>,
    /// Luminous flux in lm.
    #[schemars(range(min = 0.0))]
    luminous_flux_lm: Option<f64>,
}

/// Operation of a luminaire.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct Operation {
    /// Dimming level, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    dimming: Option<f64>,
    /// Maintenance factor.
    #[schemars(range(min = 0.0, max = 1.0))]
    maintenance_factor: Option<f64>,
    /// Electric power of one luminaire in W, undimmed and including the ballast; by default the value in the photometric file.
    #[schemars(range(min = 0.0))]
    power_w: Option<f64>,
}

/// Place and time for the sun's position.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
struct PlaceAndTime {
    /// Latitude, north positive.
    #[schemars(range(min = -90.0, max = 90.0))]
    latitude_deg: Option<f64>,
    /// Longitude, east positive.
    #[schemars(range(min = -180.0, max = 180.0))]
    longitude_deg: Option<f64>,
    /// Date, time and zone, such as "2026-06-21T12:30:00+02:00".
    date_time: Option<String>,
}

/// An array of equal luminaires.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct Array {
    /// Luminaires in a row: an array of copies, named "NAME 1", "NAME 2", … row by row; the first is at this position.
    #[schemars(range(min = 1))]
    columns: Option<u32>,
    /// Rows of the array.
    #[schemars(range(min = 1))]
    rows: Option<u32>,
    /// Vector from the first to the last column of the array.
    u: Option<Vector>,
    /// Vector from the first to the last row of the array.
    v: Option<Vector>,
}

/// Keys of a point.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct PointKeys {
    /// Name of the luminaire.
    name: String,
    /// Position.
    position: Vector,
    /// Isotropic by default; lambertian is I₀ cos γ about `aim`.
    distribution: Option<Distribution>,
    /// Direction of γ = 0; [0, 0, −1] by default.
    aim: Option<Vector>,
    /// Intensity on the axis in cd.
    #[schemars(range(min = 0.0))]
    intensity_cd: Option<f64>,
    /// Luminous flux in lm.
    #[schemars(range(min = 0.0))]
    luminous_flux_lm: Option<f64>,
    #[schemars(flatten)]
    operation: Operation,
    #[schemars(flatten)]
    array: Array,
}

/// Keys of a luminous ball.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct SphereKeys {
    /// Name of the luminaire.
    name: String,
    /// Centre.
    center: Vector,
    /// Radius.
    #[schemars(extend("exclusiveMinimum" = 0))]
    radius: f64,
    #[schemars(flatten)]
    brightness: Brightness,
    #[schemars(flatten)]
    operation: Operation,
    #[schemars(flatten)]
    array: Array,
}

/// Keys of a luminous ring.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct RingKeys {
    /// Name of the luminaire.
    name: String,
    /// Centre.
    center: Vector,
    /// Radius of the hole; 0 by default, which makes a disk.
    #[schemars(range(min = 0.0))]
    inner_radius: Option<f64>,
    /// Radius of the rim.
    #[schemars(extend("exclusiveMinimum" = 0))]
    outer_radius: f64,
    /// Direction of γ = 0; [0, 0, −1] by default.
    aim: Option<Vector>,
    #[schemars(flatten)]
    brightness: Brightness,
    #[schemars(flatten)]
    operation: Operation,
    #[schemars(flatten)]
    array: Array,
}

/// Keys of a luminous surface.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct AreaKeys {
    /// Name of the luminaire.
    name: String,
    /// A geometry or a part of one; it keeps its material.
    surface: String,
    /// Which side emits (front by default).
    side: Option<EmittingSide>,
    /// Exitance in lm/m².
    #[schemars(range(min = 0.0))]
    exitance_lm_m2: Option<f64>,
    /// Luminous flux of all emitting sides together in lm.
    #[schemars(range(min = 0.0))]
    luminous_flux_lm: Option<f64>,
    #[schemars(flatten)]
    operation: Operation,
}

/// Keys of a sky.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct SkyKeys {
    /// Name of the luminaire.
    name: String,
    /// Uniform, the traditional overcast sky, one of the general skies of ISO 15469, or the all-weather sky of Perez.
    luminance_distribution: SkyDistribution,
    /// Elevation of the sun in degrees, for skies that depend on it.
    #[schemars(range(min = 0.0, max = 90.0))]
    sun_elevation_deg: Option<f64>,
    /// Azimuth of the sun in degrees, from +y (north) towards +x (east); 180 by default.
    sun_azimuth_deg: Option<f64>,
    #[schemars(flatten)]
    place_and_time: PlaceAndTime,
    /// Luminance of the zenith in cd/m².
    #[schemars(range(min = 0.0))]
    zenith_luminance_cd_m2: Option<f64>,
    /// Horizontal illuminance in lx on an open plane from the sky alone.
    #[schemars(range(min = 0.0))]
    horizontal_illuminance_lx: Option<f64>,
    /// Direct normal illuminance in lx, for Perez's sky; the sun itself is not part of that sky.
    #[schemars(range(min = 0.0))]
    direct_normal_illuminance_lx: Option<f64>,
    /// Diffuse horizontal illuminance in lx on an open plane from the sky alone, for Perez's sky.
    #[schemars(extend("exclusiveMinimum" = 0))]
    diffuse_horizontal_illuminance_lx: Option<f64>,
    /// Reflectance of the ground, which fills everything below the horizon; 0 by default.
    #[schemars(range(min = 0.0, max = 1.0))]
    ground_reflectance: Option<f64>,
    /// Median diffuse horizontal illuminance of the site in lx, for the daylight factors that EN 17037 requires; 15,000 by default.
    #[schemars(extend("exclusiveMinimum" = 0))]
    median_diffuse_illuminance_lx: Option<f64>,
    #[schemars(flatten)]
    operation: Operation,
}

/// Keys of a sun.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct SunKeys {
    /// Name of the luminaire.
    name: String,
    /// Elevation in degrees; or place and time.
    #[schemars(range(min = -90.0, max = 90.0))]
    sun_elevation_deg: Option<f64>,
    /// Azimuth from +y (north) towards +x (east); 180 by default.
    sun_azimuth_deg: Option<f64>,
    #[schemars(flatten)]
    place_and_time: PlaceAndTime,
    /// Illuminance in lx from the sun alone on a plane perpendicular to its rays.
    #[schemars(range(min = 0.0))]
    normal_illuminance_lx: Option<f64>,
    /// Illuminance in lx from the sun alone on an open horizontal plane.
    #[schemars(range(min = 0.0))]
    horizontal_illuminance_lx: Option<f64>,
    #[schemars(flatten)]
    operation: Operation,
}

/// Keys of a luminaire from a photometric file.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct PhotometricKeys {
    /// Name of the luminaire.
    name: String,
    /// The file.
    file: String,
    /// Centre of the luminous opening.
    position: Vector,
    /// Direction of γ = 0; [0, 0, −1] by default.
    aim: Option<Vector>,
    /// Turns C0 towards C90. At 0 a luminaire that aims straight down has C0 along +x and C90 along +y.
    rotation_deg: Option<f64>,
    #[schemars(flatten)]
    operation: Operation,
    #[schemars(flatten)]
    array: Array,
}
