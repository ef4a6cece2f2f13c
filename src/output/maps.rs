//! The tables of a run: elements, receivers, result rows and error checks.

use std::f64::consts::PI;
use std::io::Write;

use glam::DVec3;
use rayon::prelude::*;

use super::OutputError;
use super::daylight::{COMPONENT_COLUMNS, DAYLIGHT_FACTOR_COLUMNS, component_fields, mean_fields};
use super::daylight_factors::daylight_factors;
use super::observers::{maps_of, point_fields};
use super::sheet::{Sheet, SheetCell};
use super::streamed::{StreamedFile, unwritable};
use crate::estimators::basis::Linear;
use crate::maps::{MapKind, MapResult};
use crate::scene::{Elements, Emission, Quantity, Scene, Side};
use crate::solver::Solution;

/// Files whose length grows with their map.
pub(super) const ELEMENTS: &str = "elements.csv";
pub(super) const RECEIVERS: &str = "receivers.csv";

/// Rows of `elements.csv` that one thread makes at a time.
const ROWS_OF_A_PIECE: usize = 4096;

const ELEMENT_COLUMNS: &[&str] = &[
    "surface",
    "element",
    "side",
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "area_m2",
    "illuminance_lx",
    "standard_error_lx",
    "direct_lx",
    "indirect_lx",
    "exitance_lm_m2",
    "luminance_cd_m2",
    "even_lx",
    "odd_lx",
    "diffuse_luminance_cd_m2",
    "emitted_luminance_cd_m2",
    "material_type",
];
/// Columns that follow these if elements adapt.
const ADAPTIVE_COLUMNS: &[&str] =
    &["discretisation_error_lx", "gradient_x_lx_per_m", "gradient_y_lx_per_m", "gradient_z_lx_per_m"];
const RECEIVER_COLUMNS: &[&str] = &[
    "receiver",
    "index",
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "illuminance_lx",
    "standard_error_lx",
    "direct_lx",
    "indirect_lx",
    "inside",
    "even_lx",
    "odd_lx",
];
const TABLE_COLUMNS: &[&str] = &[
    "name",
    "kind",
    "side",
    "average_lx",
    "average_standard_error_lx",
    "minimum_lx",
    "minimum_standard_error_lx",
    "maximum_lx",
    "uniformity_u0",
    "uniformity_u0_standard_error",
    "uniformity_ud",
    "area_m2",
    "estimated_error",
    "maximum_standard_error_lx",
    "uniformity_ud_standard_error",
    "evaluation_points",
    "covered_area_m2",
];
const CONVERGENCE_COLUMNS: &[&str] = &[
    "wall_s",
    "rays",
    "chains",
    "estimated_error",
    "random_error",
    "bias",
    "forecast_rays",
    "forecast_rays_low",
    "forecast_rays_high",
    "forecast_wall_s",
    "forecast_wall_low_s",
    "forecast_wall_high_s",
];

/// Makes `elements.csv`, if there is an element map.
pub(super) fn element_file<'a>(scene: &'a Scene, solution: &'a Solution) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let maps = solution.maps.iter().filter(|map| map.kind == MapKind::Elements);
    let file = |map: &'a MapResult| {
        StreamedFile::new(ELEMENTS, move |writer| write_elements(scene, &solution.elements, map, writer))
    };
    Ok(maps.map(file).collect())
}

/// Makes `receivers.csv`, if there are receiver sets of illuminance.
pub(super) fn receiver_file<'a>(
    scene: &'a Scene,
    solution: &'a Solution,
) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let planes = maps_of(scene, solution, Quantity::is_illuminance);
    if planes.is_empty() {
        return Ok(Vec::new());
    }
    Ok(vec![StreamedFile::new(RECEIVERS, move |writer| write_receivers(scene, &planes, writer))])
}

fn write_elements(
    scene: &Scene,
    elements: &Elements,
    map: &MapResult,
    writer: &mut dyn Write,
) -> Result<(), OutputError> {
    let rows = ElementRows::of(scene, elements, map);
    Sheet::to(ELEMENTS, &rows.columns, &mut *writer)?.end()?;
    let firsts: Vec<usize> = (0..elements.len()).step_by(ROWS_OF_A_PIECE).collect();
    // Only one piece for each thread is in memory at a time.
    for some in firsts.chunks(rayon::current_num_threads()) {
        let pieces: Vec<Result<Vec<u8>, OutputError>> =
            some.par_iter().map(|first| rows.piece(*first, (first + ROWS_OF_A_PIECE).min(elements.len()))).collect();
        for piece in pieces {
            writer.write_all(&piece?).map_err(|error| unwritable(ELEMENTS, &error))?;
        }
    }
    Ok(())
}

/// Makes rows of `elements.csv`.
struct ElementRows<'a> {
    scene: &'a Scene,
    elements: &'a Elements,
    map: &'a MapResult,
    own_emission: OwnEmission,
    columns: Vec<&'static str>,
    adapts: bool,
    /// Number of every element within its surface. Both sides of an element share it.
    numbers: Vec<u64>,
}

impl<'a> ElementRows<'a> {
    fn of(scene: &'a Scene, elements: &'a Elements, map: &'a MapResult) -> ElementRows<'a> {
        let adapts = !map.values.slopes_lx.is_empty();
        let columns = [ELEMENT_COLUMNS, if adapts { ADAPTIVE_COLUMNS } else { &[] }].concat();
        let mut next = vec![0u64; scene.surfaces.len()];
        let mut numbers = vec![0u64; elements.len()];
        for index in 0..elements.len() {
            let element = elements.element(index as u32);
            let surface = scene.triangle_surfaces[element.triangle as usize];
            numbers[index] = match (element.side, elements.opposite(index as u32)) {
                (Side::Back, Some(front)) => numbers[front as usize],
                _ => {
                    next[surface as usize] += 1;
                    next[surface as usize] - 1
                }
            };
        }
        ElementRows { scene, elements, map, own_emission: OwnEmission::of(scene), columns, adapts, numbers }
    }

    /// Some rows in the form of the file.
    fn piece(&self, first: usize, end: usize) -> Result<Vec<u8>, OutputError> {
        let mut sheet = Sheet::behind(ELEMENTS, &self.columns, first);
        (first..end).try_for_each(|index| sheet.row(&self.fields(index)))?;
        Ok(sheet.finish().bytes)
    }

    fn fields(&self, index: usize) -> Vec<SheetCell<'a>> {
        let ElementRows { scene, elements, map, .. } = *self;
        let element = elements.element(index as u32);
        let surface = &scene.surfaces[scene.triangle_surfaces[element.triangle as usize] as usize];
        let (centroid_m, normal) = elements.middle(scene, element);
        let [diffuse_lm_m2, emitted_lm_m2] = self.own_emission.exitances_lm_m2(scene, elements, map, index as u32);
        let exitance_lm_m2 = diffuse_lm_m2 + emitted_lm_m2;
        let mut fields = vec![
            SheetCell::Text(&surface.name),
            SheetCell::Count(self.numbers[index]),
            SheetCell::Text(element.side.name()),
            SheetCell::Number(centroid_m.x),
            SheetCell::Number(centroid_m.y),
            SheetCell::Number(centroid_m.z),
            SheetCell::Number(normal.x),
            SheetCell::Number(normal.y),
            SheetCell::Number(normal.z),
            SheetCell::Number(elements.area_m2(scene, element)),
            SheetCell::Number(map.values.value[index]),
            SheetCell::Number(map.values.standard_error[index]),
            SheetCell::Number(map.values.direct[index]),
            SheetCell::Number(map.values.indirect[index]),
            SheetCell::Number(exitance_lm_m2),
            SheetCell::Number(exitance_lm_m2 / PI),
        ];
        fields.extend(halves(map, index));
        fields.extend([diffuse_lm_m2, emitted_lm_m2].map(|part_lm_m2| SheetCell::Number(part_lm_m2 / PI)));
        fields.push(SheetCell::Text(scene.materials[surface.material as usize].bsdf.name()));
        if self.adapts {
            let gradient = gradient_lx_per_m(elements.corners_m(scene, element), map.values.slopes_lx[index]);
            fields.push(SheetCell::Number(map.values.discretisation_lx[index]));
            fields.extend(gradient.to_array().map(SheetCell::Number));
        }
        fields
    }
}

/// Gradient in lx/m, in the plane of the element, of the linear function with two coefficients of [`crate::estimators::basis`].
fn gradient_lx_per_m([a, b, c]: [DVec3; 3], slopes_lx: [f64; 2]) -> DVec3 {
    // The increase of the function along two of the edges gives the in-plane vector with that increase.
    let function = Linear([0.0, slopes_lx[0], slopes_lx[1]]);
    let gains_lx = [[1.0, 0.0], [0.0, 1.0]].map(|corner| function.at(corner) - function.at([0.0, 0.0]));
    let (p, q) = (b - a, c - a);
    let normal = p.cross(q);
    (gains_lx[0] * q.cross(normal) - gains_lx[1] * p.cross(normal)) / normal.length_squared().max(f64::MIN_POSITIVE)
}

/// The exitance that area luminaires add to either side of every surface, in lm/m².
pub(super) struct OwnEmission {
    front_lm_m2: Vec<f64>,
    back_lm_m2: Vec<f64>,
}

impl OwnEmission {
    pub fn of(scene: &Scene) -> OwnEmission {
        let mut own =
            OwnEmission { front_lm_m2: vec![0.0; scene.surfaces.len()], back_lm_m2: vec![0.0; scene.surfaces.len()] };
        for luminaire in &scene.luminaires {
            let Emission::Area { surfaces, front, back, exitance_lm_m2 } = &luminaire.emission else {
                continue;
            };
            for surface in surfaces {
                own.front_lm_m2[*surface as usize] += if *front { *exitance_lm_m2 } else { 0.0 };
                own.back_lm_m2[*surface as usize] += if *back { *exitance_lm_m2 } else { 0.0 };
            }
        }
        own
    }

    /// Exitance of an element side in lm/m², in two parts: diffusely scattered light, and own emission. Light from mirrors, panes
    /// and glossy lobes is in neither part, since it depends on the direction.
    pub fn exitances_lm_m2(&self, scene: &Scene, elements: &Elements, map: &MapResult, index: u32) -> [f64; 2] {
        let element = elements.element(index);
        let surface = scene.triangle_surfaces[element.triangle as usize];
        let own_lm_m2 = self.exitance_lm_m2(surface, element.side);
        let bsdf = scene.materials[scene.surfaces[surface as usize].material as usize].bsdf;
        let behind_lx = elements.opposite(index).map_or(0.0, |other| map.values.value[other as usize]);
        let here_lx = map.values.value[index as usize];
        [bsdf.diffuse_reflectance() * here_lx + bsdf.diffuse_transmittance() * behind_lx, own_lm_m2]
    }

    fn exitance_lm_m2(&self, surface: u32, side: Side) -> f64 {
        match side {
            Side::Front => self.front_lm_m2[surface as usize],
            Side::Back => self.back_lm_m2[surface as usize],
        }
    }
}

/// Illuminance from the even and the odd half; empty cells if a method has no halves.
fn halves(map: &MapResult, index: usize) -> [SheetCell<'static>; 2] {
    map.values
        .halves
        .get(index)
        .map_or([SheetCell::Text(""), SheetCell::Text("")], |halves_lx| halves_lx.map(SheetCell::Number))
}

fn write_receivers(scene: &Scene, maps: &[(&MapResult, usize)], writer: &mut dyn Write) -> Result<(), OutputError> {
    let outside_lx = scene.daylight().map(|(outside_lx, _)| outside_lx);
    let mut columns = RECEIVER_COLUMNS.to_vec();
    if outside_lx.is_some() {
        columns.extend(DAYLIGHT_FACTOR_COLUMNS);
        columns.extend(COMPONENT_COLUMNS);
    }
    let mut sheet = Sheet::to(RECEIVERS, &columns, writer)?;
    for (map, set) in maps {
        let set = &scene.receivers[*set];
        for (index, point) in set.points.iter().enumerate() {
            let mut fields = Vec::from(point_fields(map, set, index));
            fields.extend([map.values.direct[index], map.values.indirect[index]].map(SheetCell::Number));
            fields.push(SheetCell::Flag(point.inside));
            fields.extend(halves(map, index));
            if let Some(outside_lx) = outside_lx {
                let both_lx = [map.values.value[index], map.values.standard_error[index]];
                fields.extend(both_lx.map(|lx| SheetCell::Number(100.0 * lx / outside_lx)));
                fields.extend(component_fields(&map.values, index, outside_lx));
            }
            sheet.row(&fields)?;
        }
    }
    sheet.end()
}

/// Makes `tables.csv`, with daylight factors if all light comes from the sky.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub(super) fn table_file<'a>(scene: &'a Scene, solution: &'a Solution) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let rows = solution.maps.iter().flat_map(|map| &map.tables).filter(|row| row.kind.is_illuminance());
    let factors = scene.daylight().map(|_| daylight_factors(scene, solution));
    let factors = factors.as_deref();
    let mut columns = TABLE_COLUMNS.to_vec();
    if factors.is_some() {
        columns.extend(DAYLIGHT_FACTOR_COLUMNS);
        columns.extend(COMPONENT_COLUMNS);
    }
    let mut sheet = Sheet::new("tables.csv", &columns);
    for row in rows {
        let mut fields = vec![
            SheetCell::Text(&row.name),
            SheetCell::Text(row.kind.name()),
            SheetCell::Text(row.side),
            SheetCell::Number(row.average.value),
            SheetCell::Number(row.average.standard_error),
            SheetCell::Number(row.minimum.value),
            SheetCell::Number(row.minimum.standard_error),
            SheetCell::Number(row.maximum.value),
            SheetCell::Number(row.uniformity_u0.value),
            SheetCell::Number(row.uniformity_u0.standard_error),
            SheetCell::Number(row.uniformity_ud.value),
            SheetCell::Number(row.area_m2),
            SheetCell::Number(row.estimated_error),
            SheetCell::Number(row.maximum.standard_error),
            SheetCell::Number(row.uniformity_ud.standard_error),
            SheetCell::Count(row.places as u64),
            SheetCell::Number(row.covered_area_m2),
        ];
        fields.extend(factors.into_iter().flat_map(|factors| mean_fields(factors, row)));
        sheet.row(&fields)?;
    }
    Ok(vec![sheet.finish().into()])
}

/// Makes `convergence.csv`.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub(super) fn convergence_file<'a>(_: &'a Scene, solution: &'a Solution) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let mut sheet = Sheet::new("convergence.csv", CONVERGENCE_COLUMNS);
    for row in &solution.convergence {
        sheet.row(&[
            SheetCell::Number(row.wall_s),
            SheetCell::Count(row.rays),
            SheetCell::Count(row.chains),
            SheetCell::Number(row.error.estimated),
            SheetCell::Number(row.error.random),
            SheetCell::Number(row.error.bias),
            SheetCell::Number(row.forecast_rays.expected),
            SheetCell::Number(row.forecast_rays.low),
            SheetCell::Number(row.forecast_rays.high),
            SheetCell::Number(row.forecast_wall_s.expected),
            SheetCell::Number(row.forecast_wall_s.low),
            SheetCell::Number(row.forecast_wall_s.high),
        ])?;
    }
    Ok(vec![sheet.finish().into()])
}
