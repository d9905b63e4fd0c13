//! Reader of Wavefront OBJ: vertices and faces through `tobj`, attributes through [`super::obj_attributes`].
//!
//! `tobj` numbers vertices by first use, reports no line number, and stops at lines that are not UTF-8 or that continue
//! after a backslash. So it receives only complete `v` and `f` statements. Each vertex is followed by a point face of
//! its own, which keeps the file's numbering. If `tobj` fails, bisection finds the statement that it rejects.

use super::common::{malformed, within_limit};
use super::obj_attributes;
use super::polygon::FacePolygons;
use crate::surface::DOUBLE;
use crate::surface::{RawMesh, SurfaceError};
use nalgebra::Point3;
use std::borrow::Cow;
use tobj::{LoadError, LoadOptions, Mesh};

/// Parses an OBJ file.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let text = String::from_utf8_lossy(bytes);
    // Some editors write a byte-order mark at the start of a file.
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let statements = statements(text);
    within_limit(statements.len())?;
    let mesh = load(&statements, statements.len()).map_err(|error| refused(&statements, &error))?;
    let positions: Vec<Point3<f64>> = mesh.positions.chunks_exact(3).map(Point3::from_slice).collect();
    if let Some(vertex) = positions.iter().position(|point| !point.coords.iter().all(|x| x.is_finite())) {
        let statement = statements.iter().filter(|statement| statement.is_vertex).nth(vertex);
        let line = statement.map(|statement| statement.line);
        return Err(SurfaceError::NonFiniteVertex { vertex: vertex as u64, line });
    }
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
    let attributes = obj_attributes::attributes(text, positions.len(), &cut);
    Ok(RawMesh { positions_m: positions, triangles: cut.triangles, faces: cut.faces, rounding: DOUBLE, attributes })
}

/// Vertex or face statement, as passed to `tobj`.
struct Statement {
    is_vertex: bool,
    /// Number of its last line, from 1.
    line: usize,
    /// Position in the order of bisection, in which all vertices precede all faces.
    rank: usize,
    text: String,
}

/// Logical lines of `text`, joined where a backslash ends a line, each with the number of
/// its last physical line, from 1.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let end = if text.contains('\n') { '\n' } else { '\r' };
    let mut parts = text.split_terminator(end).map(|line| line.strip_suffix('\r').unwrap_or(line)).enumerate();
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
        // Nothing follows the last backslash, so the text before it is dropped.
        None
    })
}

/// Vertex statements without weights and colors, and face statements without texture and normal indices.
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

/// Ranks all vertices first, then all faces.
fn rank(statements: &mut [Statement]) {
    let vertices = statements.iter().filter(|statement| statement.is_vertex).count();
    let (mut vertex, mut face) = (0, vertices);
    for statement in statements {
        let next = if statement.is_vertex { &mut vertex } else { &mut face };
        statement.rank = *next;
        *next += 1;
    }
}

/// Loads the statements of rank below `end` as one mesh with one face per statement; a vertex yields a point face.
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

/// Rule that the statement `text` breaks, in plain words.
fn rule(error: &LoadError, text: &str) -> String {
    match error {
        LoadError::PositionParseError if text.contains(',') => {
            "a vertex needs three numbers, with decimal points instead of commas, apart by spaces".to_owned()
        }
        LoadError::PositionParseError => "a vertex needs three numbers, apart by spaces".to_owned(),
        LoadError::FaceParseError => "a face needs whole numbers other than 0 that name vertices".to_owned(),
        LoadError::FaceVertexOutOfBounds => "a face names a vertex that does not exist".to_owned(),
        other => other.to_string(),
    }
}

/// Remark on the last statement of a file, which may have been cut off.
fn ending(statements: &[Statement], line: usize) -> &'static str {
    let is_last = statements.iter().all(|statement| statement.line <= line);
    if is_last { "; the file ends there: if it was cut off, copy or export it again" } else { "" }
}

/// Error that names the first statement, vertices before faces, that `tobj` rejects.
fn refused(statements: &[Statement], error: &LoadError) -> SurfaceError {
    let (mut accepted, mut refused) = (0, statements.len());
    while refused - accepted > 1 {
        let middle = accepted.midpoint(refused);
        *(if load(statements, middle).is_ok() { &mut accepted } else { &mut refused }) = middle;
    }
    // The first statement in order of ranks may break another rule than the one that the whole file met first.
    let own = load(statements, refused).err();
    let error = own.as_ref().unwrap_or(error);
    let found = statements.iter().find(|statement| statement.rank == accepted);
    let line = found.map_or(0, |statement| statement.line);
    malformed(
        "obj",
        format!("line {line}"),
        found.map_or(error.to_string(), |found| {
            format!("{}: '{}'{}", rule(error, &found.text), found.text, ending(statements, line))
        }),
    )
}
