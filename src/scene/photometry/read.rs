//! Reads a photometric file of either format.

use std::path::Path;

use super::ies::tilt_line;
use super::text::{decode, lines_of, read_bytes};
use super::{PhotometricError, PhotometricFile, parse_eulumdat, parse_ies};

/// Reads an IES LM-63 or EULUMDAT file. IES is recognized by its extension `.ies` or its TILT line; all other files are EULUMDAT.
///
/// # Errors
/// A file that cannot be read or is larger than 64 MiB, and a malformed file, with line, token, expectation and remedy.
pub fn read_photometric_file(path: &Path) -> Result<PhotometricFile, PhotometricError> {
    let bytes = read_bytes(path)?;
    if let Some(kind) = other_kind(&bytes) {
        return Err(PhotometricError::Unreadable {
            path: path.to_path_buf(),
            reason: format!("this is {kind}, not a photometric file"),
            remedy: "give the luminaire's IES or LDT file; manufacturers offer it beside pictures and data sheets"
                .to_owned(),
        });
    }
    let folder = path.parent();
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let ies = match extension.as_deref() {
        Some("ies") => true,
        Some("ldt") => has_tilt_line(&bytes),
        _ => has_tilt_line(&bytes) || bytes.starts_with(b"IES"),
    };
    let read = if ies { parse_ies(&bytes, folder) } else { parse_eulumdat(&bytes) };
    read.map_err(|error| error.in_file(path))
}

/// Returns the kind of a file that begins like a file of another well-known kind.
fn other_kind(bytes: &[u8]) -> Option<&'static str> {
    const KINDS: [(&[u8], &str); 7] = [
        (b"\x89PNG", "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture"),
        (b"GIF8", "a GIF picture"),
        (b"%PDF", "a PDF document"),
        (b"PK\x03\x04", "a ZIP archive, which may hold it"),
        (b"<?xml", "an XML file"),
        (b"<!DOCTYPE", "a web page"),
    ];
    KINDS.iter().find(|(start, _)| bytes.starts_with(start)).map(|(_, kind)| *kind)
}

/// Whether a file has a TILT line. Only IES files have one.
fn has_tilt_line(bytes: &[u8]) -> bool {
    tilt_line(&lines_of(&decode(bytes))).is_some()
}
