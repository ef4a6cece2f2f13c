//! Checks that no two types of the library have the same name.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::sources;

/// Name of the type that a line declares. Private types count, and types in functions and in modules of tests. Indented aliases belong to
/// traits and do not count.
fn type_declared(line: &str) -> Option<&str> {
    let code = line.trim_start();
    let bare = code.strip_prefix("pub").map_or(code, |rest| {
        rest.strip_prefix('(').and_then(|rest| Some(rest.split_once(')')?.1)).unwrap_or(rest).trim_start()
    });
    let kinds = ["struct ", "enum ", "trait ", "union "];
    let alias = bare.strip_prefix("type ").filter(|_| code.len() == line.len());
    let rest = kinds.into_iter().find_map(|kind| bare.strip_prefix(kind)).or(alias)?;
    rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next()
}

/// Types that have the name of another type, each with both files.
fn types_of_one_name(files: &[(PathBuf, String)]) -> Vec<String> {
    let mut places: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (path, text) in files {
        for (number, line) in text.lines().enumerate() {
            if let Some(name) = type_declared(line) {
                places.entry(name).or_default().push(format!("{}:{}", path.display(), number + 1));
            }
        }
    }
    assert!(files.len() < 20 || places.len() > 800, "{} types were found", places.len());
    let shared = places.into_iter().filter(|(_, places)| places.len() > 1);
    shared.map(|(name, places)| format!("{name}: {}", places.join(", "))).collect()
}

#[test]
fn every_type_of_the_library_has_a_name_of_its_own() {
    let shared = types_of_one_name(&sources());
    assert!(shared.is_empty(), "names of several types each: {shared:#?}");
    let lines = [
        "pub struct Spot {",
        "    pub(crate) enum LobeKind<'a> {",
        "pub(super) type Point = [f64; 2];",
        "struct Own;",
        "    type Item = usize;",
        "pub fn f()",
    ];
    assert_eq!(lines.map(type_declared), [Some("Spot"), Some("LobeKind"), Some("Point"), Some("Own"), None, None]);
    let file = |text: &str| (PathBuf::from("a.rs"), text.to_owned());
    assert_eq!(types_of_one_name(&[file("struct A;\nstruct B;"), file("\nenum A {}")]), ["A: a.rs:1, a.rs:2"]);
}
