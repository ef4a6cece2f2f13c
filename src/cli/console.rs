//! The two output streams: results go to the standard output, everything else to standard error.

use std::io::{ErrorKind, Write};

use super::Failure;

/// Writes results to the standard output. A reader that has closed the pipe (`luxmc … | head`) is no error.
///
/// # Errors
///
/// Any other failure, such as a full disk behind a redirection.
pub fn result(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::StandardOutput(error)),
        _ => Ok(()),
    }
}

/// Writes a line to standard error. A failure is ignored, since nobody would see its message.
pub fn message(line: &str) {
    writeln!(std::io::stderr().lock(), "{line}").ok();
}
