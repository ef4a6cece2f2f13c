//! Uniformities of surfaces: the same whatever the elements, without what is covered, and none where there are too few.

use std::path::Path;

use luxmc::check::scene_from_json;
use luxmc::maps::TableRow;
use luxmc::solver::{ElementChoice, MapSelection, Settings, solve};

use crate::common::Silent;

/// The rows of a room of 4 m × 3 m × 2.5 m with a lamp near a corner, with elements as long as given, and more geometry.
fn rows(edge_m: &str, more: &str, elements: ElementChoice) -> Vec<TableRow> {
    let text = format!(
        r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
        "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "m"{edge_m} }}{more} ],
        "luminaires": [ {{ "name": "lamp", "type": "point", "position": [1,1,2], "luminous_flux_lm": 1000, "distribution": "lambertian" }} ] }}"#
    );
    let scene = scene_from_json(&text, None, Path::new(".")).expect("the room is valid");
    let settings =
        Settings { elements, target_error: Some(0.03), maps: MapSelection::Elements, seed: 4, ..Settings::default() };
    solve(&scene, &settings, &Silent).maps.remove(0).tables
}

fn row_of<'a>(rows: &'a [TableRow], name: &str) -> &'a TableRow {
    rows.iter().find(|row| row.name == name).expect("every surface has a row")
}

/// Elements of 0.15 and of 0.3 m and those that adapt give one U0, within five of its errors and the 2% that elements of a quarter
/// of a cell may smooth; two triangles, which would give 0.99 (the fault that was), give none.
#[test]
fn uniformities_do_not_depend_on_the_elements() {
    let given = |edge_m: &str| rows(edge_m, "", ElementChoice::Given);
    let fine = given(r#", "max_element_edge": 0.15"#);
    for other in [given(r#", "max_element_edge": 0.3"#), rows("", "", ElementChoice::Adaptive)] {
        for name in ["room/floor", "room/x_max"] {
            let (one, other) = (row_of(&fine, name), row_of(&other, name));
            let error = one.uniformity_u0.standard_error.hypot(other.uniformity_u0.standard_error);
            let difference = (one.uniformity_u0.value - other.uniformity_u0.value).abs();
            assert!(difference < 5.0 * error + 0.02 * one.uniformity_u0.value, "{name}: {one:?} {other:?}");
            assert_eq!(one.places, other.places);
            assert!(one.knows_ratios() && one.uniformity_u0.value < 0.8, "{one:?}");
        }
    }
    let coarse = given("");
    let floor = row_of(&coarse, "room/floor");
    assert!(floor.places == 0 && floor.uniformity_u0.value == 0.0 && !floor.knows_extremes(), "{floor:?}");
}

/// A cupboard covers 1 m² of the floor: that is told, and the darkness under it is no minimum, with given elements as with those
/// that adapt.
#[test]
fn what_is_covered_is_told_and_does_not_count() {
    let cupboard = r#", { "name": "cupboard", "type": "box", "min": [3,1,0], "max": [3.5,3,1], "material": "m" }"#;
    for (edge_m, elements) in [(r#", "max_element_edge": 0.15"#, ElementChoice::Given), ("", ElementChoice::Adaptive)] {
        let rows = rows(edge_m, cupboard, elements);
        let floor = row_of(&rows, "room/floor");
        assert!((floor.covered_area_m2 - 1.0).abs() < 0.15, "{floor:?}");
        assert!((floor.area_m2 + floor.covered_area_m2 - 12.0).abs() < 1e-6, "{floor:?}");
        assert!(floor.minimum_lx.value > 0.02 * floor.average_lx.value && floor.uniformity_u0.value < 0.9, "{floor:?}");
    }
}
