//! The two streams: results to the standard output, everything else to standard error.

use std::io::{ErrorKind, Write};

use super::Failure;

/// Writes results to the standard output. A reader that has gone away (`luxmc … | head`) is no error.
///
/// # Errors
///
/// Any other refusal, such as a full disk behind a redirection.
pub fn result(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::StandardOutput(error)),
        _ => Ok(()),
    }
}

/// Writes a line to standard error; where nobody listens there is nobody to tell.
pub fn message(line: &str) {
    writeln!(std::io::stderr().lock(), "{line}").ok();
}
