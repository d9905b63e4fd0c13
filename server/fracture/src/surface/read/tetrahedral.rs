//! Boundary of a tetrahedral mesh, the surface that is read from volume meshes.

use super::common::{malformed, within_limit};
use crate::surface::{RawMesh, SurfaceError};
use nalgebra::Point3;
use robust::{Coord3D, orient3d};

/// Faces of a tetrahedron of positive volume, outward.
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// Kind of an element.
pub(super) enum Kind {
    /// Linear tetrahedron.
    Tetrahedron,
    /// Linear triangle.
    Triangle,
    /// Point or line.
    Ignored,
    /// Other face, by name. Ignored if the file has tetrahedra.
    Face(&'static str),
    /// Other solid element, by name. Refused.
    Solid(String),
}

impl Kind {
    /// Returns true if the vertices of such elements are needed.
    pub fn has_corners(&self) -> bool {
        matches!(self, Self::Tetrahedron | Self::Triangle)
    }
}

/// Element with the number of its line or cell.
struct Element<const N: usize> {
    corners: [u32; N],
    place: usize,
}

/// Elements of a file.
pub(super) struct Elements {
    format: &'static str,
    /// Kind of place that errors name: `line` or `cell`.
    places: &'static str,
    /// Number of the first vertex in the file: 0 or 1.
    first: u32,
    tetrahedra: Vec<Element<4>>,
    triangles: Vec<Element<3>>,
    /// Place and name of the first face that is no triangle.
    face: Option<(usize, &'static str)>,
}

impl Elements {
    /// Creates an empty list. The file counts its vertices from `first`.
    pub fn new(format: &'static str, places: &'static str, first: u32) -> Self {
        Self { format, places, first, tetrahedra: Vec::new(), triangles: Vec::new(), face: None }
    }

    /// Appends an element of the file. Corners are counted from 0 and may refer to vertices defined later.
    pub fn push(&mut self, kind: &Kind, corners: &[u32], place: usize) -> Result<(), SurfaceError> {
        match kind {
            Kind::Tetrahedron => {
                let corners: [u32; 4] = self.exactly(corners, "tetrahedron", place)?;
                if (1..4).any(|k| corners[..k].contains(&corners[k])) {
                    return Err(self.wrong(place, "a tetrahedron names one vertex twice"));
                }
                self.tetrahedra.push(Element { corners, place });
                within_limit(self.tetrahedra.len())?;
            }
            Kind::Triangle => {
                let corners = self.exactly(corners, "triangle", place)?;
                self.triangles.push(Element { corners, place });
                within_limit(self.triangles.len())?;
            }
            Kind::Ignored => {}
            Kind::Face(name) => self.face = self.face.or(Some((place, *name))),
            Kind::Solid(name) => {
                let reason = format!("{name} cannot be read; convert the mesh to linear tetrahedra");
                return Err(self.wrong(place, reason));
            }
        }
        Ok(())
    }

    /// Surface of the file: the boundary of its tetrahedra, or its triangles if it has no tetrahedron.
    pub fn surface(self, positions: &[Point3<f64>]) -> Result<RawMesh, SurfaceError> {
        within_limit(positions.len())?;
        self.check_range(&self.tetrahedra, positions.len())?;
        self.check_range(&self.triangles, positions.len())?;
        let triangles = match self.face {
            Some((place, name)) if self.tetrahedra.is_empty() => {
                let reason = format!("{name} cannot be read; convert the mesh to linear tetrahedra or triangles");
                return Err(self.wrong(place, reason));
            }
            _ if self.tetrahedra.is_empty() => self.triangles.iter().map(|triangle| triangle.corners).collect(),
            _ => self.boundary(positions)?,
        };
        within_limit(triangles.len())?;
        Ok(compact(positions, triangles))
    }

    /// Triangles of exactly one tetrahedron, outward, in the order of the file.
    fn boundary(&self, positions: &[Point3<f64>]) -> Result<Vec<[u32; 3]>, SurfaceError> {
        let mut faces = Vec::with_capacity(4 * self.tetrahedra.len());
        for (element, tetrahedron) in self.tetrahedra.iter().enumerate() {
            for (opposite, face) in [3, 2, 0, 1].into_iter().zip(FACES) {
                let mut key = face.map(|corner| tetrahedron.corners[corner]);
                key.sort_unstable();
                faces.push((key, tetrahedron.corners[opposite], element as u32));
            }
        }
        faces.sort_unstable();
        // Gmsh writes an element once for each of its physical groups.
        faces.dedup_by_key(|&mut (key, opposite, _)| (key, opposite));
        let mut outer = Vec::new();
        for sharing in faces.chunk_by(|(a, ..), (b, ..)| a == b) {
            match sharing {
                [(_, opposite, element)] => outer.push((*element, *opposite)),
                [_, _] => {}
                _ => return Err(self.shared(sharing.iter().map(|(.., element)| *element))),
            }
        }
        outer.sort_unstable();
        let mut triangles = Vec::with_capacity(outer.len());
        for owned in outer.chunk_by(|(a, _), (b, _)| a == b) {
            let corners = oriented(self.tetrahedra[owned[0].0 as usize].corners, positions);
            for face in FACES.map(|face| face.map(|corner| corners[corner])) {
                if owned.iter().any(|(_, opposite)| !face.contains(opposite)) {
                    triangles.push(face);
                }
            }
        }
        Ok(triangles)
    }

    /// Error for a triangle that three or more tetrahedra share.
    fn shared(&self, elements: impl Iterator<Item = u32>) -> SurfaceError {
        let mut places: Vec<usize> = elements.map(|element| self.tetrahedra[element as usize].place).collect();
        places.sort_unstable();
        let (count, shown) = (places.len(), &places[..places.len().min(4)]);
        let shown = shown.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let reason = format!(
            "{count} tetrahedra, of {}s {shown}, share one triangle, and two at most may; remove tetrahedra that overlap",
            self.places
        );
        self.wrong(places.last().copied().unwrap_or_default(), reason)
    }

    fn check_range<const N: usize>(&self, elements: &[Element<N>], vertices: usize) -> Result<(), SurfaceError> {
        for element in elements {
            if let Some(&corner) = element.corners.iter().find(|&&corner| corner as usize >= vertices) {
                let index = u64::from(corner) + u64::from(self.first);
                let reason = format!(
                    "an element refers to vertex {index}, counted from {}, but the file has {vertices} vertices",
                    self.first
                );
                return Err(self.wrong(element.place, reason));
            }
        }
        Ok(())
    }

    fn exactly<const N: usize>(&self, corners: &[u32], name: &str, place: usize) -> Result<[u32; N], SurfaceError> {
        let wrong = |_| self.wrong(place, format!("a {name} has {N} vertices, not {}", corners.len()));
        corners.try_into().map_err(wrong)
    }

    fn wrong(&self, place: usize, reason: impl std::fmt::Display) -> SurfaceError {
        malformed(self.format, format!("{} {place}", self.places), reason)
    }
}

/// Corners of a tetrahedron, turned if its volume is negative.
fn oriented([a, b, c, d]: [u32; 4], positions: &[Point3<f64>]) -> [u32; 4] {
    let at = |corner: u32| {
        let [x, y, z] = positions[corner as usize].coords.into();
        Coord3D { x, y, z }
    };
    // The predicate is positive below the plane of the first three points, and negative for a positive volume.
    if orient3d(at(a), at(b), at(c), at(d)) > 0.0 { [a, c, b, d] } else { [a, b, c, d] }
}

/// Mesh with the vertices that the triangles use, in the order of the file. Without triangles, it keeps all.
fn compact(positions: &[Point3<f64>], mut triangles: Vec<[u32; 3]>) -> RawMesh {
    if triangles.is_empty() {
        return RawMesh::new(positions.to_vec(), triangles);
    }
    let mut is_used = vec![false; positions.len()];
    triangles.as_flattened().iter().for_each(|&corner| is_used[corner as usize] = true);
    let mut kept = Vec::new();
    let mut numbers = vec![0; positions.len()];
    for (vertex, position) in positions.iter().enumerate().filter(|(vertex, _)| is_used[*vertex]) {
        numbers[vertex] = kept.len() as u32;
        kept.push(*position);
    }
    triangles.as_flattened_mut().iter_mut().for_each(|corner| *corner = numbers[*corner as usize]);
    RawMesh::new(kept, triangles)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::surface::Surface;

    /// Corners of a unit cube.
    pub const CUBE: [[f64; 3]; 8] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
        [1.0, 1.0, 1.0],
    ];

    /// Six tetrahedra around the diagonal of the cube. Three have a negative volume.
    pub const CELLS: [[u32; 4]; 6] =
        [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];

    /// Checks that the mesh is the unit cube of 12 triangles, closed and outward.
    pub fn check_cube(mesh: &RawMesh) {
        assert_eq!((mesh.positions_m.as_slice(), mesh.triangles.len()), (&CUBE.map(Point3::from)[..], 12));
        assert!(mesh.faces.is_empty() && mesh.attributes == Default::default());
        for &[a, b, c] in &mesh.triangles {
            let [p, q, r] = [a, b, c].map(|vertex| mesh.positions_m[vertex as usize]);
            let outward = p + (q - p) / 3.0 + (r - p) / 3.0 - Point3::new(0.5, 0.5, 0.5);
            assert!((q - p).cross(&(r - p)).dot(&outward) > 0.0, "{a} {b} {c}");
        }
        let surface = Surface::repair(mesh.clone()).unwrap();
        assert!(surface.closed && surface.defects.is_empty(), "{:?}", surface.defects);
        assert!((surface.signed_volume() * surface.frame.diagonal_m.powi(3) - 1.0).abs() < 1e-12);
    }

    fn cells(cells: &[[u32; 4]]) -> Elements {
        let mut elements = Elements::new("vtk", "cell", 0);
        for (place, corners) in cells.iter().enumerate() {
            elements.push(&Kind::Tetrahedron, corners, place).unwrap();
        }
        elements
    }

    fn message(result: Result<RawMesh, SurfaceError>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn the_boundary_is_closed_and_outward() {
        let positions = CUBE.map(Point3::from);
        check_cube(&cells(&CELLS).surface(&positions).unwrap());
        let turned = CELLS.map(|[a, b, c, d]| [b, a, c, d]);
        check_cube(&cells(&turned).surface(&positions).unwrap());
        let twice = [CELLS, CELLS].concat();
        check_cube(&cells(&twice).surface(&positions).unwrap());
    }

    #[test]
    fn interior_and_unused_vertices_are_dropped() {
        let center = Point3::new(0.25, 0.25, 0.25);
        let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
        let star = cells(&[[1, 3, 4, 5], [0, 1, 4, 5], [1, 0, 3, 5], [0, 3, 4, 1]]);
        let mesh = star.surface(&[o, center, center, x, y, z]).unwrap();
        assert_eq!((mesh.positions_m, mesh.triangles.len()), (vec![o, x, y, z], 4));
    }

    #[test]
    fn faces_count_only_without_tetrahedra() {
        let positions = CUBE.map(Point3::from);
        let mut elements = cells(&CELLS);
        elements.push(&Kind::Face("a quadrilateral"), &[], 6).unwrap();
        elements.push(&Kind::Triangle, &[0, 1, 2], 7).unwrap();
        elements.push(&Kind::Ignored, &[], 8).unwrap();
        check_cube(&elements.surface(&positions).unwrap());
        let mut elements = cells(&[]);
        elements.push(&Kind::Triangle, &[2, 1, 7], 7).unwrap();
        let mesh = elements.surface(&positions).unwrap();
        assert_eq!(mesh.positions_m, [CUBE[1], CUBE[2], CUBE[7]].map(Point3::from));
        assert_eq!(mesh.triangles, [[1, 0, 2]]);
        let mut elements = cells(&[]);
        elements.push(&Kind::Face("a quadrilateral"), &[], 6).unwrap();
        let found = message(elements.surface(&positions));
        assert!(found.starts_with("malformed vtk, cell 6: a quadrilateral cannot be read; convert"), "{found}");
        let none = cells(&[]).surface(&positions).unwrap();
        assert_eq!((none.positions_m.len(), none.triangles.len()), (8, 0));
    }

    #[test]
    fn errors_name_the_element() {
        let positions = CUBE.map(Point3::from);
        let found = message(cells(&[[0, 1, 2, 4], [0, 1, 2, 5], [3, 5, 6, 7], [0, 1, 2, 6]]).surface(&positions));
        assert!(found.starts_with("malformed vtk, cell 3: 3 tetrahedra, of cells 0, 1, 3, share"), "{found}");
        let found = message(cells(&[[0, 1, 2, 4], [0, 1, 2, 8]]).surface(&positions));
        assert!(found.starts_with("malformed vtk, cell 1: an element refers to vertex 8, counted from 0"), "{found}");
        let mut elements = Elements::new("msh", "line", 1);
        for (kind, corners, part) in [
            (Kind::Tetrahedron, &[0, 1, 2][..], "line 5: a tetrahedron has 4 vertices, not 3"),
            (Kind::Tetrahedron, &[0, 1, 2, 1], "line 5: a tetrahedron names one vertex twice"),
            (Kind::Triangle, &[0, 1, 2, 3], "line 5: a triangle has 3 vertices, not 4"),
            (Kind::Solid("a prism".to_owned()), &[], "line 5: a prism cannot be read; convert the mesh to linear"),
        ] {
            let found = elements.push(&kind, corners, 5).unwrap_err().to_string();
            assert!(found.contains(part), "{found}");
        }
    }
}
