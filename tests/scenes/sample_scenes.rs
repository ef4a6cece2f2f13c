//! The sample scenes against the numbers in `scenes/expected.csv`.

use luxmc::solver::MapSelection;

use crate::common::{self, to_target};

/// Limit for the deviation of an average in combined standard errors: α = 1e-5 with Student's t at 15 degrees of freedom.
const MOST_ERRORS: f64 = 6.5;

fn gives_its_expected_averages(name: &str) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/expected.csv");
    let mut reader = csv::Reader::from_path(path).expect("scenes/expected.csv");
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    let scene = common::scene(name);
    // Seed 3. The errors are large enough for quick runs and small enough to detect 1 %.
    let solution = to_target(&scene, 3, MapSelection::Default, 0.02);
    let tables: Vec<_> = solution.maps.iter().flat_map(|map| &map.tables).collect();
    let mut compared = 0;
    for row in rows.iter().filter(|row| &row[0] == name) {
        let (expected_lx, expected_error_lx): (f64, f64) = (row[2].parse().unwrap(), row[3].parse().unwrap());
        let parts: Vec<_> = tables
            .iter()
            .filter(|table| table.name == row[1] || table.name.starts_with(&format!("{}/", &row[1])))
            .collect();
        let area: f64 = parts.iter().map(|part| part.area_m2).sum();
        let average_lx = parts.iter().map(|part| part.average.value * part.area_m2).sum::<f64>() / area;
        // Parts of one map are correlated: their errors add linearly at most.
        let error_lx = parts.iter().map(|part| part.average.standard_error * part.area_m2).sum::<f64>() / area;
        let combined_lx = error_lx.hypot(expected_error_lx);
        let z = (average_lx - expected_lx) / combined_lx;
        assert!(z.abs() < MOST_ERRORS, "{name} {}: {average_lx} ± {error_lx} against {expected_lx}, z = {z}", &row[1]);
        let z = (average_lx - 1.02 * expected_lx) / combined_lx;
        assert!(z.abs() > MOST_ERRORS, "{name} {}: a planted fault of 2% passed, z = {z}", &row[1]);
        compared += 1;
    }
    assert!(compared > 0, "{name} has no expected number");
}

#[test]
fn the_cube_gives_its_expected_averages() {
    gives_its_expected_averages("cube.json");
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn the_sphere_gives_its_expected_averages() {
    gives_its_expected_averages("sphere.json");
}

#[test]
fn the_office_gives_its_expected_averages() {
    gives_its_expected_averages("office.json");
}
