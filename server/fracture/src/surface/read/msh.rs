//! Reader of Gmsh `.msh` files, ASCII, versions 2 and 4.1.
//!
//! Source: Gmsh reference manual, chapter "Gmsh file formats", MSH file format, version 4.1 and version 2 (legacy).

use super::common::{malformed, within_limit};
use super::tetrahedral::{Elements, Kind};
use super::words::Words;
use crate::surface::{RawMesh, SurfaceError};
use nalgebra::Point3;

/// Name of the format in errors.
const FORMAT: &str = "msh";

/// Command that saves a file in a version that is read.
const CONVERT: &str = "`gmsh FILE.msh -save -format msh41 -setnumber Mesh.Binary 0 -o ASCII.msh`";

/// Version of the format.
#[derive(Clone, Copy)]
enum Version {
    /// 2.0 to 2.2.
    Two,
    /// 4.1.
    Four,
}

/// Parses a file.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let text = String::from_utf8_lossy(bytes);
    let mut words = Words::new(FORMAT, &text);
    let mut version = None;
    let mut nodes = Nodes::default();
    let mut elements = Elements::new(FORMAT, "line", 1);
    while let Some(mut row) = words.next_row() {
        let name = row.word("section")?;
        match (name, version) {
            ("$MeshFormat", _) => version = Some(read_version(&mut words)?),
            ("$Nodes" | "$Elements", None) => return Err(words.wrong(format!("{name} precedes $MeshFormat"))),
            ("$Nodes", Some(Version::Two)) => nodes.read_two(&mut words)?,
            ("$Nodes", Some(Version::Four)) => nodes.read_four(&mut words)?,
            ("$Elements", Some(version)) => {
                nodes.sort()?;
                let mut reader = ElementReader { nodes: &nodes, elements: &mut elements, corners: Vec::new() };
                match version {
                    Version::Two => reader.read_two(&mut words)?,
                    Version::Four => reader.read_four(&mut words)?,
                }
            }
            (name, Some(_)) if name.starts_with('$') => skip(&mut words, name)?,
            ("$Comments", None) => skip(&mut words, name)?,
            (_, None) => break,
            (name, Some(_)) => return Err(words.wrong(format!("'{name}' outside a section"))),
        }
    }
    if version.is_none() {
        return Err(malformed(FORMAT, "header", format!("does not begin with `$MeshFormat`; save it by {CONVERT}")));
    }
    elements.surface(&nodes.positions)
}

/// Reads the section `$MeshFormat` after its first line.
fn read_version(words: &mut Words) -> Result<Version, SurfaceError> {
    let version = words.word("version")?;
    let is_binary = words.number::<u8>("file type")? != 0;
    if is_binary {
        return Err(words.wrong(format!("the file is binary; save it as ASCII: {CONVERT}")));
    }
    let version = match version {
        "2" | "2.0" | "2.1" | "2.2" => Version::Two,
        "4.1" => Version::Four,
        _ => {
            let reason = format!("version '{version}' is not read; save the file in version 4.1: {CONVERT}");
            return Err(words.wrong(reason));
        }
    };
    words.number::<u8>("data size")?;
    close(words, "$MeshFormat")?;
    Ok(version)
}

/// Reads the end of a section.
fn close(words: &mut Words, section: &str) -> Result<(), SurfaceError> {
    let end = section.replacen('$', "$End", 1);
    let word = words.word(&end)?;
    if word == end { Ok(()) } else { Err(words.wrong(format!("'{word}' instead of {end}"))) }
}

/// Skips a section after its first line.
fn skip(words: &mut Words, section: &str) -> Result<(), SurfaceError> {
    let end = section.replacen('$', "$End", 1);
    while words.row(&end)?.next_word() != Some(end.as_str()) {}
    Ok(())
}

/// Nodes of a file, which names them by tags.
#[derive(Default)]
struct Nodes {
    positions: Vec<Point3<f64>>,
    tags: Vec<u64>,
    /// Tags in ascending order, with their nodes.
    sorted: Vec<(u64, u32)>,
}

impl Nodes {
    /// Reads the section `$Nodes` of version 2 after its first line.
    fn read_two(&mut self, words: &mut Words) -> Result<(), SurfaceError> {
        for _ in 0..words.count("nodes")? {
            let mut row = words.row("node")?;
            self.tags.push(row.number("node tag")?);
            self.positions.push(row.point(self.positions.len())?);
        }
        within_limit(self.positions.len())?;
        close(words, "$Nodes")
    }

    /// As [`Self::read_two`], of version 4.1. The coordinates of a block follow all its tags.
    fn read_four(&mut self, words: &mut Words) -> Result<(), SurfaceError> {
        let blocks = words.count("entity blocks")?;
        let total = self.positions.len() + words.count("nodes")?;
        words.rest_of_line();
        for _ in 0..blocks {
            for name in ["entity dimension", "entity tag", "parametric flag"] {
                words.number::<i64>(name)?;
            }
            let count = words.count("nodes")?;
            for _ in 0..count {
                self.tags.push(words.number("node tag")?);
            }
            for _ in 0..count {
                // Parameters on the entity may follow the coordinates.
                self.positions.push(words.row("node")?.point(self.positions.len())?);
            }
            within_limit(self.positions.len())?;
        }
        if self.positions.len() != total {
            return Err(words.wrong(format!("{} nodes instead of {total}", self.positions.len())));
        }
        close(words, "$Nodes")
    }

    /// Prepares [`Self::node`].
    fn sort(&mut self) -> Result<(), SurfaceError> {
        if self.sorted.len() == self.tags.len() {
            return Ok(());
        }
        self.sorted = self.tags.iter().copied().zip(0..).collect();
        self.sorted.sort_unstable();
        match self.sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(malformed(FORMAT, format!("node {}", pair[0].0), "is defined twice")),
            None => Ok(()),
        }
    }

    /// Node of a tag, counted from 0.
    fn node(&self, tag: u64) -> Option<u32> {
        // Most files count their nodes from 1.
        let guess = usize::try_from(tag.wrapping_sub(1)).ok().and_then(|index| self.sorted.get(index));
        let found = guess.filter(|(own, _)| *own == tag).or_else(|| {
            let index = self.sorted.binary_search_by_key(&tag, |(own, _)| *own).ok()?;
            self.sorted.get(index)
        });
        found.map(|(_, node)| *node)
    }
}

/// Reader of the section `$Elements`, one element per line.
struct ElementReader<'a> {
    nodes: &'a Nodes,
    elements: &'a mut Elements,
    /// Nodes of the present element.
    corners: Vec<u32>,
}

impl ElementReader<'_> {
    /// Reads the section of version 2 after its first line.
    fn read_two(&mut self, words: &mut Words) -> Result<(), SurfaceError> {
        for _ in 0..words.count("elements")? {
            let mut row = words.row("element")?;
            row.number::<u64>("element tag")?;
            let kind = kind(row.number("element type")?);
            for _ in 0..row.number::<usize>("number of tags")? {
                row.number::<i64>("tag")?;
            }
            self.push(&kind, row)?;
        }
        close(words, "$Elements")
    }

    /// As [`Self::read_two`], of version 4.1.
    fn read_four(&mut self, words: &mut Words) -> Result<(), SurfaceError> {
        let blocks = words.count("entity blocks")?;
        let total = words.count("elements")?;
        words.rest_of_line();
        let mut read = 0;
        for _ in 0..blocks {
            words.number::<i64>("entity dimension")?;
            words.number::<i64>("entity tag")?;
            let kind = kind(words.number("element type")?);
            let count = words.count("elements")?;
            for _ in 0..count {
                let mut row = words.row("element")?;
                row.number::<u64>("element tag")?;
                self.push(&kind, row)?;
            }
            read += count;
        }
        if read != total {
            return Err(words.wrong(format!("{read} elements instead of {total}")));
        }
        close(words, "$Elements")
    }

    /// Appends an element, whose nodes are the rest of its line.
    fn push(&mut self, kind: &Kind, mut row: Words) -> Result<(), SurfaceError> {
        self.corners.clear();
        if kind.has_corners() {
            while let Some(word) = row.next_word() {
                let node = word.parse().ok().and_then(|tag| self.nodes.node(tag));
                let unknown =
                    || row.wrong(format!("an element refers to node '{word}', which the file does not define"));
                self.corners.push(node.ok_or_else(unknown)?);
            }
        }
        self.elements.push(kind, &self.corners, row.line())
    }
}

/// Kind of an element type of Gmsh.
fn kind(number: u64) -> Kind {
    let solid = |name: &str| Kind::Solid(format!("{name} (type {number})"));
    match number {
        1 | 8 | 15 | 26..=28 | 62..=66 => Kind::Ignored,
        2 => Kind::Triangle,
        3 => Kind::Face("a quadrilateral (type 3)"),
        4 => Kind::Tetrahedron,
        5 => solid("a hexahedron"),
        6 => solid("a prism"),
        7 => solid("a pyramid"),
        9 => Kind::Face("a second-order triangle (type 9)"),
        10 | 16 => Kind::Face("a second-order quadrilateral"),
        11 => solid("a second-order tetrahedron"),
        12 | 17 => solid("a second-order hexahedron"),
        13 | 18 => solid("a second-order prism"),
        14 | 19 => solid("a second-order pyramid"),
        20..=25 => Kind::Face("a triangle of higher order"),
        29..=31 => solid("a tetrahedron of higher order"),
        _ => solid("an element of another type"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tetrahedral::tests::{CELLS, CUBE, check_cube};
    use super::*;

    /// Cube in version 2: a point, a line, two triangles of the boundary, and the tetrahedra, one of them twice.
    fn two() -> String {
        let nodes: String = CUBE.iter().enumerate().map(|(k, [x, y, z])| format!("{} {x} {y} {z}\n", k + 1)).collect();
        let first = "1 15 2 0 1 1\n2 1 2 0 1 1 2\n3 2 2 0 1 1 2 4\n4 2 2 0 1 1 4 3\n".to_owned();
        let cell = |k: usize| {
            let [a, b, c, d] = CELLS[k % 6].map(|vertex| vertex + 1);
            format!("{} 4 2 {k} 1 {a} {b} {c} {d}\n", k + 5)
        };
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"a cube\"\n$EndPhysicalNames\n\
             $Nodes\n8\n{nodes}$EndNodes\n$Elements\n11\n{}$EndElements\n",
            first + &(0..7).map(cell).collect::<String>()
        )
    }

    /// Cube in version 4.1, with sparse tags in two blocks, and parameters of some nodes.
    fn four() -> String {
        let tags = |range: std::ops::Range<usize>| range.map(|k| format!("{}\n", 100 - 7 * k)).collect::<String>();
        let row =
            |k: usize| format!("{} {} {}{}\n", CUBE[k][0], CUBE[k][1], CUBE[k][2], if k < 4 { " 0.5 0" } else { "" });
        let rows = |range: std::ops::Range<usize>| range.map(row).collect::<String>();
        let cells: String = CELLS
            .iter()
            .enumerate()
            .map(|(k, cell)| format!("{} {}\n", k + 3, cell.map(|vertex| (100 - 7 * vertex).to_string()).join(" ")))
            .collect();
        format!(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 0 0\n$EndEntities\n\
             $Nodes\n2 8 51 100\n2 1 1 4\n{}{}3 1 0 4\n{}{}$EndNodes\n\
             $Elements\n3 8 1 8\n0 1 15 1\n1 100\n2 1 2 1\n2 100 93 86\n3 1 4 6\n{cells}$EndElements\n",
            tags(0..4),
            rows(0..4),
            tags(4..8),
            rows(4..8)
        )
    }

    fn check(text: &str, start: &str) {
        let message = parse(text.as_bytes()).unwrap_err().to_string();
        assert!(message.starts_with(start), "{message}");
    }

    #[test]
    fn both_versions_are_read() {
        for text in [two(), two().replace('\n', "\r\n"), two().replacen("2.2 0", "2 0", 1), four()] {
            check_cube(&parse(text.as_bytes()).unwrap());
        }
        let comment = format!("$Comments\nany text\n$EndComments\n{}", four());
        check_cube(&parse(comment.as_bytes()).unwrap());
    }

    #[test]
    fn a_file_of_triangles_is_a_surface() {
        let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n9 1 1 1\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n\
            $Elements\n1\n1 2 0 1 3 2\n$EndElements\n";
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!((mesh.positions_m.len(), mesh.triangles), (3, vec![[0, 2, 1]]));
        check(&text.replace("1 2 0 1 3 2", "1 3 0 1 2 3 9"), "malformed msh, line 13: a quadrilateral (type 3) cannot");
    }

    #[test]
    fn binary_files_and_other_versions_are_refused() {
        check(
            &four().replacen("4.1 0", "4.1 1", 1),
            "malformed msh, line 2: the file is binary; save it as ASCII: `gmsh",
        );
        check(&four().replacen("4.1 0", "4 0", 1), "malformed msh, line 2: version '4' is not read; save the file in");
        check("$NOD\n1\n", "malformed msh, header: does not begin with `$MeshFormat`");
        check("", "malformed msh, header");
        check("$Nodes\n", "malformed msh, line 1: $Nodes precedes $MeshFormat");
        let message = parse(b"$MeshFormat\n4.1 1 8\n\x01\0\0\0").unwrap_err().to_string();
        assert!(message.ends_with("-o ASCII.msh`"), "the command is not cut: {message}");
    }

    #[test]
    fn other_solids_are_refused_by_name() {
        let line = |text: &str, part: &str| text.lines().position(|line| line.contains(part)).unwrap() + 1;
        for (number, name) in
            [(5, "a hexahedron"), (6, "a prism"), (7, "a pyramid"), (11, "a second-order tetrahedron")]
        {
            let text = four().replacen("\n3 1 4 6\n", &format!("\n3 1 {number} 6\n"), 1);
            let at = line(&text, &format!("3 1 {number} 6")) + 1;
            check(&text, &format!("malformed msh, line {at}: {name} (type {number}) cannot be read; convert the mesh"));
            let text = two().replacen("7 4 2", &format!("7 {number} 2"), 1);
            let at = line(&text, &format!("7 {number} 2"));
            check(&text, &format!("malformed msh, line {at}: {name} (type {number})"));
        }
    }

    #[test]
    fn errors_name_the_line() {
        for (from, to, start) in [
            ("1 0 0 0\n", "1 0 zero 0\n", "malformed msh, line 10: 'zero' is not a valid coordinate"),
            ("1 0 0 0\n", "1 0 nan 0\n", "vertex 0, counted from 0, in line 10 has"),
            ("1 0 0 0\n", "1 0 0\n", "malformed msh, line 10: the line ends before the coordinate"),
            ("1 0 0 0\n", "2 0 0 0\n", "malformed msh, node 2: is defined twice"),
            ("$Nodes\n8", "$Nodes\n7", "malformed msh, line 17: '8' instead of $EndNodes"),
            ("$Nodes\n8", "$Nodes\n4000000000000000000", "malformed msh, line 9: 4000000000000000000 nodes are"),
            ("$Nodes\n8", "$Nodes\n-8", "malformed msh, line 9: '-8' is not a valid number of nodes"),
            ("5 4 2 0 1 1 2 4 8", "5 4 2 0 1 1 2 4 9", "malformed msh, line 25: an element refers to node '9'"),
            ("5 4 2 0 1 1 2 4 8", "5 4 2 0 1 1 2 4 x", "malformed msh, line 25: an element refers to node 'x'"),
            ("5 4 2 0 1 1 2 4 8", "5 4 2 0 1 1 2 4", "malformed msh, line 25: a tetrahedron has 4 vertices, not 3"),
            ("5 4 2 0 1 1 2 4 8", "5 4 999999999999 0 1 1", "malformed msh, line 25: the line ends before the tag"),
            ("9 4 2 4 1 1 5 6 8", "9 4 2 4 1 1 2 8 5", "malformed msh, line 29: 3 tetrahedra, of lines 25, 26, 29"),
            ("$EndElements", "", "malformed msh, line 31: the file ends before the $EndElements"),
            ("$EndElements\n", "$EndElements\nmore\n", "malformed msh, line 33: 'more' outside a section"),
            ("$EndPhysicalNames", "", "malformed msh, line 32: the file ends before the $EndPhysicalNames"),
        ] {
            let text = two();
            assert!(text.contains(from), "{from}");
            check(&text.replacen(from, to, 1), start);
        }
        for (from, to, start) in [
            ("2 8 51 100", "2 9 51 100", "malformed msh, line 27: 8 nodes instead of 9"),
            ("3 8 1 8", "3 9 1 8", "malformed msh, line 41: 8 elements instead of 9"),
            ("3 1 4 6\n", "3 1 4 7\n", "malformed msh, line 42: '$EndElements' is not a valid element tag"),
        ] {
            let text = four();
            assert!(text.contains(from), "{from}");
            check(&text.replacen(from, to, 1), start);
        }
    }
}
