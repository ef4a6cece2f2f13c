//! Classic mistakes that do not make a scene invalid. Each is reported as a warning that says what to check.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::DVec3;
use rayon::prelude::*;

use super::advice_openings::advise_on_openings;
use super::insides::SolidLookup;
use super::shells::Shell;
use super::straight::{FirstMet, MOST_LINE_TESTS, first_met};
use super::warnings::names;
use crate::scene::{Luminaire, Quantity, ReceiverLayout, ReceiverSet, Scene, listed, place_words};

/// Lowest usual maintenance factor. A lower one is rarely intended: 0.67 to 0.8 are usual indoors, and 0.8 entered twice makes 0.64.
const LOWEST_USUAL_MAINTENANCE: f64 = 0.65;
/// A luminaire that aims upward at something nearer than this in m lights almost nothing else.
const TOO_NEAR_M: f64 = 0.1;
/// A plane is horizontal if its normal's z exceeds this, upward or downward.
const HORIZONTAL: f64 = 0.99;
/// A luminaire aims upward if its aim's z exceeds this.
const UPWARD: f64 = 0.5;
/// In a scene smaller than this in m, the openings of real luminaires would reach through everything, so its unit is wrong.
const SMALLEST_WITH_OPENINGS_M: f64 = 0.1;
/// The words for luminaires in solids.
pub const BURIED: &str = "inside of a closed solid";
/// A point this near to the bounding box, as a fraction of the box's size, does not count as outside. This is above the rounding of
/// coordinates.
const ON_BOUNDS: f64 = 1e-9;

/// Adds a warning for each classic mistake in a valid scene.
///
/// `shells` are the closed shells of the scene's geometries.
pub(super) fn advise(scene: &mut Scene, shells: &[Shell]) {
    let mut advice = Vec::new();
    advise_on_maintenance(&scene.luminaires, &mut advice);
    advise_on_units(scene, shells, &mut advice);
    advise_on_doubles(&scene.luminaires, &mut advice);
    advise_on_places(scene, shells, &mut advice);
    advise_on_grids(scene, &mut advice);
    scene.warnings.extend(advice);
}

fn advise_on_maintenance(luminaires: &[Luminaire], advice: &mut Vec<String>) {
    let (full, maintained): (Vec<&Luminaire>, Vec<&Luminaire>) =
        luminaires.iter().partition(|luminaire| luminaire.maintenance_factor == 1.0);
    if !full.is_empty() && !maintained.is_empty() {
        advice.push(format!(
            "{}: maintenance factor 1, while other luminaires have less; was it forgotten there?",
            names(full)
        ));
    }
    let twice: Vec<&Luminaire> = maintained
        .iter()
        .copied()
        .filter(|luminaire| luminaire.dimming < 1.0 && luminaire.dimming == luminaire.maintenance_factor)
        .collect();
    if !twice.is_empty() {
        advice.push(format!(
            "{}: dimming and maintenance_factor are the same number and multiply; was maintenance entered twice?",
            names(twice)
        ));
    }
    let low: Vec<&Luminaire> = maintained
        .into_iter()
        .filter(|luminaire| (0.0..LOWEST_USUAL_MAINTENANCE).contains(&luminaire.maintenance_factor))
        .collect();
    if !low.is_empty() {
        advice.push(format!(
            "{}: maintenance factor below {LOWEST_USUAL_MAINTENANCE}; was it applied twice, or is it in the flux already?",
            names(low)
        ));
    }
}

fn advise_on_units(scene: &Scene, shells: &[Shell], advice: &mut Vec<String>) {
    let [low_m, high_m] = scene.bounds_m();
    let rounding_m = ON_BOUNDS * low_m.distance(high_m);
    let is_outside =
        |point_m: DVec3| point_m.cmplt(low_m - rounding_m).any() || point_m.cmpgt(high_m + rounding_m).any();
    let has_room = shells.iter().any(|shell| shell.volume_m3 < 0.0);
    let box_m = format!("the scene's bounding box ({} to {})", place_words(low_m), place_words(high_m));
    let mut all_outside: Vec<&str> = Vec::new();
    for set in scene.receivers.iter().filter(|set| !set.is_far_field()) {
        let points = set.points.len();
        match set.points.iter().filter(|point| is_outside(point.position_m)).count() {
            0 => {}
            count if count == points => all_outside.push(&set.name),
            // Without a room, receivers may well extend beyond the surfaces.
            count if has_room => advice.push(format!(
                "{}: {count} of {points} points are outside of {box_m}, where the light of the room does not reach; tables and errors include them",
                set.name
            )),
            _ => {}
        }
    }
    if !all_outside.is_empty() {
        advice.push(format!(
            "{}: all points are outside of {box_m}; are they in the scene's length_unit?",
            listed(all_outside)
        ));
    }
}

/// Warns of two luminaires at one position that aim the same way: one of them is superfluous. One that aims up and one that aims down are
/// not.
fn advise_on_doubles(luminaires: &[Luminaire], advice: &mut Vec<String>) {
    let mut places: HashMap<[u64; 6], &Luminaire> = HashMap::new();
    let mut doubles: Vec<(&Luminaire, &Luminaire)> = Vec::new();
    for luminaire in luminaires {
        let Some(place_m) = luminaire.emission.place_m() else { continue };
        let axis = luminaire.emission.aim().unwrap_or(DVec3::ZERO);
        let [[x, y, z], [dx, dy, dz]] =
            [place_m, axis].map(|vector| (vector + DVec3::ZERO).to_array().map(f64::to_bits));
        match places.entry([x, y, z, dx, dy, dz]) {
            Entry::Occupied(first) => doubles.push((first.get(), luminaire)),
            Entry::Vacant(free) => {
                free.insert(luminaire);
            }
        }
    }
    if let [(first, second), rest @ ..] = doubles.as_slice() {
        let more = if rest.is_empty() { String::new() } else { format!(", and {} more such pairs", rest.len()) };
        advice.push(format!(
            "{} and {} stand in the same place and shine the same way{more}; was one entered twice?",
            first.name, second.name
        ));
    }
}

fn advise_on_places(scene: &Scene, shells: &[Shell], advice: &mut Vec<String>) {
    let [low_m, high_m] = scene.bounds_m();
    let size_m = low_m.distance(high_m);
    let places: Vec<(&Luminaire, DVec3)> =
        scene.luminaires.iter().filter_map(|luminaire| Some((luminaire, luminaire.emission.place_m()?))).collect();
    let places_m: Vec<DVec3> = places.iter().map(|(_, place_m)| *place_m).collect();
    let (held, _) = SolidLookup::of(shells, size_m).holding(&places_m);
    if held.len() < places.len() {
        advice.push(format!(
            "{} of {} luminaires were not checked for standing inside of solids: too many solids surround them",
            places.len() - held.len(),
            places.len()
        ));
    }
    let buried: Vec<&Luminaire> =
        places.iter().zip(held).filter(|(_, is_inside)| *is_inside).map(|((luminaire, _), _)| *luminaire).collect();
    if !buried.is_empty() {
        let count = buried.len();
        advice.push(format!(
            "{}: {BURIED}, which blocks {} light; move {} out of it, or, if the solid is a room, give it \"facing\": \"inward\"",
            names(buried),
            if count == 1 { "its" } else { "their" },
            if count == 1 { "it" } else { "them" }
        ));
    }
    let aimed = scene.luminaires.iter().filter_map(place_and_aim).count();
    if aimed * scene.triangles.len() > MOST_LINE_TESTS {
        advice.push(format!(
            "{aimed} luminaires times {} triangles are too many to check where they aim and which surfaces cut their openings",
            scene.triangles.len()
        ));
        return;
    }
    if size_m < SMALLEST_WITH_OPENINGS_M {
        return;
    }
    advise_on_openings(scene, advice);
    let mut at_ceiling = Vec::new();
    let mut at_backs = Vec::new();
    for (luminaire, aim) in scene.luminaires.iter().zip(aims_of(scene)) {
        match aim {
            Some((up, met)) if up > UPWARD && met.distance_m < TOO_NEAR_M => at_ceiling.push(luminaire),
            Some((_, met)) if met.is_dead_back => at_backs.push(luminaire),
            _ => {}
        }
    }
    if !at_ceiling.is_empty() {
        advice.push(format!(
            "{}: aimed upward at something less than {TOO_NEAR_M} m away; is \"aim\": [0, 0, -1] meant?",
            names(at_ceiling)
        ));
    }
    if !at_backs.is_empty() {
        advice.push(format!(
            "{}: aimed at the back of a one-sided surface, which absorbs the light; outside of the room, or does the surface's front face away?",
            names(at_backs)
        ));
    }
}

/// Returns the position in m and the direction of a luminaire that has a direction.
fn place_and_aim(luminaire: &Luminaire) -> Option<(DVec3, DVec3)> {
    Some((luminaire.emission.place_m()?, luminaire.emission.aim()?))
}

/// Returns for each luminaire how far up it aims (z of its direction), and what it meets there first.
fn aims_of(scene: &Scene) -> Vec<Option<(f64, FirstMet)>> {
    let aims = scene.luminaires.par_iter().map(|luminaire| {
        let (place_m, aim) = place_and_aim(luminaire)?;
        Some((aim.z, first_met(scene, place_m, aim)?))
    });
    aims.collect()
}

/// Returns the names of the luminaires that aim at the back of a one-sided surface, as a message lists them. `None` if there are none, or
/// too many for this check.
pub(crate) fn luminaires_aimed_at_backs(scene: &Scene) -> Option<String> {
    if scene.luminaires.len() * scene.triangles.len() > MOST_LINE_TESTS {
        return None;
    }
    let aims = scene.luminaires.iter().zip(aims_of(scene));
    let at_backs: Vec<&Luminaire> = aims
        .filter(|(_, aim)| aim.as_ref().is_some_and(|(_, met)| met.is_dead_back))
        .map(|(luminaire, _)| luminaire)
        .collect();
    (!at_backs.is_empty()).then(|| names(at_backs))
}

/// Warns of horizontal grids in the lower half of a scene that face down, which are rarely intended.
fn advise_on_grids(scene: &Scene, advice: &mut Vec<String>) {
    let [low_m, high_m] = scene.bounds_m();
    let middle_m = 0.5 * (low_m.z + high_m.z);
    let faces_down = |set: &&ReceiverSet| {
        matches!(set.layout, ReceiverLayout::Grid { .. })
            && set.quantity == Quantity::Perpendicular
            && set.points.iter().all(|point| point.normal.z < -HORIZONTAL && point.position_m.z < middle_m)
    };
    let grids: Vec<&str> = scene.receivers.iter().filter(faces_down).map(|set| set.name.as_str()).collect();
    if !grids.is_empty() {
        advice.push(format!(
            "{}: faces down, as its normal is u × v; exchange \"u\" and \"v\" if light from above is meant",
            listed(grids)
        ));
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::check::scene_from_json;

    /// Returns the warnings of a room 4 m × 4 m × 3 m with these luminaires.
    fn warnings(luminaires: &str) -> Vec<String> {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [
              {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "white" }},
              {{ "name": "attic", "type": "box", "min": [0,0,3.2], "max": [4,4,5], "facing": "inward", "material": "white" }},
              {{ "name": "chest", "type": "box", "min": [1,1,0], "max": [2,2,1], "material": "white" }} ],
            "luminaires": [ {luminaires} ] }}"#
        );
        scene_from_json(&text, None, Path::new(".")).expect("a valid scene").warnings
    }

    fn spot(name: &str, position: &str, more: &str) -> String {
        format!(
            r#"{{ "name": "{name}", "type": "point", "distribution": "lambertian", "luminous_flux_lm": 100,
            "position": {position}, {more} }}"#
        )
    }

    #[test]
    fn a_sound_room_has_no_warning() {
        let on_ceiling = spot("a", "[2,2,3]", r#""maintenance_factor": 0.8"#);
        let uplight = spot("b", "[3,3,2]", r#""maintenance_factor": 0.8, "aim": [0,0,1]"#);
        assert!(warnings(&format!("{on_ceiling}, {uplight}")).is_empty());
    }

    #[test]
    fn every_classic_mistake_is_reported_once() {
        for (luminaire, words) in [
            (spot("a", "[2,2,2.95]", r#""maintenance_factor": 0.8, "aim": [0,0,1]"#), "aimed upward"),
            (spot("a", "[2,2,3.1]", r#""maintenance_factor": 0.8"#), "back of a one-sided surface"),
            (spot("a", "[1.5,1.5,0.5]", r#""maintenance_factor": 0.8"#), "inside of a closed solid"),
            (spot("a", "[2,2,2]", r#""maintenance_factor": 0.8, "dimming": 0.8"#), "entered twice"),
            (spot("a", "[2,2,2]", r#""maintenance_factor": 0.4"#), "applied twice"),
            (spot("a", "[2,2,2]", r#""maintenance_factor": 0.64"#), "applied twice"),
            (
                [
                    spot("a", "[2,2,2]", r#""maintenance_factor": 0.8"#),
                    spot("b", "[2,2,2]", r#""maintenance_factor": 0.8"#),
                ]
                .join(", "),
                "in the same place",
            ),
            (
                format!(
                    "{}, {}",
                    spot("a", "[2,2,2]", r#""maintenance_factor": 0.8"#),
                    spot("b", "[3,2,2]", r#""dimming": 1"#)
                ),
                "was it forgotten there",
            ),
        ] {
            let warned: Vec<String> =
                warnings(&luminaire).into_iter().filter(|warning| warning.contains(words)).collect();
            assert_eq!(warned.len(), 1, "{words}: {warned:?}");
        }
    }

    #[test]
    fn lights_up_and_down_from_one_place_are_no_doubles() {
        let down = spot("a", "[2,2,2]", r#""maintenance_factor": 0.8"#);
        let up = spot("b", "[2,2,2]", r#""maintenance_factor": 0.8, "aim": [0,0,1]"#);
        assert!(warnings(&format!("{down}, {up}")).is_empty());
    }

    #[test]
    fn points_outside_of_a_room_are_counted() {
        for (origin, u, words) in [
            ("[0,1,0]", "[4,0,0]", None),
            ("[0.5,1,0.8]", "[30,0,0]", Some("g: 2 of 3 points are outside")),
            ("[10,1,0.8]", "[30,0,0]", Some("\"g\": all points are outside")),
        ] {
            let text = format!(
                r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": 0.5 }} }},
                "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "white" }} ],
                "luminaires": [ {{ "name": "a", "type": "point", "position": [2,2,2], "intensity_cd": 1, "maintenance_factor": 0.8 }} ],
                "receivers": [ {{ "name": "g", "type": "grid", "origin": {origin}, "u": {u}, "v": [0,1,0], "columns": 3, "rows": 1 }} ] }}"#
            );
            let warnings = scene_from_json(&text, None, Path::new(".")).expect("a valid scene").warnings;
            let warned: Vec<&String> = warnings.iter().filter(|warning| warning.contains("outside")).collect();
            assert_eq!(warned.len(), usize::from(words.is_some()), "{warned:?}");
            assert!(words.is_none_or(|words| warned[0].contains(words)), "{warned:?}");
        }
    }

    #[test]
    fn a_grid_that_looks_at_the_floor_is_reported() {
        for (v, count) in [("[0,1,0]", 0), ("[0,-1,0]", 1)] {
            let text = format!(
                r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": 0.5 }} }},
                "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "white" }} ],
                "luminaires": [ {{ "name": "a", "type": "point", "position": [2,2,2], "intensity_cd": 1, "maintenance_factor": 0.8 }} ],
                "receivers": [ {{ "name": "desk", "type": "grid", "origin": [1,2,0.8], "u": [1,0,0], "v": {v}, "columns": 2, "rows": 2 }} ] }}"#
            );
            let warnings = scene_from_json(&text, None, Path::new(".")).expect("a valid scene").warnings;
            assert_eq!(warnings.iter().filter(|warning| warning.contains("faces down")).count(), count, "{warnings:?}");
        }
    }

    #[test]
    fn metres_that_are_called_millimetres_are_reported() {
        let text = r#"{ "version": 1, "length_unit": "mm", "materials": { "white": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [8,6,3], "facing": "inward", "material": "white" } ],
            "luminaires": [ { "name": "a", "type": "point", "position": [4,3,2], "intensity_cd": 1, "maintenance_factor": 0.8 } ],
            "receivers": [ { "name": "g", "type": "grid", "origin": [1000,1000,800], "u": [1000,0,0], "v": [0,1000,0], "columns": 2, "rows": 2 } ] }"#;
        let warnings = scene_from_json(text, None, Path::new(".")).expect("a valid scene").warnings;
        assert!(warnings.iter().any(|warning| warning.contains("as its length_unit is \"mm\"")), "{warnings:?}");
        assert!(warnings.iter().any(|warning| warning.contains("all points are outside")), "{warnings:?}");
    }
}
