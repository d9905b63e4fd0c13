//! Tetrahedra with their neighbors: queries for stars and rings, and replacement of a set of tetrahedra by another.

use super::predicates::orientation;
use nalgebra::Point3;
use std::cell::Cell;

/// No tetrahedron, or no face.
pub(super) const NONE: u32 = u32::MAX;

/// Corners of the face opposite each corner of a positive tetrahedron, counter-clockwise seen from outside.
pub(super) const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// For corners i and j: the other two, in the order k, l in which (i, j, k, l) is an even permutation.
pub(super) const REST: [[[usize; 2]; 4]; 4] = [
    [[0, 0], [2, 3], [3, 1], [1, 2]],
    [[3, 2], [0, 0], [0, 3], [2, 0]],
    [[1, 3], [3, 0], [0, 0], [0, 1]],
    [[2, 1], [0, 2], [1, 0], [0, 0]],
];

/// Face of a tetrahedron, as the tetrahedron's index times 4 plus the index of the corner opposite the face.
#[inline]
pub(super) fn pack(tet: u32, corner: usize) -> u32 {
    tet << 2 | corner as u32
}

/// Tetrahedron and opposite corner of a packed face.
#[inline]
pub(super) fn unpack(face: u32) -> (u32, usize) {
    (face >> 2, (face & 3) as usize)
}

/// Tetrahedra around an edge (p, q): number i has the corners p, q, `vertices[i]` and `vertices[i + 1]`, and is positive.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    /// Tetrahedra, counter-clockwise seen from q.
    pub tets: Vec<u32>,
    /// Vertices between them.
    pub vertices: Vec<u32>,
}

/// Tetrahedralization of the inside of one large tetrahedron. Every tetrahedron in use is positive.
#[derive(Clone, Debug, Default)]
pub(super) struct Tetrahedralization {
    /// Points. The last four are the corners of the large tetrahedron.
    pub points: Vec<Point3<f64>>,
    /// Corners of each tetrahedron; `NONE` where the slot is free.
    pub tets: Vec<[u32; 4]>,
    /// Packed face beyond the face opposite each corner; `NONE` at the large tetrahedron's faces.
    pub neighbors: Vec<[u32; 4]>,
    /// Constraints among each tetrahedron's faces: bit i for the face opposite corner i, bit 4 + i if the tetrahedron
    /// lies on the inner side of that constraint.
    pub constraints: Vec<u8>,
    /// One tetrahedron around each point.
    pub incident: Vec<u32>,
    steps: Cell<u64>,
    free: Vec<u32>,
    marks: Vec<u32>,
    stamp: u32,
}

impl Tetrahedralization {
    /// Points without tetrahedra.
    pub fn new(points: Vec<Point3<f64>>) -> Self {
        Self { incident: vec![NONE; points.len()], points, ..Self::default() }
    }

    /// Counts steps: signs computed and tetrahedra visited.
    #[inline]
    pub fn count_steps(&self, count: usize) {
        self.steps.set(self.steps.get() + count as u64);
    }

    /// Steps since the last call of [`Self::take_steps`].
    pub fn steps(&self) -> u64 {
        self.steps.get()
    }

    /// Resets the number of steps to 0; returns it.
    pub fn take_steps(&self) -> u64 {
        self.steps.take()
    }

    /// Position of a point.
    #[inline]
    pub fn point(&self, vertex: u32) -> &Point3<f64> {
        &self.points[vertex as usize]
    }

    /// Sign of the volume of four points; exact.
    #[inline]
    pub fn orientation(&self, a: u32, b: u32, c: u32, d: u32) -> f64 {
        self.count_steps(1);
        orientation(self.point(a), self.point(b), self.point(c), self.point(d))
    }

    /// Vertices of a face, counter-clockwise seen from outside its tetrahedron.
    #[inline]
    pub fn face(&self, tet: u32, corner: usize) -> [u32; 3] {
        FACES[corner].map(|k| self.tets[tet as usize][k])
    }

    /// Returns true if the face opposite a corner is a constraint.
    #[inline]
    pub fn is_constraint(&self, tet: u32, corner: usize) -> bool {
        self.constraints[tet as usize] >> corner & 1 == 1
    }

    /// Corner of a tetrahedron at which a vertex lies.
    #[inline]
    pub fn corner(&self, tet: u32, vertex: u32) -> Option<usize> {
        self.tets[tet as usize].iter().position(|&other| other == vertex)
    }

    /// Starts a new set of marked tetrahedra.
    pub fn clear_marks(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.marks.fill(0);
            self.stamp = 1;
        }
    }

    /// Marks a tetrahedron; returns false if it was marked already.
    #[inline]
    pub fn mark(&mut self, tet: u32) -> bool {
        std::mem::replace(&mut self.marks[tet as usize], self.stamp) != self.stamp
    }

    /// Returns true if a tetrahedron is marked.
    #[inline]
    pub fn is_marked(&self, tet: u32) -> bool {
        self.marks[tet as usize] == self.stamp
    }

    /// Adds a tetrahedron without neighbors.
    pub fn allocate(&mut self, corners: [u32; 4]) -> u32 {
        let tet = self.free.pop().unwrap_or_else(|| {
            self.tets.push([NONE; 4]);
            self.neighbors.push([NONE; 4]);
            self.constraints.push(0);
            self.marks.push(0);
            self.tets.len() as u32 - 1
        });
        self.tets[tet as usize] = corners;
        self.neighbors[tet as usize] = [NONE; 4];
        self.constraints[tet as usize] = 0;
        self.marks[tet as usize] = 0;
        for vertex in corners {
            self.incident[vertex as usize] = tet;
        }
        tet
    }

    /// Frees the slot of a tetrahedron.
    pub fn release(&mut self, tet: u32) {
        self.tets[tet as usize] = [NONE; 4];
        self.free.push(tet);
    }

    /// Makes two faces neighbors. The second may be `NONE`.
    #[inline]
    pub fn link(&mut self, face: u32, other: u32) {
        let (tet, corner) = unpack(face);
        self.neighbors[tet as usize][corner] = other;
        if other != NONE {
            let (tet, corner) = unpack(other);
            self.neighbors[tet as usize][corner] = face;
        }
    }

    /// Marks the tetrahedra around a vertex, and no others, and returns them.
    pub fn star(&mut self, vertex: u32) -> Vec<u32> {
        self.clear_marks();
        let first = self.incident[vertex as usize];
        self.mark(first);
        let mut star = vec![first];
        let mut next = 0;
        while let Some(&tet) = star.get(next) {
            next += 1;
            for corner in 0..4 {
                let beyond = self.neighbors[tet as usize][corner];
                if self.tets[tet as usize][corner] != vertex && beyond != NONE && self.mark(beyond >> 2) {
                    star.push(beyond >> 2);
                }
            }
        }
        self.count_steps(star.len());
        star
    }

    /// A tetrahedron that contains the edge (a, b).
    pub fn tet_of_edge(&mut self, [a, b]: [u32; 2]) -> Option<u32> {
        let hint = self.incident[a as usize];
        if self.corner(hint, b).is_some() {
            return Some(hint);
        }
        self.star(a).into_iter().find(|&tet| self.corner(tet, b).is_some())
    }

    /// Tetrahedra around the edge (p, q), beginning with `tet`. None at edges of the large tetrahedron.
    pub fn ring(&self, tet: u32, [p, q]: [u32; 2]) -> Option<Ring> {
        let mut ring = Ring::default();
        let mut current = tet;
        loop {
            let [i, j] = [self.corner(current, p)?, self.corner(current, q)?];
            let [k, _] = REST[i][j];
            ring.tets.push(current);
            ring.vertices.push(self.tets[current as usize][k]);
            let beyond = self.neighbors[current as usize][k];
            if beyond == NONE {
                return None;
            }
            current = beyond >> 2;
            if current == tet {
                self.count_steps(ring.tets.len());
                return Some(ring);
            }
        }
    }

    /// Packed face with the vertices (a, b, c), whose edges exist.
    pub fn face_of(&mut self, [a, b, c]: [u32; 3]) -> Option<u32> {
        let tet = self.tet_of_edge([a, b])?;
        let ring = self.ring(tet, [a, b])?;
        let tet = ring.tets.into_iter().find(|&tet| self.corner(tet, c).is_some())?;
        let corner = (0..4).find(|&corner| ![a, b, c].contains(&self.tets[tet as usize][corner]))?;
        Some(pack(tet, corner))
    }

    /// Replaces tetrahedra by others that fill the same region, and keeps the constraints of the region's boundary.
    ///
    /// Returns the new tetrahedra.
    pub fn replace(&mut self, old: &[u32], new: &[[u32; 4]]) -> Vec<u32> {
        let mut open: Vec<([u32; 3], u32, u8)> = Vec::with_capacity(old.len() * 2 + new.len() * 4);
        for &tet in old {
            for corner in 0..4 {
                let beyond = self.neighbors[tet as usize][corner];
                if beyond == NONE || !old.contains(&(beyond >> 2)) {
                    let constraint = self.constraints[tet as usize] >> corner & 0x11;
                    open.push((sorted(self.face(tet, corner)), beyond, constraint));
                }
            }
        }
        let outside = open.len();
        old.iter().for_each(|&tet| self.release(tet));
        let created: Vec<u32> = new.iter().map(|&corners| self.allocate(corners)).collect();
        for &tet in &created {
            open.extend((0..4).map(|corner| (sorted(self.face(tet, corner)), pack(tet, corner), 0)));
        }
        // A stable order puts a face of the boundary before the new one that it meets.
        let mut order: Vec<usize> = (0..open.len()).collect();
        order.sort_unstable_by_key(|&k| (open[k].0, k));
        debug_assert!(order.len().is_multiple_of(2));
        for pair in order.chunks_exact(2) {
            let ((key, outer, constraint), (other, inner, _)) = (open[pair[0]], open[pair[1]]);
            debug_assert_eq!(key, other);
            self.link(inner, outer);
            if pair[0] < outside {
                let (tet, corner) = unpack(inner);
                self.constraints[tet as usize] |= constraint << corner;
            }
        }
        created
    }
}

/// Vertices of a face in ascending order.
pub(super) fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}
