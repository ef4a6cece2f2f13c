//! Radiance scene files: materials and surfaces as written, line by line.
//!
//! Commands (`!xform …`) are never run. They are skipped and listed.

use std::ops::Range;

use super::error::SceneError;
use super::reader::{Source, shortened};

/// A primitive: its modifier, type, name and arguments.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Primitive<'t> {
    pub modifier: &'t str,
    pub kind: &'t str,
    pub name: &'t str,
    pub strings: Vec<&'t str>,
    pub reals: Vec<f64>,
    /// Position of its type in the text.
    pub place: Range<usize>,
}

/// Content of a file.
#[derive(Debug, Default)]
pub(super) struct Primitives<'t> {
    pub primitives: Vec<Primitive<'t>>,
    /// Commands, which are not run.
    pub commands: Vec<&'t str>,
}

/// Reads all primitives of a file. An alias is a primitive of type `alias` with the old name as its string.
///
/// # Errors
///
/// Primitives that are cut short, and invalid counts or numbers.
pub(super) fn read<'t>(source: &Source<'t>) -> Result<Primitives<'t>, SceneError> {
    let mut found = Primitives::default();
    let mut words = RadianceWords { source, next: 0 };
    while let Some(first) = words.next(&mut found.commands) {
        let modifier = &source.text[first.clone()];
        let kind = words.need(&mut found.commands, &first, "the type of a primitive")?;
        let name = words.need(&mut found.commands, &kind, "the name of a primitive")?;
        let mut primitive = Primitive {
            modifier,
            kind: &source.text[kind.clone()],
            name: &source.text[name.clone()],
            strings: Vec::new(),
            reals: Vec::new(),
            place: kind.clone(),
        };
        if primitive.kind == "alias" {
            let old = words.need(&mut found.commands, &name, "the name that the alias stands for")?;
            primitive.strings.push(&source.text[old]);
            found.primitives.push(primitive);
            continue;
        }
        for _ in 0..words.count(&mut found.commands, &name)? {
            let word = words.need(&mut found.commands, &name, "a text of the primitive")?;
            primitive.strings.push(&source.text[word]);
        }
        // The format provides whole numbers, but no type uses them.
        for _ in 0..words.count(&mut found.commands, &name)? {
            words.need(&mut found.commands, &name, "a whole number of the primitive")?;
        }
        for _ in 0..words.count(&mut found.commands, &name)? {
            let word = words.need(&mut found.commands, &name, "a number of the primitive")?;
            let number = source.text[word.clone()].parse::<f64>().ok().filter(|number| number.is_finite());
            let refuse =
                || words.refuse(&word, "an argument that is not a finite number", "a number such as 0.5 or 5e-1");
            primitive.reals.push(number.ok_or_else(refuse)?);
        }
        found.primitives.push(primitive);
    }
    Ok(found)
}

/// The words of a text, without comments and commands.
struct RadianceWords<'s, 't> {
    source: &'s Source<'t>,
    next: usize,
}

impl<'t> RadianceWords<'_, 't> {
    fn next(&mut self, commands: &mut Vec<&'t str>) -> Option<Range<usize>> {
        loop {
            let rest = &self.source.text[self.next..];
            let start = self.next + rest.len() - rest.trim_start().len();
            let rest = &self.source.text[start..];
            let to_the_end_of_line = || rest.find('\n').unwrap_or(rest.len());
            match rest.chars().next()? {
                '#' => self.next = start + to_the_end_of_line(),
                '!' => {
                    let mut length = to_the_end_of_line();
                    while rest[..length].trim_end_matches('\r').ends_with('\\') && length < rest.len() {
                        length += 1 + rest[length + 1..].find('\n').unwrap_or(rest.len() - length - 1);
                    }
                    commands.push(rest[..length].trim_end());
                    self.next = start + length;
                }
                _ => {
                    let length = rest.find(char::is_whitespace).unwrap_or(rest.len());
                    self.next = start + length;
                    return Some(start..start + length);
                }
            }
        }
    }

    fn need(&mut self, commands: &mut Vec<&'t str>, of: &Range<usize>, what: &str) -> Result<Range<usize>, SceneError> {
        let next = self.next(commands);
        next.ok_or_else(|| self.refuse(of, &format!("the file ends before {what}"), "a whole primitive"))
    }

    fn count(&mut self, commands: &mut Vec<&'t str>, of: &Range<usize>) -> Result<usize, SceneError> {
        let word = self.need(commands, of, "a count of arguments")?;
        // Every argument takes at least two bytes, so no count can request more than the file has.
        let most = self.source.text.len() / 2;
        let count = self.source.text[word.clone()].parse::<usize>().ok().filter(|count| *count <= most);
        count.ok_or_else(|| {
            self.refuse(&word, "this is not a count of arguments", "a whole number, and as many arguments after it")
        })
    }

    fn refuse(&self, range: &Range<usize>, what: &str, expected: &str) -> SceneError {
        let got = format!("{:?}", shortened(&self.source.text[range.clone()]));
        let remedy = "write primitives as \"modifier type name\", then counts and arguments; or export the model again";
        self.source.refuse(range.clone(), "", what, got, expected, remedy)
    }
}
