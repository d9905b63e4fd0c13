//! The edges of a triangle mesh and what hangs on them.

use super::sets::DisjointSets;

/// One side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct HalfEdge {
    /// Its end points, the lower first.
    pub ends: [u32; 2],
    /// Its triangle.
    pub triangle: u32,
    /// Its place in the triangle: it runs from corner `side` to the next.
    pub side: u8,
    /// Whether it runs from the lower to the higher end.
    pub forward: bool,
}

/// All sides, sorted by end points.
pub(super) struct Edges {
    half_edges: Vec<HalfEdge>,
}

impl Edges {
    /// Sorts the sides of `triangles`, which must have three different corners each.
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

    /// The sides of each edge together.
    pub fn groups(&self) -> impl Iterator<Item = &[HalfEdge]> {
        self.half_edges.chunk_by(|a, b| a.ends == b.ends)
    }

    /// Per triangle: whether an edge is its own alone.
    pub fn with_boundary(&self, triangles: usize) -> Vec<bool> {
        let mut boundary = vec![false; triangles];
        for group in self.groups().filter(|group| group.len() == 1) {
            boundary[group[0].triangle as usize] = true;
        }
        boundary
    }

    /// Per triangle: whether it belongs to an edge-connected set of `doubled` triangles that ends on edges where an
    /// even number of others, and at least at one edge two of them, close the surface without it.
    pub fn walls(&self, doubled: &[bool]) -> Vec<bool> {
        let mut sets = DisjointSets::new(doubled.len());
        for group in self.groups() {
            let mut members = group.iter().map(|side| side.triangle).filter(|&t| doubled[t as usize]);
            if let Some(first) = members.next() {
                members.for_each(|other| sets.join(first, other));
            }
        }
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

    /// Whether every edge is passed as often forward as backward: the surface has no boundary as a chain.
    pub fn balanced(&self) -> bool {
        self.groups().all(|group| 2 * group.iter().filter(|side| side.forward).count() == group.len())
    }
}
