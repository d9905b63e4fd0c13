//! Surface of one fragment of an earlier labeling, as separate triangles, without a tessellation of the body.

use super::EarlierCracks;
use super::Topology;
use super::pattern::{FACE_CODE, PATTERNS, PolygonSplit, TET_CODE, mask};
use crate::lattice::{EDGES, Lattice};
use nalgebra::Point3;

/// The triangles of fragment `label`, outward, cracks before outer faces.
///
/// The diagonals of crack quadrilaterals can be other ones than those of the fragment's mesh.
pub fn fragment_faces(
    lattice: &Lattice,
    topology: &Topology,
    old: EarlierCracks<'_>,
    label: u32,
) -> Vec<[Point3<f64>; 3]> {
    let fragment = Fragment { lattice, topology, old, label };
    let mut triangles = Vec::new();
    (0..lattice.tets.len()).for_each(|tet| fragment.cracks(tet, &mut triangles));
    (0..topology.boundary.len()).for_each(|face| fragment.outer(face, &mut triangles));
    triangles
}

/// Inputs of the triangles.
struct Fragment<'a> {
    lattice: &'a Lattice,
    topology: &'a Topology,
    old: EarlierCracks<'a>,
    label: u32,
}

/// The point of a simplex, if it has one. `points` ascend.
fn point(points: &[(u32, Point3<f64>)], simplex: u32) -> Option<Point3<f64>> {
    let found = points.binary_search_by_key(&simplex, |(own, _)| *own).ok()?;
    Some(points[found].1)
}

impl Fragment<'_> {
    /// Adds the fragment's cracks in one tetrahedron.
    fn cracks(&self, tet: usize, triangles: &mut Vec<[Point3<f64>; 3]>) {
        let labels = self.lattice.tets[tet].map(|node| self.old.labels[node as usize]);
        if !labels.contains(&self.label) {
            return;
        }
        let place = |code: u8| match code {
            TET_CODE => point(&self.old.points.tets, tet as u32),
            FACE_CODE.. => point(&self.old.points.faces, self.topology.tet_faces[tet][(code - FACE_CODE) as usize]),
            _ => point(&self.old.points.edges, self.topology.tet_edges[tet][code as usize]),
        };
        for polygon in PATTERNS[mask(labels) as usize].polygons() {
            let [is_from, is_to] = EDGES[polygon.edge as usize].map(|node| labels[node] == self.label);
            let [Some(p), Some(q), Some(r), Some(s)] = polygon.corners.map(place) else { continue };
            match (is_from, is_to, polygon.split) {
                (true, _, PolygonSplit::Triangle) => triangles.push([p, q, r]),
                (true, ..) => triangles.extend([[p, q, r], [r, s, p]]),
                (_, true, PolygonSplit::Triangle) => triangles.push([p, r, q]),
                (_, true, _) => triangles.extend([[p, r, q], [r, p, s]]),
                _ => {}
            }
        }
    }

    /// Adds the fragment's part of one outer face.
    fn outer(&self, face: usize, triangles: &mut Vec<[Point3<f64>; 3]>) {
        let face = &self.topology.boundary[face];
        let labels = face.nodes.map(|node| self.old.labels[node as usize]);
        let corner = |k: usize| self.lattice.nodes[face.nodes[k % 3] as usize];
        // Edge k joins corners k and k + 1.
        let cut = |k: usize| point(&self.old.points.edges, face.edges[k % 3]);
        let own: Vec<usize> = (0..3).filter(|&k| labels[k] == self.label).collect();
        match own[..] {
            [_, _, _] => triangles.push([0, 1, 2].map(corner)),
            [a] => {
                let (Some(next), Some(before)) = (cut(a), cut(a + 2)) else { return };
                match point(&self.old.points.faces, face.face) {
                    Some(middle) => triangles.extend([[corner(a), next, middle], [corner(a), middle, before]]),
                    None => triangles.push([corner(a), next, before]),
                }
            }
            [a, b] => {
                // The own corners in order around the face.
                let a = if b == a + 1 { a } else { b };
                let (Some(next), Some(before)) = (cut(a + 1), cut(a + 2)) else { return };
                triangles.extend([[corner(a), corner(a + 1), next], [corner(a), next, before]]);
            }
            _ => {}
        }
    }
}
