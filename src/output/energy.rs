//! LENI (lighting energy) for the report and `summary.json`.

use serde_json::{Value, json};

use super::numbers::{amount, ratio};
use super::schedule::{Power, floor_area_m2};
use super::texts::say;
use crate::scene::{Energy, Scene};

/// Lighting energy of a year in kWh/m², with its basis: area in m² and installed power in W.
fn leni(scene: &Scene) -> Option<(Energy, f64, f64, f64)> {
    let energy = scene.energy?;
    let (power, area_m2) = (Power::of(scene), energy.area_m2.unwrap_or_else(|| floor_area_m2(scene)));
    let is_known = power.unknown == 0 && power.known_w > 0.0 && area_m2 > 0.0;
    is_known.then(|| (energy, area_m2, power.known_w, energy.leni_kwh_m2(power.known_w, area_m2)))
}

/// A paragraph of the report; empty if the scene does not request it or a power is unknown.
pub(super) fn energy_words(scene: &Scene) -> String {
    let Some((energy, area_m2, installed_w, leni_kwh_m2)) = leni(scene) else { return String::new() };
    let words = say!(
        "LENI {} kWh/m² a year, by the quick method of EN 15193: {} W on {} m² for {} h by day and {} h by night, \
         with the factors F<sub>C</sub> {}, F<sub>O</sub> {}, F<sub>D</sub> {}, and {} kWh/m² on standby. The \
         planner chose the hours and factors.",
        amount(leni_kwh_m2),
        amount(installed_w),
        ratio(area_m2),
        amount(energy.day_hours),
        amount(energy.night_hours),
        ratio(energy.constant_illuminance_factor),
        ratio(energy.occupancy_factor),
        ratio(energy.daylight_factor),
        ratio(energy.standby_kwh_m2)
    );
    format!("<p>{words}</p>\n")
}

/// The entry of `summary.json`; null if the scene does not request it.
pub(super) fn energy_entry(scene: &Scene) -> Value {
    let Some(energy) = scene.energy else { return Value::Null };
    let found = leni(scene);
    json!({
        "leni_kwh_m2": found.map(|(.., leni_kwh_m2)| leni_kwh_m2),
        "area_m2": found.map(|(_, area_m2, ..)| area_m2),
        "day_hours": energy.day_hours,
        "night_hours": energy.night_hours,
        "constant_illuminance_factor": energy.constant_illuminance_factor,
        "occupancy_factor": energy.occupancy_factor,
        "daylight_factor": energy.daylight_factor,
        "standby_kwh_m2": energy.standby_kwh_m2,
    })
}
