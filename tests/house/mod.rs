//! Reads the library's files for the tests of its order: their imports, the names of types, the constants, the tuned numbers and the long
//! tests.

mod campaigns;
mod constants;
mod names;
pub mod tuned;

use std::collections::{BTreeMap, BTreeSet};

/// A path in code, such as `crate::scene::Scene`, in pieces, with its line number.
pub struct Named {
    pub line: usize,
    pub path: Vec<String>,
}

/// Code without comments and without the module of tests at its end, if it has one. Line numbers do not change.
pub fn product_code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    without_comments(text)
}

/// Code without its comments. Line numbers do not change.
pub fn without_comments(text: &str) -> String {
    let bare = text.lines().map(|line| if line.trim_start().starts_with("//") { "" } else { line });
    bare.collect::<Vec<_>>().join("\n")
}

/// All paths that code names: those of `use`, at any depth of nesting, and those that begin with `crate`, `luxmc` or `super` elsewhere.
pub fn named_in(code: &str) -> Vec<Named> {
    let mut named = Vec::new();
    let mut rest = code;
    let line_at = |rest: &str| code[..code.len() - rest.len()].matches('\n').count() + 1;
    while let Some((start, is_use)) = next_path(rest) {
        let line = line_at(&rest[start..]);
        if is_use {
            let tree = &rest[start..];
            let end = tree.find(';').unwrap_or(tree.len());
            named.extend(expanded(&tree[..end]).into_iter().map(|path| Named { line, path }));
            rest = &tree[end..];
        } else {
            let path = &rest[start..];
            let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(path.len());
            named.push(Named { line, path: pieces(&path[..end]) });
            rest = &path[end..];
        }
    }
    named
}

/// The path of the module that a file below `src` holds: `scene/mod.rs` gives `scene`, `scene/photometry/ies.rs` gives
/// `scene::photometry::ies`.
pub fn module_of(file: &str) -> Vec<String> {
    let name = file.strip_suffix(".rs").unwrap_or(file);
    let name = name.strip_suffix("/mod").unwrap_or(name);
    name.split('/').map(str::to_owned).collect()
}

/// All paths that a module's code names, with `super` resolved: what another module of the library holds begins with `crate`.
pub fn resolved_in(module: &[String], code: &str) -> Vec<Named> {
    let inner = inner_modules(code);
    let resolved = |Named { line, path }: Named| {
        let ups = path.iter().take_while(|piece| *piece == "super").count();
        if ups == 0 {
            return Some(Named { line, path });
        }
        let here: Vec<&String> = module.iter().chain(&inner[line - 1]).collect();
        let kept = here[..here.len().checked_sub(ups)?].iter().map(|piece| (*piece).clone());
        Some(Named { line, path: ["crate".to_owned()].into_iter().chain(kept).chain(path[ups..].to_vec()).collect() })
    };
    named_in(code).into_iter().filter_map(resolved).collect()
}

/// For each line of formatted code, the modules within the file that the line is in: `mod tests { … }` ends at the next `}` below its `mod`.
fn inner_modules(code: &str) -> Vec<Vec<String>> {
    let mut open: Vec<(usize, String)> = Vec::new();
    let inner = code.lines().map(|line| {
        let text = line.trim_start();
        let indent = line.len() - text.len();
        if text == "}" && open.last().is_some_and(|(begun, _)| *begun == indent) {
            open.pop();
        }
        let around = open.iter().map(|(_, name)| name.clone()).collect();
        let declared = text.strip_suffix(" {").and_then(|text| text.rsplit_once("mod "));
        if let Some((visibility, name)) = declared
            && (visibility.is_empty() || visibility.starts_with("pub"))
        {
            open.push((indent, name.to_owned()));
        }
        around
    });
    inner.collect()
}

/// Start of the next path, and whether it belongs to a `use`.
fn next_path(code: &str) -> Option<(usize, bool)> {
    let begins_word =
        |at: usize| !code[..at].chars().next_back().is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':');
    let first = |word: &str, after: usize| {
        code.match_indices(word).map(|(at, _)| at).find(|at| begins_word(*at)).map(|at| at + after)
    };
    let uses = first("use ", 4).map(|at| (at, true));
    let others = ["crate::", "luxmc::", "super::"].into_iter().filter_map(|word| first(word, 0)).map(|at| (at, false));
    others.chain(uses).min_by_key(|(at, is_use)| at - if *is_use { 4 } else { 0 })
}

fn pieces(path: &str) -> Vec<String> {
    let path = path.split(" as ").next().unwrap_or_default();
    path.split("::").map(str::trim).filter(|piece| !piece.is_empty()).map(str::to_owned).collect()
}

/// Paths in the tree of a `use`: `a::{b, c::{d, e}}` gives `a::b`, `a::c::d` and `a::c::e`.
fn expanded(tree: &str) -> Vec<Vec<String>> {
    let tree = tree.trim();
    let Some((head, list)) = tree.split_once('{') else { return vec![pieces(tree)] };
    let list = list.strip_suffix('}').unwrap_or(list);
    let (mut depth, mut from, mut branches) = (0, 0, Vec::new());
    for (at, c) in list.char_indices().chain([(list.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                branches.push(list[from..at].trim());
                from = at + 1;
            }
            _ => {}
        }
    }
    let branches = branches.into_iter().filter(|branch| !branch.is_empty());
    let below = branches.flat_map(expanded);
    below
        .map(|path| pieces(head).into_iter().chain(path.into_iter().filter(|piece| piece != "self")).collect())
        .collect()
}

/// Modules of the library with their code. A key is the module's path, such as `scene::photometry::ies`.
pub struct Modules(BTreeMap<Vec<String>, String>);

impl Modules {
    /// Takes the files' names below `src`, such as `scene/mod.rs`, and their texts.
    pub fn of<'t>(files: impl IntoIterator<Item = (String, &'t str)>) -> Modules {
        let module = |(name, text): (String, &str)| (module_of(&name), product_code(text));
        let is_test = |path: &Vec<String>| path.last().is_some_and(|last| last.ends_with("tests"));
        Modules(files.into_iter().map(module).filter(|(path, _)| !is_test(path)).collect())
    }

    /// The module in which a path of the library ends. Re-exports (`pub use`) are followed to the modules below.
    fn home_of(&self, path: &[String]) -> Option<Vec<String>> {
        let length = (1..=path.len()).rev().find(|length| self.0.contains_key(&path[..*length]))?;
        let module = path[..length].to_vec();
        let Some(name) = path.get(length) else { return Some(module) };
        let shown = named_in(&self.0[&module]).into_iter().map(|named| named.path);
        for path in shown.filter(|path| path.last().is_some_and(|last| last == name || last == "*")) {
            let path: Vec<String> = path.into_iter().filter(|piece| piece != "self").collect();
            let below: Vec<String> = module.iter().cloned().chain([path[0].clone()]).collect();
            let declares = |kind: &str| {
                let declared = format!("{kind} {name}");
                let ends = |at: usize| {
                    !self.0[&below][at + declared.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
                };
                self.0[&below].match_indices(&declared).any(|(at, _)| ends(at))
            };
            let is_there = self.0.contains_key(&below)
                && (path.len() > 1 && path[1] == *name
                    || ["struct", "enum", "trait", "type", "const", "fn"].into_iter().any(declares));
            if is_there {
                return Some(below);
            }
        }
        Some(module)
    }

    /// Modules that one module imports from.
    fn imports_of(&self, module: &[String]) -> BTreeSet<Vec<String>> {
        let named = resolved_in(module, &self.0[module]).into_iter().filter(|named| named.path[0] == "crate");
        named.filter_map(|named| self.home_of(&named.path[1..])).collect()
    }

    /// Modules side by side that import each other in a circle. A file and the files in its folder count as one.
    pub fn in_circles(&self) -> BTreeSet<String> {
        let is_above = |one: &[String], other: &[String]| other.starts_with(one);
        let imports: BTreeMap<&Vec<String>, Vec<Vec<String>>> = self
            .0
            .keys()
            .map(|module| {
                let all = self.imports_of(module).into_iter();
                (module, all.filter(|other| !is_above(module, other) && !is_above(other, module)).collect())
            })
            .collect();
        let comes_back = |module: &Vec<String>| {
            let (mut seen, mut open) = (BTreeSet::new(), vec![module]);
            while let Some(next) = open.pop() {
                for other in &imports[next] {
                    if other == module {
                        return true;
                    }
                    if seen.insert(other) {
                        open.push(other);
                    }
                }
            }
            false
        };
        imports.keys().filter(|module| comes_back(module)).map(|module| module.join("/")).collect()
    }
}
