//! Reader of PLY headers, whose errors name the line and the rule that it breaks.

use super::common::malformed;
use super::ply::{Meaning, meaning, one_line};
use crate::scene::brief;
use crate::surface::SurfaceError;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Header, PropertyAccess, PropertyDef, PropertyType, ScalarType};
use std::collections::HashSet;
use std::io::ErrorKind;

/// Reads the header of the file `bytes`.
pub(super) fn read<E: PropertyAccess>(
    parser: &Parser<E>,
    reader: &mut Reader<&[u8]>,
    bytes: &[u8],
) -> Result<Header, SurfaceError> {
    if !bytes.starts_with(b"ply") {
        return Err(malformed("ply", "header", "does not begin with `ply`: the file is empty, or of another format"));
    }
    let header = parser.read_header(reader).map_err(|error| refused(parser, &error, bytes))?;
    no_name_twice(bytes)?;
    whole_indices(&header)?;
    Ok(header)
}

/// Refuses a header that names an element twice, or a property of an element twice: the parser keeps the last one alone.
fn no_name_twice(bytes: &[u8]) -> Result<(), SurfaceError> {
    let (mut elements, mut properties) = (HashSet::new(), HashSet::new());
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        let words: Vec<&str> = text.split_whitespace().collect();
        let (kind, name, is_new) = match words[..] {
            ["end_header", ..] => break,
            ["element", name, ..] => {
                properties.clear();
                ("element", name, elements.insert(name.to_owned()))
            }
            ["property", .., name] => ("property", name, properties.insert(name.to_owned())),
            _ => continue,
        };
        if !is_new {
            let reason = format!("a second {kind} `{}`; each name may stand once", brief(name));
            return Err(malformed("ply", format!("line {}", number + 1), reason));
        }
    }
    Ok(())
}

/// Refuses faces without a list of indices, and lists of indices whose values are not whole numbers.
fn whole_indices(header: &Header) -> Result<(), SurfaceError> {
    for element in header.elements.values() {
        let is_list = |property: &PropertyDef| matches!(property.data_type, PropertyType::List(..));
        let has_list = element.properties.values().any(|it| meaning(&it.name) == Meaning::Indices && is_list(it));
        if element.name == "face" && element.count > 0 && !has_list {
            let reason = "has no list of vertices: expected `property list uchar int vertex_indices`";
            return Err(malformed("ply", "element face", reason));
        }
        for property in element.properties.values().filter(|property| meaning(&property.name) == Meaning::Indices) {
            if let PropertyType::List(_, ScalarType::Float | ScalarType::Double) = property.data_type {
                let reason =
                    format!("`{}` has float values; indices must be of a whole type, such as int", property.name);
                return Err(malformed("ply", format!("element {}", element.name), reason));
            }
        }
    }
    Ok(())
}

/// Error that names the line of the header.
fn refused<E: PropertyAccess>(parser: &Parser<E>, error: &ParseError, bytes: &[u8]) -> SurfaceError {
    if error.kind() == ErrorKind::UnexpectedEof {
        return malformed("ply", "header", "the file ends before the line `end_header`: copy or export it again");
    }
    let numbered = error.line().and_then(|number| Some((number, bytes.split(|&byte| byte == b'\n').nth(number - 1)?)));
    let Some((number, line)) = numbered else { return malformed("ply", "header", one_line(error)) };
    let text = String::from_utf8_lossy(line);
    let text = text.trim_end();
    malformed("ply", format!("line {number}"), format!("{}, not '{}'", expected(parser, text), brief(text)))
}

/// Description of the lines that may stand in place of `text`.
fn expected<E: PropertyAccess>(parser: &Parser<E>, text: &str) -> &'static str {
    // The place of a line is wrong if it is valid alone.
    let is_misplaced = parser.read_header_line(text).is_ok();
    match text.split_whitespace().next() {
        Some("property") if is_misplaced => "expected a line `element` before the first line `property`",
        Some("format") if is_misplaced => "expected one line `format`",
        Some("ply") if is_misplaced => "expected `ply` in the first line alone",
        Some("format") => {
            "expected `format ascii 1.0`, `format binary_little_endian 1.0` or `format binary_big_endian 1.0`"
        }
        Some("element") => "expected `element NAME COUNT`, with a whole number, 0 or more, for COUNT",
        Some("property") => {
            "expected `property TYPE NAME` or `property list TYPE TYPE NAME`, with types such as uchar, int and float"
        }
        Some(word) if word.starts_with("ply") => "expected `ply` alone in the first line",
        _ => "expected a line that begins with `format`, `element`, `property`, `comment`, `obj_info` or `end_header`",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ply_rs_bw::ply::DefaultElement;

    #[test]
    fn errors_name_the_line_and_what_is_expected() {
        let message = |text: &str| {
            let mut reader = Reader::new(text.as_bytes());
            read(&Parser::<DefaultElement>::new(), &mut reader, text.as_bytes()).unwrap_err().to_string()
        };
        let start = "ply\nformat ascii 1.0\n";
        for (line, wanted) in [
            ("element vertex -1", "expected `element NAME COUNT`"),
            ("element vertex 99999999999999999999", "expected `element NAME COUNT`"),
            ("element vertex", "expected `element NAME COUNT`"),
            ("property float x", "expected a line `element` before"),
            ("property real x", "expected `property TYPE NAME`"),
            ("format ascii one", "expected `format ascii 1.0`"),
            ("format binary_little_endian 1.0", "expected one line `format`"),
            ("ply", "expected `ply` in the first line alone"),
            ("vertex 3", "expected a line that begins with `format`"),
            ("", "expected a line that begins with `format`"),
        ] {
            let message = message(&format!("{start}{line}\r\nend_header\n"));
            assert!(message.starts_with(&format!("malformed ply, line 3: {wanted}")), "{message}");
            assert!(message.ends_with(&format!("not '{line}'")) && !message.contains("ParseError"), "{message}");
        }
        assert!(message("ply what\n").starts_with("malformed ply, line 1: expected `ply` alone"));
        for (lines, wanted) in [
            ("element vertex 3\nproperty float x\nelement vertex 1\n", "line 5: a second element `vertex`"),
            ("element vertex 3\nproperty float x\nproperty float x\n", "line 5: a second property `x`"),
            (
                "element face 3\nproperty list uchar float vertex_indices\n",
                "element face: `vertex_indices` has float values; indices must be of a whole type",
            ),
            ("element face 3\nproperty int vertex_indices\n", "element face: has no list of vertices"),
            ("element face 3\nproperty uchar red\n", "element face: has no list of vertices"),
        ] {
            let message = message(&format!("{start}{lines}end_header\n"));
            assert!(message.contains(wanted), "{message}");
        }
        let lines = "element vertex 3\nproperty float x\nelement face 1\nproperty int x\nproperty list uchar int vertex_index\n";
        let valid = format!("{start}{lines}end_header\n");
        let mut reader = Reader::new(valid.as_bytes());
        assert!(read(&Parser::<DefaultElement>::new(), &mut reader, valid.as_bytes()).is_ok());
        assert!(message(start).contains("ends before the line `end_header`"));
        assert!(message("ply\nend_header\n").contains("format"));
        assert!(message("solid\n").contains("does not begin with `ply`"));
    }
}
