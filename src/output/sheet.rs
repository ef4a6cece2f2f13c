//! A table under construction, checked cell by cell.

use std::fmt::Write as _;
use std::io::Write;

use super::streamed::unwritable;
use super::{OutputError, ResultFile};

/// A cell of a table.
pub(super) enum SheetCell<'a> {
    /// Text, which must not be empty.
    Text(&'a str),
    /// A number in the shortest decimals that read back to the same f64.
    Number(f64),
    /// A whole number.
    Count(u64),
    /// `true` or `false`.
    Flag(bool),
}

/// A CSV table (RFC 4180 quoting, lines end with a line feed), in memory or written to a file.
pub(super) struct Sheet<W: Write = Vec<u8>> {
    name: &'static str,
    columns: Vec<&'static str>,
    writer: csv::Writer<W>,
    rows: usize,
    /// Buffer for the number that is being written.
    text: String,
}

/// Writing to memory cannot fail.
const IN_MEMORY: &str = "a table in memory takes every row";

impl Sheet {
    /// A table in memory, with its header.
    pub fn new(name: &'static str, columns: &[&'static str]) -> Sheet {
        Sheet::to(name, columns, Vec::new()).expect(IN_MEMORY)
    }

    /// A part of a table in memory, without its header, after this many rows.
    pub fn behind(name: &'static str, columns: &[&'static str], rows: usize) -> Sheet {
        Sheet::over(name, columns, Vec::new(), rows)
    }

    /// The table as a file.
    pub fn finish(self) -> ResultFile {
        ResultFile { name: self.name.to_owned(), bytes: self.writer.into_inner().expect(IN_MEMORY) }
    }
}

impl<W: Write> Sheet<W> {
    /// A table with its header, written to a writer.
    ///
    /// # Errors
    ///
    /// An error of the writer.
    pub fn to(name: &'static str, columns: &[&'static str], writer: W) -> Result<Sheet<W>, OutputError> {
        let mut sheet = Sheet::over(name, columns, writer, 0);
        sheet.taken(|writer| writer.write_record(columns))?;
        Ok(sheet)
    }

    /// A table written to a writer without a header, after this many rows.
    fn over(name: &'static str, columns: &[&'static str], writer: W, rows: usize) -> Sheet<W> {
        let writer = csv::Writer::from_writer(writer);
        Sheet { name, columns: columns.to_vec(), writer, rows, text: String::new() }
    }

    fn taken(&mut self, write: impl FnOnce(&mut csv::Writer<W>) -> csv::Result<()>) -> Result<(), OutputError> {
        write(&mut self.writer).map_err(|error| unwritable(self.name, &error.into()))
    }

    /// Adds a row with a cell for every column.
    ///
    /// # Errors
    ///
    /// A number that is not finite, and an error of the writer.
    pub fn row(&mut self, fields: &[SheetCell]) -> Result<(), OutputError> {
        debug_assert_eq!(fields.len(), self.columns.len());
        self.rows += 1;
        for (place, field) in fields.iter().enumerate() {
            match field {
                SheetCell::Text(text) => self.taken(|writer| writer.write_field(text))?,
                SheetCell::Count(count) => self.taken(|writer| writer.write_field(count.to_string()))?,
                SheetCell::Flag(flag) => self.taken(|writer| writer.write_field(flag.to_string()))?,
                SheetCell::Number(number) if number.is_finite() => {
                    let mut text = std::mem::take(&mut self.text);
                    self.taken(|writer| writer.write_field(shortest_in(&mut text, *number)))?;
                    self.text = text;
                }
                SheetCell::Number(number) => {
                    let (file, row, column) = (self.name, self.rows, self.columns[place]);
                    return Err(OutputError::NotFinite { file, row, column, got: *number });
                }
            }
        }
        self.taken(|writer| writer.write_record(None::<&[u8]>))
    }

    /// Ends a table that is written to a writer.
    ///
    /// # Errors
    ///
    /// An error of the writer.
    pub fn end(mut self) -> Result<(), OutputError> {
        self.writer.flush().map_err(|error| unwritable(self.name, &error))
    }
}

/// The shortest decimals that read back to the same f64; −0 is written as 0.
pub fn shortest(number: f64) -> String {
    shortest_in(&mut String::new(), number).to_owned()
}

/// The same, in a buffer that is reused.
fn shortest_in(text: &mut String, number: f64) -> &str {
    text.clear();
    write!(text, "{:?}", number + 0.0).expect("memory takes every letter");
    text.strip_suffix(".0").unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_read_back_to_the_same_bits() {
        let numbers = [0.1, 1.0 / 3.0, 1e300, 5e-324, 123_456_789.123_456_79, -2.5e-7, 0.0];
        for number in numbers {
            let back: f64 = shortest(number).parse().expect("a number was written");
            assert_eq!(back.to_bits(), number.to_bits());
        }
        assert_eq!([-0.0, 1.0, 0.5, 1e-7, 4096.0].map(shortest), ["0", "1", "0.5", "1e-7", "4096"]);
    }

    #[test]
    fn a_number_that_is_not_finite_is_refused_with_its_place() {
        let mut sheet = Sheet::new("t.csv", &["name", "x"]);
        assert!(sheet.row(&[SheetCell::Text("a, \"b\""), SheetCell::Number(1.0)]).is_ok());
        let refused = sheet.row(&[SheetCell::Text("c"), SheetCell::Number(f64::NAN)]);
        assert!(matches!(refused, Err(OutputError::NotFinite { row: 2, column: "x", .. })));
    }

    /// Parts of a table are joined, and an error reports its row in the whole table.
    #[test]
    fn rows_behind_others_go_on_where_these_end() {
        let mut behind = Sheet::behind("t.csv", &["name", "x"], 4096);
        behind.row(&[SheetCell::Text("b"), SheetCell::Number(-0.0)]).expect("finite");
        let refused = behind.row(&[SheetCell::Text("c"), SheetCell::Number(f64::INFINITY)]);
        assert!(matches!(refused, Err(OutputError::NotFinite { row: 4098, column: "x", .. })));
        let mut behind = Sheet::behind("t.csv", &["name", "x"], 1);
        behind.row(&[SheetCell::Text("b"), SheetCell::Number(2.0)]).expect("finite");
        assert_eq!(behind.finish().bytes, b"b,2\n");
    }

    #[test]
    fn texts_with_commas_and_quotes_are_quoted() {
        let mut sheet = Sheet::new("t.csv", &["name", "x", "n", "f"]);
        let row = [SheetCell::Text("a, \"b\""), SheetCell::Number(1.5), SheetCell::Count(7), SheetCell::Flag(true)];
        sheet.row(&row).expect("all finite");
        assert_eq!(sheet.finish().bytes, b"name,x,n,f\n\"a, \"\"b\"\"\",1.5,7,true\n");
    }
}
