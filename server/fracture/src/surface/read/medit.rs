//! Reader of Medit `.mesh` files, ASCII.
//!
//! Source: P. J. Frey, *Medit: an interactive mesh visualization software*, INRIA technical report 253 (2001).

use super::common::{malformed, within_limit};
use super::tetrahedral::{Elements, Kind};
use super::words::Words;
use crate::surface::{RawMesh, SurfaceError};
use nalgebra::Point3;

/// Name of the format in errors.
const FORMAT: &str = "mesh";

/// First word of a file.
pub(super) const MAGIC: &str = "MeshVersionFormatted";

/// Parses a file.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    // A binary file begins with 1 as an integer in either byte order.
    if bytes.starts_with(&[1, 0, 0, 0]) || bytes.starts_with(&[0, 0, 0, 1]) {
        let reason =
            "the file is binary; save it as ASCII: with the ending .mesh instead of .meshb, or by `meshio ascii FILE`";
        return Err(malformed(FORMAT, "header", reason));
    }
    let text = String::from_utf8_lossy(bytes);
    let mut words = Words::with_comments(FORMAT, &text);
    if words.next_word() != Some(MAGIC) {
        let reason = "does not begin with `MeshVersionFormatted`; export the mesh as a Medit file, ASCII";
        return Err(malformed(FORMAT, "header", reason));
    }
    words.number::<u32>("version")?;
    let mut positions = Vec::new();
    let mut elements = Elements::new(FORMAT, "line", 1);
    while let Some(keyword) = words.next_word() {
        match keyword {
            "End" => break,
            "Dimension" => {
                if words.number::<u32>("dimension")? != 3 {
                    return Err(words.wrong("only meshes of dimension 3 are read"));
                }
            }
            "Vertices" => read_vertices(&mut words, &mut positions)?,
            _ if keyword.parse::<f64>().is_ok() => {
                return Err(
                    words.wrong(format!("'{keyword}' instead of a keyword: the section is longer than announced"))
                );
            }
            _ => match kind(keyword) {
                Some(kind) if kind.has_corners() => read_elements(&mut words, &kind, &mut elements)?,
                Some(kind) => {
                    let line = words.line();
                    if words.count("elements")? > 0 {
                        elements.push(&kind, &[], line)?;
                    }
                    skip(&mut words);
                }
                None => skip(&mut words),
            },
        }
    }
    elements.surface(&positions)
}

/// Reads the section of vertices after its keyword. A reference number follows each position.
fn read_vertices(words: &mut Words, positions: &mut Vec<Point3<f64>>) -> Result<(), SurfaceError> {
    for _ in 0..words.count("vertices")? {
        positions.push(words.point(positions.len())?);
        words.word("reference")?;
    }
    within_limit(positions.len())
}

/// Reads a section of tetrahedra or triangles after its keyword. A reference number follows each element.
fn read_elements(words: &mut Words, kind: &Kind, elements: &mut Elements) -> Result<(), SurfaceError> {
    let mut corners = [0; 4];
    let corners = &mut corners[..if matches!(kind, Kind::Tetrahedron) { 4 } else { 3 }];
    for _ in 0..words.count("elements")? {
        for corner in &mut *corners {
            let number = words.number::<u32>("vertex")?;
            *corner = number.checked_sub(1).ok_or_else(|| words.wrong("vertex 0, but vertices are counted from 1"))?;
        }
        elements.push(kind, corners, words.line())?;
        words.word("reference")?;
    }
    Ok(())
}

/// Skips numbers up to the next keyword.
fn skip(words: &mut Words) {
    let mut ahead = *words;
    while ahead.next_word().is_some_and(|word| word.parse::<f64>().is_ok()) {
        *words = ahead;
    }
}

/// Kind of the elements of a section; `None` for other sections.
fn kind(keyword: &str) -> Option<Kind> {
    let orders = ["P2", "P3", "P4", "Q2", "Q3", "Q4"];
    let linear = orders.iter().find_map(|order| keyword.strip_suffix(order));
    let solid = |name: &str| {
        let order = if linear.is_some() { "higher-order " } else { "" };
        Some(Kind::Solid(format!("an element of the section {keyword}, a {order}{name},")))
    };
    match (linear.unwrap_or(keyword), linear.is_some()) {
        ("Tetrahedra", false) => Some(Kind::Tetrahedron),
        ("Tetrahedra", true) => solid("tetrahedron"),
        ("Triangles", false) => Some(Kind::Triangle),
        ("Triangles", true) => Some(Kind::Face("a triangle of higher order")),
        ("Quadrilaterals", _) => Some(Kind::Face("a quadrilateral")),
        ("Hexahedra" | "Hexaedra", _) => solid("hexahedron"),
        ("Prisms" | "Pentahedra", _) => solid("prism"),
        ("Pyramids", _) => solid("pyramid"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::tetrahedral::tests::{CELLS, CUBE, check_cube};
    use super::*;

    /// Cube with comments and sections that are skipped.
    fn cube(version: u32) -> String {
        let vertices = CUBE.map(|[x, y, z]| format!("{x} {y} {z} 0\n")).concat();
        let cells = CELLS.map(|cell| format!("{} 5\n", cell.map(|vertex| (vertex + 1).to_string()).join(" "))).concat();
        format!(
            "# a cube\nMeshVersionFormatted {version} # version\nDimension\n3\n\nVertices\n8\n{vertices}\n\
             Corners 2\n1 8\nEdges\n1\n1 2 0\nNormals 1\n0 nan inf\nQuadrilaterals 1\n1 2 4 3 0\nHexahedra\n0\n\
             Triangles\n1\n1 2 3 0\n\nTetrahedra\n6\n{cells}\nEnd\nany text\n"
        )
    }

    fn check(text: &str, start: &str) {
        let message = parse(text.as_bytes()).unwrap_err().to_string();
        assert!(message.starts_with(start), "{message}");
    }

    #[test]
    fn all_versions_are_read() {
        let last = cube(2).replacen("Dimension\n3", "Dimension 3", 1).replacen("\nEnd\nany text\n", "", 1);
        for text in [cube(1), cube(3), cube(2).replace('\n', "\r\n"), last] {
            check_cube(&parse(text.as_bytes()).unwrap());
        }
        let text = cube(2);
        let (start, cells) = text.split_once("Tetrahedra").unwrap();
        let (version, vertices) = start.split_once("Vertices").unwrap();
        let cells = cells.replacen("End\nany text\n", "", 1);
        let turned = format!("{version}Tetrahedra{cells}Vertices{vertices}");
        check_cube(&parse(turned.as_bytes()).unwrap());
    }

    #[test]
    fn a_file_of_triangles_is_a_surface() {
        let text = "MeshVersionFormatted 2 Dimension 3 Vertices 4 9 9 9 0 0 0 0 0 1 0 0 0 0 1 0 0\nTriangles 1\n4 3 2 7\nEnd\n";
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!((mesh.positions_m.len(), mesh.triangles), (3, vec![[2, 1, 0]]));
        let text = text.replace("Triangles 1\n4 3 2", "Quadrilaterals 1\n4 3 2 1");
        check(
            &text,
            "malformed mesh, line 2: a quadrilateral cannot be read; convert the mesh to linear tetrahedra or",
        );
    }

    #[test]
    fn other_files_are_refused() {
        check("", "malformed mesh, header: does not begin with `MeshVersionFormatted`");
        check("MFEM mesh v1.0\n", "malformed mesh, header: does not begin with `MeshVersionFormatted`");
        for start in ["\u{1}\0\0\0\u{2}", "\0\0\0\u{1}\u{2}"] {
            check(start, "malformed mesh, header: the file is binary; save it as ASCII");
        }
        check(
            &cube(2).replacen("Dimension\n3", "Dimension\n2", 1),
            "malformed mesh, line 4: only meshes of dimension 3",
        );
        for (keyword, name) in [
            ("Hexahedra", "hexahedron"),
            ("Prisms", "prism"),
            ("Pyramids", "pyramid"),
            ("TetrahedraP2", "higher-order tetrahedron"),
        ] {
            let text = cube(2).replacen("Corners 2\n1 8\n", &format!("{keyword} 1\n1 2 3 4 5 6 7 8 0\n"), 1);
            let start =
                format!("malformed mesh, line 17: an element of the section {keyword}, a {name}, cannot be read");
            check(&text, &start);
        }
    }

    #[test]
    fn errors_name_the_line() {
        for (from, to, start) in [
            ("Vertices\n8", "Vertices\n9", "malformed mesh, line 17: 'Corners' is not a valid coordinate"),
            ("Vertices\n8", "Vertices\n7", "malformed mesh, line 15: '1' instead of a keyword"),
            ("Vertices\n8", "Vertices\n80000000000", "malformed mesh, line 7: 80000000000 vertices are announced"),
            ("Vertices\n8", "Vertices\nmany", "malformed mesh, line 7: 'many' is not a valid number of vertices"),
            ("1 0 0 0\n", "1 nan 0 0\n", "vertex 1, counted from 0, in line 9 has"),
            ("1 0 0 0\n", "1 1e999 0 0\n", "vertex 1, counted from 0, in line 9 has"),
            ("1 2 4 8 5\n", "1 2 4 9 5\n", "malformed mesh, line 34: an element refers to vertex 9, counted from 1"),
            ("1 2 4 8 5\n", "1 2 4 0 5\n", "malformed mesh, line 34: vertex 0, but vertices are counted from 1"),
            ("1 2 4 8 5\n", "1 2 4 -1 5\n", "malformed mesh, line 34: '-1' is not a valid vertex"),
            ("1 2 4 8 5\n", "1 2 4 2 5\n", "malformed mesh, line 34: a tetrahedron names one vertex twice"),
            ("1 5 6 8 5\n", "1 2 8 5 5\n", "malformed mesh, line 38: 3 tetrahedra, of lines 34, 35, 38, share"),
            ("Tetrahedra\n6", "Tetrahedra\n7", "malformed mesh, line 41: 'End' is not a valid vertex"),
            ("1 5 7 8 5\n\nEnd\nany text\n", "1 5", "malformed mesh, line 39: the file ends before the vertex: copy"),
        ] {
            let text = cube(2);
            assert!(text.contains(from), "{from}");
            check(&text.replacen(from, to, 1), start);
        }
    }
}
