//! Vertex properties of a PLY file as scalar fields, such as painted weights.

use super::common::{PLY_EXPECTED, load, malformed};
use super::ply::{Meaning, PlyRow, check_size, meaning, one_line, scalar};
use super::ply_ascii::Rows;
use super::ply_header;
use crate::surface::SurfaceError;
use nalgebra::Point3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, Header, Property, PropertyType, ScalarType};
use std::path::Path;

/// Error for a file without vertices.
const EMPTY: SurfaceError = SurfaceError::Empty { missing: "vertices", expected: PLY_EXPECTED };

/// Reads vertex positions of a PLY file, in its coordinates, and the values of the vertex property `attribute`.
///
/// Eight-bit colors are scaled to 0 … 1; other numbers stay unchanged.
///
/// # Errors
/// Unreadable and malformed files; a file without that property; vertices or values that are not finite.
pub fn read_painted(path: &Path, attribute: &str) -> Result<(Vec<Point3<f64>>, Vec<f64>), SurfaceError> {
    parse(&load(path)?, attribute)
}

fn parse(bytes: &[u8], attribute: &str) -> Result<(Vec<Point3<f64>>, Vec<f64>), SurfaceError> {
    let mut reader = Reader::new(bytes);
    let parser = Parser::<DefaultElement>::new();
    let header = ply_header::read(&parser, &mut reader, bytes)?;
    let mut lines_read = reader.line().saturating_sub(1);
    for element in header.elements.values() {
        check_size(element, header.encoding, reader.get_ref().len())?;
        let rows = match header.encoding {
            Encoding::Ascii => {
                let mut rows = Rows::new(reader.get_ref(), lines_read);
                let read = ascii(&mut rows, element, attribute)?;
                lines_read = rows.lines_read();
                *reader.get_mut() = rows.rest();
                read
            }
            _ => binary(&parser, &mut reader, (&header, element), attribute)?,
        };
        if element.name == "vertex" {
            return columns(element, rows, attribute);
        }
    }
    Err(EMPTY)
}

/// Position and value of each row of an ASCII element; zero where it has no such property.
fn ascii(rows: &mut Rows, element: &ElementDef, attribute: &str) -> Result<Vec<(Point3<f64>, f64)>, SurfaceError> {
    let meaning_here = |name: &str| match meaning(name) {
        Meaning::Axis(axis) => Meaning::Axis(axis),
        _ if name == attribute => Meaning::Value,
        _ => Meaning::Nothing,
    };
    let value = |row: &PlyRow| match meaning(attribute) {
        Meaning::Axis(axis) => row.point[axis],
        _ => row.value,
    };
    Ok(rows.read_with(element, meaning_here)?.iter().map(|row| (row.point, value(row))).collect())
}

/// As [`ascii`], of a binary element.
fn binary(
    parser: &Parser<DefaultElement>,
    reader: &mut Reader<&[u8]>,
    (header, element): (&Header, &ElementDef),
    attribute: &str,
) -> Result<Vec<(Point3<f64>, f64)>, SurfaceError> {
    let rows = parser
        .read_payload_for_element(reader, element, header)
        .map_err(|error| malformed("ply", format!("element {}", element.name), one_line(&error)))?;
    let number = |row: &DefaultElement, name: &str| row.get(name).map_or(0.0, |value: &Property| scalar(value));
    let point = |row: &DefaultElement| Point3::from(["x", "y", "z"].map(|axis| number(row, axis)));
    Ok(rows.iter().map(|row| (point(row), number(row, attribute))).collect())
}

/// Positions and scaled values of the vertices, once they are known to be finite.
fn columns(
    element: &ElementDef,
    rows: Vec<(Point3<f64>, f64)>,
    attribute: &str,
) -> Result<(Vec<Point3<f64>>, Vec<f64>), SurfaceError> {
    let wrong = |reason: String| malformed("ply", "element vertex", reason);
    let kind = |name: &str| element.properties.get(name).map(|property| &property.data_type);
    for name in ["x", "y", "z", attribute] {
        match kind(name) {
            None => return Err(wrong(format!("has no property {name}"))),
            Some(PropertyType::List(..)) => {
                return Err(wrong(format!("the property {name} is a list; it must be one number per vertex")));
            }
            Some(PropertyType::Scalar(_)) => {}
        }
    }
    if rows.is_empty() {
        return Err(EMPTY);
    }
    for (vertex, (point, value)) in rows.iter().enumerate() {
        if !point.iter().all(|x| x.is_finite()) {
            return Err(SurfaceError::NonFiniteVertex { vertex: vertex as u64, line: None });
        }
        if !value.is_finite() {
            let reason = format!("its {attribute} is infinite or not a number; correct it, or export the file again");
            return Err(malformed("ply", format!("vertex {vertex}, counted from 0"), reason));
        }
    }
    let unit = if kind(attribute) == Some(&PropertyType::Scalar(ScalarType::UChar)) { 255.0 } else { 1.0 };
    Ok(rows.into_iter().map(|(point, value)| (point, value / unit)).unzip())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(property: &str, rows: &str) -> String {
        let count = rows.lines().count();
        format!(
            "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
             property {property}\nend_header\n{rows}"
        )
    }

    #[test]
    fn colors_go_from_zero_to_one_and_other_numbers_stay() {
        let (points, values) = parse(file("uchar red", "0 0 0 255\n1 2 3 51\n").as_bytes(), "red").unwrap();
        assert_eq!((points[1], values), (Point3::new(1.0, 2.0, 3.0), vec![1.0, 0.2]));
        let (_, values) = parse(file("float wear", "0 0 0 2.5\n").as_bytes(), "wear").unwrap();
        assert_eq!(values, [2.5]);
    }

    #[test]
    fn meshes_without_vertex_colors_are_rejected() {
        let refused = |text: String, attribute: &str| parse(text.as_bytes(), attribute).unwrap_err();
        assert!(refused(file("uchar red", "0 0 0 1\n"), "blue").to_string().contains("blue"));
        assert!(matches!(refused(file("uchar red", ""), "red"), SurfaceError::Empty { .. }));
        assert!(matches!(refused("ply\nwhat".to_owned(), "red"), SurfaceError::Malformed { .. }));
        assert!(matches!(refused(file("uchar red", "0 0\n"), "red"), SurfaceError::Malformed { .. }));
    }

    #[test]
    fn numbers_are_those_of_mesh_files_and_errors_name_the_attribute() {
        let (points, values) = parse(file("float wear", ".5 1. 0 .25\n").as_bytes(), "wear").unwrap();
        assert_eq!((points[0], values[0]), (Point3::new(0.5, 1.0, 0.0), 0.25));
        let (_, values) = parse(file("float wear", "1 2 3 0\n").as_bytes(), "z").unwrap();
        assert_eq!(values, [3.0]);
        let check = |text: String, parts: &[&str]| {
            let message = parse(text.as_bytes(), "wear").unwrap_err().to_string();
            assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        };
        check(file("float wear", "0 0 0 1\n0 0 0 1e999\n"), &["vertex 1", "wear", "infinite"]);
        check(file("float wear", "0 0 0 nan\n"), &["vertex 0", "wear"]);
        check(file("float wear", "0 0 0 x\n"), &["'x' is not a number"]);
        check(file("list uchar float wear", "0 0 0 1 0.5\n"), &["wear is a list", "one number per vertex"]);
        check(file("float wear", "0 nan 0 1\n"), &["vertex 0", "coordinate"]);
        check(file("float wear", "0 0 0 1\n").replace("property float y\n", ""), &["no property y"]);
    }

    #[test]
    fn binary_files_are_read_too() {
        let header = file("float wear", "").replace("ascii", "binary_little_endian").replace("vertex 0", "vertex 2");
        let body = |wear: f32| [0.0, 1.0, 2.0, 0.5, 3.0, 4.0, 5.0, wear].map(f32::to_le_bytes).concat();
        let bytes = |wear| [header.as_bytes(), &body(wear)].concat();
        let (points, values) = parse(&bytes(0.75), "wear").unwrap();
        assert_eq!((points[1], values), (Point3::new(3.0, 4.0, 5.0), vec![0.5, 0.75]));
        let message = parse(&bytes(f32::INFINITY), "wear").unwrap_err().to_string();
        assert!(message.contains("vertex 1") && message.contains("wear"), "{message}");
    }
}
