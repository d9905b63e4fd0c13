//! Reader of PLY, ASCII and binary of either byte order: vertices, faces and triangle strips.
//!
//! `ply-rs-bw` reads headers, through [`super::ply_header`], and binary bodies. [`super::ply_ascii`] reads ASCII bodies.

use super::common::{malformed, within_limit};
use super::ply_ascii::Rows;
use super::ply_header;
use super::polygon::{FacePolygons, FaceTriangles};
use crate::surface::{DOUBLE, SINGLE, TriangleAttributes, VertexLists};
use crate::surface::{RawMesh, SurfaceError};
use nalgebra::Point3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use std::io::ErrorKind;

/// Values of one row of an element: coordinates and attributes of a vertex, or vertex indices.
#[derive(Default)]
pub(super) struct PlyRow {
    /// Position of a vertex.
    pub point: Point3<f64>,
    /// Normal of a vertex.
    pub normal: [f64; 3],
    /// Texture coordinates of a vertex.
    pub uv: [f64; 2],
    /// Red, green, blue and alpha of a vertex, from 0 to 1.
    pub color: [f64; 4],
    /// Vertex indices of a face or strip.
    pub indices: Vec<i64>,
    /// Value of the property that a painted field names.
    pub value: f64,
}

/// Meaning of a property.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Meaning {
    Axis(usize),
    Normal(usize),
    Uv(usize),
    Color(usize),
    Indices,
    Value,
    Nothing,
}

/// Meaning of the property called `name`.
pub(super) fn meaning(name: &str) -> Meaning {
    match name {
        "x" => Meaning::Axis(0),
        "y" => Meaning::Axis(1),
        "z" => Meaning::Axis(2),
        "nx" => Meaning::Normal(0),
        "ny" => Meaning::Normal(1),
        "nz" => Meaning::Normal(2),
        "u" | "s" | "texture_u" => Meaning::Uv(0),
        "v" | "t" | "texture_v" => Meaning::Uv(1),
        "red" => Meaning::Color(0),
        "green" => Meaning::Color(1),
        "blue" => Meaning::Color(2),
        "alpha" => Meaning::Color(3),
        "vertex_indices" | "vertex_index" => Meaning::Indices,
        _ => Meaning::Nothing,
    }
}

/// Parses a PLY file.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let mut reader = Reader::new(bytes);
    let parser = Parser::<PlyRow>::new();
    let header = ply_header::read(&parser, &mut reader, bytes)?;
    let mut lines_read = reader.line().saturating_sub(1);
    let mut body = Body::default();
    for element in header.elements.values() {
        check_size(element, header.encoding, reader.get_ref().len())?;
        let rows = match header.encoding {
            Encoding::Ascii => {
                let mut rows = Rows::new(reader.get_ref(), lines_read);
                let read = rows.read(element)?;
                lines_read = rows.lines_read();
                *reader.get_mut() = rows.rest();
                read
            }
            _ => parser
                .read_payload_for_element(&mut reader, element, &header)
                .map_err(|error| malformed("ply", format!("element {}", element.name), body_error(&error)))?,
        };
        body.take(element, rows)?;
    }
    body.finish(&header)
}

/// Text of an error in the body of a file.
fn body_error(error: &ParseError) -> String {
    match error.kind() {
        ErrorKind::UnexpectedEof => "the file ends there: copy or export it again".to_owned(),
        _ => one_line(error),
    }
}

/// Text of an error with all white space replaced by single spaces.
pub(super) fn one_line(error: &impl ToString) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Checks the row count of an element against the remaining bytes.
///
/// A larger count is false and must not reach an allocation.
pub(super) fn check_size(element: &ElementDef, encoding: Encoding, bytes: usize) -> Result<(), SurfaceError> {
    let ElementDef { name, count, .. } = element;
    if *count > 0 && element.properties.is_empty() {
        return Err(malformed("ply", format!("element {name}"), "has no properties"));
    }
    let fitting = bytes / row_bytes(element, encoding).max(1);
    if *count > fitting {
        let place = format!("element {name}, row {fitting}, counted from 0");
        let reason = format!(
            "the header announces {count} rows, but the file ends in this one at the latest: copy or export it again"
        );
        return Err(malformed("ply", place, reason));
    }
    within_limit(*count)
}

/// Least number of bytes of a row. In text, the reader of its lines names a row that is missing.
fn row_bytes(element: &ElementDef, encoding: Encoding) -> usize {
    let scalar = |scalar: &ScalarType| match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let binary = element.properties.values().map(|property| match &property.data_type {
        PropertyType::Scalar(own) | PropertyType::List(own, _) => scalar(own),
    });
    match encoding {
        Encoding::Ascii => 1,
        _ => binary.sum(),
    }
}

#[derive(Default)]
struct Body {
    positions: Vec<Point3<f64>>,
    lists: VertexLists,
    polygons: FacePolygons,
}

impl Body {
    fn take(&mut self, element: &ElementDef, rows: Vec<PlyRow>) -> Result<(), SurfaceError> {
        match element.name.as_str() {
            "vertex" => {
                for axis in ["x", "y", "z"] {
                    if !element.properties.contains_key(axis) {
                        return Err(malformed("ply", "element vertex", format!("has no property {axis}")));
                    }
                }
                self.positions.extend(rows.iter().map(|row| row.point));
                let has = |wanted: &[Meaning]| {
                    let meanings: Vec<Meaning> = element.properties.keys().map(|name| meaning(name)).collect();
                    wanted.iter().all(|wanted| meanings.contains(wanted))
                };
                if has(&[0, 1, 2].map(Meaning::Normal)) {
                    self.lists.normals.extend(rows.iter().map(|row| row.normal.map(|x| x as f32)));
                }
                if has(&[0, 1].map(Meaning::Uv)) {
                    self.lists.uvs.extend(rows.iter().map(|row| row.uv.map(|x| x as f32)));
                }
                if has(&[0, 1, 2].map(Meaning::Color)) {
                    let has_alpha = has(&[Meaning::Color(3)]);
                    let color = |[r, g, b, a]: [f64; 4]| [r, g, b, if has_alpha { a } else { 1.0 }].map(|x| x as f32);
                    self.lists.colors.extend(rows.iter().map(|row| color(row.color)));
                }
            }
            "face" => {
                for row in &rows {
                    let corners = self.corners(&row.indices)?;
                    self.polygons.push(corners);
                }
            }
            "tristrips" => {
                for strip in rows.iter().flat_map(|row| row.indices.split(|&index| index == -1)) {
                    let corners = self.corners(strip)?;
                    for (k, window) in corners.windows(3).enumerate() {
                        let (a, b) = if k % 2 == 0 { (0, 1) } else { (1, 0) };
                        self.polygons.push([window[a], window[b], window[2]]);
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Converts indices to unsigned numbers. Their upper range is checked once all vertices are read.
    fn corners(&self, indices: &[i64]) -> Result<Vec<u32>, SurfaceError> {
        let (face, vertices) = (self.polygons.len() as u64, self.positions.len() as u64);
        let convert =
            |&index: &i64| u32::try_from(index).map_err(|_| SurfaceError::VertexOutOfBounds { face, index, vertices });
        indices.iter().map(convert).collect()
    }

    fn finish(self, header: &Header) -> Result<RawMesh, SurfaceError> {
        let FaceTriangles { triangles, faces, .. } = self.polygons.triangles(&self.positions)?;
        let attributes = TriangleAttributes::of_vertices(&triangles, &self.lists).fitting(triangles.len());
        let is_double = |element: &ElementDef| {
            let kind = element.properties.get("x").map(|x| &x.data_type);
            kind != Some(&PropertyType::Scalar(ScalarType::Float))
        };
        let rounding = if header.elements.get("vertex").is_none_or(is_double) { DOUBLE } else { SINGLE };
        Ok(RawMesh { positions_m: self.positions, triangles, faces, rounding, attributes })
    }
}

impl PropertyAccess for PlyRow {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        match meaning(name) {
            Meaning::Axis(axis) => self.point[axis] = scalar(&value),
            Meaning::Normal(axis) => self.normal[axis] = scalar(&value),
            Meaning::Uv(axis) => self.uv[axis] = scalar(&value),
            Meaning::Color(channel) => self.color[channel] = scalar(&value) / color_max(&value),
            Meaning::Indices => self.indices = list(value),
            Meaning::Value | Meaning::Nothing => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// Value of a color channel that stands for 1: 65,535 of unsigned 16-bit numbers, 255 of other whole numbers, and 1 of floats.
fn color_max(value: &Property) -> f64 {
    match value {
        Property::UShort(_) => color_max_of(&ScalarType::UShort),
        Property::Float(_) => color_max_of(&ScalarType::Float),
        Property::Double(_) => color_max_of(&ScalarType::Double),
        _ => color_max_of(&ScalarType::Int),
    }
}

/// As [`color_max`], of the type of a property.
pub(super) fn color_max_of(kind: &ScalarType) -> f64 {
    match kind {
        ScalarType::UShort => u16::MAX.into(),
        ScalarType::Float | ScalarType::Double => 1.0,
        _ => u8::MAX.into(),
    }
}

/// Numeric value of a scalar property of any type; NaN for a list.
pub(super) fn scalar(value: &Property) -> f64 {
    match *value {
        Property::Char(v) => f64::from(v),
        Property::UChar(v) => f64::from(v),
        Property::Short(v) => f64::from(v),
        Property::UShort(v) => f64::from(v),
        Property::Int(v) => f64::from(v),
        Property::UInt(v) => f64::from(v),
        Property::Float(v) => f64::from(v),
        Property::Double(v) => v,
        _ => f64::NAN,
    }
}

/// Indices from a list of integers of any type; empty for other values.
fn list(value: Property) -> Vec<i64> {
    fn widen<T: Into<i64>>(values: Vec<T>) -> Vec<i64> {
        values.into_iter().map(Into::into).collect()
    }
    match value {
        Property::ListChar(v) => widen(v),
        Property::ListUChar(v) => widen(v),
        Property::ListShort(v) => widen(v),
        Property::ListUShort(v) => widen(v),
        Property::ListInt(v) => widen(v),
        Property::ListUInt(v) => widen(v),
        _ => Vec::new(),
    }
}
