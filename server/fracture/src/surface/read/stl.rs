//! Reader of STL, ASCII and binary, through `stl_io`.
//!
//! The format cannot share vertices, so equal corners are merged into one vertex. `stl_io` takes every file that begins
//! with "solid " for ASCII, stops after the first solid, requires a name and accepts only small letters. So binary
//! files lose their header first, and ASCII solids are passed one by one in small letters.

use super::common::{malformed, within_limit};
use crate::surface::SINGLE;
use crate::surface::{RawMesh, SurfaceError};
use nalgebra::Point3;
use std::collections::HashMap;
use std::io::Cursor;
use stl_io::create_stl_reader;

const HEADER: usize = 84;
const FACET: usize = 50;

/// Parses an STL file.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let facets = bytes.get(80..HEADER).map(|count| count.iter().rev().fold(0, |n, &byte| n << 8 | usize::from(byte)));
    let exact = facets.is_some_and(|facets| facets * FACET + HEADER == bytes.len());
    match facets {
        _ if !exact && is_ascii(bytes) => parse_ascii(&String::from_utf8_lossy(bytes).to_lowercase()),
        Some(facets) => parse_binary(bytes, facets),
        None => Err(malformed(
            "stl",
            format!("byte {}", bytes.len()),
            "ends inside the header, and does not begin with `solid` as text does: it is no STL file; export the mesh again",
        )),
    }
}

/// Returns true if the file begins with "solid" and continues as text.
fn is_ascii(bytes: &[u8]) -> bool {
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(1024)]).to_lowercase();
    start.trim_start().starts_with("solid") && (start.contains("facet") || start.contains("endsolid"))
}

fn parse_binary(bytes: &[u8], facets: usize) -> Result<RawMesh, SurfaceError> {
    let whole = (bytes.len() - HEADER) / FACET;
    if whole < facets {
        return Err(malformed(
            "stl",
            format!("byte {}", bytes.len()),
            format!("ends after {whole} of {facets} facets"),
        ));
    }
    // Another tail is no facet: some programs write notes there.
    if whole > facets && (bytes.len() - HEADER).is_multiple_of(FACET) {
        return Err(malformed(
            "stl",
            "byte 80",
            format!("counts {facets} facets, but {whole} follow; export the mesh again"),
        ));
    }
    let mut builder = Builder::default();
    builder.add([vec![0; 80], bytes[80..].to_vec()].concat())?;
    Ok(builder.mesh)
}

/// Parses `text` (in small letters): any number of solids, each from a line "solid …" to a line "endsolid …".
fn parse_ascii(text: &str) -> Result<RawMesh, SurfaceError> {
    let mut builder = Builder::default();
    let mut solid = String::new();
    let mut vertex = 0;
    for (line, statement) in text.lines().enumerate() {
        let mut words = statement.split_whitespace();
        let word = words.next();
        if word == Some("vertex") {
            // `stl_io` names no line.
            if words.any(is_not_finite) {
                return Err(SurfaceError::NonFiniteVertex { vertex, line: Some(line + 1) });
            }
            vertex += 1;
        }
        match word {
            None => {}
            Some("solid") if solid.is_empty() => solid.push_str("solid it\n"),
            Some("endsolid") if !solid.is_empty() => builder.add((std::mem::take(&mut solid) + "endsolid\n").into())?,
            Some(word) if solid.is_empty() => {
                return Err(malformed("stl", format!("line {}", line + 1), format!("'{word}' outside a solid")));
            }
            // `stl_io` refuses normals that are not finite. Facets without area have such ones; no normal is used.
            Some("facet") if statement.split_whitespace().any(is_not_finite) => solid.push_str("facet normal 0 0 0\n"),
            Some(_) => {
                solid.push_str(statement);
                solid.push('\n');
            }
        }
    }
    if !solid.is_empty() {
        builder.add(solid.into())?;
    }
    Ok(builder.mesh)
}

/// Returns true for a word that is a number, but no finite one.
fn is_not_finite(word: &str) -> bool {
    word.parse::<f32>().is_ok_and(|number| !number.is_finite())
}

/// Collects triangles and merges their equal corners.
struct Builder {
    mesh: RawMesh,
    places: HashMap<[u32; 3], u32>,
}

impl Default for Builder {
    fn default() -> Self {
        let mesh = RawMesh { rounding: SINGLE, ..RawMesh::new(Vec::new(), Vec::new()) };
        Self { mesh, places: HashMap::new() }
    }
}

impl Builder {
    /// Reads one solid. Errors name the facet, counted from 0 over all solids.
    fn add(&mut self, solid: Vec<u8>) -> Result<(), SurfaceError> {
        let mut solid = Cursor::new(solid);
        let at = |facet: usize, error: std::io::Error| malformed("stl", format!("facet {facet}"), error);
        for facet in create_stl_reader(&mut solid).map_err(|error| at(self.mesh.triangles.len(), error))? {
            let facet = facet.map_err(|error| at(self.mesh.triangles.len(), error))?;
            self.push(facet.vertices.map(|vertex| vertex.0))?;
        }
        Ok(())
    }

    fn push(&mut self, corners: [[f32; 3]; 3]) -> Result<(), SurfaceError> {
        let RawMesh { positions_m, triangles, .. } = &mut self.mesh;
        within_limit(triangles.len())?;
        let mut triangle = [0; 3];
        for (k, corner) in corners.iter().enumerate() {
            if !corner.iter().all(|c| c.is_finite()) {
                return Err(SurfaceError::NonFiniteVertex { vertex: (3 * triangles.len() + k) as u64, line: None });
            }
            let key = corner.map(|c| (c + 0.0).to_bits());
            let next = positions_m.len() as u32;
            triangle[k] = *self.places.entry(key).or_insert(next);
            if triangle[k] == next {
                positions_m.push(Point3::from(corner.map(f64::from)));
            }
        }
        triangles.push(triangle);
        Ok(())
    }
}
