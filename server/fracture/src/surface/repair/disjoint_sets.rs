//! Disjoint sets of indices.
//!
//! The lowest member represents its set, so results do not depend on the order of joins.
//!
//! Based on: R. E. Tarjan, *Efficiency of a good but not linear set union algorithm* (1975), with path halving.

/// Partition of 0 .. n into sets.
pub(crate) struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Creates `n` sets of one member each.
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    /// Lowest member of the set of `index`.
    pub fn root(&mut self, mut index: u32) -> u32 {
        while self.parent[index as usize] != index {
            let grandparent = self.parent[self.parent[index as usize] as usize];
            self.parent[index as usize] = grandparent;
            index = grandparent;
        }
        index
    }

    /// Unites the sets of `a` and `b`.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
