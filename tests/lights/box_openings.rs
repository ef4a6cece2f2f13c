//! Luminous boxes at ceilings: the lower face emits downward, whatever stands above, and equally at every height.

use std::path::Path;

use luxmc::check::scene_from_json;
use luxmc::scene::Scene;
use luxmc::solver::{MapSelection, Settings, solve};

use crate::common::Silent;

/// A room of 4 m × 4 m × 3 m with walls of this reflectance. The luminaire file has a box of 400 mm × 400 mm × 25 mm with its centre at
/// `height_m`.
fn room(reflectance: f64, height_m: f64) -> Scene {
    let text = format!(
        r#"{{ "version": 1, "materials": {{ "walls": {{ "type": "diffuse", "reflectance": {reflectance} }} }},
        "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "walls" }} ],
        "luminaires": [ {{ "name": "panel", "type": "photometric", "file": "photometric/box_panel.ldt", "position": [2,2,{height_m}] }} ],
        "receivers": [ {{ "name": "floor", "type": "grid", "origin": [1,1,0], "u": [2,0,0], "v": [0,2,0], "columns": 3, "rows": 3 }},
                       {{ "name": "wall", "type": "grid", "origin": [0,1,2.2], "u": [0,2,0], "v": [0,0,0.6], "columns": 3, "rows": 3 }} ] }}"#
    );
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    scene_from_json(&text, None, &folder).expect("a valid scene")
}

fn means_lx(scene: &Scene) -> [f64; 2] {
    let settings = Settings { target_error: Some(0.004), maps: MapSelection::Receivers, ..Settings::default() };
    let solution = solve(scene, &settings, &Silent);
    assert_eq!(solution.target_met, Some(true));
    [0, 1].map(|set: usize| solution.maps[set].tables[0].average.value)
}

/// Positions: hanging below the ceiling, a tenth of a millimetre in it, with its centre in it, 1 cm above it, and its lower face flush with
/// it. The floor gets the same light within 2 %. The walls, to which a recessed box shows no sides, get the same within 6 %. When the top
/// emitted through the box itself, the second position gave 0.56 of the first (the planted fault).
#[test]
fn the_light_of_a_box_does_not_hang_on_how_far_it_is_let_into_the_ceiling() {
    let hanging = means_lx(&room(0.0, 3.0 - 0.0125));
    assert!(hanging.iter().all(|lx| *lx > 0.5), "{hanging:?}");
    for height_m in [3.0 - 0.0124, 3.0 - 0.005, 3.0, 3.01, 3.0125] {
        let scene = room(0.0, height_m);
        let there = means_lx(&scene);
        let [floor, wall] = [0, 1].map(|set: usize| there[set] / hanging[set]);
        assert!((floor - 1.0).abs() < 0.02, "{height_m}: {floor} of the floor's light when hanging");
        assert!((wall - 1.0).abs() < 0.06, "{height_m}: {wall} of the wall's light when hanging");
        let told = scene.warnings.iter().any(|warning| warning.contains("panel: its luminous box reaches"));
        assert_eq!(told, height_m > 3.0 - 0.0115, "{height_m}: {:?}", scene.warnings);
        assert!(!scene.warnings.iter().any(|warning| warning.contains("lies behind")), "{:?}", scene.warnings);
    }
}

/// A box entirely above the ceiling lights only the ceiling's back. The warning names the luminaire's position and does not call the
/// normals flipped.
#[test]
fn a_box_above_the_ceiling_is_reported_as_one_that_shines_from_behind() {
    let scene = room(0.5, 3.02);
    let settings = Settings { chains: Some(4096), maps: MapSelection::Elements, ..Settings::default() };
    let warnings = solve(&scene, &settings, &Silent).warnings;
    let told = warnings.iter().find(|warning| warning.contains("of the flux hits the back")).expect("told");
    assert!(told.contains("panel shines at it from behind") && !told.contains("flipped"), "{told}");
}
