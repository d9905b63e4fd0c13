//! Bytes of a glTF file: the parts of the binary container, and the views of buffers.

use super::uri::load;
use super::{Defect, whole};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// Splits a file into its JSON and its binary chunk. A file that is not in the binary container is all JSON.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Defect> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let version = word(bytes, 4);
    if version != Some(2) {
        let version = version.map_or_else(|| "missing".to_owned(), |version| version.to_string());
        return Err(Defect::malformed("byte 4", format!("the version of the container is {version}, not 2")));
    }
    let json = chunk(bytes, HEADER_BYTES, b"JSON")?;
    let json = json.ok_or_else(|| Defect::malformed("byte 12", "the first chunk is not JSON"))?;
    let next = HEADER_BYTES + CHUNK_HEADER_BYTES + json.len();
    let binary = if next < bytes.len() { chunk(bytes, next, b"BIN\0")? } else { None };
    Ok((json, binary))
}

/// Content of the chunk at byte `at`; `None` for one of another kind.
fn chunk<'a>(bytes: &'a [u8], at: usize, kind: &[u8; 4]) -> Result<Option<&'a [u8]>, Defect> {
    let cut = || Defect::malformed(format!("byte {at}"), "the file ends within a chunk: copy or export it again");
    let length = word(bytes, at).ok_or_else(cut)?;
    let content = at + CHUNK_HEADER_BYTES;
    let found = bytes.get(at + 4..content).ok_or_else(cut)?;
    let content = bytes.get(content..).and_then(|rest| rest.get(..length)).ok_or_else(cut)?;
    Ok((found == kind).then_some(content))
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let word = bytes.get(at..)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*word)).ok()
}

/// The buffers of a document, which are read when a view of them is needed.
pub(super) struct Buffers<'a> {
    root: &'a Value,
    binary: Option<&'a [u8]>,
    folder: &'a Path,
    loaded: BTreeMap<usize, Vec<u8>>,
}

impl<'a> Buffers<'a> {
    /// Buffers of the document `root` in `folder` with this binary chunk.
    pub(super) fn new(root: &'a Value, binary: Option<&'a [u8]>, folder: &'a Path) -> Self {
        Self { root, binary, folder, loaded: BTreeMap::new() }
    }

    /// Folder of the document.
    pub(super) fn folder(&self) -> &'a Path {
        self.folder
    }

    /// Bytes of a view.
    pub(super) fn view(&mut self, index: usize) -> Result<Vec<u8>, Defect> {
        let place = format!("bufferView {index}");
        let root = self.root;
        let view = root["bufferViews"].get(index).ok_or_else(|| Defect::malformed(&place, "does not exist"))?;
        let required = |key| {
            let number = whole(view, key, &place)?;
            number.ok_or_else(|| Defect::malformed(&place, format!("has no {key}")))
        };
        let (buffer, length) = (required("buffer")?, required("byteLength")?);
        let offset = whole(view, "byteOffset", &place)?.unwrap_or(0);
        let bytes = self.buffer(buffer)?;
        let own = bytes.get(offset..).and_then(|rest| rest.get(..length));
        own.map(<[u8]>::to_vec).ok_or_else(|| {
            let held = bytes.len();
            let reason = format!("its bytes {offset} to {offset} + {length} exceed buffer {buffer}, which has {held}");
            Defect::malformed(&place, reason)
        })
    }

    fn buffer(&mut self, index: usize) -> Result<&[u8], Defect> {
        let place = format!("buffer {index}");
        let root = self.root;
        let buffer = root["buffers"].get(index).ok_or_else(|| Defect::malformed(&place, "does not exist"))?;
        let Some(uri) = buffer.get("uri") else {
            let binary = self.binary.filter(|_| index == 0);
            return binary.ok_or_else(|| Defect::malformed(&place, "has neither a uri nor a binary chunk"));
        };
        if !self.loaded.contains_key(&index) {
            let uri = uri.as_str().ok_or_else(|| Defect::malformed(&place, "its uri is not a text"))?;
            self.loaded.insert(index, load(self.folder, uri, &place)?.bytes);
        }
        Ok(self.loaded.get(&index).map_or(&[], Vec::as_slice))
    }
}
