//! Geometry in the scene file's schema.

use std::collections::BTreeMap;

use schemars::JsonSchema;

use super::Vector;

/// Which side of a closed shape is its front.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) enum Facing {
    Outward,
    Inward,
}

/// p′ = T·R_z·R_y·R_x·s·p.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct Transform {
    /// Scale, applied first.
    #[schemars(extend("exclusiveMinimum" = 0))]
    scale: Option<f64>,
    /// Rotations about the fixed x, y and z axes in degrees, counter-clockwise seen from the axis' tip.
    rotate_deg: Option<Vector>,
    /// Translation, applied last.
    translate: Option<Vector>,
}

/// Materials of single faces of a box.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct BoxMaterials {
    /// Lowest z.
    floor: Option<String>,
    /// Highest z.
    ceiling: Option<String>,
    /// All four walls.
    walls: Option<String>,
    /// Wall at the lowest x.
    x_min: Option<String>,
    /// Wall at the highest x.
    x_max: Option<String>,
    /// Wall at the lowest y.
    y_min: Option<String>,
    /// Wall at the highest y.
    y_max: Option<String>,
}

/// Keys of every geometry.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct CommonOfGeometry {
    /// Name of the geometry.
    name: String,
    /// Whether both sides reflect and are reported.
    two_sided: Option<bool>,
    /// Whether the report and the terminal list it (area luminaires: false by default).
    report: Option<bool>,
    /// Scale, rotation and translation.
    transform: Option<Transform>,
}

/// Geometry.
#[derive(JsonSchema)]
#[schemars(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) enum GeometryKind {
    /// An axis-parallel box; its faces are NAME/floor, /ceiling, /x_min, /x_max, /y_min and /y_max.
    Box {
        #[schemars(flatten)]
        common: CommonOfGeometry,
        /// Lowest corner.
        min: Vector,
        /// Highest corner.
        max: Vector,
        /// Which side of the faces is their front (outward by default).
        facing: Option<Facing>,
        /// Material of all faces that `materials` does not name.
        material: Option<String>,
        /// Materials of single faces.
        materials: Option<BoxMaterials>,
        /// Triangles are split into elements until no edge is longer.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max_element_edge: Option<f64>,
    },
    /// A rectangle; its normal is u × v.
    Rectangle {
        #[schemars(flatten)]
        common: CommonOfGeometry,
        /// A corner.
        origin: Vector,
        /// Vector from the corner along one side.
        u: Vector,
        /// Vector from the corner along the other side.
        v: Vector,
        /// Material.
        material: String,
        /// Triangles are split into elements until no edge is longer.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max_element_edge: Option<f64>,
    },
    /// A mesh from a Wavefront OBJ file, its parts NAME/USEMTL, or from a glTF 2.0 file, its parts NAME/MATERIAL; STL and PLY too. Or of
    /// `vertices` and `faces` that stand here.
    #[schemars(extend("oneOf" = [{"required": ["file"]}, {"required": ["vertices", "faces"]}]))]
    Mesh {
        #[schemars(flatten)]
        common: CommonOfGeometry,
        /// The OBJ, glTF, GLB, STL or PLY file.
        file: Option<String>,
        /// Vertices instead of a file.
        vertices: Option<Vec<Vector>>,
        /// The numbers of the vertices of each face, from 0, counter-clockwise seen from its front.
        #[schemars(length(min = 1))]
        faces: Option<Vec<Vec<u32>>>,
        /// Material of all parts without one of their own.
        material: Option<String>,
        /// Materials by the file's `usemtl` or material names; otherwise the scene's material of that name is used.
        materials: Option<BTreeMap<String, String>>,
        /// Triangles are split into elements until no edge is longer.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max_element_edge: Option<f64>,
    },
    /// A sphere, as triangles inscribed in it.
    Sphere {
        #[schemars(flatten)]
        common: CommonOfGeometry,
        /// Centre.
        center: Vector,
        /// Radius.
        #[schemars(extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Which side is the front (outward by default).
        facing: Option<Facing>,
        /// Material.
        material: String,
        /// Longest edge of the sphere's triangles.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max_element_edge: Option<f64>,
    },
    /// A smooth closed body whose radius by direction is a series of spherical harmonics; rays meet it exactly.
    #[schemars(rename = "spherical_harmonics")]
    SphericalHarmonics {
        #[schemars(flatten)]
        common: CommonOfGeometry,
        /// Point from which the radius is measured (the origin by default).
        center: Option<Vector>,
        /// Terms [l, m, coefficient] of r = Σ c_lm Y_lm, l up to 31; instead of a file.
        coefficients: Option<Vec<(u32, i32, f64)>>,
        /// The file of coefficients (CSV, `l,m,coefficient`).
        file: Option<String>,
        /// Which side is the front (outward by default).
        facing: Option<Facing>,
        /// Material.
        material: String,
        /// Longest chord of the body's elements.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max_element_edge: Option<f64>,
    },
}
