//! Files whose length grows with a map. They are written row by row, so that no copy of the map is in memory.

use std::io::Write;

use super::{OutputError, ResultFile};

/// A function that writes a file.
type Writing<'a> = Box<dyn Fn(&mut dyn Write) -> Result<(), OutputError> + Send + Sync + 'a>;

/// A result file whose content is made while it is written.
pub struct StreamedFile<'a> {
    /// Plain file name.
    pub name: String,
    writing: Writing<'a>,
}

impl<'a> StreamedFile<'a> {
    /// A file with this name, written by a function.
    pub fn new(
        name: impl Into<String>,
        writing: impl Fn(&mut dyn Write) -> Result<(), OutputError> + Send + Sync + 'a,
    ) -> StreamedFile<'a> {
        StreamedFile { name: name.into(), writing: Box::new(writing) }
    }

    /// A file whose content exists already.
    pub fn of(file: &'a ResultFile) -> StreamedFile<'a> {
        StreamedFile::new(file.name.as_str(), |writer| write_bytes(file, writer))
    }

    /// A file with this name, whose content is made in memory when it is written.
    pub fn later(name: impl Into<String>, make: impl Fn() -> ResultFile + Send + Sync + 'a) -> StreamedFile<'a> {
        StreamedFile::new(name, move |writer| write_bytes(&make(), writer))
    }

    /// Writes the file.
    ///
    /// # Errors
    ///
    /// An error of the writer, with the file's name, and a number that no table may hold.
    pub fn write_to(&self, writer: &mut dyn Write) -> Result<(), OutputError> {
        (self.writing)(writer)
    }

    /// Makes the file in memory.
    ///
    /// # Errors
    ///
    /// A number that no table may hold.
    pub fn made(self) -> Result<ResultFile, OutputError> {
        let mut bytes = Vec::new();
        self.write_to(&mut bytes)?;
        Ok(ResultFile { name: self.name, bytes })
    }
}

impl From<ResultFile> for StreamedFile<'_> {
    fn from(file: ResultFile) -> Self {
        StreamedFile::new(file.name.clone(), move |writer| write_bytes(&file, writer))
    }
}

fn write_bytes(file: &ResultFile, writer: &mut dyn Write) -> Result<(), OutputError> {
    writer.write_all(&file.bytes).map_err(|error| unwritable(&file.name, &error))
}

/// The error for a file that the disk does not accept. The caller that opened the file adds its directory.
pub(super) fn unwritable(name: &str, error: &std::io::Error) -> OutputError {
    OutputError::unwritable(name, "the file cannot be written", error)
}
