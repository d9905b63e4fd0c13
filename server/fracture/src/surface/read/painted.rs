//! Vertex properties of a PLY file as scalar fields, such as painted weights.

use super::ply::{check_size, one_line, scalar};
use super::{PLY_EXPECTED, SurfaceError, load, malformed, ply_header};
use nalgebra::Point3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, Property, PropertyType, ScalarType};
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
    for element in header.elements.values() {
        check_size(element, reader.get_ref().len())?;
        let rows = parser
            .read_payload_for_element(&mut reader, element, &header)
            .map_err(|error| malformed("ply", format!("element {}", element.name), one_line(&error)))?;
        if element.name != "vertex" {
            continue;
        }
        let unit = match element.properties.get(attribute).map(|property| &property.data_type) {
            None => return Err(malformed("ply", "element vertex", format!("has no property {attribute}"))),
            Some(PropertyType::Scalar(ScalarType::UChar)) => 255.0,
            Some(_) => 1.0,
        };
        let number =
            |row: &DefaultElement, name: &str| row.get(name).map_or(f64::NAN, |value: &Property| scalar(value));
        let point = |row: &DefaultElement| Point3::from(["x", "y", "z"].map(|axis| number(row, axis)));
        let points: Vec<Point3<f64>> = rows.iter().map(point).collect();
        let values: Vec<f64> = rows.iter().map(|row| number(row, attribute) / unit).collect();
        let finite = |vertex: &usize| points[*vertex].iter().all(|x| x.is_finite()) && values[*vertex].is_finite();
        return match (0..points.len()).find(|vertex| !finite(vertex)) {
            Some(vertex) => Err(SurfaceError::NonFiniteVertex { vertex: vertex as u64, line: None }),
            None if points.is_empty() => Err(EMPTY),
            None => Ok((points, values)),
        };
    }
    Err(EMPTY)
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
}
