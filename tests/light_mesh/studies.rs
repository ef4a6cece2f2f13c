//! Small versions of the studies of light meshes: every one runs, its tables contain numbers, and its pictures are drawn.

use std::fs;
use std::process::Command;

use luxmc::validation::studies::{
    DirectForm, Findings, Interpolation, Only, STUDIES, StudyWishes, studies_named, study_csv, study_md, study_section,
};

fn found(name: &str) -> Findings {
    found_only(name, Only::default())
}

fn found_only(name: &str, only: Only) -> Findings {
    let study = studies_named(name)[0];
    (study.run)(&mut StudyWishes { quick: true, only, tell: &mut |_| {} })
        .unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn number(cell: &str) -> f64 {
    let digits: String = cell.chars().filter(|letter| letter.is_ascii_digit() || *letter == '.').collect();
    digits.parse().unwrap_or_else(|_| panic!("{cell} is no number"))
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn every_study_tells_numbers_and_draws() {
    for study in STUDIES {
        let found = found(study.name);
        assert_eq!((found.name, found.title), (study.name, study.title));
        assert!(!found.results.is_empty() && !found.tables.is_empty(), "{}", study.name);
        let texts = [study_md(&found), study_csv(&found), study_section(&found)];
        for text in &texts {
            assert!(!text.contains("NaN") && !text.contains("inf"), "{}: {text}", study.name);
        }
        assert_eq!(texts[2].matches("<svg").count(), found.pictures.len(), "{}", study.name);
        for (_, table) in &found.tables {
            assert!(table.rows.iter().all(|row| row.len() == table.header.len()), "{}", study.name);
        }
    }
    assert_eq!(studies_named("light-mesh").len(), 9);
    assert_eq!(["shadow-rivals", "scaling", "choice"].map(|name| studies_named(name).len()), [1, 1, 1]);
    assert!(studies_named("cube").is_empty());
}

/// The error decreases with the step for every radius. An area of more points is more accurate, for more rays.
#[test]
fn steps_and_sources_are_in_order() {
    let steps = found("light-mesh-steps");
    let rows = &steps.tables[0].1.rows;
    for column in 1..5 {
        let errors: Vec<f64> = rows.iter().map(|row| number(&row[column])).collect();
        assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
    }
    let sources = found("light-mesh-sources");
    let rows = &sources.tables[0].1.rows;
    let of = |row: usize, column: usize| number(&rows[row][column]);
    assert_eq!([1, 2, 3].map(|row| of(row, 1) / of(0, 1)), [5.0, 25.0, 225.0]);
    // With the view ray of a picture added, the ratio is the papers' 2 : 6 : 172, except for what their scene does not light.
    assert_eq!([0, 1, 2, 3].map(|row| of(row, 4)), [2.0, 6.0, 26.0, 226.0]);
    assert!(of(3, 6) < of(1, 6) && of(1, 6) < of(0, 6), "{rows:?}");
}

/// The set of lamps that a point sees contains more information than one number of their light. With the same points its error is far
/// smaller, and only its error decreases with the step once shadows are resolved. The planted fault, exchanged forms, fails.
#[test]
fn visibility_beats_one_number_and_finer_meshes_help_it_alone() {
    let rows = &found("light-mesh-forms").tables[0].1.rows;
    let errors = |cells: &str, form: &str| -> Vec<f64> {
        rows.iter().filter(|row| row[0] == cells && row[2] == form).map(|row| number(&row[5])).collect()
    };
    let [coarse, fine, scalar] = [errors("20", "visibility"), errors("40", "visibility"), errors("40", "scalar")];
    assert_eq!([coarse.len(), fine.len(), scalar.len()], [4; 3]);
    assert!(coarse.iter().zip(&fine).all(|(coarse, fine)| fine < coarse), "{coarse:?} {fine:?}");
    let beats = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a < b);
    assert!(beats(&fine, &scalar), "{fine:?} {scalar:?}");
    assert!(!beats(&scalar, &fine), "the planted fault passed");
}

/// Rows that are left out with `--mesh-direct` and `--mesh-interpolation` do not change the others.
#[test]
fn forms_can_be_asked_for_one_by_one() {
    let all = found("light-mesh-forms").tables.remove(0).1.rows;
    let only = Only { direct: Some(DirectForm::Scalar), interpolation: Some(Interpolation::Sphere) };
    let some = found_only("light-mesh-forms", only).tables.remove(0).1.rows;
    let expected: Vec<_> = all.into_iter().filter(|row| row[2] == "scalar" && row[3].starts_with("sphere")).collect();
    assert_eq!(some, expected);
    assert_eq!(some.len(), 4);
}

/// Light on a plane, interpolated from the mesh points, approaches the light on a floor as the mesh gets finer, with every φ₅. A quarter of
/// the light from all sides does not. The planted fault, exchanged forms, fails.
#[test]
fn planes_beat_one_number_of_indirect_light() {
    let rows = &found("light-mesh-indirect").tables[0].1.rows;
    let errors = |cells: &str, form: &str| -> Vec<f64> {
        rows.iter().filter(|row| row[0] == cells && row[2] == form).map(|row| number(&row[5])).collect()
    };
    let [coarse, plane, scalar] = [errors("10", "plane"), errors("20", "plane"), errors("20", "scalar")];
    assert_eq!([coarse.len(), plane.len(), scalar.len()], [4; 3]);
    let beats = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a < b);
    assert!(beats(&plane, &coarse) && beats(&plane, &scalar), "{coarse:?} {plane:?} {scalar:?}");
    assert!(!beats(&scalar, &plane), "the planted fault passed");
}

/// The penumbra by shadow rays is that of the ball. It is within 3 % of the width by similar triangles between a tenth and nine tenths
/// (0.248 m). The mesh of a point source is far from it (as a wrong source would be).
#[test]
fn the_real_penumbra_is_the_balls() {
    let rows = &found("light-mesh-penumbra").tables[0].1.rows;
    assert!((number(&rows[0][4]) / 0.248 - 1.0).abs() < 0.03, "{:?}", rows[0]);
    let point = rows.iter().find(|row| row[0] == "point" && row[2] == "0.15").expect("a point");
    assert!((number(&point[4]) / 0.248 - 1.0).abs() > 0.2, "{point:?}");
}

#[test]
fn compare_runs_a_study_by_its_name_and_lists_them() {
    let home = tempfile::tempdir().expect("a folder");
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_luxmc")).args(arguments).current_dir(home.path()).output().expect("it starts")
    };
    let help = run(&["compare", "--help"]);
    assert!(String::from_utf8_lossy(&help.stdout).contains("light-mesh-penumbra"));
    let done = run(&["compare", "light-mesh-luminaires", "--quick", "--out", "out"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(String::from_utf8_lossy(&done.stdout).contains("The mesh is faster"));
    let out = home.path().join("out");
    for name in ["compare.html", "compare.md", "light-mesh-luminaires.csv"] {
        assert!(fs::metadata(out.join(name)).is_ok_and(|file| file.len() > 200), "{name}");
    }
    assert!(!out.join("compare.csv").exists());
}
