//! Strict JSON: from the text of a scene file to a syntax tree with positions.

use std::path::Path;
use std::str::Utf8Error;

use jsonc_parser::ast::Value;
use jsonc_parser::errors::{ParseError, ParseErrorKind};
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};
use serde::de::IgnoredAny;

use super::error::SceneError;
use super::plain_file::read_plain_file;
use super::reader::{Source, shortened};

/// Largest file in bytes that is read without `--allow-large`: vertices and faces of some five million triangles.
pub(super) const LARGEST_FILE_BYTES: u64 = 512 << 20;

/// Reads a file as UTF-8 text.
///
/// # Errors
///
/// A file that is missing, cannot be read, is no plain file, is too large or is not UTF-8.
pub(super) fn read_text(path: &Path, kind: &str) -> Result<String, SceneError> {
    String::from_utf8(read_bytes(path, kind)?)
        .map_err(|error| not_utf8(error.as_bytes(), &error.utf8_error(), path, kind))
}

/// Reads a file as bytes.
///
/// # Errors
///
/// A file that is missing, cannot be read, is no plain file or is too large.
pub(super) fn read_bytes(path: &Path, kind: &str) -> Result<Vec<u8>, SceneError> {
    read_plain_file(path, LARGEST_FILE_BYTES).map_err(|error| unreadable(path, kind, &error))
}

/// Returns bytes as UTF-8 text.
///
/// # Errors
///
/// Bytes that are not UTF-8.
pub(super) fn text_of<'t>(bytes: &'t [u8], path: &Path, kind: &str) -> Result<&'t str, SceneError> {
    str::from_utf8(bytes).map_err(|error| not_utf8(bytes, &error, path, kind))
}

fn not_utf8(bytes: &[u8], error: &Utf8Error, path: &Path, kind: &str) -> SceneError {
    let valid = error.valid_up_to();
    Source { text: &String::from_utf8_lossy(bytes), path }.refuse(
        valid..valid + 1,
        "",
        format!("{kind} is not UTF-8 text"),
        format!("the byte 0x{:02X}", bytes[valid]),
        "UTF-8 text",
        "save the file as UTF-8",
    )
}

fn unreadable(path: &Path, kind: &str, error: &std::io::Error) -> SceneError {
    let remedy = match error.kind() {
        std::io::ErrorKind::NotFound => "check the name and the folder; names within a scene file are relative to it",
        std::io::ErrorKind::PermissionDenied => "allow reading the file",
        std::io::ErrorKind::FileTooLarge => "check that this is the intended file; --allow-large reads it",
        std::io::ErrorKind::OutOfMemory => "use a machine with more memory, or a smaller file",
        std::io::ErrorKind::ResourceBusy => "try again when no program writes to it",
        _ => "give the name of a plain file that can be read",
    };
    SceneError::of_file(path, format!("{kind} cannot be read"), error.to_string(), "a file that can be read", remedy)
}

/// Parses strict JSON: no comments, no trailing commas, nothing beyond RFC 8259.
pub(super) fn parse<'t>(source: &Source<'t>) -> Result<Value<'t>, SceneError> {
    let options = ParseOptions {
        allow_comments: false,
        allow_loose_object_property_names: false,
        allow_trailing_commas: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: false,
        allow_bare_decimal_point_numbers: false,
        allow_non_finite_numbers: false,
        allow_extended_string_escapes: false,
    };
    // The parser of the syntax tree accepts a few things that are not JSON, such as 012 or line breaks within texts. A second, stricter
    // parser finds them. If both report an error, the earlier one counts.
    let strict = serde_json::from_str::<IgnoredAny>(source.text).err().map(|error| refuse_strictly(source, &error));
    match (parse_to_ast(source.text, &CollectOptions::default(), &options), strict) {
        (Ok(_), Some((_, refusal))) => Err(refusal),
        (Err(error), Some((start, refusal))) if start + 1 < error.range().start => Err(refusal),
        (Err(error), _) => Err(refuse_syntax(source, &error)),
        (Ok(parsed), None) => parsed.value.ok_or_else(|| {
            source.refuse(0..1, "", "an empty scene file", "no JSON at all", "a JSON object", "see `luxmc schema`")
        }),
    }
}

fn refuse_syntax(source: &Source, error: &ParseError) -> SceneError {
    let range = error.range();
    let (expected, remedy) = advice(error.kind());
    let what = format!("malformed JSON: {}", lower_first(&error.kind().to_string()));

    // An object or list without an end is reported at its beginning. The message also says where the text ended.
    let is_unterminated =
        matches!(error.kind(), ParseErrorKind::UnterminatedObject | ParseErrorKind::UnterminatedArray);
    if is_unterminated {
        let last_line = source.text.lines().count().max(1);
        let got = format!("the end of the text in line {last_line}, before the closing bracket");
        return source.refuse(range.start..range.start + 1, "", what, got, expected, remedy);
    }
    let word = source.text.get(range.start..).and_then(|rest| rest.split_whitespace().next());
    let got = word.map_or("the end of the text".into(), |word| format!("{:?}", shortened(word)));
    source.refuse(range.start..range.end, "", what, got, expected, remedy)
}

/// Returns a refusal and its byte position.
fn refuse_strictly(source: &Source, error: &serde_json::Error) -> (usize, SceneError) {
    let text = source.text;
    let start = byte_of(text, error.line(), error.column());
    let message = error.to_string();
    let message = message.split(" at line ").next().unwrap_or_default();
    if message.starts_with("control character") {
        let control = text.bytes().skip(start).position(|byte| byte < 0x20).map_or(start, |offset| start + offset);
        let refusal = match text.as_bytes().get(control) {
            Some(b'\n' | b'\r') => source.refuse(
                control..control + 1,
                "",
                "malformed JSON: a text without its closing quote",
                "the end of the line",
                "a double quote at the end of the text",
                "close the text; line ends within it are written \\n",
            ),
            byte => source.refuse(
                control..control + 1,
                "",
                "malformed JSON: a control character within a text",
                format!("the byte 0x{:02X}", byte.copied().unwrap_or_default()),
                "printable characters",
                "write tabs as \\t, others as \\u00XX, or delete it",
            ),
        };
        return (control, refusal);
    }
    if text.trim().is_empty() {
        let what = "malformed JSON: the file is empty";
        let remedy = "name the scene file, or begin one: luxmc new office --out DIR";
        return (
            start,
            source.refuse(start..start + 1, "", what, "no text at all", "a JSON object: a scene file", remedy),
        );
    }
    let refusal = source.refuse(
        start..start + 1,
        "",
        format!("malformed JSON: {message}"),
        "text that is not JSON",
        "strict JSON (RFC 8259)",
        "correct the text at this place",
    );
    (start, refusal)
}

/// Returns what was expected and a remedy for a syntax error.
fn advice(kind: &ParseErrorKind) -> (&'static str, &'static str) {
    match kind {
        ParseErrorKind::CommentsNotAllowed => ("JSON without comments", "delete the comment"),
        ParseErrorKind::TrailingCommasNotAllowed => ("no comma after the last value", "delete the comma"),
        ParseErrorKind::ExpectedComma => ("a comma between two values", "insert a comma"),
        ParseErrorKind::UnterminatedObject => {
            ("} at the end of the object", "close the object; the file may be cut short")
        }
        ParseErrorKind::UnterminatedArray => ("] at the end of the list", "close the list; the file may be cut short"),
        ParseErrorKind::NonFiniteNumbersNotAllowed => {
            ("a finite number", "write a number; JSON has no NaN or Infinity")
        }
        ParseErrorKind::SingleQuotedStringsNotAllowed => ("text in double quotes", "use \" instead of '"),
        ParseErrorKind::ExpectedStringObjectProperty => ("a key in double quotes", "put the key in double quotes"),
        ParseErrorKind::ExpectedColonAfterObjectKey => ("a colon between key and value", "insert a colon"),
        ParseErrorKind::ExpectedObjectValue => ("a value after the colon", "add the value; the file may be cut short"),
        ParseErrorKind::MultipleRootJsonValues => {
            ("the end of the file", "delete what follows the scene's closing bracket")
        }
        ParseErrorKind::BareDecimalPointNumbersNotAllowed => ("a digit on both sides of the point", "write 0.5 or 5.0"),
        ParseErrorKind::HexadecimalNumbersNotAllowed => ("a decimal number", "write the number in decimal"),
        ParseErrorKind::UnaryPlusNumbersNotAllowed => ("a number without a plus sign", "delete the plus sign"),
        ParseErrorKind::NestingDepthExceeded => ("a scene file's few levels of brackets", "see `luxmc schema`"),
        ParseErrorKind::String(_) => {
            ("a text that ends on its line, with JSON's escapes", "check its quotes and backslashes")
        }
        _ => ("strict JSON (RFC 8259)", "correct the text at this place"),
    }
}

fn lower_first(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or(String::new(), |first| first.to_lowercase().chain(characters).collect())
}

/// Returns the byte position of a line and column. Both count from 1, the column in bytes.
fn byte_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    start + column.saturating_sub(1)
}
