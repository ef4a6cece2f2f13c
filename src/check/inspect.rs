//! The plain facts of a scene that was read, for people and for programs.

use std::sync::Arc;

use serde::{Serialize, Serializer};

use super::faults::MeshFaults;
use super::insides::Enclosures;
use super::inspect_bodies::{InspectedBody, bodies_of};
use super::mesh_faults::mesh_faults;
use super::shells::{one_vertex_a_place, shells_over};
use crate::scene::{Elements, Side};
use crate::scene::{Luminaire, Product, Quantity, ReceiverLayout, ReceiverSet, Scene, SurfaceId};

/// The plain facts of a scene. All values are in SI and photometric units.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// Title of the scene.
    pub title: String,
    /// Its file.
    pub path: Option<String>,
    /// Units of the numbers.
    pub units: InspectedUnits,
    /// Lowest coordinates of the geometry.
    pub bounds_min_m: [f64; 3],
    /// Highest coordinates of the geometry.
    pub bounds_max_m: [f64; 3],
    /// Whether no light of the luminaires can leave the scene: around each of them lies a piece of surface without a boundary that reflects
    /// on its inside.
    pub closed: bool,
    /// Connected pieces of surface.
    pub shells: Vec<InspectedShell>,
    /// Holes, T-junctions, doubled and turned triangles.
    pub mesh: MeshFaults,
    /// All surfaces.
    pub surfaces: Vec<InspectedSurface>,
    /// Smooth bodies of spherical harmonics.
    pub bodies: Vec<InspectedBody>,
    /// All luminaires.
    pub luminaires: Vec<InspectedLuminaire>,
    /// All sets of receivers.
    pub receivers: Vec<InspectedReceivers>,
    /// Sums over the scene.
    pub totals: InspectedTotals,
    /// The reader's warnings for the user.
    pub warnings: Vec<String>,
}

/// Units of an [`Inspection`], whatever the file's `length_unit`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct InspectedUnits {
    /// Of lengths.
    pub length: &'static str,
    /// Of areas.
    pub area: &'static str,
    /// Of luminous flux.
    pub luminous_flux: &'static str,
    /// Of luminous intensity.
    pub intensity: &'static str,
}

/// A connected piece of surface. Exactly coinciding vertices of different geometries connect them.
#[derive(Clone, Debug, Serialize)]
pub struct InspectedShell {
    /// Its surfaces.
    pub surfaces: Vec<String>,
    /// Number of triangles.
    pub triangles: usize,
    /// Whether every edge is used equally often in both directions (twice in all, where the mesh is simple).
    pub closed: bool,
    /// Direction in which the fronts of a closed piece face: `inward` or `outward`.
    pub facing: Option<&'static str>,
    /// Volume enclosed by a closed piece in m³.
    pub volume_m3: Option<f64>,
}

/// A surface.
#[derive(Clone, Debug, Serialize)]
pub struct InspectedSurface {
    /// Name.
    pub name: String,
    /// Geometry that it belongs to.
    pub geometry: String,
    /// Material.
    pub material: String,
    /// Total reflectance of the material, 0 to 1; for glass at normal incidence.
    pub reflectance: f64,
    /// Total transmittance of the material, 0 to 1; for glass at normal incidence.
    pub transmittance: f64,
    /// Area of one side in m².
    pub area_m2: f64,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of elements of one side.
    pub elements: u64,
    /// Sides that reflect and are reported.
    pub sides: Vec<&'static str>,
}

/// A luminaire; all values are maintained.
#[derive(Clone, Debug, Serialize)]
pub struct InspectedLuminaire {
    /// Name.
    pub name: String,
    /// `isotropic`, `lambertian`, `photometric`, `area` or `sphere`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Position in m; for an area luminaire the middle of its surfaces.
    pub position_m: [f64; 3],
    /// Direction of γ = 0, where there is one.
    pub aim: Option<[f64; 3]>,
    /// Direction of C0 including its rotation, of photometric luminaires.
    pub c0: Option<[f64; 3]>,
    /// Product data from the photometric file.
    #[serde(serialize_with = "product_itself")]
    pub product: Option<Arc<Product>>,
    /// Luminous flux in lm.
    pub luminous_flux_lm: f64,
    /// Dimming, 0 to 1.
    pub dimming: f64,
    /// Maintenance factor, 0 to 1.
    pub maintenance_factor: f64,
    /// Electric power in W, without dimming, if the photometric file gives it.
    pub power_w: Option<f64>,
    /// Intensity on the axis in cd, of point luminaires.
    pub intensity_cd: Option<f64>,
    /// Extents of the luminous opening along C0, C90 and the axis in m, if the photometric file gives an opening with an extent.
    pub opening_m: Option<[f64; 3]>,
    /// Exitance in lm/m², of surfaces and spheres.
    pub exitance_lm_m2: Option<f64>,
    /// Surfaces that emit.
    pub surfaces: Vec<String>,
}

/// A set of receivers.
#[derive(Clone, Debug, Serialize)]
pub struct InspectedReceivers {
    /// Name.
    pub name: String,
    /// `grid` or `points`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// `perpendicular`, `cylindrical` or `semi-cylindrical` illuminance.
    pub quantity: &'static str,
    /// Number of points.
    pub points: usize,
    /// Points inside of closed solids; they are left out of tables and errors.
    pub inside: usize,
    /// Columns of a grid.
    pub columns: Option<u32>,
    /// Rows of a grid.
    pub rows: Option<u32>,
    /// Distance of a grid's points along its columns in m (for a single point: the width that it represents).
    pub column_spacing_m: Option<f64>,
    /// Distance of a grid's points along its rows in m (for a single point: the depth that it represents).
    pub row_spacing_m: Option<f64>,
    /// Area that a grid represents in m².
    pub area_m2: Option<f64>,
}

/// Sums over a scene.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct InspectedTotals {
    /// Number of surfaces.
    pub surfaces: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of element sides, the rows of the element map.
    pub element_sides: usize,
    /// Area of all surfaces, one side each, in m².
    pub area_m2: f64,
    /// Number of luminaires.
    pub luminaires: usize,
    /// Maintained luminous flux in lm.
    pub luminous_flux_lm: f64,
    /// Number of receiver points.
    pub receiver_points: usize,
}

/// Returns the contents of a scene as the reader understood it.
pub fn inspect(scene: &Scene) -> Inspection {
    let elements = Elements::of(scene);
    let [low_m, high_m] = scene.bounds_m();
    let vertex_of = one_vertex_a_place(scene);
    let shells = shells_over(scene, &vertex_of);
    let enclosures = Enclosures::of(scene, &shells);
    let surfaces = surfaces_of(scene, &elements);
    let inspected_shells = shells
        .iter()
        .map(|shell| {
            let mut ids: Vec<SurfaceId> =
                shell.triangles.iter().map(|triangle| scene.triangle_surfaces[*triangle as usize]).collect();
            ids.dedup();
            ids.sort_unstable();
            ids.dedup();
            InspectedShell {
                surfaces: ids.iter().map(|id| scene.surfaces[*id as usize].name.clone()).collect(),
                triangles: shell.triangles.len(),
                closed: shell.closed,
                facing: shell.closed.then_some(if shell.volume_m3 > 0.0 { "outward" } else { "inward" }),
                volume_m3: shell.closed.then_some(shell.volume_m3.abs()),
            }
        })
        .collect();
    Inspection {
        title: scene.title.clone(),
        path: scene.path.as_ref().map(|path| path.display().to_string()),
        units: InspectedUnits { length: "m", area: "m²", luminous_flux: "lm", intensity: "cd" },
        bounds_min_m: low_m.to_array(),
        bounds_max_m: high_m.to_array(),
        closed: enclosures.shut_in_all(),
        shells: inspected_shells,
        mesh: mesh_faults(scene, &shells, &vertex_of),
        totals: InspectedTotals {
            surfaces: surfaces.len(),
            triangles: scene.triangles.len(),
            element_sides: elements.len(),
            area_m2: surfaces.iter().map(|surface| surface.area_m2).sum(),
            luminaires: scene.luminaires.len(),
            luminous_flux_lm: scene.luminous_flux_lm(),
            receiver_points: scene.receivers.iter().map(|set| set.points.len()).sum(),
        },
        surfaces,
        bodies: bodies_of(scene),
        luminaires: scene.luminaires.iter().map(|luminaire| inspect_luminaire(scene, luminaire)).collect(),
        receivers: scene.receivers.iter().map(inspect_receivers).collect(),
        warnings: scene.warnings.clone(),
    }
}

/// Returns the surfaces alone. It skips the slower search for faults and the test whether luminaires are enclosed.
pub fn inspect_surfaces(scene: &Scene) -> Vec<InspectedSurface> {
    surfaces_of(scene, &Elements::of(scene))
}

fn surfaces_of(scene: &Scene, elements: &Elements) -> Vec<InspectedSurface> {
    (0..scene.surfaces.len() as SurfaceId).map(|id| inspect_surface(scene, elements, id)).collect()
}

fn inspect_surface(scene: &Scene, elements: &Elements, id: SurfaceId) -> InspectedSurface {
    let surface = &scene.surfaces[id as usize];
    let material = &scene.materials[surface.material as usize];
    let sides = if surface.two_sided { vec![Side::Front, Side::Back] } else { vec![Side::Front] };
    let range = elements.of_surface(scene, id);
    let [reflectance, transmittance] = material.bsdf.shares_at_normal_incidence();
    InspectedSurface {
        name: surface.name.clone(),
        geometry: surface.geometry.clone(),
        material: material.name.clone(),
        reflectance,
        transmittance,
        area_m2: surface.triangles.clone().map(|triangle| scene.triangle_area_m2(triangle)).sum(),
        triangles: surface.triangles.len(),
        elements: u64::from(range.end - range.start) / sides.len() as u64,
        sides: sides.into_iter().map(Side::name).collect(),
    }
}

fn inspect_luminaire(scene: &Scene, luminaire: &Luminaire) -> InspectedLuminaire {
    let emission = &luminaire.emission;
    let position_m = match (emission.place_m(), emission.openings()) {
        (Some(place_m), _) => place_m.to_array(),
        (None, Some(openings)) => openings.outside_m().to_array(),
        (None, None) => middle_m(scene, emission.surfaces()),
    };
    let opening_m = emission.opening().map(|opening| opening.extents_m());
    InspectedLuminaire {
        name: luminaire.name.clone(),
        kind: emission.kind_name(),
        position_m,
        aim: emission.aim().map(|aim| aim.to_array()),
        c0: emission.c0().map(|c0| c0.to_array()),
        product: luminaire.product.clone(),
        luminous_flux_lm: luminaire.luminous_flux_lm,
        dimming: luminaire.dimming,
        maintenance_factor: luminaire.maintenance_factor,
        power_w: luminaire.power_w,
        intensity_cd: emission.intensity_cd(),
        opening_m: opening_m.filter(|extents| extents.iter().any(|m| *m > 0.0)),
        exitance_lm_m2: emission.exitance_lm_m2(),
        surfaces: emission.surfaces().iter().map(|id| scene.surfaces[*id as usize].name.clone()).collect(),
    }
}

fn product_itself<S: Serializer>(product: &Option<Arc<Product>>, serializer: S) -> Result<S::Ok, S::Error> {
    product.as_deref().serialize(serializer)
}

/// Returns the middle of some surfaces, weighted by area.
fn middle_m(scene: &Scene, surfaces: &[SurfaceId]) -> [f64; 3] {
    let triangles = || surfaces.iter().flat_map(|id| scene.surfaces[*id as usize].triangles.clone());
    let area_m2: f64 = triangles().map(|triangle| scene.triangle_area_m2(triangle)).sum();
    let sum = triangles()
        .map(|triangle| scene.triangle_area_m2(triangle) * scene.corners_m(triangle).iter().sum::<glam::DVec3>() / 3.0)
        .sum::<glam::DVec3>();
    (sum / area_m2).to_array()
}

fn inspect_receivers(set: &ReceiverSet) -> InspectedReceivers {
    let mut inspected = InspectedReceivers {
        name: set.name.clone(),
        kind: "points",
        quantity: set.quantity.name(),
        points: if set.observers.is_empty() { set.points.len() } else { set.observers.len() },
        inside: match set.observers.is_empty() {
            true => set.points.iter().filter(|point| point.inside).count(),
            false => set.observers.iter().filter(|eye| eye.inside).count(),
        },
        columns: None,
        rows: None,
        column_spacing_m: None,
        row_spacing_m: None,
        area_m2: None,
    };
    inspected.kind = match set.quantity {
        Quantity::Luminance => "luminance",
        Quantity::Intensity { .. } => "intensity",
        Quantity::Glare(_) if set.observers.len() > 1 => "ugr_grid",
        Quantity::Glare(_) => "ugr",
        _ => inspected.kind,
    };
    if let ReceiverLayout::View { columns, rows, .. } = set.layout {
        (inspected.columns, inspected.rows) = (Some(columns), Some(rows));
    }
    if let ReceiverLayout::Grid { columns, rows, u_m, v_m, area_m2, .. } = set.layout {
        inspected.kind = "grid";
        inspected.columns = Some(columns);
        inspected.rows = Some(rows);
        inspected.column_spacing_m = Some(u_m.length() / f64::from(columns.max(2) - 1));
        inspected.row_spacing_m = Some(v_m.length() / f64::from(rows.max(2) - 1));
        inspected.area_m2 = Some(area_m2);
    }
    inspected
}
