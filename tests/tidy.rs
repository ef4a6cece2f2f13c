//! Rules of order for the sources: floors, prints, f32, and the length of files.

mod house;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use house::{Modules, Named, module_of, named_in, product_code, resolved_in, tuned, without_comments};

/// Rooms and their floors. A room may use only rooms with lower numbers.
const FLOORS: &[(&str, u32)] = &[
    ("base", 0),
    ("scene", 1),
    ("geometry", 2),
    ("sampling", 2),
    ("check", 3),
    ("transport", 4),
    ("caches", 4),
    ("estimators", 5),
    ("maps", 6),
    ("control", 7),
    ("solver", 8),
    ("light_mesh", 8),
    ("radiosity", 8),
    ("year", 8),
    ("analytic", 9),
    ("methods", 9),
    ("output", 9),
    ("validation", 10),
    ("cli", 11),
];

/// Lines of a file that can be read in one sitting.
const LONGEST_FILE: usize = 600;

/// Rust files below a folder with their texts, sorted by path.
fn rust_files(folder: &Path) -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
        let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        entries.sort();
        for path in entries {
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                found.push((path, text));
            }
        }
    }
    let mut found = Vec::new();
    walk(folder, &mut found);
    found
}

fn sources() -> Vec<(PathBuf, String)> {
    let found = rust_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert!(found.len() > 20, "the sources were not found");
    found
}

fn room_of(path: &Path) -> Option<String> {
    let inside = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap();
    let mut parts = inside.components();
    let first = parts.next()?.as_os_str().to_str()?.to_owned();
    parts.next().map(|_| first)
}

/// Whether a file holds tests only.
fn is_test(path: &Path) -> bool {
    path.file_stem().is_some_and(|stem| stem.to_str().is_some_and(|stem| stem.ends_with("tests")))
}

fn floor(room: &str) -> u32 {
    FLOORS.iter().find(|(name, _)| *name == room).unwrap_or_else(|| panic!("src/{room} stands on no floor")).1
}

/// The name of a file below `src`.
fn inside(path: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    path.strip_prefix(root).unwrap().to_str().unwrap().to_owned()
}

/// The files of the library by their names below `src`.
fn modules(sources: &[(PathBuf, String)]) -> Modules {
    let rooms = sources.iter().filter(|(path, _)| room_of(path).is_some());
    Modules::of(rooms.map(|(path, text)| (inside(path), text.as_str())))
}

fn complaints(check: impl Fn(&Path, &str) -> Vec<String>) -> Vec<String> {
    sources().iter().flat_map(|(path, text)| check(path, text)).collect()
}

/// Lines of a room's file that use a room which is not above it, with that room.
fn rooms_not_above(file: &str, text: &str) -> Vec<(usize, String)> {
    let module = module_of(file);
    let (room, own) = (&module[0], floor(&module[0]));
    let named = resolved_in(&module, &without_comments(text)).into_iter();
    let others = named.filter(|named| ["crate", "luxmc"].contains(&named.path[0].as_str()));
    let others = others.filter_map(|Named { line, path }| Some((line, path.get(1)?.clone())));
    let is_room = |other: &str| FLOORS.iter().any(|(name, _)| *name == other);
    others.filter(|(_, other)| is_room(other) && other != room && floor(other) >= own).collect()
}

#[test]
fn rooms_use_only_the_floors_above_them() {
    let broken = complaints(|path, text| {
        let Some(room) = room_of(path) else { return Vec::new() };
        let wrong = rooms_not_above(&inside(path), text).into_iter();
        wrong.map(|(number, other)| format!("{}:{number}: {room} uses {other}", path.display())).collect()
    });
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    // `super` may lead out of a room, from a file and from a module within it.
    let text = "use super::super::solver::X;\nuse super::b::Y;\nmod tests {\n    use super::super::super::cli;\n}\nuse super::super::base;\n";
    let found = [(1, "solver".to_owned()), (4, "cli".to_owned())];
    assert_eq!(rooms_not_above("maps/a.rs", text), found);
}

/// The façade in `lib.rs` would bypass the floors. It is for code outside of the library and for tests.
#[test]
fn rooms_do_not_look_through_the_facade() {
    let broken = complaints(|path, text| {
        let Some(room) = room_of(path).filter(|_| !is_test(path)) else { return Vec::new() };
        let named = resolved_in(&module_of(&inside(path)), &product_code(text)).into_iter();
        let named = named.filter(|named| named.path[0] == "crate");
        let wrong =
            named.filter(|named| !named.path.get(1).is_some_and(|other| FLOORS.iter().any(|(name, _)| name == other)));
        wrong.map(|named| format!("{}:{}: {room} uses {}", path.display(), named.line, named.path.join("::"))).collect()
    });
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Names that a room's code may not contain in a path. Tests are exempt.
const MUST_NOT_KNOW: &[(&str, &[&str])] = &[
    ("base", &["rayon", "random", "time", "fs"]),
    ("scene", &["rayon", "random", "time"]),
    ("geometry", &["random", "time", "fs"]),
    ("sampling", &["rayon", "time", "fs"]),
    ("check", &["random", "time", "fs"]),
    ("transport", &["rayon", "time", "fs", "io"]),
    ("caches", &["rayon", "random", "time", "fs", "io"]),
    ("estimators", &["time", "fs", "io"]),
    ("maps", &["rayon", "random", "time", "fs", "io"]),
    ("control", &["rayon", "random", "time", "fs", "io"]),
    ("solver", &["fs"]),
    ("light_mesh", &["fs"]),
    ("radiosity", &["random", "time", "fs"]),
    ("year", &["time", "fs"]),
    ("analytic", &["rayon", "random", "time", "fs"]),
    ("methods", &["rayon", "random", "fs"]),
    ("output", &["random"]),
];

/// Files that may use one of these names, as the only ones of their room. Tables that are built before the packets start are built on
/// several threads, and a very long path reads the clock.
const KNOW_FOR_THEIR_ROOM: &[(&str, &str)] = &[
    ("transport/patience.rs", "time"),
    ("transport/selection_by_cell.rs", "rayon"),
    ("transport/selection_by_region.rs", "rayon"),
    ("transport/unlit.rs", "rayon"),
];

#[test]
fn rooms_do_not_know_what_is_not_theirs() {
    let (mut seen, mut known) = (BTreeSet::new(), BTreeSet::new());
    let broken: Vec<String> = sources()
        .iter()
        .flat_map(|(path, text)| {
            let room = room_of(path).unwrap_or_default();
            let forbidden =
                MUST_NOT_KNOW.iter().filter(|(name, _)| *name == room && !is_test(path)).flat_map(|(_, words)| *words);
            let named = named_in(&product_code(text));
            seen.extend(named.iter().flat_map(|named| named.path.clone()));
            let knows = |word: &&str| named.iter().find(|named| named.path.iter().any(|piece| piece == *word));
            let wrong = forbidden.filter_map(|word| Some((*word, knows(word)?.line)));
            let may_know = |word: &str| {
                KNOW_FOR_THEIR_ROOM.iter().find(|(file, known)| path.ends_with(file) && *known == word).copied()
            };
            let (excepted, wrong): (Vec<_>, Vec<_>) = wrong.partition(|(word, _)| may_know(word).is_some());
            known.extend(excepted.into_iter().filter_map(|(word, _)| may_know(word)));
            let wrong = wrong.into_iter();
            wrong.map(|(word, line)| format!("{}:{line}: {room} knows of {word}", path.display())).collect::<Vec<_>>()
        })
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert_eq!(
        known.len(),
        KNOW_FOR_THEIR_ROOM.len(),
        "KNOW_FOR_THEIR_ROOM tells of files that know nothing by now: {known:?}"
    );
    // A word that no file names forbids nothing.
    let words = MUST_NOT_KNOW.iter().flat_map(|(_, words)| *words);
    let idle: Vec<&&str> = words.filter(|word| !seen.contains(**word)).collect();
    assert!(idle.is_empty(), "{idle:?}");
}

#[test]
fn files_of_a_room_do_not_import_each_other_in_circles() {
    let sources = sources();
    let found = modules(&sources).in_circles();
    assert!(found.is_empty(), "files in circles of imports: {found:#?}");
}

/// Units as documents write them, and the endings of names for them.
const UNITS: &[(&str, &str)] = &[
    ("m", "m"),
    ("mm", "mm"),
    ("m²", "m2"),
    ("m³", "m3"),
    ("lx", "lx"),
    ("lx²", "lx2"),
    ("lm", "lm"),
    ("lm/m²", "m2"),
    ("cd", "cd"),
    ("cd/m²", "m2"),
    ("sr", "sr"),
    ("s", "s"),
    ("W", "w"),
    ("degrees", "deg"),
    ("rad", "rad"),
    ("radians", "rad"),
];

/// Whether one number or an array of one kind of number, not several kinds side by side.
fn is_one_quantity(kind: &str) -> bool {
    (kind.contains("f64") || kind.contains("Estimate")) && !kind.contains('(')
}

/// Name and type of the field of a struct, if the line declares one.
fn field_in(line: &str) -> Option<(&str, &str)> {
    let visibilities = ["pub ", "pub(crate) ", "pub(super) "];
    let bare = visibilities.into_iter().find_map(|visible| line.strip_prefix(visible)).unwrap_or(line);
    let (name, kind) = bare.strip_suffix(',')?.split_once(": ")?;
    name.chars().all(|c| c.is_alphanumeric() || c == '_').then_some((name, kind))
}

/// Name and result of a function, if its signature begins at the beginning of a text.
fn function_in(text: &str) -> Option<(&str, String)> {
    let end = text.find(" {\n").into_iter().chain(text.find(";\n")).min()?;
    let signature = text[..end].trim_start();
    let before_name = signature.split("fn ").next()?;
    let is_function = before_name.split_whitespace().all(|word| word.starts_with("pub") || word == "const");
    let (name, rest) = signature.split_once("fn ").filter(|_| is_function)?.1.split_once(['(', '<'])?;
    let result = rest.rsplit_once(") -> ")?.1.split(" where").next()?;
    Some((name, result.trim().to_owned()))
}

/// The unit that a text states, such as lx in "the illuminance in lx"; `None` if it states several. The unit of a position ("at a point in
/// m") does not count.
fn unit_told(text: &str) -> Option<&'static str> {
    let words: Vec<&str> = text.split([' ', ',', '.', ';', ':', '(', ')']).collect();
    let told = words.windows(3).filter(|words| words[1] == "in" && words[0] != "point");
    let told = told.filter_map(|words| UNITS.iter().find(|(unit, _)| *unit == words[2]));
    let endings: BTreeSet<&str> = told.map(|(_, ending)| *ending).collect();
    endings.first().copied().filter(|_| endings.len() == 1)
}

/// Fields of f64 and estimates, and functions that return one, whose document states a unit that the name lacks, or leaves the unit to a
/// quantity while the name has one. Of a function's document only the first sentence counts, as the rest may be about its arguments.
fn names_with_wrong_units(text: &str) -> Vec<String> {
    let (mut document, mut wrong, mut rest) = (String::new(), Vec::new(), text);
    while let Some((line, after)) = rest.split_once('\n') {
        let whole = std::mem::replace(&mut rest, after);
        let line = line.trim();
        if let Some(told) = line.strip_prefix("///") {
            document += told;
            document.push(' ');
            continue;
        }
        if line.starts_with("#[") {
            continue;
        }
        let field = field_in(line).filter(|(_, kind)| is_one_quantity(kind)).map(|(name, _)| (name, &*document));
        let function = function_in(whole).filter(|(_, kind)| is_one_quantity(kind));
        let function = function.map(|(name, _)| (name, document.split(". ").next().unwrap_or_default()));
        if let Some((name, told)) = field.or(function) {
            let has = |unit: &str| {
                name.split('_').any(|piece| piece == unit || piece == "per" || piece == "lumens" && unit == "lm")
            };
            // A weight can be an area or have no unit.
            let lacks = unit_told(told).is_some_and(|unit| !has(unit)) && !document.contains("or 1");
            let is_left_open = told.contains("in the unit of");
            if lacks || is_left_open && name.split('_').any(|piece| UNITS.iter().any(|(_, unit)| *unit == piece)) {
                wrong.push(name.to_owned());
            }
        }
        document.clear();
    }
    wrong
}

#[test]
fn fields_and_functions_have_their_units_in_their_names() {
    let found = complaints(|path, text| {
        // The fields of the command line's arguments are the names of its options, and their documents are its help.
        if room_of(path).is_none_or(|room| room == "cli") {
            return Vec::new();
        }
        let file = inside(path);
        names_with_wrong_units(text).into_iter().map(|name| format!("{file}: {name}")).collect()
    });
    assert!(found.is_empty(), "names and documents that disagree on the unit: {found:#?}");
    let fields = "    /// Its area in m².\n    area: f64,\n    /// Its area in m².\n    pub area_m2: f64,\n";
    assert_eq!(names_with_wrong_units(fields), ["area"]);
    let fields = "    /// In the map, in the unit of `quantity`.\n    pub value: f64,\n    /// The mean, in the unit of\n    /// `quantity`.\n    pub mean_lx: Estimate,\n";
    assert_eq!(names_with_wrong_units(fields), ["mean_lx"]);
    let functions = "/// Returns the flux in lm. Lengths in m.\npub fn flux(\n    a: f64,\n) -> f64 {\n/// Lengths in m.\nfn f() -> u8 {\n\
                     /// Its value at a point in m.\n#[inline]\nfn value(at: f64) -> Option<f64> {\n";
    assert_eq!(names_with_wrong_units(functions), ["flux"]);
}

/// Pieces of names for rays and for tests of what lies inside a surface.
const WORDS_OF_RAYS: [&str; 9] = ["ray", "rays", "met", "hit", "hits", "occluded", "trace", "winding", "encloses"];

/// Pieces of the names in a line: `first_met` gives `first` and `met`. Comments and strings do not count.
fn pieces_of_names(line: &str) -> Vec<&str> {
    if line.trim_start().starts_with("//") {
        return Vec::new();
    }
    // Text between quotes is every second piece.
    line.split('"').step_by(2).flat_map(|code| code.split(|c: char| !c.is_alphanumeric())).collect()
}

#[test]
fn the_scene_is_read_value_by_value_without_a_ray() {
    let broken = complaints(|path, text| {
        if room_of(path).is_none_or(|room| room != "scene") {
            return Vec::new();
        }
        let lines = text.lines().enumerate();
        let pieces =
            lines.flat_map(|(number, line)| pieces_of_names(line).into_iter().map(move |piece| (number + 1, piece)));
        let wrong = pieces.filter(|(_, piece)| WORDS_OF_RAYS.contains(piece));
        wrong.map(|(number, piece)| format!("{}:{number}: scene knows of {piece}", path.display())).collect()
    });
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(pieces_of_names("    first_met(scene, \"a ray\")").iter().any(|piece| WORDS_OF_RAYS.contains(piece)));
    assert!(!pieces_of_names("let array = \"a ray\";").contains(&"ray"));
}

#[test]
fn only_the_command_line_prints() {
    let broken = complaints(|path, text| {
        if room_of(path).is_none_or(|room| room == "cli") {
            return Vec::new();
        }
        let code = text.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//"));
        let prints = code.filter(|(_, line)| ["println!", "print!", "dbg!"].iter().any(|print| line.contains(print)));
        prints.map(|(number, _)| format!("{}:{}: prints", path.display(), number + 1)).collect()
    });
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn only_the_geometry_works_in_f32_or_knows_obvhs() {
    let broken = complaints(|path, text| {
        // Fonts, pixels, glTF and PDF use f32, and no result passes through them.
        let draws_pixels = ["output/font.rs", "output/raster.rs", "output/glb.rs", "output/pdf/ink.rs"]
            .iter()
            .any(|drawing| path.ends_with(drawing));
        if draws_pixels || room_of(path).is_some_and(|room| room == "geometry") {
            return Vec::new();
        }
        // Millions of cells and their lookup tables are stored in f32 and summed in f64.
        let keeps_cells =
            ["estimators/gathering.rs", "solver/gathering.rs"].iter().any(|keeping| path.ends_with(keeping));
        let in_cells = path.parent().is_some_and(|folder| folder.ends_with("solver/gathering"));
        if keeps_cells || in_cells || room_of(path).is_some_and(|room| room == "caches") {
            return Vec::new();
        }
        // The sampling weights of emitters and of anchors are stored in f32. The probability of a choice is computed from the same weights.
        let weighs = ["sampling/abreast.rs", "sampling/few_beacons.rs", "estimators/anchor_blocks.rs"];
        if weighs.iter().any(|weighing| path.ends_with(weighing)) {
            return Vec::new();
        }
        let code = text.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//"));
        let wrong =
            code.filter(|(_, line)| line.contains(": f32") || line.contains("as f32") || line.contains("obvhs"));
        wrong.map(|(number, line)| format!("{}:{}: {}", path.display(), number + 1, line.trim())).collect()
    });
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn files_can_be_read_in_one_sitting() {
    let long = complaints(|path, text| {
        let lines = text.lines().count();
        if lines > LONGEST_FILE { vec![format!("{}: {lines} lines", path.display())] } else { Vec::new() }
    });
    assert!(long.is_empty(), "{}", long.join("\n"));
}

/// Largest number of characters in a line of `docs/methods.md`.
const LONGEST_LINE: usize = 160;

#[test]
fn lines_of_the_methods_can_be_read_side_by_side() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/methods.md")).unwrap();
    let lines = text.lines().enumerate().map(|(number, line)| (number + 1, line.chars().count()));
    let long: Vec<(usize, usize)> = lines.filter(|(_, length)| *length > LONGEST_LINE).collect();
    assert!(long.is_empty(), "lines of docs/methods.md, and their lengths: {long:?}");
}

/// Numbers of the equations of `docs/methods.md`, in order. They stand at the end of a formula's line.
fn equations(methods: &str) -> Vec<u32> {
    let formulas = methods.lines().filter(|line| line.starts_with("    "));
    formulas.filter_map(|line| line.strip_suffix(')')?.rsplit_once("  (")?.1.parse().ok()).collect()
}

/// Equations that a file cites: `docs/methods.md (2), (3)` cites two.
fn equations_cited(text: &str) -> Vec<u32> {
    let comments =
        text.lines().map(|line| line.trim().trim_start_matches(['/', '!']).trim()).collect::<Vec<_>>().join(" ");
    let mut cited = Vec::new();
    for after in comments.split("docs/methods.md").skip(1) {
        let mut rest = after;
        while let Some((number, behind)) =
            rest.trim_start_matches([' ', ',']).strip_prefix('(').and_then(|rest| rest.split_once(')'))
        {
            let Ok(number) = number.parse() else { break };
            cited.push(number);
            rest = behind;
        }
    }
    cited
}

#[test]
fn equations_are_numbered_once_and_cited_where_they_are_computed() {
    let methods = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/methods.md")).unwrap();
    // The number of a formula has no letter, and every formula has a number.
    let formulas = methods.lines().filter(|line| line.starts_with("    ") && !line.trim().is_empty());
    let unnumbered: Vec<&str> = formulas.filter(|line| equations(line).is_empty()).collect();
    assert!(unnumbered.is_empty(), "formulas of docs/methods.md without a number: {unnumbered:#?}");
    let mut numbers = equations(&methods);
    numbers.sort_unstable();
    assert!(numbers.len() > 20, "the equations were not found");
    assert!(numbers.iter().copied().eq(1..=numbers.len() as u32), "not each once: {numbers:?}");
    let mut cited = BTreeSet::new();
    let unknown = complaints(|path, text| {
        let unknown = equations_cited(text).into_iter().filter(|number| !numbers.contains(number));
        unknown.map(|number| format!("{}: there is no equation ({number})", path.display())).collect()
    });
    sources().iter().for_each(|(_, text)| cited.extend(equations_cited(text)));
    assert!(unknown.is_empty(), "{}", unknown.join("\n"));
    let left_out: Vec<&u32> = numbers.iter().filter(|number| !cited.contains(number)).collect();
    assert!(left_out.is_empty(), "equations of docs/methods.md that no code cites: {left_out:?}");
    assert_eq!(equations("    a = b (c)        (7)\nas in (8)\n    d  (9)"), [7, 9]);
    assert_eq!(equations_cited("//! as docs/methods.md\n//! (7), (9) says (2); docs/methods.md, section (1)"), [7, 9]);
}

/// Paths between back quotes: all that contain a slash, and files of Rust and Markdown.
fn paths_named(text: &str) -> Vec<&str> {
    // Blocks of commands are fenced by three back quotes. Text between single back quotes is every second piece.
    let prose = text.split("```").step_by(2);
    let quoted = prose.flat_map(|prose| prose.split('`').skip(1).step_by(2));
    let is_path = |quoted: &&str| !quoted.contains(' ') && (quoted.contains('/') || quoted.ends_with(".md"));
    quoted.filter(is_path).collect()
}

#[test]
fn the_files_that_documents_of_the_house_name_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (document, least) in [("CONTRIBUTING.md", 40), ("docs/architecture.md", 30)] {
        let text = fs::read_to_string(root.join(document)).unwrap();
        let named = paths_named(&text);
        assert!(named.len() > least, "{named:?}");
        // The architecture document names files relative to `src`.
        let is_there = |path: &&str| root.join(path).exists() || root.join("src").join(path).exists();
        let missing: Vec<&str> = named.into_iter().filter(|path| !is_there(path)).collect();
        assert!(missing.is_empty(), "{document} names what is not there: {}", missing.join(", "));
    }
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        assert!(root.join(licence).exists(), "{licence}");
    }
}

/// Largest number of test binaries. Each is linked separately, which takes longer than most of them run.
const MOST_TEST_BINARIES: usize = 14;

#[test]
fn tests_stand_in_few_binaries() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let entries = fs::read_dir(&tests).unwrap().map(|entry| entry.unwrap().path());
    let own = |path: &PathBuf| path.extension().is_some_and(|end| end == "rs") || path.join("main.rs").exists();
    let binaries: Vec<PathBuf> = entries.filter(own).collect();
    assert!(binaries.len() > 4, "{binaries:?}");
    assert!(
        binaries.len() <= MOST_TEST_BINARIES,
        "tests/ holds {} binaries: a file of tests is a module of one of its folders: {binaries:?}",
        binaries.len()
    );
    for folder in binaries.iter().filter(|path| path.is_dir()) {
        let main = fs::read_to_string(folder.join("main.rs")).unwrap();
        for (path, _) in rust_files(folder) {
            let name = path.file_stem().unwrap().to_str().unwrap();
            assert!(name == "main" || main.contains(&format!("mod {name};")), "{} is in no binary", path.display());
        }
    }
}

/// `validation/tuning/table.py` writes `docs/tuned.md` anew.
#[test]
fn every_number_of_the_engine_is_listed_and_tuned_ones_stand_in_their_table() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let list = fs::read_to_string(root.join("validation/tuning/kinds.txt")).unwrap();
    let table = fs::read_to_string(root.join("docs/tuned.md")).unwrap();
    let mut listed = tuned::kinds_in(&list);
    assert!(listed.len() > 400, "{} numbers are listed", listed.len());
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        let file = path.strip_prefix(root.join("src")).unwrap().to_str().unwrap();
        if !tuned::ROOMS.iter().any(|room| file.starts_with(&format!("{room}/"))) || file.contains("tests") {
            continue;
        }
        for (name, value) in tuned::numbers_in(&product_code(&text)) {
            let Some(index) = listed.iter().position(|(of, known, _)| (*of, *known) == (file, name)) else {
                wrong.push(format!("{file}: validation/tuning/kinds.txt does not say what {name} is"));
                continue;
            };
            let (.., kind) = listed.swap_remove(index);
            let row = format!("| `{file}` `{name}` | {value} | {kind} |");
            if tuned::TUNED.contains(&kind) && !table.contains(&row) {
                wrong.push(format!("docs/tuned.md has no row that begins with {row}: run validation/tuning/table.py"));
            }
        }
    }
    wrong.extend(listed.iter().map(|(file, name, _)| format!("kinds.txt: {file} has no number {name}")));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_checks_see_what_they_forbid() {
    assert_eq!(
        paths_named("see `src/a.rs` and `B.md`, `luxmc x/y z`\n```sh\ncd `c/d`\n```\n`e/` `f`"),
        ["src/a.rs", "B.md", "e/"]
    );
    let code = "// use crate::none::Here;\nuse crate::{maps::judge, solver::{self, Settings as S}};\nlet x = crate::scene::inspect(a);\n";
    let named: Vec<(usize, String)> =
        named_in(&without_comments(code)).into_iter().map(|named| (named.line, named.path.join("::"))).collect();
    let expected =
        [(2, "crate::maps::judge"), (2, "crate::solver"), (2, "crate::solver::Settings"), (3, "crate::scene::inspect")];
    assert_eq!(named, expected.map(|(line, path)| (line, path.to_owned())));
    // A file and the files in its folder may use each other. Files side by side may not, not even through the room's `mod.rs`.
    let files = [
        ("room/mod.rs", "mod a;\nmod b;\npub use b::B;\nconst C: u32 = 0;"),
        ("room/a.rs", "use super::{B, C};"),
        ("room/b.rs", "use super::C;\npub struct B;\nfn f() { super::a::g() }"),
        ("room/b/c.rs", "use super::B;"),
        ("room/d.rs", "use super::a::g;\n#[cfg(test)]\nmod tests {\n    use crate::room::e::E;\n}"),
        ("room/e.rs", "use super::d::D;"),
    ];
    let circles = Modules::of(files.map(|(name, text)| (name.to_owned(), text))).in_circles();
    assert_eq!(circles.into_iter().collect::<Vec<_>>(), ["room/a", "room/b"]);
}
