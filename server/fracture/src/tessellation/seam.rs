//! Seams: points where new cracks meet earlier ones, placed so that the earlier cracks do not move.
//!
//! The method is ours. One fragment of an earlier labeling is divided into children; the other fragments stay as they
//! are.
//!
//! - On an edge between a child and another fragment, the point is that of the earlier crack.
//! - On a face with two children and another fragment, the point is on the segment in which the earlier crack crosses
//!   the face.
//! - In a tetrahedron with three children and another fragment, the point is on the triangle of the earlier crack.
//! - In a tetrahedron with two children and two other fragments, the point is moved so that the earlier fragment's part
//!   keeps its volume.
//!
//! The children's volumes then add up to the fragment's, on one condition: in every tetrahedron that an earlier crack
//! divides two nodes from two, its four edge points are coplanar. They are if one bisector determined them.

use super::barycentric::{MARGIN, on_edge, on_face};
use super::cut::NONE;
use super::pattern::{ALL_CUT, FACE_CODE, PATTERNS, Polygon, PolygonSplit, TET_CODE, mask};
use super::{BisectorSites, FixedPoints, Topology};
use crate::lattice::{EDGES, Lattice};
use nalgebra::{Point3, Vector3};

/// Smallest weight of an earlier crack point in a new one between them, because earlier ones can be close together.
const WEIGHT_MIN: f64 = 0.1;

/// Start points on a ridge for the volume correction, as weights of its ends, tried if the first leads out of the
/// tetrahedron.
///
/// At an end of the ridge, the new cracks are in the triangles of the earlier ones, and nothing is left to correct.
const RIDGE: [[f64; 2]; 7] =
    [[0.5, 0.5], [0.9, 0.1], [0.1, 0.9], [0.97, 0.03], [0.03, 0.97], [0.995, 0.005], [0.005, 0.995]];

/// An earlier labeling with its crack points.
#[derive(Clone, Copy, Debug)]
pub struct EarlierCracks<'a> {
    /// Fragment of each node.
    pub labels: &'a [u32],
    /// All its crack points.
    pub points: &'a FixedPoints,
}

/// The points of `old`, and the points of `labels` where new cracks meet earlier ones.
///
/// `labels` (one per node) divide one fragment of `old` and leave the others intact. `sites` are evaluated at nodes of
/// the divided fragment only.
pub fn seam(
    lattice: &Lattice,
    topology: &Topology,
    old: EarlierCracks<'_>,
    labels: &[u32],
    sites: BisectorSites<'_>,
) -> FixedPoints {
    let (faces, tets) = (0..topology.faces.len() as u32, 0..lattice.tets.len() as u32);
    seam_among(lattice, topology, (faces, tets), old, labels, sites)
}

/// As [`seam`], on these faces and tetrahedra, if earlier cracks divide no others.
pub fn seam_among(
    lattice: &Lattice,
    topology: &Topology,
    (faces, tets): (impl IntoIterator<Item = u32>, impl IntoIterator<Item = u32>),
    old: EarlierCracks<'_>,
    labels: &[u32],
    sites: BisectorSites<'_>,
) -> FixedPoints {
    let [of_edges, of_faces] = [(topology.edges.len(), &old.points.edges), (topology.faces.len(), &old.points.faces)]
        .map(|(count, fixed)| slots(count, fixed));
    let mut fixed = old.points.clone();
    let seam = Seam { lattice, topology, old, labels, sites, edges: of_edges, faces: of_faces };
    for face in faces {
        fixed.faces.extend(seam.face(face as usize).map(|place| (face, place)));
    }
    let complete = Seam { faces: slots(topology.faces.len(), &fixed.faces), ..seam };
    for tet in tets {
        let place = complete.tet(tet as usize, &fixed);
        fixed.tets.extend(place.map(|place| (tet, place)));
    }
    fixed
}

/// Index in `fixed` of each of `count` simplices.
fn slots(count: usize, fixed: &[(u32, Point3<f64>)]) -> Vec<u32> {
    let mut slots = vec![NONE; count];
    for (slot, (simplex, _)) in fixed.iter().enumerate() {
        if let Some(own) = slots.get_mut(*simplex as usize) {
            *own = slot as u32;
        }
    }
    slots
}

/// Inputs of the seams; `edges` and `faces` are the indices of the points of each simplex.
struct Seam<'a> {
    lattice: &'a Lattice,
    topology: &'a Topology,
    old: EarlierCracks<'a>,
    labels: &'a [u32],
    sites: BisectorSites<'a>,
    edges: Vec<u32>,
    faces: Vec<u32>,
}

impl Seam<'_> {
    fn labels_of<const N: usize>(&self, nodes: [u32; N]) -> ([u32; N], [u32; N]) {
        (nodes.map(|node| self.old.labels[node as usize]), nodes.map(|node| self.labels[node as usize]))
    }

    /// The earlier point of the edge between two nodes.
    fn edge_point(&self, edges: &[u32], a: u32, b: u32) -> Option<Point3<f64>> {
        let key = [a.min(b), a.max(b)];
        let edge = edges.iter().find(|edge| self.topology.edges[**edge as usize] == key)?;
        self.old.points.edges.get(self.edges[*edge as usize] as usize).map(|(_, place)| *place)
    }

    /// The new point on a face with two children and another fragment.
    fn face(&self, face: usize) -> Option<Point3<f64>> {
        let nodes = self.topology.faces[face];
        let (old, new) = self.labels_of(nodes);
        if !distinct(&new) {
            return None;
        }
        let other = (0..3).find(|&k| old[(k + 1) % 3] == old[(k + 2) % 3] && old[k] != old[(k + 1) % 3])?;
        let pair = [nodes[(other + 1) % 3], nodes[(other + 2) % 3]];
        let [p, q] = pair.map(|node| self.edge_point(&self.topology.face_edges[face], node, nodes[other]));
        let [t, u] = self.between(pair, [new[(other + 1) % 3], new[(other + 2) % 3]]);
        Some(Point3::from(p?.coords * t + q?.coords * u))
    }

    /// Weights of two nodes at the bisector of their labels.
    fn between(&self, nodes: [u32; 2], labels: [u32; 2]) -> [f64; 2] {
        let sites = labels.map(|label| self.sites.of_fragment[label as usize]);
        on_edge(self.sites.preferences(nodes, sites), WEIGHT_MIN)
    }

    /// The new point in a tetrahedron of four labels, some of them of children.
    fn tet(&self, tet: usize, fixed: &FixedPoints) -> Option<Point3<f64>> {
        let nodes = self.lattice.tets[tet];
        let (old, new) = self.labels_of(nodes);
        if !distinct(&new) || distinct(&old) {
            return None;
        }
        let own = (0..4).map(|k| old[k]).find(|label| old.iter().filter(|other| *other == label).count() > 1)?;
        let inside: Vec<usize> = (0..4).filter(|&k| old[k] == own).collect();
        let outside: Vec<usize> = (0..4).filter(|&k| old[k] != own).collect();
        match (inside.as_slice(), outside.as_slice()) {
            (&[a, b, c], &[other]) => self.on_triangle(tet, [a, b, c], other),
            (&[a, b], _) => self.on_ridge(tet, [a, b], fixed),
            _ => None,
        }
    }

    /// Three children and another fragment: a point on the triangle of the earlier crack.
    fn on_triangle(&self, tet: usize, inside: [usize; 3], other: usize) -> Option<Point3<f64>> {
        let nodes = self.lattice.tets[tet];
        let own = inside.map(|k| nodes[k]);
        let [a, b, c] = own.map(|node| self.sites.of_fragment[self.labels[node as usize] as usize]);
        let [p, q, r] =
            own.map(|node| self.edge_point(&self.topology.tet_edges[tet], node, nodes[other]).map(|p| p.coords));
        let weights = on_face([b, c].map(|other| self.sites.preferences(own, [a, other])), MARGIN);
        let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
        let towards = ((WEIGHT_MIN - least) / (1.0 / 3.0 - least)).max(0.0);
        let [t, u, v] = weights.map(|weight| weight + towards * (1.0 / 3.0 - weight));
        Some(Point3::from(p? * t + q? * u + r? * v))
    }

    /// Two children and two others: a point near the segment in which the three earlier fragments met, at which the
    /// volume is unchanged.
    fn on_ridge(&self, tet: usize, inside: [usize; 2], fixed: &FixedPoints) -> Option<Point3<f64>> {
        let nodes = self.lattice.tets[tet];
        let own = inside.map(|k| nodes[k]);
        let [t, u] = self.between(own, own.map(|node| self.labels[node as usize]));
        let mut corners = Corners { places: [None; 11] };
        for (k, &edge) in self.topology.tet_edges[tet].iter().enumerate() {
            corners.places[k] = self.old.points.edges.get(self.edges[edge as usize] as usize).map(|(_, place)| *place);
        }
        for (k, &face) in self.topology.tet_faces[tet].iter().enumerate() {
            let slot = self.faces[face as usize] as usize;
            corners.places[k + FACE_CODE as usize] = fixed.faces.get(slot).map(|(_, place)| *place);
        }
        // Face k is opposite node k, so the face of a child is opposite its sibling.
        let ends = [inside[1], inside[0]].map(|k| corners.places[k + FACE_CODE as usize]);
        let ends = [ends[0]?.coords, ends[1]?.coords];
        let (old, _) = self.labels_of(nodes);
        let base = self.lattice.nodes[own[0] as usize];
        let before = corners.patch(mask(old), inside, base)?;
        let mut best: Option<(f64, Point3<f64>)> = None;
        for [t, u] in std::iter::once([t, u]).chain(RIDGE) {
            let first = Point3::from(ends[0] * t + ends[1] * u);
            corners.places[TET_CODE as usize] = Some(first);
            let after = corners.patch(ALL_CUT, inside, base)?;
            let step = after.area * (3.0 * (before.volume - after.volume) / after.area.norm_squared());
            let room = if step.iter().all(|x| x.is_finite()) { self.room(tet, first, step) } else { 0.0 };
            let place = if room > 0.0 { first + step * room } else { first };
            if best.is_none_or(|(most, _)| room > most) {
                best = Some((room, place));
            }
            if room == 1.0 {
                break;
            }
        }
        best.map(|(_, place)| place)
    }

    /// The largest share of `step`, at most 1, that leaves each barycentric coordinate of `from` at least half of its
    /// value.
    fn room(&self, tet: usize, from: Point3<f64>, step: Vector3<f64>) -> f64 {
        let base = self.lattice.nodes[self.lattice.tets[tet][0] as usize];
        let Some(inverse) = self.lattice.edge_matrix(tet).try_inverse() else { return 0.0 };
        let four = |rest: Vector3<f64>, sum: f64| [sum - rest.sum(), rest.x, rest.y, rest.z];
        let (start, change) = (four(inverse * (from - base), 1.0), four(inverse * step, 0.0));
        let room = |(start, change): (&f64, &f64)| if *change < -0.5 * start { -0.5 * start / change } else { 1.0 };
        start.iter().zip(&change).map(room).fold(1.0, f64::min).max(0.0)
    }
}

fn distinct<const N: usize>(labels: &[u32; N]) -> bool {
    (1..N).all(|k| !labels[..k].contains(&labels[k]))
}

/// Crack points of one tetrahedron by corner code.
struct Corners {
    places: [Option<Point3<f64>>; 11],
}

/// Volume between a part of a crack and a base point, and area vector of the part.
struct Patch {
    volume: f64,
    area: Vector3<f64>,
}

impl Corners {
    /// The cracks of a pattern between the nodes `inside` and the others; normals point away from the former.
    fn patch(&self, mask: u8, inside: [usize; 2], base: Point3<f64>) -> Option<Patch> {
        let polygons = PATTERNS[mask as usize].polygons();
        let joint = polygons.iter().filter(|polygon| polygon.split == PolygonSplit::Joint);
        let mut totals = [0.0; 2];
        for polygon in joint {
            for (k, total) in totals.iter_mut().enumerate() {
                *total += (self.corner_position(polygon, k)? - self.corner_position(polygon, k + 2)?).norm_squared();
            }
        }
        let mut patch = Patch { volume: 0.0, area: Vector3::zeros() };
        for polygon in polygons {
            let ends = EDGES[polygon.edge as usize].map(|node| inside.contains(&node));
            if ends[0] == ends[1] {
                continue;
            }
            let turn = usize::from(polygon.split == PolygonSplit::Joint && totals[1] < totals[0]);
            let sign = if ends[0] { 1.0 } else { -1.0 };
            let corner = |k: usize| Some(self.corner_position(polygon, (k + turn) % 4)? - base);
            let [p, q, r, s] = [corner(0)?, corner(1)?, corner(2)?, corner(3)?];
            let halves =
                if polygon.split == PolygonSplit::Triangle { &[[p, q, r]][..] } else { &[[p, q, r], [r, s, p]] };
            for [p, q, r] in halves {
                patch.volume += sign * p.dot(&q.cross(r)) / 6.0;
                patch.area += (q - p).cross(&(r - p)) * (0.5 * sign);
            }
        }
        Some(patch)
    }

    fn corner_position(&self, polygon: &Polygon, corner: usize) -> Option<Point3<f64>> {
        self.places[polygon.corners[corner] as usize]
    }
}
