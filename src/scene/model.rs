//! The valid scene: what every later room may rely on without asking again.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

use super::bodies::{Body, body_of};
use super::emission::Emission;
use super::energy::Energy;
use super::materials::Material;
use super::photometric_luminaire::Product;
use super::project::Project;
use super::quantity::Quantity;
use super::sky::DaylightTargets;
use super::standard::Requirement;

/// A surface's place in [`Scene::surfaces`].
pub type SurfaceId = u32;
/// A material's place in [`Scene::materials`].
pub type MaterialId = u32;

/// A lighting scene in metres, lumens and candelas, checked once when it was read.
///
/// Made by [`crate::read_scene`] and [`crate::scene_from_json`]; what holds there is not checked again.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Free text from the file; may be empty.
    pub title: String,
    /// Whose work it is.
    pub project: Project,
    /// What a year's energy is computed from, where that is asked for.
    pub energy: Option<Energy>,
    /// The scene file, where there is one.
    pub path: Option<PathBuf>,
    /// All materials that the file names.
    pub materials: Vec<Material>,
    /// Vertices in metres.
    pub vertices_m: Vec<DVec3>,
    /// Vertex numbers of every triangle; the front is seen counter-clockwise. None has zero area.
    pub triangles: Vec<[u32; 3]>,
    /// Into how many parts each edge of a triangle is cut: its `n²` elements have edges no longer than asked.
    pub divisions: Vec<u32>,
    /// The surface of every triangle.
    pub triangle_surfaces: Vec<SurfaceId>,
    /// Parts of geometries, in the order of the file; their triangles lie in `triangles` one range after the other.
    pub surfaces: Vec<Surface>,
    /// Smooth bodies, whose leaves are among the triangles.
    pub bodies: Vec<Arc<Body>>,
    /// Names of the surfaces that stay out of reports and of the terminal's tables.
    pub unreported: BTreeSet<String>,
    /// All luminaires; their intensities are maintained values.
    pub luminaires: Vec<Luminaire>,
    /// All sets of receivers.
    pub receivers: Vec<ReceiverSet>,
    /// What the reader thinks its user should know.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Whether reports and the terminal tell of a surface.
    pub fn is_reported(&self, surface: &str) -> bool {
        !self.unreported.contains(surface)
    }
}

/// A part of a geometry that tables list: `room/floor`, `desks/Wood`, or a whole geometry without parts.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Name as tables and luminaires use it.
    pub name: String,
    /// Name of the geometry it is a part of.
    pub geometry: String,
    /// Its material.
    pub material: MaterialId,
    /// Whether both sides reflect and are reported.
    pub two_sided: bool,
    /// Its triangles, never empty.
    pub triangles: Range<u32>,
}

/// A source of light. Everything in it is a maintained value: `dimming` and `maintenance_factor` are already in.
#[derive(Clone, Debug)]
pub struct Luminaire {
    /// Name in the file.
    pub name: String,
    /// Maintained luminous flux in lm.
    pub luminous_flux_lm: f64,
    /// Dimming, 0 to 1.
    pub dimming: f64,
    /// Maintenance factor, 0 to 1.
    pub maintenance_factor: f64,
    /// Electric power in W, not dimmed, where the scene or the photometric file tells it.
    pub power_w: Option<f64>,
    /// What its photometric file says that it is.
    pub product: Option<std::sync::Arc<Product>>,
    /// How and where it emits.
    pub emission: Emission,
}

/// A named set of points at which illuminance is asked for, or of directions of view from which luminance is.
#[derive(Clone, Debug)]
pub struct ReceiverSet {
    /// Name in the file.
    pub name: String,
    /// What is asked for at the points.
    pub quantity: Quantity,
    /// Grid or points.
    pub layout: ReceiverLayout,
    /// The points in the order of the tables (a grid row by row).
    pub points: Vec<ReceiverPoint>,
    /// Observers whose glare is rated; empty where something else is asked for.
    pub observers: Vec<GlareObserver>,
    /// What the set is to keep.
    pub requirements: Vec<Requirement>,
}

/// An observer whose glare is rated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlareObserver {
    /// The eye in m.
    pub eye_m: DVec3,
    /// Unit vector along the line of sight.
    pub view: DVec3,
    /// Within a closed solid, where nobody looks.
    pub inside: bool,
}

/// How the points of a set are arranged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReceiverLayout {
    /// `columns` × `rows` points, row by row, spanned by the vectors `u` and `v` in m.
    Grid {
        /// Points in a row.
        columns: u32,
        /// Rows.
        rows: u32,
        /// First point's corner of the grid in m.
        origin_m: DVec3,
        /// Along the columns, from the first to the last point, in m.
        u_m: DVec3,
        /// Along the rows, from the first to the last point, in m.
        v_m: DVec3,
        /// Area that the grid stands for in m².
        area_m2: f64,
    },
    /// Points in no order; directions in the order of a list.
    Points,
    /// Every n-th point of a set, where runs share them out.
    Part(super::receivers_part::ReceiversPart),
    /// Directions of view turned evenly about an axis.
    Fan {
        /// Angle of the first direction in degrees.
        from_deg: f64,
        /// Angle of the last one in degrees.
        to_deg: f64,
    },
    /// A picture: directions through the middles of the cells of a flat screen, row by row from the upper left.
    View {
        /// Cells in a row.
        columns: u32,
        /// Rows.
        rows: u32,
        /// Full angles of view across and upright in degrees.
        field_deg: [f64; 2],
    },
    /// From an eye to the elements of a surface.
    Towards {
        /// The eye in m.
        eye_m: DVec3,
    },
    /// Directions of an intensity distribution.
    Intensity(super::intensity_table::IntensityTable),
}

impl ReceiverSet {
    /// The points that lie somewhere: none where intensities of the far field are asked for.
    pub fn placed_points(&self) -> &[ReceiverPoint] {
        if self.is_far_field() { &[] } else { &self.points }
    }

    /// Whether it asks for what leaves the scene, as seen from afar.
    pub fn is_far_field(&self) -> bool {
        matches!(self.quantity, Quantity::Intensity { .. })
    }

    /// The directions of an intensity distribution, where it asks for one.
    pub fn intensity_table(&self) -> Option<&super::intensity_table::IntensityTable> {
        match &self.layout {
            ReceiverLayout::Intensity(table) => Some(table),
            _ => None,
        }
    }
}

/// A point with a direction, at which illuminance is asked for, or from which luminance is.
#[derive(Clone, Copy, Debug)]
pub struct ReceiverPoint {
    /// Place in m.
    pub position_m: DVec3,
    /// Unit normal of the receiving side; the direction of view where luminance is asked for.
    pub normal: DVec3,
    /// Weight in averages and errors (an area in m², or 1).
    pub weight: f64,
    /// Lies inside a closed solid: marked in the table, left out of averages and errors.
    pub inside: bool,
}

impl Scene {
    /// Illuminance in lx of an open horizontal plane and what daylight factors are held against, where all light is the sky's.
    pub fn daylight(&self) -> Option<(f64, DaylightTargets)> {
        let mut lit = self.luminaires.iter().filter(|luminaire| luminaire.luminous_flux_lm > 0.0);
        match (lit.next().map(|luminaire| &luminaire.emission), lit.next()) {
            (Some(Emission::Sky { sky, targets, .. }), None) => Some((sky.horizontal_lx(), *targets)),
            _ => None,
        }
    }

    /// Corners of a triangle in m.
    #[inline]
    pub fn corners_m(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.vertices_m[vertex as usize])
    }

    /// Area of a triangle in m²; of a leaf that of the smooth body.
    #[inline]
    pub fn triangle_area_m2(&self, triangle: u32) -> f64 {
        if let Some(body) = body_of(&self.bodies, triangle) {
            return body.leaf_area_m2(triangle);
        }
        let [a, b, c] = self.corners_m(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Unit normal of a triangle's front.
    #[inline]
    pub fn triangle_normal(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners_m(triangle);
        (b - a).cross(c - a).normalize()
    }

    /// Surface of a triangle.
    #[inline]
    pub fn surface_of(&self, triangle: u32) -> &Surface {
        &self.surfaces[self.triangle_surfaces[triangle as usize] as usize]
    }

    /// Number of a triangle's surface.
    pub fn surface_id_of(&self, triangle: u32) -> SurfaceId {
        self.triangle_surfaces[triangle as usize]
    }

    /// Area in m² of all surfaces, both sides of those that count on both.
    pub fn area_m2(&self) -> f64 {
        (0..self.triangles.len() as u32)
            .map(|triangle| {
                let sides = if self.surface_of(triangle).two_sided { 2.0 } else { 1.0 };
                sides * self.triangle_area_m2(triangle)
            })
            .sum()
    }

    /// Maintained flux of all luminaires in lm.
    pub fn luminous_flux_lm(&self) -> f64 {
        self.luminaires.iter().map(|luminaire| luminaire.luminous_flux_lm).sum()
    }
}
