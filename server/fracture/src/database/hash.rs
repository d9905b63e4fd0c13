//! Hash of a bake's input.

use crate::surface::{CrackSheets, Surface, TriangleAttributes};

/// BLAKE3 of a normalized surface (positions, triangles, attributes) and of its crack sheets, hexadecimal.
///
/// Stored in [`BakeReport::input_hash`](crate::pipeline::BakeReport::input_hash).
pub fn input_hash(surface: &Surface, sheets: Option<&CrackSheets>) -> String {
    let mut hasher = blake3::Hasher::new();
    for position in &surface.positions {
        position.iter().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
    }
    for corner in surface.triangles.as_flattened() {
        hasher.update(&corner.to_le_bytes());
    }
    let TriangleAttributes { normals, uvs, uvs2, colors, materials, names, lost: _ } = &surface.attributes;
    let numbers = normals.iter().flatten().flatten().chain(uvs.iter().flatten().flatten());
    numbers.for_each(|x| _ = hasher.update(&x.to_le_bytes()));
    materials.iter().for_each(|material| _ = hasher.update(&material.to_le_bytes()));
    names.iter().for_each(|name| _ = hasher.update(name.as_bytes()));
    // A word before each, so that no other input has the same bytes; inputs without them keep their hash.
    for (word, values) in
        [("uvs2", uvs2.as_flattened().as_flattened()), ("colors", colors.as_flattened().as_flattened())]
    {
        if !values.is_empty() {
            hasher.update(word.as_bytes());
            values.iter().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
        }
    }
    for corner in sheets.map_or(&[][..], CrackSheets::triangles).as_flattened() {
        corner.iter().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
    }
    hasher.finalize().to_hex().to_string()
}
