//! Compression of what files contain in binary.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

/// Bytes compressed with zlib (RFC 1950), which browsers call "deflate".
pub fn zlib(bytes: &[u8], level: Compression) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), level);
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("memory takes every byte")
}
