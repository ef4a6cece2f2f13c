//! The valid scene: data that all other rooms can use without further checks.

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

/// Index of a surface in [`Scene::surfaces`].
pub type SurfaceId = u32;
/// Index of a material in [`Scene::materials`].
pub type MaterialId = u32;

/// A lighting scene in metres, lumens and candelas. It is checked once, at reading.
///
/// [`crate::read_scene`] and [`crate::scene_from_json`] make it. Later code does not repeat their checks.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Free text from the file; may be empty.
    pub title: String,
    /// Client, author, date and notes of the project.
    pub project: Project,
    /// Data for the energy of a year, if the file has them.
    pub energy: Option<Energy>,
    /// Path of the scene file, if there is one.
    pub path: Option<PathBuf>,
    /// All materials that the file names.
    pub materials: Vec<Material>,
    /// Vertices in metres.
    pub vertices_m: Vec<DVec3>,
    /// Vertex numbers of every triangle, counter-clockwise as seen from the front. No triangle has zero area.
    pub triangles: Vec<[u32; 3]>,
    /// Number of parts `n` into which each edge of a triangle is cut. The edges of its `n²` elements are no longer than the file
    /// requires.
    pub divisions: Vec<u32>,
    /// The surface of every triangle.
    pub triangle_surfaces: Vec<SurfaceId>,
    /// Parts of geometries, in the order of the file. Each has one range of `triangles`; the ranges follow one another.
    pub surfaces: Vec<Surface>,
    /// Smooth bodies. Their leaves are among the triangles.
    pub bodies: Vec<Arc<Body>>,
    /// Names of the surfaces that are left out of reports and of the terminal's tables.
    pub unreported: BTreeSet<String>,
    /// All luminaires; their intensities are maintained values.
    pub luminaires: Vec<Luminaire>,
    /// All sets of receivers.
    pub receivers: Vec<ReceiverSet>,
    /// Warnings of the reader for the user.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Lowest and highest coordinates of the geometry in m.
    pub fn bounds_m(&self) -> [DVec3; 2] {
        let corners = || (0..self.triangles.len() as u32).flat_map(|triangle| self.corners_m(triangle));
        [corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max)]
    }

    /// Whether reports and the terminal show a surface.
    pub fn is_reported(&self, surface: &str) -> bool {
        !self.unreported.contains(surface)
    }
}

/// A part of a geometry with its own row in tables: `room/floor`, `desks/Wood`, or a whole geometry without parts.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Name as tables and luminaires use it.
    pub name: String,
    /// Name of the geometry that contains it.
    pub geometry: String,
    /// Its material.
    pub material: MaterialId,
    /// Whether both sides reflect and are reported.
    pub two_sided: bool,
    /// Its triangles; never empty.
    pub triangles: Range<u32>,
}

/// A source of light. Its photometric values are maintained values: they include `dimming` and `maintenance_factor`.
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
    /// Electric power in W without dimming, if the scene or the photometric file gives it.
    pub power_w: Option<f64>,
    /// Product data from its photometric file.
    pub product: Option<std::sync::Arc<Product>>,
    /// How and where it emits.
    pub emission: Emission,
}

/// A named set of points at which illuminance is computed, or of directions of view for luminance.
#[derive(Clone, Debug)]
pub struct ReceiverSet {
    /// Name in the file.
    pub name: String,
    /// Quantity that is computed at the points.
    pub quantity: Quantity,
    /// Arrangement of the points.
    pub layout: ReceiverLayout,
    /// The points in the order of the tables (a grid row by row).
    pub points: Vec<ReceiverPoint>,
    /// Observers whose glare is rated; empty for other quantities.
    pub observers: Vec<GlareObserver>,
    /// Requirements that the set must meet.
    pub requirements: Vec<Requirement>,
}

/// An observer whose glare is rated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlareObserver {
    /// The eye in m.
    pub eye_m: DVec3,
    /// Unit vector along the line of sight.
    pub view: DVec3,
    /// Whether the eye lies within a closed solid, where nobody can look.
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
        /// Corner of the grid in m: its first point.
        origin_m: DVec3,
        /// Vector along the columns, from the first to the last point, in m.
        u_m: DVec3,
        /// Vector along the rows, from the first to the last point, in m.
        v_m: DVec3,
        /// Area in m² that the grid represents.
        area_m2: f64,
    },
    /// Points in no order, or directions in the order of a list.
    Points,
    /// Every n-th point of a set, if several runs share its points.
    Part(super::receivers_part::ReceiversPart),
    /// Directions of view in a plane turned evenly about an axis.
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
        /// Full angles of view in degrees, horizontal and vertical in the picture.
        field_deg: [f64; 2],
    },
    /// Lines of sight from an eye to the elements of a surface.
    Towards {
        /// The eye in m.
        eye_m: DVec3,
    },
    /// Directions of an intensity distribution.
    Intensity(super::intensity_table::IntensityTable),
}

impl ReceiverSet {
    /// The points that have a position: none for intensities of the far field.
    pub fn placed_points(&self) -> &[ReceiverPoint] {
        if self.is_far_field() { &[] } else { &self.points }
    }

    /// Whether the set is for far-field intensities of the light that leaves the scene.
    pub fn is_far_field(&self) -> bool {
        matches!(self.quantity, Quantity::Intensity { .. })
    }

    /// The directions of the intensity distribution, if the set is for one.
    pub fn intensity_table(&self) -> Option<&super::intensity_table::IntensityTable> {
        match &self.layout {
            ReceiverLayout::Intensity(table) => Some(table),
            _ => None,
        }
    }
}

/// A point with a direction: for illuminance the normal, for luminance the direction of view.
#[derive(Clone, Copy, Debug)]
pub struct ReceiverPoint {
    /// Position in m.
    pub position_m: DVec3,
    /// Unit normal of the receiving side, or the direction of view for luminance.
    pub normal: DVec3,
    /// Weight in averages and errors (an area in m², or 1).
    pub weight: f64,
    /// Whether it lies inside a closed solid. Tables mark such points; averages and errors leave them out.
    pub inside: bool,
}

impl Scene {
    /// Illuminance in lx of an open horizontal plane, and targets for daylight factors. `None` unless all light comes from one sky.
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

    /// Area of a triangle in m². For a leaf: the area on its smooth body.
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

    /// Area in m² of all surfaces. Two-sided surfaces count with both sides.
    pub fn area_m2(&self) -> f64 {
        (0..self.triangles.len() as u32)
            .map(|triangle| {
                let sides = if self.surface_of(triangle).two_sided { 2.0 } else { 1.0 };
                sides * self.triangle_area_m2(triangle)
            })
            .sum()
    }

    /// Luminaires other than sky and sun.
    pub fn lamps(&self) -> impl Iterator<Item = &Luminaire> + Clone {
        self.luminaires.iter().filter(|luminaire| !luminaire.emission.is_daylight())
    }

    /// Maintained flux of all luminaires in lm, sky and sun included.
    pub fn luminous_flux_lm(&self) -> f64 {
        self.luminaires.iter().map(|luminaire| luminaire.luminous_flux_lm).sum()
    }
}
