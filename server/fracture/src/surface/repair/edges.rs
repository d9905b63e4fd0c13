//! Edges of a triangle mesh and their incident triangles.

use super::disjoint_sets::DisjointSets;
use nalgebra::Point3;

/// One side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct HalfEdge {
    /// End points, the lower index first.
    pub ends: [u32; 2],
    /// Triangle of this side.
    pub triangle: u32,
    /// Side number: it runs from corner `side` to the next corner.
    pub side: u8,
    /// True if it runs from the lower to the higher end point.
    pub forward: bool,
}

/// All sides of a mesh, sorted by end points.
pub(super) struct Edges {
    half_edges: Vec<HalfEdge>,
}

impl Edges {
    /// Sorts the sides of `triangles`, each of which must have three different corners.
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let mut half_edges = Vec::with_capacity(triangles.len() * 3);
        for (triangle, corners) in triangles.iter().enumerate() {
            for side in 0..3 {
                let (from, to) = (corners[side], corners[(side + 1) % 3]);
                half_edges.push(HalfEdge {
                    ends: [from.min(to), from.max(to)],
                    triangle: triangle as u32,
                    side: side as u8,
                    forward: from < to,
                });
            }
        }
        half_edges.sort_unstable();
        Self { half_edges }
    }

    /// Sides grouped by edge.
    pub fn groups(&self) -> impl Iterator<Item = &[HalfEdge]> {
        self.half_edges.chunk_by(|a, b| a.ends == b.ends)
    }

    /// For each triangle, whether it has an edge of its own (an open edge).
    pub fn with_boundary(&self, triangles: usize) -> Vec<bool> {
        let mut boundary = vec![false; triangles];
        for group in self.groups().filter(|group| group.len() == 1) {
            boundary[group[0].triangle as usize] = true;
        }
        boundary
    }

    /// For each triangle, whether it belongs to an inner wall.
    ///
    /// A wall is an edge-connected set of `doubled` triangles. At every edge of it, an even number of other triangles
    /// closes the surface without it; at one edge at least, that number is not 0.
    pub fn walls(&self, doubled: &[bool]) -> Vec<bool> {
        let mut sets = self.connected(doubled);
        let (mut open, mut attached) = (vec![false; doubled.len()], vec![false; doubled.len()]);
        for group in self.groups() {
            let others = group.iter().filter(|side| !doubled[side.triangle as usize]).count();
            if let Some(member) = group.iter().find(|side| doubled[side.triangle as usize]) {
                let root = sets.root(member.triangle) as usize;
                open[root] |= others % 2 == 1;
                attached[root] |= others > 0;
            }
        }
        let is_wall = |t: usize, root: usize| doubled[t] && attached[root] && !open[root];
        (0..doubled.len()).map(|t| is_wall(t, sets.root(t as u32) as usize)).collect()
    }

    /// For each triangle, whether it belongs to a shell of `doubled` triangles whose normals point inward.
    ///
    /// A shell is an edge-connected set that is closed by itself.
    pub fn inward_shells(&self, positions: &[Point3<f64>], triangles: &[[u32; 3]], doubled: &[bool]) -> Vec<bool> {
        let mut sets = self.connected(doubled);
        let mut open = vec![false; doubled.len()];
        for group in self.groups() {
            let own: Vec<HalfEdge> = group.iter().filter(|side| doubled[side.triangle as usize]).copied().collect();
            if let Some(first) = own.first() {
                open[sets.root(first.triangle) as usize] |= !Self::is_balanced(&own);
            }
        }
        let mut volumes = vec![0.0; doubled.len()];
        for (triangle, corners) in triangles.iter().enumerate().filter(|(triangle, _)| doubled[*triangle]) {
            let [a, b, c] = corners.map(|vertex| positions[vertex as usize].coords);
            volumes[sets.root(triangle as u32) as usize] += a.dot(&b.cross(&c));
        }
        let is_inward = |t: usize, root: usize| doubled[t] && !open[root] && volumes[root] < 0.0;
        (0..doubled.len()).map(|t| is_inward(t, sets.root(t as u32) as usize)).collect()
    }

    /// Sets of marked triangles that are connected through edges.
    fn connected(&self, marked: &[bool]) -> DisjointSets {
        let mut sets = DisjointSets::new(marked.len());
        for group in self.groups() {
            let mut members = group.iter().map(|side| side.triangle).filter(|&t| marked[t as usize]);
            if let Some(first) = members.next() {
                members.for_each(|other| sets.join(first, other));
            }
        }
        sets
    }

    /// Returns true if every edge is passed equally often in both directions: the surface has no boundary as a chain.
    pub fn balanced(&self) -> bool {
        self.groups().all(Self::is_balanced)
    }

    /// Returns true if the sides of one edge run equally often in both directions.
    pub fn is_balanced(group: &[HalfEdge]) -> bool {
        2 * group.iter().filter(|side| side.forward).count() == group.len()
    }
}
