//! The bytes that a glTF file refers to: its own, those of files beside it, and those written into the JSON.
//!
//! A model may come from strangers. The reader opens no file outside the model's folder and uses no network. It compares every offset and
//! count with the available bytes before it uses them.

use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::Document;
use gltf::accessor::Accessor;
use gltf::buffer::{Buffer, Source};
use percent_encoding::percent_decode_str;

use super::error::SceneError;
use super::mesh_builder::refusal;
use super::parse::{self, LARGEST_FILE_BYTES};
use super::plain_file::largest_bytes;
use super::reader::shortened;

/// All buffers of a file. Each is read at its first use.
pub(super) struct Buffers<'a> {
    path: &'a Path,
    /// The second chunk of a GLB file.
    binary: Option<&'a [u8]>,
    read: Vec<Option<Cow<'a, [u8]>>>,
    bytes: u64,
}

/// The elements of an accessor, all within their buffer.
pub(super) struct AccessorElements<'b> {
    bytes: &'b [u8],
    stride: usize,
    size: usize,
    pub count: usize,
}

impl<'b> AccessorElements<'b> {
    /// The bytes of an element.
    pub fn at(&self, index: usize) -> &'b [u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}

impl<'a> Buffers<'a> {
    /// Makes the buffers of a document. None is read yet.
    pub fn new(path: &'a Path, document: &Document, binary: Option<&'a [u8]>) -> Buffers<'a> {
        Buffers { path, binary, read: vec![None; document.buffers().len()], bytes: 0 }
    }

    /// Reads the buffer of an accessor, unless it is already read.
    pub fn load(&mut self, accessor: &Accessor) -> Result<(), SceneError> {
        let Some(view) = accessor.view() else { return Ok(()) };
        let buffer = view.buffer();
        if self.read[buffer.index()].is_none() {
            let mut bytes = self.bytes_of(&buffer)?;
            if bytes.len() < buffer.length() {
                return Err(refusal(
                    self.path,
                    format!("buffer {} is cut short", buffer.index()),
                    format!("{} bytes", bytes.len()),
                    &format!("{} bytes, as the file says", buffer.length()),
                ));
            }
            match &mut bytes {
                Cow::Borrowed(slice) => *slice = &slice[..buffer.length()],
                Cow::Owned(own) => own.truncate(buffer.length()),
            }
            self.read[buffer.index()] = Some(bytes);
        }
        Ok(())
    }

    /// Returns the elements of an accessor whose buffer is loaded.
    pub fn elements(&self, accessor: &Accessor) -> Result<AccessorElements<'_>, SceneError> {
        let refuse = |what: &str, got: String, expected: &str| {
            refusal(self.path, format!("accessor {} {what}", accessor.index()), got, expected)
        };
        if accessor.sparse().is_some() {
            return Err(refuse("is sparse", "sparse storage".to_owned(), "all elements in a buffer"));
        }
        let loaded = accessor.view().and_then(|view| Some((self.read[view.buffer().index()].as_ref()?, view)));
        let Some((buffer, view)) = loaded else {
            return Err(refuse("has no data", "no buffer view".to_owned(), "a buffer view"));
        };
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            let expected = format!("at least {size} bytes, the size of an element");
            return Err(refuse("has elements that overlap", format!("a stride of {stride} bytes"), &expected));
        }
        let of_view = view.offset().checked_add(view.length()).and_then(|end| buffer.get(view.offset()..end));
        let Some(bytes) = of_view else {
            let got = format!("{} bytes from byte {}", view.length(), view.offset());
            return Err(refuse(
                "extends beyond its buffer",
                got,
                &format!("a buffer view within {} bytes", buffer.len()),
            ));
        };
        let count = accessor.count();
        let needed = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|bytes| bytes.checked_add(size)),
        };
        let from = accessor.offset();
        let end = needed.and_then(|bytes| bytes.checked_add(from));
        let Some(bytes) = end.and_then(|end| bytes.get(from..end)) else {
            let got = format!("{count} elements of {size} bytes, {stride} apart, from byte {from}");
            return Err(refuse(
                "extends beyond its buffer view",
                got,
                &format!("elements within {} bytes", view.length()),
            ));
        };
        Ok(AccessorElements { bytes, stride, size, count })
    }

    fn bytes_of(&mut self, buffer: &Buffer) -> Result<Cow<'a, [u8]>, SceneError> {
        let number = buffer.index();
        let uri = match buffer.source() {
            Source::Bin => {
                return self.binary.map(Cow::Borrowed).ok_or_else(|| {
                    let what = format!("buffer {number} has no data");
                    refusal(
                        self.path,
                        what,
                        "neither a URI nor a binary chunk",
                        "a URI, or a GLB file with its BIN chunk",
                    )
                });
            }
            Source::Uri(uri) => uri,
        };
        let bytes = match uri.strip_prefix("data:") {
            Some(data) => {
                let (_, text) = data.split_once(";base64,").unwrap_or_default();
                let what = || format!("buffer {number} is not valid base64");
                BASE64_STANDARD.decode(text).map_err(|error| {
                    refusal(self.path, what(), error.to_string(), "data:application/octet-stream;base64,…")
                })?
            }
            None => parse::read_bytes(&self.file_of(number, uri)?, "the glTF buffer")?,
        };
        self.bytes += bytes.len() as u64;
        if self.bytes > largest_bytes(LARGEST_FILE_BYTES) {
            let expected = format!("at most {LARGEST_FILE_BYTES} bytes without --allow-large");
            let what = "the buffers are too large together";
            return Err(refusal(self.path, what, format!("{} bytes", self.bytes), &expected));
        }
        Ok(Cow::Owned(bytes))
    }

    /// Returns the path of a relative URI. The file must be in the folder of the glTF file or below it.
    fn file_of(&self, number: usize, uri: &str) -> Result<PathBuf, SceneError> {
        let refuse = |what: &str| {
            let expected = "the name of a file in the folder of the glTF file, or below it";
            let remedy = "put the buffer beside the glTF file, or export the model as GLB";
            let got = format!("{:?}", shortened(uri));
            SceneError::of_file(self.path, format!("buffer {number} {what}"), got, expected, remedy)
        };
        if uri.split('/').next().is_some_and(|first| first.contains(':')) {
            return Err(refuse("is not a file; nothing is fetched from other places"));
        }
        let Ok(name) = percent_decode_str(uri).decode_utf8() else {
            return Err(refuse("has a name that is not UTF-8"));
        };
        let name = Path::new(name.as_ref());
        let inside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
        if !name.components().all(inside) || uri.contains(['\\', '\0']) || name.as_os_str().is_empty() {
            return Err(refuse("lies outside the folder of the glTF file"));
        }
        Ok(self.path.parent().unwrap_or(Path::new("")).join(name))
    }
}
