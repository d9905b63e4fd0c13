//! STL, ASCII and binary. Equal corners become one vertex, since the format cannot share them.
//!
//! Read here and not by `stl_io`, which stops at the end of the first of several ASCII solids, takes any binary file
//! whose header begins with "solid " for ASCII, and knows no capital letters.

use super::{RawMesh, SurfaceError, malformed, within_limit};
use crate::surface::{DOUBLE, SINGLE};
use nalgebra::Point3;
use std::collections::HashMap;

const HEADER: usize = 84;
const FACET: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let facets = bytes.get(80..HEADER).map(|count| little_u32(count) as usize);
    let exact = facets.is_some_and(|facets| facets * FACET + HEADER == bytes.len());
    match facets {
        _ if !exact && is_ascii(bytes) => parse_ascii(&String::from_utf8_lossy(bytes)),
        Some(facets) => parse_binary(&bytes[HEADER..], facets),
        None => Err(malformed("stl", format!("byte {}", bytes.len()), "ends inside the header")),
    }
}

/// Begins with "solid" and goes on as text would.
fn is_ascii(bytes: &[u8]) -> bool {
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(1024)]).to_lowercase();
    start.trim_start().starts_with("solid") && (start.contains("facet") || start.contains("endsolid"))
}

fn little_u32(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

fn parse_binary(records: &[u8], facets: usize) -> Result<RawMesh, SurfaceError> {
    if records.len() < facets * FACET {
        let reason = format!("ends after {} of {facets} facets", records.len() / FACET);
        return Err(malformed("stl", format!("byte {}", records.len() + HEADER), reason));
    }
    let mut builder = Builder::new(SINGLE);
    for record in records.chunks_exact(FACET).take(facets) {
        let number = |k: usize| f64::from(f32::from_bits(little_u32(&record[12 + 4 * k..16 + 4 * k])));
        builder.push([0, 3, 6].map(|k| Point3::new(number(k), number(k + 1), number(k + 2))))?;
    }
    Ok(builder.mesh)
}

fn parse_ascii(text: &str) -> Result<RawMesh, SurfaceError> {
    let mut builder = Builder::new(DOUBLE);
    let mut corners = Vec::new();
    let mut in_solid = false;
    for (line, statement) in text.lines().enumerate() {
        let wrong = |reason: String| malformed("stl", format!("line {}", line + 1), reason);
        let mut words = statement.split_whitespace();
        match words.next().unwrap_or_default().to_lowercase().as_str() {
            "solid" => in_solid = true,
            "endsolid" => in_solid = false,
            "facet" => corners.clear(),
            "vertex" => corners.push(vertex(words).map_err(wrong)?),
            "endfacet" => {
                let triangle: [_; 3] = std::mem::take(&mut corners)
                    .try_into()
                    .map_err(|corners: Vec<_>| wrong(format!("a facet of {} vertices", corners.len())))?;
                builder.push(triangle)?;
            }
            "" | "outer" | "endloop" => {}
            word => return Err(wrong(format!("unexpected '{word}'"))),
        }
    }
    if in_solid {
        return Err(malformed("stl", format!("line {}", text.lines().count()), "ends inside a solid"));
    }
    Ok(builder.mesh)
}

fn vertex<'a>(words: impl Iterator<Item = &'a str>) -> Result<Point3<f64>, String> {
    let numbers: Vec<f64> = words
        .map(|word| word.parse().map_err(|_| format!("'{word}' is not a number")))
        .collect::<Result<_, String>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Point3::new(x, y, z)),
        _ => Err("a vertex needs three coordinates".to_owned()),
    }
}

/// Collects triangles and shares their equal corners.
struct Builder {
    mesh: RawMesh,
    places: HashMap<[u64; 3], u32>,
}

impl Builder {
    fn new(rounding: f64) -> Self {
        let mesh = RawMesh { positions_m: Vec::new(), triangles: Vec::new(), faces: Vec::new(), rounding };
        Self { mesh, places: HashMap::new() }
    }

    fn push(&mut self, corners: [Point3<f64>; 3]) -> Result<(), SurfaceError> {
        let RawMesh { positions_m, triangles, .. } = &mut self.mesh;
        within_limit(triangles.len())?;
        let mut triangle = [0; 3];
        for (k, corner) in corners.iter().enumerate() {
            if !corner.coords.iter().all(|c| c.is_finite()) {
                return Err(SurfaceError::NonFiniteVertex { vertex: (3 * triangles.len() + k) as u64 });
            }
            let key = [corner.x, corner.y, corner.z].map(|c| (c + 0.0).to_bits());
            let next = positions_m.len() as u32;
            triangle[k] = *self.places.entry(key).or_insert(next);
            if triangle[k] == next {
                positions_m.push(*corner);
            }
        }
        triangles.push(triangle);
        Ok(())
    }
}
