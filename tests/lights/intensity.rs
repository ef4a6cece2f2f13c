//! Far-field intensity distributions of the light that leaves a scene, against closed formulas, and the photometric files made from them.
//!
//! Comparisons with randomness allow 5 standard errors of 16 replicas (t with 15 degrees of freedom, some 2e-4 each) with the seed below,
//! or 4.5 for the mean over many directions. They must detect a planted fault.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use luxmc::base::solid_angle::triangle_solid_angle_sr;
use luxmc::check::scene_from_json;
use luxmc::output::{ResultFile, leaving_light, result_files};
use luxmc::scene::photometry::{PhotometricFile, parse_eulumdat, parse_ies, read_photometric_file};
use luxmc::scene::{IntensityTable, Scene};
use luxmc::solver::{MapSelection, Settings, Silent, Solution, solve};

const SEED: u64 = 31;
const WITHIN: f64 = 5.0;

const BLACK: &str = r#""black": { "type": "diffuse", "reflectance": 0 }"#;
/// A scene needs a surface. This one hides nothing.
const SPECK: &str = r#"{ "name": "speck", "type": "rectangle", "origin": [0,0,-50], "u": [0,0.001,0], "v": [0.001,0,0], "material": "black" }"#;

fn scene_of(materials: &str, geometry: &str, luminaires: &str, receiver: &str) -> Scene {
    let text = format!(
        r#"{{ "version": 1, "title": "Test, \"quoted\"", "materials": {{ {materials} }}, "geometry": [ {geometry} ],
        "luminaires": [ {luminaires} ], "receivers": [ {{ "name": "far", "type": "intensity" {receiver} }} ] }}"#
    );
    scene_from_json(&text, None, Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_or_else(|error| panic!("{error}"))
}

fn solved(scene: &Scene, chains: u64, threads: usize) -> Solution {
    let settings = Settings {
        seed: SEED,
        chains: Some(chains),
        maps: MapSelection::Receivers,
        threads: Some(threads),
        ..Settings::default()
    };
    solve(scene, &settings, &Silent)
}

fn table(scene: &Scene) -> &IntensityTable {
    scene.receivers[0].intensity_table().expect("an intensity receiver")
}

/// Every direction with its C and γ in degrees, its value and its standard error in cd.
fn directions(scene: &Scene, solution: &Solution) -> Vec<([f64; 2], DVec3, f64, f64)> {
    let (table, values) = (table(scene), &solution.maps[0].values);
    assert_eq!(solution.maps[0].quantity.unit(), "cd");
    let told = |(entry, (plane, step)): (usize, (u32, u32))| {
        let angles_deg = [table.c_deg(plane), table.gamma_deg(step)];
        (angles_deg, table.direction(plane, step), values.value[entry], values.standard_error[entry])
    };
    table.places().enumerate().map(told).collect()
}

fn file<'a>(files: &'a [ResultFile], ending: &str) -> &'a ResultFile {
    files.iter().find(|file| file.name.ends_with(ending)).unwrap_or_else(|| panic!("a file {ending}"))
}

/// Both photometric files that a run writes, as luxmc reads them.
fn read_back(scene: &Scene, solution: &Solution) -> [PhotometricFile; 2] {
    let files = result_files(scene, solution).expect("files");
    let ies = parse_ies(&file(&files, "intensity-far.ies").bytes, None).unwrap_or_else(|error| panic!("{error}"));
    let ldt = parse_eulumdat(&file(&files, "intensity-far.ldt").bytes).unwrap_or_else(|error| panic!("{error}"));
    [ies, ldt]
}

#[test]
fn a_bare_luminaire_gives_its_own_file_back() {
    for name in ["downlight.ldt", "troffer.ies", "spotlight.ies", "wall_washer.ldt"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/luminaires").join(name);
        let truth = read_photometric_file(&path).expect("a sample file");
        let luminaire = format!(
            r#"{{ "name": "lamp", "type": "photometric", "file": "scenes/luminaires/{name}", "position": [1,2,3], "aim": [0.3,-0.2,-1],
                 "rotation_deg": 30 }}"#
        );
        let receiver = r#", "aim": [0.3,-0.2,-1], "rotation_deg": 30, "c_planes": 72, "gamma_step_deg": 1, "luminous_opening": [0.5,0.3,0]"#;
        let scene = scene_of(BLACK, SPECK, &luminaire, receiver);
        let solution = solved(&scene, 1, 2);
        let most_cd = truth.web.maximum_intensity_cd();
        let mut worst_cd = 0.0f64;
        for ([c_deg, gamma_deg], _, value_cd, error_cd) in directions(&scene, &solution) {
            worst_cd = worst_cd.max((value_cd - truth.web.intensity_cd(c_deg, gamma_deg)).abs());
            assert!(error_cd <= 1e-12 * value_cd, "{name}: what is computed is exact but for rounding: {error_cd}");
        }
        assert!(worst_cd < 1e-6 * most_cd, "{name}: off by {worst_cd} cd of {most_cd}");

        // Files contain nine digits of the same intensities, and the same flux.
        let light = &leaving_light(&scene, &solution)[0];
        for read in read_back(&scene, &solution) {
            let format = read.format;
            assert!(read.warnings.is_empty(), "{name} {format:?}: {:?}", read.warnings);
            assert!((read.luminous_flux_lm() / light.luminous_flux_lm.value - 1.0).abs() < 1e-7, "{name} {format:?}");
            for ([c_deg, gamma_deg], _, value_cd, _) in directions(&scene, &solution) {
                let off_cd = read.web.intensity_cd(c_deg, gamma_deg) - value_cd;
                assert!(off_cd.abs() < 1e-7 * most_cd, "{name} {format:?}: off by {off_cd} at {c_deg}, {gamma_deg}");
            }
            let extents_m = read.opening.extents_m();
            assert!([0.5, 0.3, 0.0].iter().zip(extents_m).all(|(given, read)| (given - read).abs() < 1e-9));
            let ratio = read.light_output_ratio.expect("relative photometry");
            assert!((ratio - light.light_output_ratio).abs() < 1e-6, "{name} {format:?}: {ratio}");
        }
        // A table of this resolution keeps the flux of the file that it was made from.
        assert!((light.luminous_flux_lm.value / truth.luminous_flux_lm() - 1.0).abs() < 2e-3, "{name}");
    }
}

#[test]
fn areas_balls_and_panes_are_seen_from_afar_as_they_are() {
    let panel = r#"{ "name": "panel", "type": "rectangle", "origin": [0,0,2], "u": [0,1.5,0], "v": [1,0,0], "material": "black" }"#;
    let light =
        r#"{ "name": "panel", "type": "area", "surface": "panel", "exitance_lm_m2": 400, "maintenance_factor": 0.5 }"#;
    let scene = scene_of(BLACK, panel, light, "");
    let solution = solved(&scene, 64, 2);
    for (_, direction, value_cd, _) in directions(&scene, &solution) {
        // The panel faces down: u × v is −z.
        let exact_cd = 200.0 / PI * 1.5 * (-direction.z).max(0.0);
        assert!((value_cd - exact_cd).abs() < 1e-9 * 100.0, "{direction}: {value_cd}, exact {exact_cd}");
    }

    let ball = r#"{ "name": "ball", "type": "sphere", "center": [0,0,0], "radius": 0.1, "exitance_lm_m2": 5000 }"#;
    let pane = r#"{ "name": "pane", "type": "rectangle", "origin": [-500,-500,-1], "u": [1000,0,0], "v": [0,1000,0], "material": "pane" }"#;
    let materials = r#""pane": { "type": "glass", "refractive_index": 1.5, "internal_transmittance": 1 }"#;
    let scene = scene_of(materials, pane, ball, "");
    let solution = solved(&scene, 20_000, 2);
    let (table, values) = (table(&scene), &solution.maps[0].values);
    let whole_cd = 5000.0 * 0.1 * 0.1;
    // Down: two faces of reflectance 0.04 with all inner reflections, T = (1 − R)/(1 + R). Up: all of it, and mirror images in addition.
    let down = table.entry(0, 0);
    let through_cd = whole_cd * 0.96 / 1.04;
    assert!((values.direct[down] - through_cd).abs() < 1e-9 * whole_cd, "{}", values.direct[down]);
    assert!((values.direct[table.entry(3, 30)] - whole_cd).abs() < 1e-9 * whole_cd);
    let upwards = (19..36).flat_map(|step| (0..24).map(move |plane| (plane, step)));
    assert!(
        upwards.into_iter().any(|(plane, step)| values.indirect[table.entry(plane, step)] > 0.0),
        "the pane mirrors"
    );
}

/// Mean of value over truth among some directions, and its standard error; and the largest deviation of a direction in standard errors.
fn held_against(told: &[(f64, f64, f64)]) -> (f64, f64, f64) {
    let exact: f64 = told.iter().map(|(_, _, exact)| exact).sum();
    let value: f64 = told.iter().map(|(value, _, _)| value).sum();
    let error = told.iter().map(|(_, error, _)| error * error).sum::<f64>().sqrt();
    let worst = told.iter().map(|(value, error, exact)| (value - exact).abs() / error).fold(0.0, f64::max);
    (value / exact, error / exact, worst)
}

/// A lamp in a corner of two large mirrors: four lamps, I (1 + ρ)² in every direction of the open quarter.
#[test]
fn a_lamp_in_a_trough_of_mirrors_is_four_lamps() {
    let materials = r#""silver": { "type": "mirror", "reflectance": 0.8 }"#;
    let mirrors = r#"{ "name": "left", "type": "rectangle", "origin": [0,0,-100], "u": [0,100,0], "v": [0,0,200], "material": "silver" },
        { "name": "back", "type": "rectangle", "origin": [0,0,-100], "u": [0,0,200], "v": [100,0,0], "material": "silver" }"#;
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [0.3,0.2,0], "intensity_cd": 100 }"#;
    let scene = scene_of(materials, mirrors, lamp, r#", "c_planes": 12, "gamma_step_deg": 10"#);
    let solution = solved(&scene, 400_000, 2);
    // Cells that lie entirely in the quarter: C from 30° to 60°, γ from 30° to 150°.
    let inside = directions(&scene, &solution)
        .into_iter()
        .filter(|([c_deg, gamma_deg], ..)| [30.0, 60.0].contains(c_deg) && (30.0..=150.0).contains(gamma_deg));
    let told: Vec<(f64, f64, f64)> = inside.map(|(_, _, value, error)| (value, error, 100.0 * 1.8 * 1.8)).collect();
    assert_eq!(told.len(), 26);
    let (ratio, error, worst) = held_against(&told);
    assert!((ratio - 1.0).abs() < 4.5 * error && worst < WITHIN, "{ratio} ± {error}, worst {worst}");
    // The planted fault: a mirror of 0.82 would give 2.2 % more.
    assert!((ratio * (1.82f64 / 1.8).powi(2) - 1.0).abs() > 4.5 * error, "the planted fault passed: ± {error}");
    // No light leaves behind the mirrors.
    let behind = directions(&scene, &solution)
        .into_iter()
        .filter(|([c_deg, gamma_deg], ..)| [210.0, 240.0].contains(c_deg) && (30.0..=150.0).contains(gamma_deg));
    assert!(behind.into_iter().all(|(_, _, value_cd, _)| value_cd == 0.0));
}

/// A lamp above a diffuse sheet: I + ρ I Ω cos θ/π above it, where Ω is the solid angle of the sheet, and I or nothing below.
#[test]
fn a_lamp_over_a_diffuse_sheet_is_met_in_closed_form() {
    let materials = r#""white": { "type": "diffuse", "reflectance": 0.9 }"#;
    let sheet = r#"{ "name": "sheet", "type": "rectangle", "origin": [-1,-0.5,0], "u": [2,0,0], "v": [0,1,0], "material": "white" }"#;
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [0.2,0.1,0.4], "intensity_cd": 100 }"#;
    let scene = scene_of(materials, sheet, lamp, r#", "aim": [0,0,1], "c_planes": 8, "gamma_step_deg": 10"#);
    let solution = solved(&scene, 400_000, 2);
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0) - DVec3::new(0.2, 0.1, 0.4);
    let corners = [at(-1.0, -0.5), at(1.0, -0.5), at(1.0, 0.5), at(-1.0, 0.5)];
    let solid_angle_sr = triangle_solid_angle_sr(corners[0], corners[1], corners[2])
        + triangle_solid_angle_sr(corners[0], corners[2], corners[3]);
    let reflected_cd = 0.9 * 100.0 * solid_angle_sr / PI;
    let mut told = Vec::new();
    for ([_, gamma_deg], direction, value, error) in directions(&scene, &solution) {
        if gamma_deg < 85.0 {
            // Tables contain means over cells. For the cosine over 10° the mean is (sin 5°)/5° of the value at the centre, and similar at
            // the pole.
            let half = 5.0f64.to_radians();
            let mean_cosine = match gamma_deg {
                0.0 => half.sin().powi(2) / (2.0 * (1.0 - half.cos())),
                _ => direction.z * half.cos(),
            };
            told.push((value, error, 100.0 + reflected_cd * mean_cosine));
        } else if gamma_deg > 95.0 {
            // The back of the sheet absorbs what it hides, and reflects nothing downward.
            let reach_m = 0.4 / -direction.z;
            let [x, y] = [0.2 + direction.x * reach_m, 0.1 + direction.y * reach_m];
            let is_hidden = (-1.0..1.0).contains(&x) && (-0.5..0.5).contains(&y);
            assert_eq!(value, if is_hidden { 0.0 } else { 100.0 }, "{direction}");
        }
    }
    let (ratio, error, worst) = held_against(&told);
    assert!((ratio - 1.0).abs() < 4.5 * error && worst < WITHIN, "{ratio} ± {error}, worst {worst}");
    let reflected = told.iter().map(|(value, ..)| value - 100.0).sum::<f64>()
        / told.iter().map(|(_, _, exact)| exact - 100.0).sum::<f64>();
    let all = told.iter().map(|(_, _, exact)| exact).sum::<f64>()
        / told.iter().map(|(_, _, exact)| exact - 100.0).sum::<f64>();
    assert!((1.02 * reflected - 1.0).abs() > 4.5 * error * all, "2 % more of the sheet would go unseen: ± {error}");
}

/// The light that leaves an open white box: the table sums to the chains' balance, and to less than the lamp emits.
#[test]
fn the_flux_of_the_table_is_what_leaves_the_scene() {
    let materials = r#""white": { "type": "diffuse", "reflectance": 0.8 }"#;
    let walls = [
        ("floor", "[0,0,0]", "[1,0,0]", "[0,1,0]"),
        ("south", "[0,0,0]", "[0,0,1]", "[1,0,0]"),
        ("north", "[0,1,0]", "[1,0,0]", "[0,0,1]"),
        ("west", "[0,0,0]", "[0,1,0]", "[0,0,1]"),
        ("east", "[1,0,0]", "[0,0,1]", "[0,1,0]"),
    ];
    let wall = |(name, origin, u, v): (&str, &str, &str, &str)| {
        format!(
            r#"{{ "name": "{name}", "type": "rectangle", "origin": {origin}, "u": {u}, "v": {v}, "material": "white" }}"#
        )
    };
    let geometry = walls.map(wall).join(", ");
    let lamp =
        r#"{ "name": "lamp", "type": "point", "position": [0.5,0.5,0.3], "luminous_flux_lm": 1000, "dimming": 0.5 }"#;
    let scene = scene_of(materials, &geometry, lamp, r#", "aim": [0,0,1], "gamma_step_deg": 2"#);
    let solution = solved(&scene, 200_000, 2);
    let balance = solution.flux_balance.as_ref().expect("chains were traced");
    let light = &leaving_light(&scene, &solution)[0];
    let flux = light.luminous_flux_lm;
    // The number of packets that leave has a binomial variance. Direct light is cut off between two rows of the table.
    let chance_lm = (balance.escaped_lm * (500.0 - balance.escaped_lm) / 200_000.0).sqrt();
    let allowed_lm = 5.0 * chance_lm.hypot(flux.standard_error) + 0.004 * 500.0;
    assert!((flux.value - balance.escaped_lm).abs() < allowed_lm, "{flux:?}, balance {}", balance.escaped_lm);
    assert!((1.05 * flux.value - balance.escaped_lm).abs() > allowed_lm, "the planted fault passed");
    assert!((light.lamps_lm - 500.0).abs() < 1e-9 && (light.light_output_ratio - flux.value / 500.0).abs() < 1e-12);
    assert!(solution.maps[0].values.value.iter().all(|intensity_cd| *intensity_cd >= 0.0));
    for read in read_back(&scene, &solution) {
        assert!(read.warnings.is_empty(), "{:?}", read.warnings);
        assert!((read.luminous_flux_lm() / flux.value - 1.0).abs() < 1e-7, "{:?}", read.format);
    }
    // The same numbers for any number of threads.
    let again = solved(&scene, 200_000, 1);
    assert!(again.maps[0].values.value == solution.maps[0].values.value);
}

/// A single plane holds the mean over all planes.
#[test]
fn a_single_plane_is_the_mean_over_all() {
    let path = "scenes/luminaires/wall_washer.ldt";
    let lamp = format!(r#"{{ "name": "lamp", "type": "photometric", "file": "{path}", "position": [0,0,0] }}"#);
    let scene = scene_of(BLACK, SPECK, &lamp, r#", "c_planes": 1, "gamma_step_deg": 10"#);
    let solution = solved(&scene, 4000, 2);
    let truth = read_photometric_file(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect("a sample file");
    for ([_, gamma_deg], _, value_cd, error_cd) in directions(&scene, &solution) {
        let exact_cd =
            (0..3600).map(|tenth| truth.web.intensity_cd(0.1 * f64::from(tenth), gamma_deg)).sum::<f64>() / 3600.0;
        let allowed_cd = WITHIN * error_cd + 1e-4 * truth.web.maximum_intensity_cd();
        assert!((value_cd - exact_cd).abs() < allowed_cd, "{gamma_deg}: {value_cd} ± {error_cd}, exact {exact_cd}");
    }
    for read in read_back(&scene, &solution) {
        let flux_lm = leaving_light(&scene, &solution)[0].luminous_flux_lm.value;
        assert!((read.luminous_flux_lm() / flux_lm - 1.0).abs() < 1e-7, "{:?}", read.format);
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let read = |luminaire: &str, receiver: &str| {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ {BLACK} }}, "geometry": [ {SPECK} ], "luminaires": [ {luminaire} ],
            "receivers": [ {{ "name": "far", "type": "intensity" {receiver} }} ] }}"#
        );
        scene_from_json(&text, None, Path::new(".")).map(|_| ()).map_err(|error| error.to_string())
    };
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [0,0,0], "intensity_cd": 1 }"#;
    let sky =
        r#"{ "name": "sky", "type": "sky", "luminance_distribution": "uniform", "horizontal_illuminance_lx": 1000 }"#;
    assert_eq!(read(lamp, ""), Ok(()));
    for (luminaire, receiver, said) in [
        (lamp, r#", "gamma_step_deg": 7"#, "180° divided by a whole number"),
        (lamp, r#", "gamma_step_deg": 0.1"#, "180° divided by a whole number"),
        (lamp, r#", "c_planes": 1000"#, "at most 720"),
        (lamp, r#", "c_planes": 0"#, "C planes"),
        (lamp, r#", "luminous_opening": [1, 2]"#, "three extents"),
        (lamp, r#", "position": [0,0,0]"#, "position"),
        (sky, "", "without sky and sun"),
    ] {
        let told = read(luminaire, receiver).expect_err(receiver);
        assert!(told.contains(said), "{told}");
    }
}
