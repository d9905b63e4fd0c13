//! Contents of URIs: data URIs, and files in the folder of the document or below.
//!
//! The engine's reader of meshes has the same rules for buffers.

use super::{Defect, regular_file};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use shatter_proto::text::quoted;
use std::path::{Component, Path, PathBuf};

/// Content of a URI.
pub(super) struct Content {
    pub bytes: Vec<u8>,
    /// Media type that a data URI states, or the ending of the file's name, in lower case; may be empty.
    pub kind: String,
}

/// Reads the content of `uri` for the part `place` of a document in `folder`.
pub(super) fn load(folder: &Path, uri: &str, place: &str) -> Result<Content, Defect> {
    let refused = |reason: String| Defect::malformed(place, reason);
    if let Some(data) = data_uri(uri) {
        let encoded = data.split_once(',').and_then(|(head, data)| Some((head.strip_suffix(";base64")?, data)));
        let (head, data) = encoded.ok_or_else(|| refused("is a data URI without base64".to_owned()))?;
        let bytes = STANDARD.decode(data).map_err(|error| refused(format!("its data URI is damaged: {error}")))?;
        let kind = head.split(';').next().unwrap_or_default().to_lowercase();
        return Ok(Content { bytes, kind });
    }
    let file = beside(folder, uri).map_err(refused)?;
    let kind = file.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    Ok(Content { bytes: regular_file(&file)?, kind })
}

/// The part of a data URI after its scheme.
fn data_uri(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_once(':')?;
    scheme.eq_ignore_ascii_case("data").then_some(rest)
}

/// Path of the file in or below `folder` that `uri` names.
///
/// Rejects absolute names, other schemes, `..`, and links that lead out of the folder, because a model from elsewhere must not read the
/// user's other files.
fn beside(folder: &Path, uri: &str) -> Result<PathBuf, String> {
    let name = percent_decoded(uri).ok_or("its name is not UTF-8")?;
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    // On some systems a backslash separates folders, and a colon follows a drive letter.
    let leaves = name.is_empty() || name.contains([':', '\\', '\0']) || !Path::new(&name).components().all(plain);
    let file = folder.join(&name);
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let leads_out = |file: &Path| match (file.canonicalize(), folder.canonicalize()) {
        (Ok(file), Ok(folder)) => !file.starts_with(folder),
        // A missing file cannot be read, so it leads nowhere.
        _ => false,
    };
    if leaves || leads_out(&file) {
        return Err(format!("'{}' leads out of the folder of the glTF file: put the file beside it", quoted(&name)));
    }
    Ok(file)
}

/// Decodes percent escapes such as %20.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let digit = |k: usize| tail.get(k).and_then(|&digit| (digit as char).to_digit(16));
        match (first, digit(0), digit(1)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((high * 16 + low) as u8);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok()
}
