//! The 3D view of `report.html`: the page holds the numbers of the tables.

use std::io::Read as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use luxmc::output::{ReportContext, plots, report_files, result_files};
use luxmc::solver::ElementChoice;
use luxmc::{MapSelection, Scene, Settings, Silent, Solution, scene_from_json, solve};
use serde_json::Value;

const SCENE: &str = r#"{ "version": 1, "title": "a room",
  "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 }, "wood": { "type": "diffuse", "reflectance": 0.3 } },
  "geometry": [ { "name": "room </script>", "type": "box", "min": [100, 200, 0], "max": [104, 203, 2.5], "facing": "inward", "material": "paint",
                  "max_element_edge": 1 },
                { "name": "board", "type": "rectangle", "origin": [101, 201, 1], "u": [1, 0, 0], "v": [0, 1, 0], "material": "wood", "two_sided": true },
                { "name": "block", "type": "box", "min": [102.9, 201.9, 0], "max": [103.4, 202.4, 1], "material": "wood" } ],
  "luminaires": [ { "name": "lamp", "type": "point", "position": [102, 201.5, 2], "intensity_cd": 100 } ],
  "receivers": [ { "name": "plane", "type": "grid", "origin": [100.5, 200.5, 0.8], "u": [3, 0, 0], "v": [0, 2, 0], "columns": 7, "rows": 5 } ] }"#;

fn solved(elements: ElementChoice, maps: MapSelection) -> (Scene, Solution) {
    solved_scene(SCENE, elements, maps)
}

pub fn solved_scene(scene: &str, elements: ElementChoice, maps: MapSelection) -> (Scene, Solution) {
    let scene = scene_from_json(scene, None, Path::new(".")).expect("valid");
    let settings = Settings { chains: Some(64), maps, elements, ..Settings::default() };
    let solution = solve(&scene, &settings, &Silent);
    (scene, solution)
}

pub fn page_of(scene: &Scene, solution: &Solution) -> String {
    let context = ReportContext {
        scene: "a.json".into(),
        command: "luxmc".into(),
        repeats_digits: true,
        unix_time_s: 0,
        wall_s: 1.0,
        threads: 1,
        language: luxmc::output::Language::ENGLISH,
    };
    let (file, _) = report_files(scene, solution, &plots(scene, solution), &context);
    String::from_utf8(file.bytes).expect("text")
}

pub fn table(scene: &Scene, solution: &Solution, name: &str) -> Vec<csv::StringRecord> {
    let files = result_files(scene, solution).expect("finite");
    let file = files.into_iter().find(|file| file.name == name).expect("written");
    csv::Reader::from_reader(&file.bytes[..]).records().map(|row| row.expect("a row")).collect()
}

/// The data as the page's script reads them.
struct Held {
    about: Value,
    corners: Vec<Vec<u16>>,
    parts: Vec<u16>,
    means: Vec<Vec<u16>>,
    at_corners: Vec<Vec<u16>>,
}

impl Held {
    fn of(page: &str) -> Held {
        let between =
            |start: &str| page.split(start).nth(1).and_then(|rest| rest.split("</script>").next()).expect(start);
        let about: Value = serde_json::from_str(between("id=\"view-about\">")).expect("JSON");
        let packed = STANDARD.decode(between("id=\"view-data\">")).expect("base 64");
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).expect("zlib");
        let mut rest = &bytes[..];
        let mut column = |length: usize| {
            let (here, after) = rest.split_at(2 * length);
            rest = after;
            let mut code = 0u16;
            let add = |i: usize| {
                code = code.wrapping_add(u16::from_le_bytes([here[i], here[length + i]]));
                code
            };
            (0..length).map(add).collect::<Vec<u16>>()
        };
        let count = |key: &str| about[key].as_u64().expect(key) as usize;
        let corners = (0..9).map(|_| column(count("facets"))).collect();
        let parts = column(count("facets"));
        let means = (0..4).map(|_| column(count("facets"))).collect();
        let sloped = if about["is_sloped"] == true { 3 } else { 0 };
        let at_corners = (0..sloped).map(|_| column(count("facets"))).collect();
        (0..6).for_each(|_| drop(column(count("lines"))));
        assert!(rest.is_empty(), "nothing is left over");
        Held { about, corners, parts, means, at_corners }
    }

    fn number(&self, key: &str) -> f64 {
        self.about[key].as_f64().expect(key)
    }

    fn lux(&self, code: u16) -> Option<f64> {
        let share = (f64::from(code) - 1.0) / 65_533.0 - 1.0;
        match code {
            u16::MAX => None,
            0 => Some(0.0),
            _ => Some(self.number("most_lx") * (share * self.number("span")).exp()),
        }
    }

    /// Corner of a triangle in m.
    fn corner(&self, facet: usize, corner: usize) -> [f64; 3] {
        let step_m = self.number("step_m");
        [0, 1, 2].map(|axis| {
            self.about["low_m"][axis].as_f64().expect("m") + step_m * f64::from(self.corners[3 * corner + axis][facet])
        })
    }

    /// Differences from a row of a table. `columns` holds the column of x and that of the illuminance, after which its error, the direct
    /// and the indirect light follow.
    fn faults(&self, facet: usize, row: &csv::StringRecord, middle_m: [f64; 3], columns: [usize; 2]) -> Vec<String> {
        let told = |column: usize| row[column].parse::<f64>().expect("a number");
        let mut faults = Vec::new();
        for (axis, found_m) in middle_m.iter().enumerate() {
            let away_m = (found_m - told(columns[0] + axis)).abs();
            if away_m > 0.51 * self.number("step_m") {
                faults.push(format!("triangle {facet} lies {away_m} m off"));
            }
        }
        // The page has total, direct, indirect and error; the tables have total, error, direct and indirect.
        for (quantity, column) in [0, 2, 3, 1].into_iter().enumerate() {
            let wanted_lx = told(columns[1] + column).max(0.0);
            let found_lx = self.lux(self.means[quantity][facet]).unwrap_or(f64::INFINITY);
            // The tolerance is half a step of the code, and whatever is below nine decades.
            if (found_lx - wanted_lx).abs() > 1.7e-4 * wanted_lx + 1.01e-9 * self.number("most_lx") {
                faults.push(format!("triangle {facet} has {found_lx} for {wanted_lx}"));
            }
        }
        faults
    }
}

fn middle_m(corners_m: [[f64; 3]; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| corners_m.iter().map(|corner_m| corner_m[axis]).sum::<f64>() / 3.0)
}

/// Elements that are hidden by contact have no value.
fn element_faults(held: &Held, rows: &[csv::StringRecord], covered: &[bool]) -> Vec<String> {
    let is_covered = |facet: usize| covered.get(facet).is_some_and(|covered| *covered);
    let of_row = |(facet, row): (usize, &csv::StringRecord)| {
        let middle_m = middle_m([0, 1, 2].map(|corner| held.corner(facet, corner)));
        let mut faults = match is_covered(facet) {
            true if held.lux(held.means[0][facet]).is_some() => vec![format!("triangle {facet} has a value")],
            true => Vec::new(),
            false => held.faults(facet, row, middle_m, [3, 10]),
        };
        let name = held.about["parts"][usize::from(held.parts[facet])].as_str().expect("a name").to_owned();
        let wanted = if &row[2] == "back" { format!("{}, back", &row[0]) } else { row[0].to_owned() };
        if name != wanted {
            faults.push(format!("triangle {facet} is named {name}, not {wanted}"));
        }
        faults
    };
    rows.iter().enumerate().flat_map(of_row).collect()
}

#[test]
fn the_page_holds_what_the_tables_hold() {
    let (scene, solution) = solved(ElementChoice::Given, MapSelection::All);
    let page = page_of(&scene, &solution);
    let mut held = Held::of(&page);
    let elements = table(&scene, &solution, "elements.csv");
    assert!(elements.len() > 100 && held.number("surface_facets") == elements.len() as f64);
    assert_eq!(element_faults(&held, &elements, &solution.maps[0].values.in_contact), Vec::<String>::new());

    // The cell of a receiver is two triangles. The middle of its diagonal is the point.
    let receivers = table(&scene, &solution, "receivers.csv");
    assert_eq!(receivers.len(), 35);
    assert_eq!(held.parts.len(), elements.len() + 2 * receivers.len());
    let mut inside = 0;
    for (index, row) in receivers.iter().enumerate() {
        for facet in [0, 1].map(|half| elements.len() + 2 * index + half) {
            if &row[12] == "true" {
                inside += 1;
                assert_eq!(held.lux(held.means[0][facet]), None, "what lies inside of a solid has no value");
                continue;
            }
            let across = if facet % 2 == elements.len() % 2 { [0, 2] } else { [0, 1] };
            let ends_m = across.map(|corner| held.corner(facet, corner));
            let middle_m = [0, 1, 2].map(|axis| 0.5 * (ends_m[0][axis] + ends_m[1][axis]));
            assert_eq!(held.faults(facet, row, middle_m, [2, 8]), Vec::<String>::new());
        }
    }
    assert!(inside > 0, "a point lies in the block");

    // A value that is off by one in a thousand is detected, and so is a position that is off by a few steps.
    let code = held.means[0][7];
    held.means[0][7] = code.wrapping_add(4);
    assert_eq!(element_faults(&held, &elements, &solution.maps[0].values.in_contact).len(), 1);
    held.means[0][7] = code;
    held.corners[0][9] = held.corners[0][9].wrapping_add(6);
    assert_eq!(element_faults(&held, &elements, &solution.maps[0].values.in_contact).len(), 1);
}

#[test]
fn elements_that_adapt_keep_their_slopes() {
    let (scene, solution) = solved(ElementChoice::Adaptive, MapSelection::Elements);
    let held = Held::of(&page_of(&scene, &solution));
    let elements = table(&scene, &solution, "elements.csv");
    assert_eq!(element_faults(&held, &elements, &solution.maps[0].values.in_contact), Vec::<String>::new());
    let map = &solution.maps[0];
    let covered = &map.values.in_contact;
    assert!(covered.iter().any(|covered| *covered), "the block stands on the floor");
    for (index, row) in elements.iter().enumerate().filter(|(index, _)| !covered[*index]) {
        let at_corners_lx = map.values.at_corners_lx(index);
        let turned = if &row[2] == "back" { [0, 2, 1] } else { [0, 1, 2] };
        for (column, corner) in turned.into_iter().enumerate() {
            let (found_lx, wanted_lx) =
                (held.lux(held.at_corners[column][index]).expect("a value"), at_corners_lx[corner]);
            assert!((found_lx - wanted_lx).abs() <= 1.7e-4 * wanted_lx + 1.01e-9 * held.number("most_lx"));
        }
    }
}

#[test]
fn without_an_element_map_the_scene_is_grey_and_receivers_have_colours() {
    let (scene, solution) = solved(ElementChoice::Given, MapSelection::Receivers);
    let page = page_of(&scene, &solution);
    let held = Held::of(&page);
    let surfaces = held.number("surface_facets") as usize;
    assert!(surfaces > 100 && held.means[0][..surfaces].iter().all(|code| *code == u16::MAX));
    assert!(held.means[0][surfaces..].iter().any(|code| *code != u16::MAX));
}

#[test]
fn the_page_stands_by_itself_and_names_cannot_end_its_scripts() {
    let (scene, solution) = solved(ElementChoice::Given, MapSelection::All);
    let page = page_of(&scene, &solution);
    assert_eq!(page.matches("<script").count(), 3);
    assert_eq!(page.matches("</script").count(), 3, "the room's name ends a script");
    for outside in ["http://", "https://", " src=", "@import", "fetch("] {
        let own = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!own.contains(outside), "{outside}");
    }
    let script = page.rsplit("<script>\n").next().and_then(|rest| rest.split("</script>").next()).expect("a script");
    assert!(script.contains("webgl") && script.lines().count() <= 300, "it can be read in one sitting");
    let without = String::from_utf8(
        report_files(
            &scene,
            &solution,
            &[],
            &ReportContext {
                scene: String::new(),
                command: String::new(),
                repeats_digits: false,
                unix_time_s: 0,
                wall_s: 0.0,
                threads: 1,
                language: luxmc::output::Language::ENGLISH,
            },
        )
        .0
        .bytes,
    );
    assert!(!without.expect("text").contains("view-data"), "pages without plots have no view");
}

/// Of 230 receiver sets the report lists 200 and states how many it leaves out. With 200 sets it leaves out none.
#[test]
fn of_very_many_receiver_sets_a_report_lists_the_first_and_tells_of_the_rest() {
    let page_of_sets = |count: usize| {
        let set = |i: usize| {
            let x = 100.1 + 0.01 * i as f64;
            format!(r#"{{ "name": "set {i}.", "type": "points", "points": [[{x}, 201.5, 0.8, 0, 0, 1]] }}"#)
        };
        let mut json: Value = serde_json::from_str(SCENE).expect("JSON");
        let sets = (0..count).map(set).collect::<Vec<_>>().join(",");
        json["receivers"] = serde_json::from_str(&format!("[{sets}]")).expect("JSON");
        let scene = scene_from_json(&json.to_string(), None, Path::new(".")).expect("valid");
        let settings = Settings { chains: Some(16), maps: MapSelection::Receivers, ..Settings::default() };
        page_of(&scene, &solve(&scene, &settings, &Silent))
    };
    let listed = |page: &str| page.matches("<td class=\"text\">set ").count();
    let page = page_of_sets(230);
    assert_eq!(listed(&page), 200);
    assert!(page.contains("Not listed: 30 more receiver sets; tables.csv contains all."));
    let page = page_of_sets(200);
    assert_eq!(listed(&page), 200);
    assert!(!page.contains("Not listed"));
}
