//! The named numbers of the engine's files, and their kinds from `validation/tuning/kinds.txt`.

/// Rooms whose numbers are listed.
pub const ROOMS: &[&str] = &[
    "caches",
    "transport",
    "control",
    "estimators",
    "geometry",
    "light_mesh",
    "maps",
    "methods",
    "radiosity",
    "sampling",
    "solver",
    "year",
];

/// Kinds of numbers that were chosen by trials or by judgement.
pub const TUNED: &[&str] = &["speed", "forecast", "model"];

/// Names and values of the constants outside of functions and types whose value has a digit.
pub fn numbers_in(code: &str) -> Vec<(&str, &str)> {
    let number = |line| {
        let line: &str = line;
        let rest = line.strip_prefix("const ").or_else(|| {
            let public = line.strip_prefix("pub")?;
            let public = public.strip_prefix('(').and_then(|rest| Some(rest.split_once(')')?.1)).unwrap_or(public);
            public.strip_prefix(" const ")
        })?;
        let (name, rest) = rest.split_once(": ")?;
        let value = rest.split_once(" = ")?.1.strip_suffix(';')?;
        value.contains(|sign: char| sign.is_ascii_digit()).then_some((name, value))
    };
    code.lines().filter_map(number).collect()
}

/// File, name and kind of every listed number.
pub fn kinds_in(list: &str) -> Vec<(&str, &str, &str)> {
    let lines = list.lines().filter(|line| !line.starts_with('#'));
    let of_files = lines.filter_map(|line| line.split_once(": "));
    of_files
        .flat_map(|(file, groups)| groups.split("; ").map(move |group| (file, group)))
        .flat_map(|(file, group)| {
            let (kind, names) = group.split_once(' ').unwrap_or((group, ""));
            names.split(' ').map(move |name| (file, name, kind))
        })
        .collect()
}

#[test]
fn numbers_and_kinds_are_read() {
    let code = "const A: f64 = 0.5;\npub(super) const B: u32 = 1 << 3;\nconst C: f64 = A;\n    const D: u8 = 1;\npub const E: [f64; 2] = [1.0; 2];";
    assert_eq!(numbers_in(code), [("A", "0.5"), ("B", "1 << 3"), ("E", "[1.0; 2]")]);
    assert_eq!(kinds_in("# a: b C\nx.rs: speed A B; guard C").len(), 3);
}
