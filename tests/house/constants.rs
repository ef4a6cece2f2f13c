//! Checks that no constant is copied from file to file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::product_code;
use crate::sources;

/// Names and values of all constants in code, also of those in functions. Switches of traits, whose values are `true` and `false`, do not
/// count.
fn constants_in(code: &str) -> Vec<(String, String)> {
    let declared = code.match_indices("const ").filter_map(|(at, word)| {
        let starts_word = code[..at].chars().next_back().is_none_or(char::is_whitespace);
        let rest = &code[at + word.len()..];
        let name = rest.split(|c: char| !(c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')).next()?;
        let rest = rest[name.len()..].strip_prefix(": ").filter(|_| starts_word)?;
        Some((name.to_owned(), value_of(rest)?))
    });
    declared.filter(|(_, value)| value != "true" && value != "false").collect()
}

/// The value in a declaration: what is between ` =` and the semicolon outside of brackets, without spaces and the underscores of numbers.
fn value_of(declaration: &str) -> Option<String> {
    let (mut depth, mut quoted) = (0, false);
    let end = declaration.char_indices().find_map(|(at, c)| {
        match c {
            '"' => quoted = !quoted,
            '[' | '(' | '{' if !quoted => depth += 1,
            ']' | ')' | '}' if !quoted => depth -= 1,
            _ => {}
        }
        (c == ';' && depth == 0 && !quoted).then_some(at)
    })?;
    let value = declaration[..end].split_once(" =")?.1;
    Some(value.chars().filter(|c| !c.is_whitespace() && *c != '_').collect())
}

/// Constants with the same name and value in several files.
fn copies(files: &[(PathBuf, String)]) -> Vec<String> {
    let mut places: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    let is_test = |path: &PathBuf| path.file_stem().is_some_and(|stem| stem.to_string_lossy().ends_with("tests"));
    for (path, text) in files.iter().filter(|(path, _)| !is_test(path)) {
        let mut found = constants_in(&product_code(text));
        found.sort();
        found.dedup();
        found.into_iter().for_each(|constant| places.entry(constant).or_default().push(path.display().to_string()));
    }
    assert!(files.len() < 20 || places.len() > 1500, "{} constants were found", places.len());
    let shared = places.into_iter().filter(|(_, places)| places.len() > 1);
    shared.map(|((name, value), places)| format!("{name} = {value}: {}", places.join(", "))).collect()
}

#[test]
fn no_constant_stands_in_two_files() {
    let found = copies(&sources());
    assert!(
        found.is_empty(),
        "constants of one name and value: one home if they mean the same, else two names: {found:#?}"
    );
    let code = "const A: f64 = 1_000.5;\n    pub(super) const B: [f64; 2] =\n        [0.5; 2];\nconst fn c() {}\nconst D: bool = true;\nconst E: &str = \"a; b\";";
    let told: Vec<String> = constants_in(code).into_iter().map(|(name, value)| format!("{name} {value}")).collect();
    assert_eq!(told, ["A 1000.5", "B [0.5;2]", "E \"a;b\""]);
    let file = |name: &str, text: &str| (PathBuf::from(name), text.to_owned());
    let files = [
        file("a.rs", "const A: u32 = 1_000;\nconst B: u32 = 1;"),
        file("b.rs", "pub const A: usize = 1000;\nconst B: u32 = 2;"),
    ];
    assert_eq!(copies(&files), ["A = 1000: a.rs, b.rs"]);
}
