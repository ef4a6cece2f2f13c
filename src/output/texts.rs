//! Words of pages, plots and tables in the reader's language.
//!
//! The sources contain the English words, in `say!("…")`. A file for each language in `texts/` has the translation of each. A page
//! is made [in a language](in_language): all words and numbers that are formatted meanwhile are in it. CSV and JSON files are not
//! translated. `tests/texts.rs` checks that a language has a translation for all words in use, and for no others.

use std::cell::Cell;
use std::collections::HashMap;
use std::fmt::{Display, Write as _};
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

/// The files of the languages other than English.
const FILES: [&str; 1] = [include_str!("texts/de.json")];

/// A language of pages, plots and tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Language {
    /// Index in [`FILES`]; `None`: English.
    file: Option<usize>,
}

/// A file of texts.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Texts {
    /// Code of the language by ISO 639-1.
    language: String,
    /// The decimal sign of a number.
    decimal_sign: String,
    /// Translations of English words. `{}` is the next value; `{0}`, `{1}` are values by their number.
    texts: HashMap<String, String>,
}

thread_local! {
    static LANGUAGE: Cell<Language> = const { Cell::new(Language::ENGLISH) };
}

fn all() -> &'static [Texts] {
    static ALL: OnceLock<Vec<Texts>> = OnceLock::new();
    ALL.get_or_init(|| FILES.iter().map(|file| serde_json::from_str(file).expect("a sound file of texts")).collect())
}

impl Language {
    /// The language of the sources.
    pub const ENGLISH: Language = Language { file: None };

    /// All languages, English first.
    pub fn all() -> Vec<Language> {
        std::iter::once(None).chain((0..FILES.len()).map(Some)).map(|file| Language { file }).collect()
    }

    /// Code by ISO 639-1: `en`, `de`.
    pub fn code(self) -> &'static str {
        self.texts().map_or("en", |texts| &texts.language)
    }

    /// The language with a code.
    ///
    /// # Errors
    ///
    /// A code that no language has; the text lists the existing codes.
    pub fn of_code(code: &str) -> Result<Language, String> {
        let languages = Language::all();
        let known = || languages.iter().map(|language| language.code()).collect::<Vec<_>>().join(", ");
        let named = languages.iter().find(|language| language.code() == code);
        named.copied().ok_or_else(|| format!("the languages are {}", known()))
    }

    fn texts(self) -> Option<&'static Texts> {
        self.file.map(|file| &all()[file])
    }
}

impl From<Language> for String {
    fn from(language: Language) -> String {
        language.code().to_owned()
    }
}

impl TryFrom<String> for Language {
    type Error = String;

    fn try_from(code: String) -> Result<Language, String> {
        Language::of_code(&code)
    }
}

/// Runs work in a language: until it ends, all words and numbers that this thread formats are in that language.
pub fn in_language<T>(language: Language, work: impl FnOnce() -> T) -> T {
    struct Before(Language);
    impl Drop for Before {
        fn drop(&mut self) {
            LANGUAGE.set(self.0);
        }
    }
    let _before = Before(LANGUAGE.replace(language));
    work()
}

/// The current language of this thread.
pub(crate) fn language() -> Language {
    LANGUAGE.get()
}

/// English words translated to the current language.
pub(crate) fn said(english: &'static str) -> &'static str {
    language().texts().and_then(|texts| texts.texts.get(english)).map_or(english, String::as_str)
}

/// The same, with values inserted.
pub(crate) fn said_with(english: &'static str, values: &[&dyn Display]) -> String {
    let mut text = String::new();
    let mut rest = said(english);
    let mut next = 0;
    while let Some((before, after)) = rest.split_once('{') {
        let Some((number, behind)) = after.split_once('}') else { break };
        text += before;
        let index = number.parse().unwrap_or(next);
        if let Some(value) = values.get(index) {
            write!(text, "{value}").ok();
        }
        next = index + 1;
        rest = behind;
    }
    text + rest
}

/// A number's text with the decimal sign of the current language.
pub(crate) fn decimal(number: impl Into<String>) -> String {
    let number = number.into();
    match language().texts() {
        Some(texts) if texts.decimal_sign != "." => number.replace('.', &texts.decimal_sign),
        _ => number,
    }
}

/// The separator between numbers in a row, which differs from the decimal sign.
pub(crate) fn separator() -> &'static str {
    if decimal(".") == "," { "; " } else { ", " }
}

/// Translates words to the current language; `{}` stand for the values that follow.
macro_rules! say {
    ($english:literal $(,)?) => { $crate::output::texts::said($english) };
    ($english:literal, $($value:expr),+ $(,)?) => { $crate::output::texts::said_with($english, &[$(&$value),+]) };
}

/// Marks words that are translated later with [`said`], if they are chosen at run time.
macro_rules! words {
    ($english:literal) => {
        $english
    };
}

pub(crate) use {say, words};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_language_is_spoken_until_its_work_is_done() {
        let german = Language::of_code("de").expect("there is German");
        assert_eq!(language(), Language::ENGLISH);
        assert_eq!(in_language(german, || (language(), decimal("1.5"))), (german, "1,5".to_owned()));
        let fails = std::panic::catch_unwind(|| in_language(german, || panic!("planted")));
        assert!(fails.is_err() && language() == Language::ENGLISH && decimal("1.5") == "1.5");
        assert!(Language::of_code("xx").is_err_and(|why| why.contains("en, de")));
    }

    #[test]
    fn values_stand_where_the_words_want_them() {
        assert_eq!(said_with("{} of {} stand", &[&2, &"x{}"]), "2 of x{} stand");
        assert_eq!(said_with("{1} before {0}", &[&"a", &"b"]), "b before a");
    }
}
