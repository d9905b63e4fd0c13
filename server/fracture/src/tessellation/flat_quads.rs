//! Cracks across pairs of boundary triangles that lie in one plane.
//!
//! Behind two such triangles, a mesh of an input surface can have a tetrahedron without height: two of its faces are the
//! triangles, the two others cover the same quadrilateral with the other diagonal. The mesher removes nearly all of them;
//! databases baked earlier have more. The crack points of both pairs are found independently, so that the two pairs can
//! differ in where the crack runs. Parts of the crack would then lie in the surface. Here, the points are moved to where
//! both pairs of faces are divided alike:
//!
//! - two labels: points on the diagonals lie on the straight line between the points on the rim;
//! - three labels, two of them at opposite corners: the points on both faces with three labels are one point, and those on
//!   the diagonals lie on the straight lines from there to the rim;
//! - four labels: all points that are not on the rim are where the diagonals cross.
//!
//! No position helps where two opposite corners have one label and the two others have others: one pair of faces joins
//! what the other divides. Functions that are linear on the quadrilateral have no such labels, but those of a diagram are
//! linear on the tetrahedra of the lattice only. One corner then receives the label of its two neighbors.
//!
//! Ours.

use super::Topology;
use super::barycentric::{edge_margin, kept_inside, relative_height, simplex_margin, triangle_height};
use super::cut::{CutSimplices, NONE};
use super::pattern::ALL_CUT;
use super::points::CrackPoints;
use super::topology::OuterFace;
use crate::lattice::Lattice;
use crate::memory::held;
use nalgebra::{Point3, Vector3};

/// Height of a tetrahedron below which it counts as flat, over its longest edge.
const FLAT: f64 = 1e-4;

/// Smallest barycentric coordinate of a joint point in the triangle that two faces share. In both faces it has then those
/// of [`MARGIN`](super::MARGIN) or more, unless the diagonals cross far from their middles.
const JOINT_MARGIN: f64 = 0.05;

/// A flat tetrahedron with two faces on the boundary, as a convex quadrilateral with its diagonals.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FlatQuad {
    tet: u32,
    /// Nodes around the quadrilateral.
    corners: [u32; 4],
    /// Edge k joins corners k and k + 1.
    rim: [u32; 4],
    /// Diagonal k joins corners k and k + 2.
    diagonals: [u32; 2],
    /// Face k lacks corner k.
    faces: [u32; 4],
    /// Fractions of both diagonals at which they cross.
    crossing: [f64; 2],
}

/// All flat tetrahedra with two faces on the boundary, by tetrahedron.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FlatQuads(Vec<FlatQuad>);

impl FlatQuads {
    /// Those of `lattice`, whose incidences are in `topology`.
    pub fn new(lattice: &Lattice, topology: &Topology) -> Self {
        let mut outer: Vec<&OuterFace> = topology.boundary.iter().collect();
        outer.sort_by_key(|face| face.tet);
        let pairs = outer.chunk_by(|a, b| a.tet == b.tet);
        Self(pairs.filter_map(|faces| FlatQuad::new(lattice, topology, faces)).collect())
    }

    /// Frees what the list reserved and does not use.
    pub fn shrink(&mut self) {
        self.0.shrink_to_fit();
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        held(&self.0)
    }

    /// Gives one corner of each quadrilateral in which only opposite corners have one label the label of these two: the
    /// corner nearest to where the diagonals cross.
    pub fn join_opposite_corners(&self, labels: &mut [u32]) {
        for quad in &self.0 {
            let [a, b, c, d] = quad.corners.map(|node| labels[node as usize]);
            let (one, two) = (a == c && b != a && d != a, b == d && a != b && c != b);
            let (diagonal, label) = if one {
                (1, a)
            } else if two {
                (0, b)
            } else {
                continue;
            };
            let nearest = if quad.crossing[diagonal] > 0.5 { diagonal + 2 } else { diagonal };
            labels[quad.corners[nearest] as usize] = label;
        }
    }

    /// Moves the points of cracks across the quadrilaterals.
    pub fn straighten(&self, lattice: &Lattice, points: &mut CrackPoints) {
        for quad in &self.0 {
            if points.masks[quad.tet as usize] != 0 {
                FlatCrack { quad, places: quad.corners.map(|node| lattice.nodes[node as usize]), points }.straighten();
            }
        }
    }
}

impl FlatQuad {
    /// The quadrilateral of a tetrahedron whose faces on the boundary are `faces`, if there are two, it is flat, and its
    /// diagonals cross.
    fn new(lattice: &Lattice, topology: &Topology, faces: &[&OuterFace]) -> Option<Self> {
        let &[one, two] = faces else { return None };
        let places = lattice.corners(one.tet as usize);
        if relative_height(&places) > FLAT {
            return None;
        }
        let opposite = |face: &OuterFace, other: &OuterFace| (0..3).find(|k| !other.nodes.contains(&face.nodes[*k]));
        let (first, second) = (opposite(one, two)?, opposite(two, one)?);
        let [a, b] = [1, 2].map(|step| one.nodes[(first + step) % 3]);
        let corners = [one.nodes[first], a, two.nodes[second], b];
        let edge = |k: usize, l: usize| {
            let own = [corners[k].min(corners[l]), corners[k].max(corners[l])];
            topology.tet_edges[one.tet as usize].into_iter().find(|&edge| topology.edges[edge as usize] == own)
        };
        let face = |k: usize| {
            let lacks = |face: &u32| !topology.faces[*face as usize].contains(&corners[k]);
            topology.tet_faces[one.tet as usize].into_iter().find(lacks)
        };
        let [p, q, r, s] = corners.map(|node| lattice.nodes[node as usize]);
        let plane = Plane::of([p, q, r, s]);
        let crossing = [plane.fraction([p, r], [q, s])?, plane.fraction([q, s], [p, r])?];
        crossing.iter().all(|t| *t > 0.0 && *t < 1.0).then_some(Self {
            tet: one.tet,
            corners,
            rim: [edge(0, 1)?, edge(1, 2)?, edge(2, 3)?, edge(3, 0)?],
            diagonals: [edge(0, 2)?, edge(1, 3)?],
            faces: [face(0)?, face(1)?, face(2)?, face(3)?],
            crossing,
        })
    }
}

/// Points of a crack across one quadrilateral.
struct FlatCrack<'a> {
    quad: &'a FlatQuad,
    /// Its corners.
    places: [Point3<f64>; 4],
    points: &'a mut CrackPoints,
}

impl FlatCrack<'_> {
    fn straighten(mut self) {
        let Self { quad, points, .. } = &self;
        let cut: Vec<usize> = (0..4).filter(|k| points.edges.slots[quad.rim[*k] as usize] != NONE).collect();
        match *cut.as_slice() {
            [one, two] => {
                let ends = [one, two].map(|k| self.rim_point(k));
                (0..2).for_each(|diagonal| self.move_to_line(diagonal, ends));
            }
            [_, _, _] => self.join_triple_points(6 - cut.iter().sum::<usize>()),
            _ if self.points.masks[quad.tet as usize] == ALL_CUT => self.gather(),
            _ => (),
        }
    }

    /// Joins the points on the two faces with three labels. Corners `equal` and `equal + 1` have one label.
    fn join_triple_points(&mut self, equal: usize) {
        let [one, two, three, four] = [0, 1, 2, 3].map(|step| (equal + step) % 4);
        let [p, q] = [one, two].map(|face| place(&mut self.points.faces, self.quad.faces[face]).map(|place| *place));
        let (Some(p), Some(q)) = (p, q) else { return };
        // Both faces contain the triangle between the crossing of the diagonals and the two corners with labels of their own.
        let triangle = [self.center(), self.places[three], self.places[four]];
        let plane = Plane::of(self.places);
        let joint = blend(triangle, kept_inside(plane.weights(triangle, nalgebra::center(&p, &q)), JOINT_MARGIN));
        [one, two].into_iter().for_each(|face| self.move_in_face(face, joint));
        self.move_to_line(one % 2, [self.rim_point(two), joint]);
        self.move_to_line(two % 2, [self.rim_point(four), joint]);
    }

    /// Moves all points that are not on the rim to where the diagonals cross.
    fn gather(&mut self) {
        let [s, t] = self.quad.crossing;
        let center = self.center();
        (0..4).for_each(|face| self.move_in_face(face, center));
        (0..2).for_each(|diagonal| self.move_to_line(diagonal, self.diagonal(1 - diagonal)));
        if let Some(point) = place(&mut self.points.tets, self.quad.tet) {
            let weights = kept_inside([(1.0 - s) / 2.0, (1.0 - t) / 2.0, s / 2.0, t / 2.0], simplex_margin(0.0));
            let offsets = (1..4).map(|k| (self.places[k] - self.places[0]) * weights[k]);
            *point = self.places[0] + offsets.sum::<Vector3<f64>>();
        }
    }

    /// The point at which the diagonals cross.
    fn center(&self) -> Point3<f64> {
        let [from, to] = self.diagonal(0);
        from + (to - from) * self.quad.crossing[0]
    }

    fn diagonal(&self, own: usize) -> [Point3<f64>; 2] {
        [own, own + 2].map(|corner| self.places[corner])
    }

    /// The point on edge `k` of the rim, which is cut.
    fn rim_point(&self, k: usize) -> Point3<f64> {
        let edges = &self.points.edges;
        edges.places[edges.slots[self.quad.rim[k] as usize] as usize]
    }

    /// Moves the point on a diagonal to the straight line through `ends`, inside the margin, if it is cut.
    fn move_to_line(&mut self, diagonal: usize, ends: [Point3<f64>; 2]) {
        let [from, to] = self.diagonal(diagonal);
        let margin = edge_margin((to - from).norm());
        let t = Plane::of(self.places).fraction([from, to], ends);
        if let (Some(t), Some(point)) = (t, place(&mut self.points.edges, self.quad.diagonals[diagonal])) {
            *point = from + (to - from) * t.clamp(margin, 1.0 - margin);
        }
    }

    /// Moves the point on a face to `to`, inside the margin, if it has one.
    fn move_in_face(&mut self, face: usize, to: Point3<f64>) {
        let triangle = [1, 2, 3].map(|step| self.places[(face + step) % 4]);
        let plane = Plane::of(self.places);
        if let Some(point) = place(&mut self.points.faces, self.quad.faces[face]) {
            *point =
                blend(triangle, kept_inside(plane.weights(triangle, to), simplex_margin(triangle_height(triangle))));
        }
    }
}

/// The crack point of a simplex, if it has one.
fn place(points: &mut CutSimplices, simplex: u32) -> Option<&mut Point3<f64>> {
    points.places.get_mut(points.slots[simplex as usize] as usize)
}

/// The point with barycentric coordinates `weights`.
fn blend([a, b, c]: [Point3<f64>; 3], weights: [f64; 3]) -> Point3<f64> {
    a + (b - a) * weights[1] + (c - a) * weights[2]
}

/// The plane of a quadrilateral, by its normal.
struct Plane(Vector3<f64>);

impl Plane {
    fn of([a, b, c, d]: [Point3<f64>; 4]) -> Self {
        Self((c - a).cross(&(d - b)))
    }

    /// Fraction of an edge at which the straight line through `ends` crosses it; `None` if they are parallel.
    fn fraction(&self, [from, to]: [Point3<f64>; 2], ends: [Point3<f64>; 2]) -> Option<f64> {
        let across = self.0.cross(&(ends[1] - ends[0]));
        let t = across.dot(&(ends[0] - from)) / across.dot(&(to - from));
        t.is_finite().then_some(t)
    }

    /// Barycentric coordinates of a point; they sum to 1.
    fn weights(&self, [a, b, c]: [Point3<f64>; 3], point: Point3<f64>) -> [f64; 3] {
        let area = |p: Point3<f64>, q: Point3<f64>, r: Point3<f64>| self.0.dot(&(q - p).cross(&(r - p)));
        let [second, third] = [area(a, point, c), area(a, b, point)].map(|part| part / area(a, b, c));
        [1.0 - second - third, second, third]
    }
}
