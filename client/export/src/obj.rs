//! Text of a Wavefront OBJ file.
//!
//! Based on: *Object Files (.obj)*, Alias|Wavefront, *Advanced Visualizer Manual*, appendix B1.

use std::fmt::{Display, Write};

/// Triangles of one material.
pub(super) struct Part<'a> {
    /// The material; `None` for no material.
    pub material: Option<&'a str>,
    /// Indices of vertices, three per triangle.
    pub indices: &'a [u32],
}

/// Vertices of a file. OBJ numbers points, normals and texture coordinates separately, so that vertices which differ only in attributes
/// share their point, and the surface is closed in the file.
pub(super) struct Vertices<'a, N> {
    /// Points, one per vertex.
    pub points: &'a [[N; 3]],
    /// For every vertex the vertex whose point it uses: itself, or a lower one. Empty: itself.
    pub merged: &'a [u32],
    /// Normals, one per vertex, or empty.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates, one per vertex, or empty.
    pub uvs: &'a [[f32; 2]],
}

/// Appends points, attributes and triangles; every index must name a vertex. Vertices without a triangle are left out.
pub(super) fn mesh<N: Display>(text: &mut String, vertices: &Vertices<'_, N>, parts: &[Part<'_>]) {
    let point = |vertex: u32| vertices.merged.get(vertex as usize).copied().unwrap_or(vertex);
    let corners = || parts.iter().flat_map(|part| part.indices);
    let points = numbers(vertices.points.len(), corners().map(|vertex| point(*vertex)));
    let attributes = numbers(vertices.points.len(), corners().copied());
    rows(text, "v", vertices.points, &points);
    rows(text, "vt", vertices.uvs, &attributes);
    rows(text, "vn", vertices.normals, &attributes);
    for part in parts.iter().filter(|part| !part.indices.is_empty()) {
        if let Some(material) = part.material {
            line(text, format_args!("usemtl {material}"));
        }
        for triangle in part.indices.chunks_exact(3) {
            text.push('f');
            for &vertex in triangle {
                let (point, look) = (points[point(vertex) as usize], attributes[vertex as usize]);
                let _ = match (vertices.uvs.is_empty(), vertices.normals.is_empty()) {
                    (true, true) => write!(text, " {point}"),
                    (true, false) => write!(text, " {point}//{look}"),
                    (false, true) => write!(text, " {point}/{look}"),
                    (false, false) => write!(text, " {point}/{look}/{look}"),
                };
            }
            text.push('\n');
        }
    }
}

/// Numbers from one, in order, for the used vertices; zero for the others.
fn numbers(count: usize, used: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut numbers = vec![0; count];
    used.for_each(|vertex| numbers[vertex as usize] = 1);
    let mut next = 0;
    for number in numbers.iter_mut().filter(|number| **number > 0) {
        next += 1;
        *number = next;
    }
    numbers
}

fn rows<N: Display, const K: usize>(text: &mut String, word: &str, rows: &[[N; K]], numbers: &[u32]) {
    for (row, _) in rows.iter().zip(numbers).filter(|(_, number)| **number > 0) {
        text.push_str(word);
        row.iter().for_each(|x| {
            let _ = write!(text, " {x}");
        });
        text.push('\n');
    }
}

/// Appends a line. Writing to a string cannot fail.
pub(super) fn line(text: &mut String, content: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(content);
    text.push('\n');
}
