//! The luminaire schedule: luminaires of one kind together, and what they take and give.

use std::sync::Arc;

use crate::scene::{Emission, Luminaire, Scene};

/// Luminaires that differ in nothing but name, place and aim.
#[derive(Clone, Debug)]
pub struct ScheduleRow {
    /// Letter by which the plan names them.
    pub letter: String,
    /// Their places in [`Scene::luminaires`].
    pub members: Vec<usize>,
    /// How they emit, in words.
    pub kind: &'static str,
}

/// Luminaires of one kind together, in the order of the scene.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// One row a kind.
    pub rows: Vec<ScheduleRow>,
}

/// What the luminaires of a scene take, where it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Power {
    /// Sum of the known powers in W, not dimmed.
    pub known_w: f64,
    /// Luminaires whose power is unknown.
    pub unknown: usize,
}

impl Schedule {
    /// Sorts the luminaires of a scene.
    pub fn of(scene: &Scene) -> Schedule {
        let mut rows: Vec<ScheduleRow> = Vec::new();
        for (index, luminaire) in scene.luminaires.iter().enumerate() {
            match rows.iter_mut().find(|row| are_alike(&scene.luminaires[row.members[0]], luminaire)) {
                Some(row) => row.members.push(index),
                None => rows.push(ScheduleRow {
                    letter: letters(rows.len()),
                    members: vec![index],
                    kind: kind(&luminaire.emission),
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
        // A sky draws none.
        let draws = |luminaire: &&Luminaire| !matches!(luminaire.emission, Emission::Sky { .. });
        let unknown = scene.luminaires.iter().filter(draws).filter(|luminaire| luminaire.power_w.is_none()).count();
        Power { known_w, unknown }
    }
}

/// A, B, …, Z, AA, AB, …
fn letters(index: usize) -> String {
    let letter = char::from(b'A' + (index % 26) as u8);
    if index < 26 { letter.to_string() } else { format!("{}{letter}", letters(index / 26 - 1)) }
}

fn kind(emission: &Emission) -> &'static str {
    match emission {
        Emission::Isotropic { .. } => "point, equal in all directions",
        Emission::Lambertian { .. } => "point, cosine distribution",
        Emission::Photometric { .. } => "measured distribution",
        Emission::Area { .. } => "luminous surface, diffuse",
        Emission::Sphere { .. } => "luminous sphere",
        Emission::Sky { .. } => "sky",
    }
}

fn are_alike(one: &Luminaire, other: &Luminaire) -> bool {
    // The same lamps may differ by rounding, where their flux follows from an area.
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

/// Area in m² of what faces upward at the lowest level of a scene: the floor, by which specific powers are counted.
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
    use super::letters;

    #[test]
    fn kinds_never_run_out_of_letters() {
        assert_eq!([0, 25, 26, 27, 52, 702].map(letters), ["A", "Z", "AA", "AB", "BA", "AAA"]);
    }
}
