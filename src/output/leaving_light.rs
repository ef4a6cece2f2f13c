//! Computed intensity distributions and the values derived from them.

use std::f64::consts::PI;

use super::observers::maps_of;
use crate::maps::{Estimate, MapResult, ROUNDING_OF_SUMS};
use crate::scene::photometry::IntensityWeb;
use crate::scene::{IntensityTable, Quantity, Scene};
use crate::solver::Solution;

/// A computed intensity distribution and the values derived from it.
#[derive(Clone, Debug)]
pub struct LeavingLight<'a> {
    /// Its map.
    pub map: &'a MapResult,
    /// Its directions.
    pub table: &'a IntensityTable,
    /// The distribution in the form of photometric files, with all C planes.
    pub web: IntensityWeb,
    /// Total flux in lm.
    pub luminous_flux_lm: Estimate,
    /// Total flux over the maintained flux of all luminaires of the scene.
    pub light_output_ratio: f64,
    /// The greatest intensity in cd.
    pub maximum_cd: Estimate,
    /// C and γ of the greatest intensity, in degrees.
    pub maximum_at_deg: [f64; 2],
    /// Maintained flux of the luminaires in lm.
    pub lamps_lm: f64,
    /// Electric power of the luminaires in W, undimmed; 0 unless all of it is known.
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
    let intensities_cd: Vec<f64> = intensities_cd.map(|entry| values.value[entry].max(0.0)).collect();
    let c_deg = (0..=table.planes).map(|plane| table.c_deg(plane)).collect();
    let gamma_deg = (0..=table.steps).map(|step| table.gamma_deg(step)).collect();
    let web = IntensityWeb::new(c_deg, gamma_deg, intensities_cd).ok()?;
    let row = map.tables.first()?;
    let flux_lm = web.luminous_flux_lm();
    let lamps_lm = scene.luminous_flux_lm();
    let most = table.places().enumerate().max_by(|(a, _), (b, _)| {
        let cd = |entry: usize| values.value[entry];
        // Of equal intensities, the first.
        cd(*a).total_cmp(&cd(*b)).then(b.cmp(a))
    });
    let (entry, (plane, step)) = most?;
    let powers: Option<Vec<f64>> = scene.luminaires.iter().map(|luminaire| luminaire.power_w).collect();
    let known = |value: f64, standard_error: f64| {
        let standard_error = if standard_error > ROUNDING_OF_SUMS * value { standard_error } else { 0.0 };
        Estimate { value, standard_error }
    };
    Some(LeavingLight {
        map,
        table,
        web,
        luminous_flux_lm: known(flux_lm, 4.0 * PI * row.average.standard_error),
        light_output_ratio: if lamps_lm > 0.0 { flux_lm / lamps_lm } else { 0.0 },
        maximum_cd: known(values.value[entry], values.standard_error[entry]),
        maximum_at_deg: [table.c_deg(plane), table.gamma_deg(step)],
        lamps_lm,
        power_w: powers.map_or(0.0, |powers| powers.iter().sum()),
    })
}
