//! Wavefront OBJ: vertices and faces, through `tobj`; how they look is read by [`super::obj_looks`].
//!
//! `tobj` numbers vertices by first use, tells no place in the file, and stops at lines that are no UTF-8 or that go on
//! after a backslash. So it is handed statements, `v` and `f` alone and whole, with a point of every vertex just behind
//! it, which keeps the file's own numbers; and where it refuses, halving finds the statement that it refuses.

use super::polygon::FacePolygons;
use super::{RawMesh, SurfaceError, malformed, obj_looks, within_limit};
use crate::surface::DOUBLE;
use nalgebra::Point3;
use std::borrow::Cow;
use tobj::{LoadError, LoadOptions, Mesh};

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let text = String::from_utf8_lossy(bytes);
    // Some editors begin a file with a mark that is no part of its first line.
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let statements = statements(text);
    within_limit(statements.len())?;
    let mesh = load(&statements, statements.len()).map_err(|error| refused(&statements, &error))?;
    let positions: Vec<Point3<f64>> = mesh.positions.chunks_exact(3).map(Point3::from_slice).collect();
    let mut polygons = FacePolygons::default();
    let mut start = 0;
    for (statement, &arity) in statements.iter().zip(&mesh.face_arities) {
        let end = start + arity as usize;
        if !statement.is_vertex {
            polygons.push(mesh.indices[start..end].iter().copied());
        }
        start = end;
    }
    let cut = polygons.triangles(&positions)?;
    let looks = obj_looks::looks(text, &cut);
    Ok(RawMesh { positions_m: positions, triangles: cut.triangles, faces: cut.faces, rounding: DOUBLE, looks })
}

/// A vertex or a face, as `tobj` shall see it.
struct Statement {
    is_vertex: bool,
    /// The last of its lines, from 1.
    line: usize,
    /// How many vertices, or how many vertices and faces, come before it: what is left out first when halving.
    rank: usize,
    text: String,
}

/// The lines of `text`, joined where a backslash ends one, each with the number of its last part, from 1.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut parts = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (mut number, first) = parts.next()?;
        let Some(first) = first.strip_suffix('\\') else { return Some((number + 1, Cow::Borrowed(first))) };
        let mut whole = first.to_owned() + " ";
        for (next, part) in parts.by_ref() {
            number = next;
            match part.strip_suffix('\\') {
                Some(part) => whole = whole + part + " ",
                None => return Some((number + 1, Cow::Owned(whole + part))),
            }
        }
        // Nothing follows the last backslash: what stands before it is left out.
        None
    })
}

/// Vertices without weights and colors, faces without texture and normal indices.
fn statements(text: &str) -> Vec<Statement> {
    let mut statements = Vec::new();
    for (line, whole) in lines(text) {
        let mut words = whole.split('#').next().unwrap_or_default().split_whitespace();
        let text = match words.next() {
            Some("v") => Some(words.take(3).fold("v".to_owned(), |text, word| text + " " + word)),
            Some("f") => {
                Some(words.fold("f".to_owned(), |text, word| text + " " + word.split('/').next().unwrap_or("")))
            }
            _ => None,
        };
        statements.extend(text.map(|text| Statement { is_vertex: text.starts_with('v'), line, rank: 0, text }));
    }
    rank(&mut statements);
    statements
}

/// All vertices, then all faces.
fn rank(statements: &mut [Statement]) {
    let vertices = statements.iter().filter(|statement| statement.is_vertex).count();
    let (mut vertex, mut face) = (0, vertices);
    for statement in statements {
        let next = if statement.is_vertex { &mut vertex } else { &mut face };
        statement.rank = *next;
        *next += 1;
    }
}

/// One mesh of the statements of rank below `end`: per statement one face, for a vertex the point alone.
fn load(statements: &[Statement], end: usize) -> Result<Mesh, LoadError> {
    let mut text = String::new();
    for statement in statements.iter().filter(|statement| statement.rank < end) {
        text += &statement.text;
        text += if statement.is_vertex { "\nf -1\n" } else { "\n" };
    }
    let options = LoadOptions { single_index: true, ..LoadOptions::default() };
    let (mut models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| Err(LoadError::OpenFileFailed))?;
    models.pop().map(|model| model.mesh).ok_or(LoadError::GenericFailure)
}

/// Names the first statement, vertices before faces, that `tobj` refuses.
fn refused(statements: &[Statement], error: &LoadError) -> SurfaceError {
    let (mut accepted, mut refused) = (0, statements.len());
    while refused - accepted > 1 {
        let middle = accepted.midpoint(refused);
        *(if load(statements, middle).is_ok() { &mut accepted } else { &mut refused }) = middle;
    }
    let found = statements.iter().find(|statement| statement.rank == accepted);
    let line = found.map_or(0, |statement| statement.line);
    malformed(
        "obj",
        format!("line {line}"),
        found.map_or(error.to_string(), |found| format!("{error}: '{}'", found.text)),
    )
}
