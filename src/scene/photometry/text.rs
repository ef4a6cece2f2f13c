//! Converts bytes to lines and numbers, for files of any system.

use std::io::ErrorKind;
use std::path::Path;

use super::super::plain_file::read_plain_file;
use super::PhotometricError;

/// Largest file in bytes that is read without `--allow-large`. A quarter-degree table of the whole sphere takes some 10 MB of text.
const LARGEST_FILE_BYTES: u64 = 64 << 20;

/// Reads the bytes of a regular file within the size limit.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>, PhotometricError> {
    let unreadable = |reason: String, remedy: &str| PhotometricError::Unreadable {
        path: path.to_path_buf(),
        reason,
        remedy: remedy.to_string(),
    };
    let check_name = "check the name; it is relative to the file that names it";
    read_plain_file(path, LARGEST_FILE_BYTES).map_err(|error| {
        let remedy = match error.kind() {
            ErrorKind::NotFound | ErrorKind::IsADirectory | ErrorKind::Other => check_name,
            ErrorKind::FileTooLarge => {
                "a photometric file has a few kilobytes: check that this is one; --allow-large reads it"
            }
            _ => "check that it may be read",
        };
        unreadable(error.to_string(), remedy)
    })
}

/// Decodes the text of a file: UTF-8, UTF-16 with a byte order mark, or otherwise Latin-1. The mark is removed.
pub(super) fn decode(bytes: &[u8]) -> String {
    let utf16 = |bytes: &[u8], word: fn([u8; 2]) -> u16| {
        let words: Vec<u16> = bytes.chunks_exact(2).map(|pair| word([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&words)
    };
    match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => decode(rest),
        [0xFF, 0xFE, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => text.to_string(),
            Err(_) => bytes.iter().map(|&byte| byte as char).collect(),
        },
    }
}

/// Splits a text into lines. They end with CR LF, LF or CR alone. An end-of-file mark of DOS (Ctrl-Z) ends the text.
pub(super) fn lines_of(text: &str) -> Vec<String> {
    let text = text.split('\u{1A}').next().unwrap_or_default();
    let even = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace('\r', "\n");
    let mut lines: Vec<String> = even.split('\n').map(str::to_string).collect();
    if lines.last().is_some_and(String::is_empty) {
        lines.pop();
    }
    lines
}

/// Meaning of a comma among numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Comma {
    /// It separates two numbers.
    Delimiter,
    /// It is the decimal point.
    Decimal,
}

/// Parses a finite number. Decimal commas are allowed only with [`Comma::Decimal`].
pub(super) fn number(token: &str, comma: Comma) -> Option<f64> {
    let is_numeric = token.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b',' | b'e' | b'E'));
    let with_point = if comma == Comma::Decimal { token.replacen(',', ".", 1) } else { token.to_string() };
    with_point.parse().ok().filter(|value: &f64| is_numeric && value.is_finite())
}

/// A sequence of numbers; line breaks have no meaning.
pub(super) struct Tokens<'a> {
    items: Vec<(usize, &'a str)>,
    comma: Comma,
    next: usize,
    last_line: usize,
}

impl<'a> Tokens<'a> {
    /// Makes the tokens of lines. The first line has the number `first_line` in its file.
    pub fn new(lines: &'a [String], first_line: usize, comma: Comma) -> Self {
        let parts = move |c: char| c.is_whitespace() || c == '\0' || (comma == Comma::Delimiter && c == ',');
        let items = lines.iter().enumerate().flat_map(|(index, line)| {
            line.split(parts).filter(|token| !token.is_empty()).map(move |token| (first_line + index, token))
        });
        Tokens { items: items.collect(), comma, next: 0, last_line: first_line + lines.len().saturating_sub(1) }
    }

    /// Number of tokens not yet read.
    pub fn left(&self) -> usize {
        self.items.len() - self.next
    }

    /// Line number of the next token, or of the last line.
    pub fn line(&self) -> usize {
        self.items.get(self.next).map_or(self.last_line, |item| item.0)
    }

    /// Reads the next number.
    pub fn number(&mut self, what: &str) -> Result<f64, PhotometricError> {
        let Some(&(line, token)) = self.items.get(self.next) else {
            return Err(PhotometricError::ended(self.last_line, what));
        };
        let value = number(token, self.comma).ok_or_else(|| {
            let remedy = "write a plain decimal number there, such as 12.5, and check that none is missing before it";
            PhotometricError::malformed(line, token, what, remedy)
        })?;
        self.next += 1;
        Ok(value)
    }

    /// Reads the next number. It is refused unless `holds` returns true.
    pub fn checked(&mut self, what: &str, remedy: &str, holds: impl Fn(f64) -> bool) -> Result<f64, PhotometricError> {
        let value = self.number(what)?;
        if holds(value) { Ok(value) } else { Err(self.refuse_last(what, remedy)) }
    }

    /// Reads the next number as a count of values that the file still contains.
    ///
    /// A count beyond the rest of the file is refused here, before memory of that size is allocated.
    pub fn count(&mut self, what: &str, least: usize) -> Result<usize, PhotometricError> {
        let value = self.number(what)?;
        if !(value.fract() == 0.0 && value >= least as f64) {
            let expected = format!("{what}: a whole number of at least {least}");
            return Err(self.refuse_last(&expected, "count the values in the file and write their number there"));
        }
        if value > self.left() as f64 {
            let expected = format!("{what}: no more than the {} values left in the file", self.left());
            return Err(self.refuse_last(&expected, "the file is cut off or the count is wrong; correct the count"));
        }
        Ok(value as usize)
    }

    /// Reads the next `count` numbers. Each must satisfy `holds`.
    pub fn list(
        &mut self,
        count: usize,
        what: &str,
        remedy: &str,
        holds: impl Fn(f64) -> bool,
    ) -> Result<Vec<f64>, PhotometricError> {
        if count > self.left() {
            let (have, line) = (self.left(), self.last_line);
            return Err(PhotometricError::ended(
                line,
                format!("{count} values, each {what}, but only {have} are there"),
            ));
        }
        (0..count).map(|_| self.checked(what, remedy, &holds)).collect()
    }

    /// Reads the next `count` numbers, strictly increasing within a range.
    pub fn angles(
        &mut self,
        count: usize,
        what: &str,
        range_deg: std::ops::RangeInclusive<f64>,
    ) -> Result<Vec<f64>, PhotometricError> {
        let expected =
            format!("{what} from {} to {} degrees, each above the one before", range_deg.start(), range_deg.end());
        let remedy = "check the counts of angles, and that no angle is missing, doubled or out of order";
        let mut angles = Vec::with_capacity(count.min(self.left()));
        for _ in 0..count {
            let before = angles.last().copied().unwrap_or(f64::NEG_INFINITY);
            angles.push(self.checked(&expected, remedy, |angle| angle > before && range_deg.contains(&angle))?);
        }
        Ok(angles)
    }

    /// Makes an error at the token that was read last.
    pub fn refuse_last(&self, expected: &str, remedy: &str) -> PhotometricError {
        let (line, token) = self.items[self.next - 1];
        PhotometricError::malformed(line, token, expected, remedy)
    }
}
