//! The luminaire schedule: luminaires grouped by kind, and their power and flux.

use std::sync::Arc;

use super::texts::words;
use crate::scene::{Emission, Luminaire, Scene};

/// Largest number of kinds with a row each; all luminaires of further kinds share the last row.
const MOST_KINDS: usize = 60;

/// Luminaires that differ only in name, position and aim, or the rest of very many kinds.
#[derive(Clone, Debug)]
pub struct ScheduleRow {
    /// Letter of these luminaires on the plan.
    pub letter: String,
    /// Their indices in [`Scene::luminaires`].
    pub members: Vec<usize>,
    /// How they emit, in words.
    pub kind: &'static str,
    /// Whether they are of one kind; otherwise their values differ.
    pub is_one_kind: bool,
}

/// Luminaires grouped by kind, in the order of the scene, with a readable number of rows.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// One row for each kind.
    pub rows: Vec<ScheduleRow>,
}

/// Electric power of the luminaires of a scene, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Power {
    /// Sum of the known powers in W, undimmed.
    pub known_w: f64,
    /// Number of luminaires whose power is unknown.
    pub unknown: usize,
}

impl Schedule {
    /// Groups the luminaires of a scene.
    pub fn of(scene: &Scene) -> Schedule {
        let mut rows: Vec<ScheduleRow> = Vec::new();
        for (index, luminaire) in scene.luminaires.iter().enumerate() {
            let takes =
                |row: &&mut ScheduleRow| !row.is_one_kind || are_alike(&scene.luminaires[row.members[0]], luminaire);
            match rows.iter_mut().find(takes) {
                Some(row) => row.members.push(index),
                None => rows.push(ScheduleRow {
                    letter: letters(rows.len()),
                    members: vec![index],
                    kind: if rows.len() < MOST_KINDS { luminaire.emission.words() } else { words!("of further kinds") },
                    is_one_kind: rows.len() < MOST_KINDS,
                }),
            }
        }
        Schedule { rows }
    }

    /// The letter of a luminaire.
    pub fn letter_of(&self, luminaire: usize) -> &str {
        self.rows.iter().find(|row| row.members.contains(&luminaire)).map_or("", |row| &row.letter)
    }
}

impl Power {
    /// Power of all luminaires.
    pub fn of(scene: &Scene) -> Power {
        let known_w =
            scene.luminaires.iter().filter_map(|luminaire| luminaire.power_w).fold(0.0, |sum, power_w| sum + power_w);
        // Daylight uses no power.
        let draws = |luminaire: &&Luminaire| !luminaire.emission.is_daylight();
        let unknown = scene.luminaires.iter().filter(draws).filter(|luminaire| luminaire.power_w.is_none()).count();
        Power { known_w, unknown }
    }
}

/// The letters of a row: A, B, …, Z, AA, AB, …
fn letters(index: usize) -> String {
    let letter = char::from(b'A' + (index % 26) as u8);
    if index < 26 { letter.to_string() } else { format!("{}{letter}", letters(index / 26 - 1)) }
}

fn are_alike(one: &Luminaire, other: &Luminaire) -> bool {
    // The fluxes of equal lamps may differ by rounding, if they follow from an area.
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs());
    let distribution = match (&one.emission, &other.emission) {
        (Emission::Photometric { web: a, .. }, Emission::Photometric { web: b, .. }) => Arc::ptr_eq(a, b) || a == b,
        (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
    };
    distribution
        && close(one.luminous_flux_lm, other.luminous_flux_lm)
        && one.dimming == other.dimming
        && one.maintenance_factor == other.maintenance_factor
        && one.power_w == other.power_w
}

/// Area in m² of the surfaces that face upward at the lowest level of a scene: the floor, to which power per area refers.
pub fn floor_area_m2(scene: &Scene) -> f64 {
    /// Upward faces within this height in m of the lowest one belong to the floor.
    const LEVEL_M: f64 = 0.05;
    let upward: Vec<(f64, f64)> = (0..scene.triangles.len() as u32)
        .filter(|triangle| scene.triangle_normal(*triangle).z > 0.99)
        .map(|triangle| {
            let height_m = scene.corners_m(triangle).iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
            (height_m, scene.triangle_area_m2(triangle))
        })
        .collect();
    let lowest_m = upward.iter().map(|(height_m, _)| *height_m).fold(f64::INFINITY, f64::min);
    upward.iter().filter(|(height_m, _)| *height_m < lowest_m + LEVEL_M).map(|(_, area_m2)| area_m2).sum()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{MOST_KINDS, Schedule, letters};
    use crate::check::scene_from_json;

    /// 1,000 luminaires with different fluxes: the schedule has a readable number of rows and lists every luminaire once.
    #[test]
    fn luminaires_of_very_many_kinds_share_the_last_row() {
        let lamps: Vec<String> = (1..=1000)
            .map(|n| format!(r#"{{ "name": "{n}", "type": "point", "position": [1, 1, 1], "luminous_flux_lm": {n} }}"#))
            .collect();
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [2,2,2], "facing": "inward", "material": "m" }} ],
            "luminaires": [ {} ] }}"#,
            lamps.join(", ")
        );
        let scene = scene_from_json(&text, None, Path::new(".")).expect("a valid scene");
        let rows = Schedule::of(&scene).rows;
        assert_eq!(rows.len(), MOST_KINDS + 1);
        assert!(rows[..MOST_KINDS].iter().all(|row| row.is_one_kind && row.members.len() == 1));
        assert!(!rows[MOST_KINDS].is_one_kind);
        let members: Vec<usize> = rows.iter().flat_map(|row| row.members.clone()).collect();
        assert_eq!(members, (0..1000).collect::<Vec<_>>());
    }

    #[test]
    fn kinds_never_run_out_of_letters() {
        assert_eq!([0, 25, 26, 27, 52, 702].map(letters), ["A", "Z", "AA", "AB", "BA", "AAA"]);
    }
}
