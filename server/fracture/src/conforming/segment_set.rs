//! The edges of a surface, by vertex.

/// Set of the edges of a closed surface.
#[derive(Debug, Default)]
pub(super) struct SegmentSet {
    starts: Vec<u32>,
    ends: Vec<u32>,
}

impl SegmentSet {
    /// Edges of closed, oriented triangles over `count` vertices.
    pub fn new(count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0; count + 1];
        for &vertex in triangles.iter().flatten() {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..count {
            starts[vertex + 1] += starts[vertex];
        }
        let (mut next, mut ends) = (starts.clone(), vec![0; triangles.len() * 3]);
        for &[a, b, c] in triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                ends[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        }
        for vertex in 0..count {
            ends[starts[vertex] as usize..starts[vertex + 1] as usize].sort_unstable();
        }
        Self { starts, ends }
    }

    /// Vertices at the other end of each edge of a vertex, ascending.
    pub fn of(&self, vertex: u32) -> &[u32] {
        match self.starts.get(vertex as usize..vertex as usize + 2) {
            Some(&[start, end]) => &self.ends[start as usize..end as usize],
            _ => &[],
        }
    }

    /// Returns true if (a, b) is an edge of the surface.
    pub fn contains(&self, [a, b]: [u32; 2]) -> bool {
        self.of(a).binary_search(&b).is_ok()
    }
}
