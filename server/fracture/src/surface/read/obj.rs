//! Wavefront OBJ: `v` and `f` statements; everything else is left out.
//!
//! Read here and not by `tobj`, which drops vertices of no face, renumbers the others per group, reads f32 unless a
//! global feature is set, and tells no line: then a defect could not be found in the file.

use super::polygon::Polygons;
use super::{RawMesh, SurfaceError, malformed, within_limit};
use crate::surface::DOUBLE;
use nalgebra::Point3;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let text = String::from_utf8_lossy(bytes);
    let mut positions = Vec::new();
    let mut polygons = Polygons::default();
    let mut pending = String::new();
    for (line, part) in text.lines().enumerate() {
        let statement = match (part.strip_suffix('\\'), pending.is_empty()) {
            (Some(part), _) => {
                pending.push_str(part);
                pending.push(' ');
                continue;
            }
            (None, true) => part,
            (None, false) => {
                pending.push_str(part);
                pending.as_str()
            }
        };
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("v") => positions.push(vertex(words).map_err(|reason| malformed("obj", at(line), reason))?),
            Some("f") => face(words, line, positions.len(), &mut polygons)?,
            _ => {}
        }
        pending.clear();
    }
    within_limit(positions.len())?;
    let (triangles, faces) = polygons.triangles(&positions)?;
    Ok(RawMesh { positions_m: positions, triangles, faces, rounding: DOUBLE })
}

fn at(line: usize) -> String {
    format!("line {}", line + 1)
}

/// The first three numbers; a weight or a colour may follow.
fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<Point3<f64>, String> {
    let mut point = Point3::origin();
    for axis in 0..3 {
        let word = words.next().ok_or("a vertex needs three coordinates")?;
        point[axis] = word.parse().map_err(|_| format!("'{word}' is not a number"))?;
    }
    Ok(point)
}

/// Corners `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or backwards from the latest vertex if negative.
fn face<'a>(
    words: impl Iterator<Item = &'a str>,
    line: usize,
    vertices: usize,
    polygons: &mut Polygons,
) -> Result<(), SurfaceError> {
    let mut corners = Vec::new();
    for word in words.take_while(|word| !word.starts_with('#')) {
        let number = word.split('/').next().unwrap_or_default();
        let index: i64 =
            number.parse().map_err(|_| malformed("obj", at(line), format!("'{word}' is not a vertex index")))?;
        let index = if index < 0 { index.saturating_add(vertices as i64) } else { index - 1 };
        let vertices = vertices as u64;
        let error = SurfaceError::VertexOutOfBounds { face: polygons.len() as u64, index, vertices };
        corners.push(u32::try_from(index).map_err(|_| error)?);
    }
    polygons.push(corners);
    Ok(())
}
