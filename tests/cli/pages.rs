//! Files of `solve` for people, and the first hour: plots, report, ParaView file, `new`, `completions`.

use std::path::Path;

use crate::cli_support::*;

fn names(out: &Path) -> Vec<String> {
    summary(out)["files"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|name| name.as_str().expect("text").to_owned())
        .collect()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Checks that every tag of an XML text is closed in order, and that no tag of ours has an attribute twice.
fn assert_well_formed(name: &str, text: &str) {
    let mut open: Vec<&str> = Vec::new();
    for piece in text.split('<').skip(1) {
        let tag = piece.split('>').next().expect("a split has a first part");
        if tag.starts_with(['?', '!']) || tag.ends_with('/') {
            continue;
        }
        let label = tag.split_whitespace().next().expect("a name");
        match label.strip_prefix('/') {
            Some(closed) => assert_eq!(open.pop(), Some(closed), "{name}"),
            None => open.push(label),
        }
    }
    assert!(open.is_empty(), "{name}: {open:?} not closed");
}

#[test]
fn every_template_reads_without_a_warning_of_its_own_and_solves_as_it_is() {
    for (kind, maps) in [
        ("office", "desks"),
        ("corridor", "floor"),
        ("classroom", "desks"),
        ("gym", "playing area"),
        ("hall", "aisles"),
    ] {
        let home = tempfile::tempdir().expect("a temporary directory");
        let project = home.path().join("project");
        let made = run(&["new", kind, "--out", text(&project)]);
        assert_eq!(code(&made), 0, "{}", errors(&made));
        assert!(read(&project.join("README.txt")).contains("maintenance_factor"));

        let scene = project.join(format!("{kind}.json"));
        let inspected = run(&["inspect", text(&scene), "--json"]);
        assert_eq!(code(&inspected), 0, "{}", errors(&inspected));
        let inspection: serde_json::Value = serde_json::from_str(&results(&inspected)).expect("JSON");
        assert_eq!(inspection["closed"], true, "{kind}");
        let warnings = inspection["warnings"].as_array().expect("a list");
        assert!(
            warnings.iter().all(|warning| warning.to_string().contains("inside of a closed solid")),
            "{warnings:?}"
        );

        let out = project.join("results");
        let solved = run(&["solve", text(&scene), "--out", text(&out), "--chains", "2000", "--maps", maps, "--quiet"]);
        assert_eq!(code(&solved), 0, "{}", errors(&solved));
        let plot = format!("map-{}.svg", maps.replace(' ', "-"));
        assert!(out.join(&plot).is_file() && out.join("report.html").is_file(), "{kind}: {:?}", listing(&out));

        // A second project does not overwrite the first.
        let again = run(&["new", kind, "--out", text(&project)]);
        assert_eq!(code(&again), 2);
        assert!(errors(&again).contains("remedy"));
    }
}

#[test]
fn plots_come_in_the_formats_asked_for_and_are_taken_away_again() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let project = home.path().join("p");
    assert_eq!(code(&run(&["new", "corridor", "--out", text(&project)])), 0);
    let (scene, out) = (project.join("corridor.json"), home.path().join("out"));
    let solve = |plots: &str| {
        let output =
            run(&["solve", text(&scene), "--out", text(&out), "--chains", "3000", "--plots", plots, "--quiet"]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        names(&out)
    };
    let both = solve("svg,png");
    for stem in [
        "convergence",
        "map-floor",
        "map-floor-values",
        "map-corridor-floor",
        "map-corridor-x_min",
        "luminaire-wall-washer-1",
    ] {
        for ending in ["svg", "png"] {
            assert!(both.contains(&format!("{stem}.{ending}")), "{stem}.{ending} is missing in {both:?}");
        }
    }
    assert!(std::fs::read(out.join("map-floor.png")).expect("there").starts_with(b"\x89PNG"));
    for name in both.iter().filter(|name| name.ends_with(".svg")) {
        assert_well_formed(name, &read(&out.join(name)));
    }
    let none = solve("none");
    assert!(none.iter().all(|name| !name.ends_with(".svg") && !name.ends_with(".png")), "{none:?}");
    assert!(!out.join("map-floor.svg").exists() && out.join("report.html").is_file());
}

/// A cube whose faces emit alike has the same illuminance everywhere. Its map has one colour and states this. It has no isolux lines,
/// because they would show only noise.
#[test]
fn a_map_without_differences_is_drawn_as_that() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let lamp = |face: &str| {
        format!(r#"{{ "name": "{face}", "type": "area", "surface": "r/{face}", "luminous_flux_lm": 1000 }}"#)
    };
    let lamps = ["floor", "ceiling", "x_min", "x_max", "y_min", "y_max"].map(lamp).join(", ");
    let text_of = |lamps: &str| {
        format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [4,4,4], "facing": "inward", "material": "m" }} ],
            "luminaires": [ {lamps} ],
            "receivers": [ {{ "name": "p", "type": "grid", "origin": [1,1,1], "u": [2,0,0], "v": [0,2,0], "columns": 6, "rows": 6 }} ] }}"#
        )
    };
    let uneven = r#"{ "name": "l", "type": "point", "position": [2, 2, 3], "luminous_flux_lm": 1000 }"#;
    for (name, lamps, is_even) in [("even", lamps.as_str(), true), ("uneven", uneven, false)] {
        let (scene, out) = (home.path().join(format!("{name}.json")), home.path().join(name));
        std::fs::write(&scene, text_of(lamps)).expect("written");
        let output = solve_file(&scene, &out, &["--target-error", "2%", "--maps", "p", "--quiet"]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        let plot = read(&out.join("map-p.svg"));
        assert_eq!(
            plot.contains("No isolux lines: the values differ by little more than their error."),
            is_even,
            "{name}"
        );
    }
}

#[test]
fn the_report_tells_the_numbers_of_the_tables_and_stands_by_itself() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let project = home.path().join("p");
    assert_eq!(code(&run(&["new", "office", "--out", text(&project)])), 0);
    let (scene, out) = (project.join("office.json"), home.path().join("out"));
    let output = run(&["solve", text(&scene), "--out", text(&out), "--target-error", "5%", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let report = read(&out.join("report.html"));
    let (header, rows) = table(&out.join("tables.csv"));
    let column = |name: &str| header.iter().position(|column| column == name).expect("a column");
    for row in rows.iter().filter(|row| row[column("kind")] == "grid") {
        let average: f64 = row[column("average_lx")].parse().expect("a number");
        let quantity = if row[0] == "faces" { " (cylindrical)" } else { "" };
        assert!(
            report.contains(&format!("<td class=\"text\">{}{quantity}</td><td>{average:.0} <span", row[0])),
            "{row:?}"
        );
    }
    for words in [
        "maintenance factor 0.80",
        "stated error of at most 5.0",
        "--target-error 0.05",
        "troffer 1 … troffer 12",
        "Electric power 384 W",
        "W/m² for every 100 lx",
    ] {
        assert!(report.contains(words), "{words}");
    }
    // The report loads nothing from elsewhere.
    for link in ["src=", "href=", "url(", "@import"] {
        assert!(!report.contains(link), "{link}");
    }
}

/// Output requested in German is in German. Numbers for other programs do not change.
#[test]
fn a_language_changes_pages_and_no_numbers_for_programs() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let project = home.path().join("p");
    assert_eq!(code(&run(&["new", "corridor", "--out", text(&project)])), 0);
    let scene = project.join("corridor.json");
    let solve = |language: &str| {
        let out = home.path().join(language);
        let solved =
            run(&["solve", text(&scene), "--out", text(&out), "--chains", "3000", "--quiet", "--language", language]);
        assert_eq!(code(&solved), 0, "{}", errors(&solved));
        (results(&solved), out)
    };
    let ((told, english), (erzaehlt, german)) = (solve("en"), solve("de"));
    assert!(
        told.contains("required") && erzaehlt.contains("gefordert") && !erzaehlt.contains("required"),
        "{erzaehlt}"
    );
    assert!(read(&english.join("report.html")).contains("<h2>Verdicts</h2>"));
    assert!(read(&german.join("report.html")).contains("<h2>Urteile</h2>"));
    for name in ["receivers.csv", "tables.csv", "verdicts.csv", "ugr.csv"] {
        assert_eq!(read(&english.join(name)), read(&german.join(name)), "{name}");
    }
    for out in [&english, &german] {
        let pdf = std::fs::read(out.join("report.pdf")).expect("written");
        assert!(pdf.starts_with(b"%PDF-1.7") && pdf.ends_with(b"%%EOF"));
    }
    assert_eq!(code(&run(&["solve", text(&scene), "--out", text(&english), "--language", "xx"])), 2);
}

/// A classroom from the first command to its page. What a client reads first stands first. Housings and everything kept out of reports
/// stand in files only.
#[test]
fn the_first_page_tells_whose_project_it_is_and_whether_it_passes() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let room = |more: &str| {
        format!(
            r#"{{ "version": 1, "title": "Room 7", "project": {{ "client": "A & B", "date": "in spring", "notes": "First line.\nSecond line." }},
          "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
          "geometry": [
            {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "grey" }},
            {{ "name": "lamp", "type": "box", "min": [1.5,1,2.3], "max": [2.5,2,2.35], "material": "grey"{more} }},
            {{ "name": "shelf", "type": "box", "min": [0.1,0.1,0.5], "max": [0.5,1,1.5], "material": "grey", "report": false }},
            {{ "name": "table", "type": "box", "min": [2.6,1,0.5], "max": [3.5,2,0.7], "material": "grey" }} ],
          "luminaires": [ {{ "name": "panel", "type": "area", "surface": "lamp/floor", "luminous_flux_lm": 4000, "maintenance_factor": 0.8 }} ],
          "receivers": [ {{ "name": "desk", "type": "grid", "origin": [1,1,0.8], "u": [2,0,0], "v": [0,1,0], "columns": 8, "rows": 5,
            "requirements": {{ "average_lx": 10, "minimum_lx": 5000 }} }} ] }}"#
        )
    };
    let solve = |more: &str, name: &str| {
        let (scene, out) = (home.path().join(format!("{name}.json")), home.path().join(name));
        std::fs::write(&scene, room(more)).expect("written");
        let solved = run(&["solve", text(&scene), "--out", text(&out), "--chains", "20000"]);
        assert_eq!(code(&solved), 0, "{}", errors(&solved));
        (out, results(&solved), errors(&solved))
    };
    let (out, printed, told) = solve("", "plain");
    let report = read(&out.join("report.html"));
    let place = |words: &str| report.find(words).unwrap_or_else(|| panic!("{words} is missing"));
    let order = [
        "Room 7",
        "A &amp; B",
        "in spring",
        "<p>Second line.</p>",
        "1 of 2 requirements are met, 1 not.",
        "Not met: E<sub>min</sub> ≥ 5000 lx (desk).",
        "<h2>Verdicts</h2>",
        "<h3>Plan</h3>",
        "<h3>Illuminance: desk</h3>",
        "Luminaire schedule",
        "<h2>Results</h2>",
        "How this was computed, and how certain it is",
        "Evidence",
    ];
    let places = order.map(place);
    assert!(places.is_sorted(), "{places:?}");
    for name in ["lamp/floor", "lamp/x_min", "shelf/x_max"] {
        assert!(!printed.contains(name) && !report.contains(name), "{name} is told of");
        assert!(!out.join(format!("map-{}.svg", name.replace('/', "-"))).exists(), "{name} is drawn");
        assert!(
            read(&out.join("tables.csv")).contains(name)
                && read(&out.join("elements.csv")).contains(&format!("{name},"))
        );
    }
    assert!(told.contains("12 surfaces of luminaires or with \"report\": false"), "{told}");
    for name in ["room/floor", "table/ceiling"] {
        assert!(printed.contains(name) && report.contains(name), "{name} is not told of");
    }
    // On request the luminaire is shown, with the same numbers.
    let (asked, printed, _) = solve(r#", "report": true"#, "asked");
    assert!(printed.contains("lamp/x_min") && read(&asked.join("report.html")).contains("lamp/floor"));
    assert_eq!(read(&asked.join("tables.csv")), read(&out.join("tables.csv")));
}

#[test]
fn the_paraview_file_holds_every_row_of_the_elements() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let project = home.path().join("p");
    assert_eq!(code(&run(&["new", "corridor", "--out", text(&project)])), 0);
    let out = home.path().join("out");
    let scene = project.join("corridor.json");
    let output = run(&["solve", text(&scene), "--out", text(&out), "--chains", "3000", "--plots", "none", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let file = read(&out.join("scene.vtp"));
    assert_well_formed("scene.vtp", &file);
    let rows = table(&out.join("elements.csv")).1.len();
    assert!(file.contains(&format!("NumberOfPoints=\"{}\"", 3 * rows)));
    assert!(file.contains(&format!("NumberOfPolys=\"{rows}\"")));
    assert!(std::fs::read(out.join("scene.glb")).expect("there").starts_with(b"glTF"));

    // Without the element map there is no 3D file.
    let output = run(&["solve", text(&scene), "--out", text(&out), "--chains", "3000", "--maps", "floor", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(!out.join("scene.vtp").exists() && !out.join("scene.glb").exists());
}

#[test]
fn inspect_draws_luminaires_and_plans() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let project = home.path().join("p");
    assert_eq!(code(&run(&["new", "office", "--out", text(&project)])), 0);
    let plots = home.path().join("plots");
    let file = project.join("luminaires/troffer.ies");
    let output = run(&["inspect", text(&file), "--plots", text(&plots)]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(listing(&plots), ["luminaire-troffer.svg"]);
    let scene = project.join("office.json");
    assert_eq!(code(&run(&["inspect", text(&scene), "--plots", text(&plots)])), 0);
    assert_eq!(listing(&plots), ["luminaire-troffer-1.svg", "luminaire-troffer.svg", "plan.svg"]);
    assert_well_formed("plan.svg", &read(&plots.join("plan.svg")));
}

#[test]
fn shells_get_their_completions() {
    for shell in ["bash", "zsh", "fish"] {
        let output = run(&["completions", shell]);
        assert_eq!(code(&output), 0);
        assert!(results(&output).contains("target-error"), "{shell}");
    }
    // The values of an option are completed if they are a few fixed words.
    for words in ["auto collision gather local local-naive radiosity light-mesh", "adaptive given", "en de"] {
        assert!(results(&run(&["completions", "bash"])).contains(words), "{words}");
    }
}

#[test]
fn the_manual_has_a_page_for_every_command() {
    let home = tempfile::tempdir().expect("a temporary directory");
    assert_eq!(code(&run(&["man", "--out", text(home.path())])), 0);
    let pages = listing(home.path());
    for page in ["luxmc.1", "luxmc-solve.1", "luxmc-convert.1", "luxmc-man.1"] {
        assert!(pages.iter().any(|name| name == page), "{page}: {pages:?}");
    }
    let solve = run(&["man", "solve"]);
    assert_eq!(code(&solve), 0);
    assert_eq!(results(&solve), read(&home.path().join("luxmc-solve.1")));
    for words in [".TH luxmc-solve 1", "target\\-error", "Examples:"] {
        assert!(results(&solve).contains(words), "{words}: {}", results(&solve));
    }
    let unknown = run(&["man", "magic"]);
    assert!(code(&unknown) == 2 && errors(&unknown).contains("solve"), "{}", errors(&unknown));
}

/// The long version states commit, target and processor. The short one is a single line.
#[test]
fn the_version_tells_what_was_built_and_what_it_runs_on() {
    let short = results(&run(&["-V"]));
    assert_eq!(short, format!("luxmc {}\n", env!("CARGO_PKG_VERSION")));
    let long = results(&run(&["--version"]));
    assert!(long.starts_with(short.trim()), "{long}");
    let value = |key: &str| {
        let line = long.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_else(|| panic!("{key}: {long}"));
        line.trim().to_owned()
    };
    assert!(
        value("target:").contains(std::env::consts::ARCH)
            && value("processor:").contains("needed beyond the target: none")
    );
    let commit = value("commit:");
    assert!(commit.starts_with("not known") || (4..=12).contains(&commit.len()), "{commit}");
}

/// Terminal, report and files of a run that rates glare. The worst point of a grid is shown with its position. A low rating is "< 10" for
/// people and a number in the file. A luminaire that does not count is named with the reason.
#[test]
fn ratings_are_reported_where_people_look() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = home.path().join("room.json");
    let room = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
      "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [6,4,3], "facing": "inward", "material": "grey" } ],
      "luminaires": [ { "name": "steep one", "type": "sphere", "center": [1.5,2,2.8], "radius": 0.1, "luminous_flux_lm": 1000 },
        { "name": "far one", "type": "sphere", "center": [5,2,2.8], "radius": 0.1, "luminous_flux_lm": 300 } ],
      "receivers": [ { "name": "dim view", "type": "ugr", "position": [1,2,1.2], "view_direction": [1,0,0] },
        { "name": "seats", "type": "ugr_grid", "origin": [1,1,1.2], "u": [4,0,0], "v": [0,2,0], "columns": 3, "rows": 2, "background": "tabular" } ] }"#;
    std::fs::write(&scene, room.replace("300 }", "30 }")).expect("a file");
    let out = home.path().join("out");
    let solved = run(&["solve", text(&scene), "--out", text(&out), "--chains", "2000", "--maps", "receivers"]);
    assert_eq!(code(&solved), 0, "{}", errors(&solved));
    let printed = results(&solved);
    let row = |name: &str| printed.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{printed}"));
    assert!(row("dim view").contains("< 10"), "{printed}");
    assert!(row("seats").contains("worst of 48, at ("), "{printed}");

    let file = read(&out.join("ugr.csv"));
    let ugr = |line: &str| line.split(',').nth(7).and_then(|cell| cell.parse::<f64>().ok()).expect("a rating");
    let dim = file.lines().find(|line| line.starts_with("dim view")).expect("a row");
    assert!(ugr(dim) < 10.0, "{dim}");
    let worst = file.lines().filter(|line| line.starts_with("seats")).map(ugr).fold(f64::MIN, f64::max);
    let told = summary(&out)["glare"].clone();
    assert_eq!(told.as_array().map(Vec::len), Some(2));
    assert_eq!(told[1]["observers"], 48);
    assert!((told[1]["ugr"].as_f64().expect("a number") - worst).abs() < 1e-12);
    assert_eq!(told[0]["outside_position_index"][0]["luminaire"], "steep one");

    let report = read(&out.join("report.html"));
    assert!(report.contains("&lt; 10") && report.contains("the worst of 48") && report.contains("each a wedge"));
    assert!(report.contains("too steeply above the eye (H/R beyond the table, at most 1.9): steep one"));
}
