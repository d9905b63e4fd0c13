//! Edges that are in the way of a constraint, in the order in which they were found.

use super::split_surface::ascending;
use std::collections::HashSet;

/// List of edges without repetition.
#[derive(Debug, Default)]
pub(super) struct EdgeList {
    edges: Vec<([u32; 2], u32)>,
    known: HashSet<[u32; 2]>,
}

impl EdgeList {
    /// Adds an edge and a tetrahedron that contains it; returns false if the list has the edge already.
    pub fn add(&mut self, edge: [u32; 2], tet: u32) -> bool {
        let is_new = self.known.insert(ascending(edge));
        if is_new {
            self.edges.push((edge, tet));
        }
        is_new
    }

    /// All edges, each with a tetrahedron that contains it.
    pub fn all(&self) -> &[([u32; 2], u32)] {
        &self.edges
    }
}
