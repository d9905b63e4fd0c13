//! The binary container of glTF 2.0 (Khronos, section 4.4): a header and two chunks, each padded to four bytes.

use super::ExportError;

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const JSON: &[u8; 4] = b"JSON";
const BINARY: &[u8; 4] = b"BIN\0";
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// Assembles a file from a JSON document and its buffer.
pub(super) fn frame(json: &[u8], binary: &[u8]) -> Result<Vec<u8>, ExportError> {
    let padded = |length: usize| length.next_multiple_of(4);
    let total = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + padded(json.len()) + padded(binary.len());
    let total_u32 = u32::try_from(total).map_err(|_| ExportError::TooLarge { bytes: total })?;
    let mut bytes = Vec::with_capacity(total);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&total_u32.to_le_bytes());
    chunk(&mut bytes, JSON, json, b' ');
    chunk(&mut bytes, BINARY, binary, 0);
    Ok(bytes)
}

fn chunk(bytes: &mut Vec<u8>, kind: &[u8; 4], content: &[u8], padding: u8) {
    let length = content.len().next_multiple_of(4);
    bytes.extend_from_slice(&(length as u32).to_le_bytes());
    bytes.extend_from_slice(kind);
    bytes.extend_from_slice(content);
    bytes.resize(bytes.len() + length - content.len(), padding);
}
