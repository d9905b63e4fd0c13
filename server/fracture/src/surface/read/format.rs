//! Detection of the format of a mesh file from its contents, for files with the extension of another format.

use super::common::malformed;
use super::{medit, vtk};
use crate::surface::SurfaceError;

/// Number of bytes that are examined.
const EXAMINED: usize = 4096;

/// Words that begin the lines of an OBJ file.
const OBJ_WORDS: [&str; 8] = ["v", "vn", "vt", "f", "o", "g", "mtllib", "usemtl"];

/// First bytes of a text in UTF-16, in either byte order.
const UTF_16: [[u8; 2]; 2] = [[0xff, 0xfe], [0xfe, 0xff]];

/// The error for a text in UTF-16, or a file with the extension of another format; `None` if the format is not recognized, or the
/// extension is right.
pub(super) fn misnamed(bytes: &[u8], extension: &str) -> Option<SurfaceError> {
    if UTF_16.iter().any(|mark| bytes.starts_with(mark)) {
        return Some(malformed("text", "beginning", "the file is in UTF-16; save it as UTF-8 or ASCII".to_owned()));
    }
    let (found, others) = detect(&bytes[..bytes.len().min(EXAMINED)])?;
    let reason = format!("the file has the contents of .{found}; rename it to end in .{found}");
    (extension != found && !others.contains(&extension)).then(|| malformed(found, "beginning", reason))
}

/// Extension of the format that a file begins with, and further extensions of the same reader.
fn detect(start: &[u8]) -> Option<(&'static str, &'static [&'static str])> {
    if start.starts_with(b"glTF") {
        return Some(("glb", &["gltf"]));
    }
    let text = String::from_utf8_lossy(start);
    // Lines that begin with # are skipped below.
    if text.trim_start().starts_with(vtk::MAGIC) {
        return Some(("vtk", &[]));
    }
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let first = lines.next()?;
    match first.split_whitespace().next()? {
        "ply" => Some(("ply", &[])),
        "$MeshFormat" => Some(("msh", &[])),
        medit::MAGIC => Some(("mesh", &[])),
        "solid" if text.contains("facet") => Some(("stl", &[])),
        word if OBJ_WORDS.contains(&word) => Some(("obj", &[])),
        word if word.starts_with('{') && text.contains("\"asset\"") => Some(("gltf", &["glb"])),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(bytes: &[u8], extension: &str, part: Option<&str>) {
        let message = misnamed(bytes, extension).map(|error| error.to_string());
        match part {
            Some(part) => assert!(message.as_ref().is_some_and(|text| text.contains(part)), "{message:?}"),
            None => assert_eq!(message, None),
        }
    }

    #[test]
    fn the_format_of_a_renamed_file_is_named() {
        let obj = b"# made by hand\n\nv 0 0 0\n";
        check(obj, "ply", Some("rename it to end in .obj"));
        check(obj, "obj", None);
        check(b"ply\nformat ascii 1.0\n", "stl", Some(".ply"));
        check(b"solid cube\n facet normal 0 0 1\n", "obj", Some(".stl"));
        check(b"solid cube\n", "obj", None);
        check(b"glTF\x02\0\0\0", "obj", Some(".glb"));
        check(b"glTF\x02\0\0\0", "gltf", None);
        check(b"{\"asset\": {}}", "ply", Some(".gltf"));
        check(b"$MeshFormat\n4.1 0 8\n", "mesh", Some("rename it to end in .msh"));
        check(b"# vtk DataFile Version 3.0\nv\nASCII\n", "obj", Some("rename it to end in .vtk"));
        check(b"# vtk DataFile Version 3.0\nv\nASCII\n", "vtk", None);
        check(b"# made by hand\nMeshVersionFormatted 2\n", "msh", Some("rename it to end in .mesh"));
        check(b"\xff\xfev\0 \x000\0", "obj", Some("save it as UTF-8"));
        check(b"\xfe\xff\0v\0 \x000", "ply", Some("save it as UTF-8"));
        for unknown in [&b"\0\x01\x02"[..], b"", b"hello"] {
            check(unknown, "ply", None);
        }
    }
}
