//! Images, whose bytes are embedded into the new file.

use super::buffers::Buffers;
use super::uri::{Content, load};
use super::{Defect, SourceImage, whole};
use serde_json::Value;
use shatter_proto::text::quoted;

/// Format of an image.
struct Format {
    media_type: &'static str,
    /// Endings of files.
    endings: &'static [&'static str],
    /// Extension of a texture that names such an image; `None` for a format of glTF itself.
    extension: Option<&'static str>,
}

const FORMATS: [Format; 6] = [
    Format { media_type: "image/png", endings: &["png"], extension: None },
    Format { media_type: "image/jpeg", endings: &["jpg", "jpeg"], extension: None },
    Format { media_type: "image/webp", endings: &["webp"], extension: Some("EXT_texture_webp") },
    Format { media_type: "image/avif", endings: &["avif"], extension: Some("EXT_texture_avif") },
    Format { media_type: "image/ktx2", endings: &["ktx2"], extension: Some("KHR_texture_basisu") },
    Format { media_type: "image/vnd-ms.dds", endings: &["dds"], extension: Some("MSFT_texture_dds") },
];

/// Reads all images. `extensions` are those that the document uses.
pub(super) fn read(
    images: Vec<Value>,
    buffers: &mut Buffers<'_>,
    extensions: &[String],
) -> Result<Vec<SourceImage>, Defect> {
    let read = |(index, image)| one(image, &format!("image {index}"), buffers, extensions);
    images.into_iter().enumerate().map(read).collect()
}

fn one(image: Value, place: &str, buffers: &mut Buffers<'_>, extensions: &[String]) -> Result<SourceImage, Defect> {
    let refused = |reason: &str| Defect::malformed(place, reason);
    let content = match (image.get("uri"), whole(&image, "bufferView", place)?) {
        (Some(uri), None) => {
            let uri = uri.as_str().ok_or_else(|| refused("its uri is not a text"))?;
            load(buffers.folder(), uri, place)?
        }
        (None, Some(view)) => Content { bytes: buffers.view(view)?, kind: String::new() },
        (None, None) => return Err(refused("has neither a uri nor a bufferView")),
        (Some(_), Some(_)) => return Err(refused("has both a uri and a bufferView; keep one of the two")),
    };
    let stated = match image.get("mimeType") {
        None => content.kind,
        Some(stated) => stated.as_str().ok_or_else(|| refused("its mimeType is not a text"))?.to_lowercase(),
    };
    let named = |format: &&Format| format.media_type == stated || format.endings.contains(&stated.as_str());
    let is_usable = |format: &&Format| match format.extension {
        Some(needed) => extensions.iter().any(|used| used == needed),
        None => true,
    };
    let Some(format) = FORMATS.iter().find(named).filter(is_usable) else {
        let reason = match stated.as_str() {
            "" => "has no mimeType: state image/png or image/jpeg".to_owned(),
            other => format!("has the format '{}': convert it to PNG or JPEG", quoted(other)),
        };
        return Err(refused(&reason));
    };
    let Value::Object(mut members) = image else { return Err(refused("is not an object")) };
    members.remove("uri");
    members.insert("mimeType".to_owned(), format.media_type.into());
    Ok(SourceImage { members, bytes: content.bytes })
}
