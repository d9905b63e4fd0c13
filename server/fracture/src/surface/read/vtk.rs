//! Reader of legacy VTK files, ASCII, with an unstructured grid: cells as lists of vertices, or as offsets and connectivity.
//!
//! Source: VTK documentation, "VTK File Formats", simple legacy formats, versions 1.0 to 5.1.

use super::common::{malformed, within_limit};
use super::tetrahedral::{Elements, Kind};
use super::words::Words;
use crate::surface::{RawMesh, SurfaceError};
use nalgebra::Point3;

/// Name of the format in errors.
const FORMAT: &str = "vtk";

/// First words of a file.
pub(super) const MAGIC: &str = "# vtk DataFile";

/// Parses a file.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let text = String::from_utf8_lossy(bytes);
    let mut words = Words::new(FORMAT, &text);
    read_header(&mut words)?;
    let mut grid = Grid::default();
    while let Some(word) = words.next_word() {
        match word.to_ascii_uppercase().as_str() {
            "POINTS" => grid.read_points(&mut words)?,
            "CELLS" => grid.read_cells(&mut words)?,
            "CELL_TYPES" => grid.read_types(&mut words)?,
            // The grid precedes its data.
            "CELL_DATA" | "POINT_DATA" => break,
            _ => {
                words.rest_of_line();
            }
        }
    }
    grid.surface()
}

/// Reads the lines before the grid. The second line is any text.
fn read_header(words: &mut Words) -> Result<(), SurfaceError> {
    let begins = words.next_row().is_some_and(|mut row| {
        let start = row.rest_of_line();
        start.get(..MAGIC.len()).is_some_and(|start| start.eq_ignore_ascii_case(MAGIC))
    });
    if !begins {
        let reason = "does not begin with `# vtk DataFile`; export the mesh as a legacy VTK file, ASCII";
        return Err(malformed(FORMAT, "header", reason));
    }
    words.skip_next_line();
    let encoding = words.word("encoding")?;
    if encoding.eq_ignore_ascii_case("BINARY") {
        let reason = "the file is binary; save it as ASCII: in ParaView by Save Data with file type ASCII, \
                      or by `meshio ascii FILE.vtk`";
        return Err(words.wrong(reason));
    }
    if !encoding.eq_ignore_ascii_case("ASCII") {
        return Err(words.wrong(format!("'{encoding}' instead of ASCII")));
    }
    let word = words.word("DATASET")?;
    if !word.eq_ignore_ascii_case("DATASET") {
        return Err(words.wrong(format!("'{word}' instead of DATASET")));
    }
    let dataset = words.word("kind of dataset")?;
    if !dataset.eq_ignore_ascii_case("UNSTRUCTURED_GRID") {
        let reason = format!("the dataset is '{dataset}'; only UNSTRUCTURED_GRID is read: convert the mesh to it");
        return Err(words.wrong(reason));
    }
    Ok(())
}

/// Points and cells of a file.
#[derive(Default)]
struct Grid {
    positions: Vec<Point3<f64>>,
    /// Vertices of all cells.
    connectivity: Vec<u32>,
    /// Start of each cell in `connectivity`, and the end of the last.
    offsets: Vec<usize>,
    types: Vec<u64>,
}

impl Grid {
    /// Reads the points, after the keyword.
    fn read_points(&mut self, words: &mut Words) -> Result<(), SurfaceError> {
        let count = words.count("points")?;
        words.word("data type")?;
        self.positions.clear();
        for vertex in 0..count {
            self.positions.push(words.point(vertex)?);
        }
        Ok(())
    }

    /// Reads the vertices of the cells in either layout, after the keyword.
    fn read_cells(&mut self, words: &mut Words) -> Result<(), SurfaceError> {
        let count = words.count("cells")?;
        let size = words.number::<usize>("number of integers")?;
        self.connectivity.clear();
        self.offsets.clear();
        let mut ahead = *words;
        if ahead.next_word().is_some_and(|word| word.eq_ignore_ascii_case("OFFSETS")) {
            *words = ahead;
            return self.read_offsets(words, (count, size));
        }
        self.offsets.push(0);
        for _ in 0..count {
            let corners = words.number::<usize>("number of vertices")?;
            for _ in 0..corners {
                self.connectivity.push(words.number("vertex")?);
            }
            self.offsets.push(self.connectivity.len());
        }
        let found = self.connectivity.len() + count;
        if found != size {
            return Err(words.wrong(format!("the cells have {found} integers instead of {size}")));
        }
        Ok(())
    }

    /// Reads offsets and connectivity, after the first keyword.
    fn read_offsets(&mut self, words: &mut Words, (count, size): (usize, usize)) -> Result<(), SurfaceError> {
        words.word("data type")?;
        for _ in 0..count {
            self.offsets.push(words.number("offset")?);
        }
        let word = words.word("CONNECTIVITY")?;
        if !word.eq_ignore_ascii_case("CONNECTIVITY") {
            return Err(words.wrong(format!("'{word}' instead of CONNECTIVITY")));
        }
        words.word("data type")?;
        for _ in 0..size {
            self.connectivity.push(words.number("vertex")?);
        }
        Ok(())
    }

    /// Reads the types of the cells, after the keyword.
    fn read_types(&mut self, words: &mut Words) -> Result<(), SurfaceError> {
        let count = words.count("cell types")?;
        self.types.clear();
        for _ in 0..count {
            self.types.push(words.number("cell type")?);
        }
        Ok(())
    }

    fn surface(self) -> Result<RawMesh, SurfaceError> {
        let cells = self.offsets.len().saturating_sub(1);
        within_limit(cells)?;
        if cells != self.types.len() {
            let reason =
                format!("{} types of {cells} cells: the file is incomplete; export it again", self.types.len());
            return Err(malformed(FORMAT, "CELL_TYPES", reason));
        }
        let mut elements = Elements::new(FORMAT, "cell", 0);
        for (cell, (&number, ends)) in self.types.iter().zip(self.offsets.windows(2)).enumerate() {
            let Some(corners) = self.connectivity.get(ends[0]..ends[1]) else {
                let reason = format!(
                    "offsets {} to {}, with {} vertices of all cells",
                    ends[0],
                    ends[1],
                    self.connectivity.len()
                );
                return Err(malformed(FORMAT, format!("cell {cell}"), reason));
            };
            elements.push(&kind(number), corners, cell)?;
        }
        elements.surface(&self.positions)
    }
}

/// Kind of a cell type of VTK.
fn kind(number: u64) -> Kind {
    let solid = |name: &str| Kind::Solid(format!("{name} (type {number})"));
    match number {
        0..=4 | 21 | 35 | 68 | 75 => Kind::Ignored,
        5 => Kind::Triangle,
        6 => Kind::Face("a triangle strip (type 6)"),
        7 => Kind::Face("a polygon (type 7)"),
        8 => Kind::Face("a pixel (type 8)"),
        9 => Kind::Face("a quadrilateral (type 9)"),
        10 => Kind::Tetrahedron,
        11 => solid("a voxel"),
        12 => solid("a hexahedron"),
        13 => solid("a prism"),
        14 => solid("a pyramid"),
        22 => Kind::Face("a second-order triangle (type 22)"),
        23 | 28 | 30 | 34 | 36 | 69 | 70 | 76 | 77 => Kind::Face("a face of higher order"),
        24 => solid("a second-order tetrahedron"),
        25 | 29 | 33 => solid("a second-order hexahedron"),
        26 | 31 | 32 => solid("a second-order prism"),
        27 | 37 => solid("a second-order pyramid"),
        71 | 78 => solid("a tetrahedron of higher order"),
        _ => solid("a cell of another type"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tetrahedral::tests::{CELLS, CUBE, check_cube};
    use super::*;

    fn header(version: &str) -> String {
        let points = CUBE.map(|[x, y, z]| format!("{x} {y} {z}"));
        format!(
            "# vtk DataFile Version {version}\nPOINTS of a cube\nASCII\nDATASET UNSTRUCTURED_GRID\n\
             FIELD FieldData 1\nTIME 1 1 double\n0.5\nPOINTS 8 double\n{}  {}\n{}\n\n",
            points[..3].join(" "),
            points[3..5].join(" "),
            points[5..].join("\n")
        )
    }

    /// Cube with a line and a triangle before the tetrahedra, one list of vertices per cell.
    fn classic() -> String {
        let cells = CELLS.map(|cell| format!("4 {}\n", cell.map(|vertex| vertex.to_string()).join(" "))).concat();
        let types = "10\n".repeat(6);
        let header = header("3.0");
        format!(
            "{header}CELLS 8 37\n2 0 1\n3 0 1 2\n{cells}\nCELL_TYPES 8\n3\n5\n{types}\nCELL_DATA 8\nSCALARS a int\n"
        )
    }

    /// The same in the layout of version 5.1.
    fn offsets() -> String {
        let cells = CELLS.as_flattened().iter().map(|vertex| vertex.to_string()).collect::<Vec<_>>().join(" ");
        format!(
            "{}METADATA\nINFORMATION 0\n\nCELLS 9 29\nOFFSETS vtktypeint64\n0 2 5 9 13 17 21 25\n29\n\
             CONNECTIVITY vtktypeint64\n0 1 0 1 2 {cells}\nCELL_TYPES 8\n3 5 10 10 10 10 10 10\n",
            header("5.1")
        )
    }

    fn check(text: &str, start: &str) {
        let message = parse(text.as_bytes()).unwrap_err().to_string();
        assert!(message.starts_with(start), "{message}");
    }

    #[test]
    fn both_layouts_are_read() {
        for text in [classic(), classic().replace('\n', "\r\n"), classic().replace("POINTS of a cube", ""), offsets()] {
            check_cube(&parse(text.as_bytes()).unwrap());
        }
    }

    #[test]
    fn a_file_of_triangles_is_a_surface() {
        let text = format!("{}CELLS 2 6\n1 3\n3 7 2 1\nCELL_TYPES 2\n1\n5\n", header("2.0"));
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!((mesh.positions_m.len(), mesh.triangles), (3, vec![[2, 1, 0]]));
        check(
            &text.replace("\n5\n", "\n9\n"),
            "malformed vtk, cell 1: a quadrilateral (type 9) cannot be read; convert",
        );
    }

    #[test]
    fn other_files_are_refused() {
        check("", "malformed vtk, header: does not begin with `# vtk DataFile`");
        let binary = classic().replacen("ASCII", "BINARY", 1);
        check(&binary, "malformed vtk, line 3: the file is binary; save it as ASCII");
        check(&classic().replacen("ASCII", "text", 1), "malformed vtk, line 3: 'text' instead of ASCII");
        let data = classic().replacen("UNSTRUCTURED_GRID", "POLYDATA", 1);
        check(&data, "malformed vtk, line 4: the dataset is 'POLYDATA'; only UNSTRUCTURED_GRID is read");
        for (number, name) in
            [(12, "a hexahedron"), (13, "a prism"), (14, "a pyramid"), (24, "a second-order tetrahedron")]
        {
            let text = classic().replacen("5\n10\n", &format!("5\n{number}\n"), 1);
            check(&text, &format!("malformed vtk, cell 2: {name} (type {number}) cannot be read; convert the mesh"));
        }
    }

    #[test]
    fn errors_name_the_place() {
        for (from, to, start) in [
            ("POINTS 8", "POINTS 9", "malformed vtk, line 14: 'CELLS' is not a valid coordinate"),
            ("POINTS 8", "POINTS 90000000000", "malformed vtk, line 8: 90000000000 points are announced"),
            ("1 1 1\n\n", "1 1 nan\n\n", "vertex 7, counted from 0, in line 12 has"),
            ("1 1 1\n\n", "1 1 -1e999\n\n", "vertex 7, counted from 0, in line 12 has"),
            ("4 0 1 3 7\n", "4 0 1 3 8\n", "malformed vtk, cell 2: an element refers to vertex 8, counted from 0"),
            ("4 0 1 3 7\n", "4 0 1 3 -1\n", "malformed vtk, line 17: '-1' is not a valid vertex"),
            ("4 0 1 3 7\n", "3 0 1 3\n", "malformed vtk, line 22: the cells have 36 integers instead of 37"),
            ("4 0 4 5 7\n", "4 0 1 7 4\n", "malformed vtk, cell 6: 3 tetrahedra, of cells 2, 3, 6, share one triangle"),
            ("CELL_TYPES 8", "CELL_TYPES 7", "malformed vtk, CELL_TYPES: 7 types of 8 cells"),
        ] {
            let text = classic();
            assert!(text.contains(from), "{from}");
            check(&text.replacen(from, to, 1), start);
        }
        for (from, to, start) in [
            ("5 9 13", "5 4 13", "malformed vtk, cell 2: offsets 5 to 4, with 29 vertices of all cells"),
            ("25\n29\n", "25\n30\n", "malformed vtk, cell 7: offsets 25 to 30"),
            ("CONNECTIVITY", "OTHER", "malformed vtk, line 21: 'OTHER' instead of CONNECTIVITY"),
            ("0 2 5 9", "0 3 6 9", "malformed vtk, cell 2: a tetrahedron has 4 vertices, not 3"),
            ("CELLS 9 29", "CELLS 9 290", "malformed vtk, line 23: 'CELL_TYPES' is not a valid vertex"),
        ] {
            let text = offsets();
            assert!(text.contains(from), "{from}");
            check(&text.replacen(from, to, 1), start);
        }
        let cut = offsets();
        let cut = &cut[..cut.find("CELL_TYPES").unwrap()];
        check(cut, "malformed vtk, CELL_TYPES: 0 types of 8 cells: the file is incomplete");
    }
}
