//! Attributes of the faces of an OBJ file: `vt`, `vn`, `usemtl`, the references of faces, and colors after the
//! coordinates of vertices.

use super::obj::lines;
use super::polygon::FaceTriangles;
use crate::surface::{NO_MATERIAL, TriangleAttributes, VertexLists};
use std::collections::HashMap;

/// Reference of a corner that has none.
const NONE: usize = usize::MAX;

/// Reference of a corner to a missing entry.
const BAD: usize = usize::MAX - 1;

/// Attribute lists of the file, and the references of each corner of each face.
#[derive(Default)]
struct Lists {
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Colors of the vertices; not a number for those without one.
    colors: Vec<[f32; 4]>,
    corners: Vec<[usize; 2]>,
    /// Material of each face.
    materials: Vec<u32>,
    names: Vec<String>,
    places: HashMap<String, u32>,
    material: Option<u32>,
}

/// Attributes of the triangles that the faces of `text`, with this number of vertices, were cut into.
pub(super) fn attributes(text: &str, vertices: usize, cut: &FaceTriangles) -> TriangleAttributes {
    let mut lists = Lists::default();
    for (_, line) in lines(text) {
        lists.take(&line);
    }
    let uvs = corner_values(&lists, cut, 0, |index| lists.uvs.get(index).copied(), [f32::NAN; 2]);
    let normals = corner_values(&lists, cut, 1, |index| lists.normals.get(index).copied(), [f32::NAN; 3]);
    let material = |face: &u32| lists.materials.get(*face as usize).copied();
    let materials = if lists.names.is_empty() { Vec::new() } else { cut.faces.iter().filter_map(material).collect() };
    let has_colors = lists.colors.len() == vertices && lists.colors.iter().any(|color| !color[0].is_nan());
    let colors = if has_colors { lists.colors } else { Vec::new() };
    let of_vertices = VertexLists { colors, ..VertexLists::default() };
    let colored = TriangleAttributes::of_vertices(&cut.triangles, &of_vertices);
    TriangleAttributes { normals, uvs, materials, names: lists.names, ..colored }.fitting(cut.triangles.len())
}

/// Values of one list for the corners of all triangles; `nothing` for missing entries. Empty
/// if no corner has a reference.
fn corner_values<T: Copy>(
    lists: &Lists,
    cut: &FaceTriangles,
    list: usize,
    of: impl Fn(usize) -> Option<T>,
    nothing: T,
) -> Vec<[T; 3]> {
    let reference = |place: usize| lists.corners.get(place).map_or(NONE, |corner| corner[list]);
    if lists.corners.iter().all(|corner| corner[list] == NONE) {
        return Vec::new();
    }
    cut.places.iter().map(|places| places.map(|place| of(reference(place)).unwrap_or(nothing))).collect()
}

impl Lists {
    fn take(&mut self, line: &str) {
        let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
        match words.next() {
            Some("v") => self.colors.push(color(words)),
            Some("vt") => self.uvs.push(numbers(words)),
            Some("vn") => self.normals.push(numbers(words)),
            Some("usemtl") => {
                let name = words.collect::<Vec<_>>().join(" ");
                let next = self.names.len() as u32;
                let place = *self.places.entry(name.clone()).or_insert(next);
                if place == next {
                    self.names.push(name);
                }
                self.material = Some(place);
            }
            Some("f") => {
                let lengths = [self.uvs.len(), self.normals.len()];
                self.corners.extend(words.map(|word| {
                    let mut references = word.split('/').skip(1);
                    lengths.map(|length| {
                        references.next().filter(|word| !word.is_empty()).map_or(NONE, |word| reference(word, length))
                    })
                }));
                self.materials.push(self.material.unwrap_or(NO_MATERIAL));
            }
            _ => {}
        }
    }
}

/// Color of a vertex: three or four numbers after its coordinates. A single one is a weight.
fn color<'a>(words: impl Iterator<Item = &'a str>) -> [f32; 4] {
    let given: Vec<f32> = words.skip(3).map(|word| word.parse().unwrap_or(f32::NAN)).collect();
    match given[..] {
        [r, g, b] => [r, g, b, 1.0],
        [r, g, b, a] => [r, g, b, a],
        _ => [f32::NAN; 4],
    }
}

/// Numbers of a line. Missing ones are 0; words that are no numbers become NaN.
fn numbers<'a, const N: usize>(mut words: impl Iterator<Item = &'a str>) -> [f32; N] {
    [(); N].map(|()| words.next().map_or(0.0, |word| word.parse().unwrap_or(f32::NAN)))
}

/// Index from 0 of a reference: positive ones count from 1, negative ones backwards from the last of `length` entries.
fn reference(word: &str, length: usize) -> usize {
    match word.parse::<i64>() {
        Ok(index) if index > 0 => index as usize - 1,
        Ok(index) if index < 0 => length.checked_sub(index.unsigned_abs() as usize).unwrap_or(BAD),
        _ => BAD,
    }
}
