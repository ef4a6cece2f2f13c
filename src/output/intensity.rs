//! The intensity distribution of all that leaves a scene: a table, and IES and EULUMDAT files that read back to it.

use std::f64::consts::PI;

use super::observers::maps_of;
use super::photometric_writer::{eulumdat_text, ies_text};
use super::sheet::{Field, Sheet};
use super::{OutputError, ResultFile, file_name_part};
use crate::maps::{Estimate, MapResult};
use crate::scene::photometry::IntensityWeb;
use crate::scene::{IntensityTable, Quantity, Scene};
use crate::solver::Solution;

const COLUMNS: &[&str] =
    &["receiver", "c_deg", "gamma_deg", "intensity_cd", "standard_error_cd", "direct_cd", "indirect_cd"];

/// Errors below this share of a value are rounding.
const ROUNDING: f64 = 1e-12;

/// A computed intensity distribution and what is told of it.
#[derive(Clone, Debug)]
pub struct LeavingLight<'a> {
    /// Its map.
    pub map: &'a MapResult,
    /// Its directions.
    pub table: &'a IntensityTable,
    /// The distribution as photometric files have it, the whole way round.
    pub web: IntensityWeb,
    /// Flux in lm that it adds up to.
    pub luminous_flux_lm: Estimate,
    /// That flux over the maintained flux of all luminaires of the scene.
    pub light_output_ratio: f64,
    /// The greatest intensity in cd.
    pub maximum_cd: Estimate,
    /// C and γ in degrees where it is.
    pub maximum_at_deg: [f64; 2],
    /// Maintained flux in lm of the luminaires.
    pub lamps_lm: f64,
    /// Their electric power in W, undimmed, where all of it is known; else 0.
    pub power_w: f64,
}

/// The intensity distributions of a run, in the order of the scene file.
pub fn leaving_light<'a>(scene: &'a Scene, solution: &'a Solution) -> Vec<LeavingLight<'a>> {
    let maps = maps_of(scene, solution, |quantity| matches!(quantity, Quantity::Intensity { .. }));
    maps.into_iter().filter_map(|(map, set)| of_map(scene, map, scene.receivers[set].intensity_table()?)).collect()
}

fn of_map<'a>(scene: &Scene, map: &'a MapResult, table: &'a IntensityTable) -> Option<LeavingLight<'a>> {
    let values = &map.values;
    let planes = (0..table.planes).chain(std::iter::once(0));
    let intensities_cd = planes.flat_map(|plane| (0..=table.steps).map(move |step| table.entry(plane, step)));
    let intensities_cd: Vec<f64> = intensities_cd.map(|entry| values.illuminance_lx[entry].max(0.0)).collect();
    let c_deg = (0..=table.planes).map(|plane| table.c_deg(plane)).collect();
    let gamma_deg = (0..=table.steps).map(|step| table.gamma_deg(step)).collect();
    let web = IntensityWeb::new(c_deg, gamma_deg, intensities_cd).ok()?;
    let row = map.tables.first()?;
    let flux_lm = web.luminous_flux_lm();
    let lamps_lm = scene.luminous_flux_lm();
    let most = table.places().enumerate().max_by(|(a, _), (b, _)| {
        let cd = |entry: usize| values.illuminance_lx[entry];
        // Of equal ones the first.
        cd(*a).total_cmp(&cd(*b)).then(b.cmp(a))
    });
    let (entry, (plane, step)) = most?;
    let powers: Option<Vec<f64>> = scene.luminaires.iter().map(|luminaire| luminaire.power_w).collect();
    let known = |value: f64, standard_error: f64| {
        let standard_error = if standard_error > ROUNDING * value { standard_error } else { 0.0 };
        Estimate { value, standard_error }
    };
    Some(LeavingLight {
        map,
        table,
        web,
        luminous_flux_lm: known(flux_lm, 4.0 * PI * row.average_lx.standard_error),
        light_output_ratio: if lamps_lm > 0.0 { flux_lm / lamps_lm } else { 0.0 },
        maximum_cd: known(values.illuminance_lx[entry], values.standard_error_lx[entry]),
        maximum_at_deg: [table.c_deg(plane), table.gamma_deg(step)],
        lamps_lm,
        power_w: powers.map_or(0.0, |powers| powers.iter().sum()),
    })
}

/// `intensity.csv`, and of every distribution an IES and an EULUMDAT file, where there is one.
///
/// # Errors
///
/// A number that is not finite: no table holds one.
pub(super) fn intensity_files(scene: &Scene, solution: &Solution) -> Result<Vec<ResultFile>, OutputError> {
    let all = leaving_light(scene, solution);
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let mut sheet = Sheet::new("intensity.csv", COLUMNS);
    let mut files = Vec::new();
    for light in &all {
        let values = &light.map.values;
        for (plane, step) in
            (0..light.table.planes).flat_map(|plane| (0..=light.table.steps).map(move |step| (plane, step)))
        {
            let entry = light.table.entry(plane, step);
            sheet.row(&[
                Field::Text(&light.map.name),
                Field::Number(light.table.c_deg(plane)),
                Field::Number(light.table.gamma_deg(step)),
                Field::Number(values.illuminance_lx[entry]),
                Field::Number(values.standard_error_lx[entry]),
                Field::Number(values.direct_lx[entry]),
                Field::Number(values.indirect_lx[entry]),
            ])?;
        }
        let stem = format!("intensity-{}", file_name_part(&light.map.name));
        files.push(ResultFile { name: format!("{stem}.ies"), bytes: ies_text(scene, light).into_bytes() });
        files.push(ResultFile { name: format!("{stem}.ldt"), bytes: eulumdat_text(scene, light).into_bytes() });
    }
    files.insert(0, sheet.finish());
    Ok(files)
}
