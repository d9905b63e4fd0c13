//! Sums of forces on a few nodes of a body.

use nalgebra::Vector3;

/// Sparse sums over a few nodes of a body.
#[derive(Default)]
pub(super) struct ForceSums {
    /// Sum of each node; zero outside `nodes`.
    sums: Vec<Vector3<f64>>,
    /// Membership of each node in `nodes`.
    among: Vec<bool>,
    /// Nodes with a sum, in order of arrival.
    nodes: Vec<u32>,
}

impl ForceSums {
    /// Clears all sums and resizes to `count` nodes.
    pub(super) fn begin(&mut self, count: usize) {
        for node in self.nodes.drain(..) {
            (self.sums[node as usize], self.among[node as usize]) = (Vector3::zeros(), false);
        }
        self.sums.resize(count, Vector3::zeros());
        self.among.resize(count, false);
    }

    pub(super) fn add(&mut self, node: u32, more: Vector3<f64>) {
        if !std::mem::replace(&mut self.among[node as usize], true) {
            self.nodes.push(node);
        }
        self.sums[node as usize] += more;
    }

    /// Nodes with their sums, in order of arrival.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        self.nodes.iter().map(|node| (*node as usize, self.sums[*node as usize]))
    }
}
