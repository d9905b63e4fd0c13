//! Restriction of quadratic displacements to what a reduced strike needs, with values at the nodes only.
//!
//! A contact applies forces to boundary nodes, and each stands for a traction that also loads edges. The work of that
//! traction is the product of the force with the *trace*: the displacement of the node plus shares of the functions of
//! the edges around it. Energies follow from the strains at the nodes. So neither needs the edges.

use super::EdgeFunctions;
use crate::elasticity::residual::{dot, unit};
use crate::elasticity::{Elasticity, NodalLoad, Support};
use std::ops::Range;

/// Rows of a restricted snapshot of a body with this number of unknowns of nodes.
///
/// They are the trace of the displacement and its work with the inertial forces of six unit accelerations, the strains
/// at the nodes, and trace and work of D⁻¹f, the forces over the diagonal of the stiffness.
#[derive(Clone, Copy)]
pub(in crate::elasticity) struct SnapshotRows {
    size: usize,
}

impl SnapshotRows {
    pub(in crate::elasticity) fn new(size: usize) -> Self {
        Self { size }
    }

    /// Number of all rows.
    pub(in crate::elasticity) fn count(self) -> usize {
        self.weighted_work().end
    }

    /// Trace of the displacement.
    pub(in crate::elasticity) fn trace(self) -> Range<usize> {
        0..self.size
    }

    /// Work of the displacement with the inertial forces of unit accelerations.
    pub(in crate::elasticity) fn work(self) -> Range<usize> {
        self.size..self.size + 6
    }

    /// Strains at the nodes.
    pub(in crate::elasticity) fn strains(self) -> Range<usize> {
        let first = self.work().end;
        first..first + 2 * self.size
    }

    /// Trace of D⁻¹f.
    pub(in crate::elasticity) fn weighted(self) -> Range<usize> {
        let first = self.strains().end;
        first..first + self.size
    }

    /// Work of D⁻¹f with the inertial forces of unit accelerations.
    pub(in crate::elasticity) fn weighted_work(self) -> Range<usize> {
        let first = self.weighted().end;
        first..first + 6
    }
}

impl Elasticity {
    /// Fills `rows` ([`SnapshotRows`]) with the restriction of the solution `displacement` under `forces`.
    pub(in crate::elasticity) fn restrict(
        &self,
        edges: &EdgeFunctions,
        displacement: &[f64],
        forces: &[f64],
        rows: &mut [f64],
    ) {
        let parts = SnapshotRows::new(self.size());
        let weighted: Vec<f64> = forces.iter().zip(self.inverse_diagonal()).map(|(f, inverse)| f * inverse).collect();
        self.trace(edges, displacement, &mut rows[parts.trace()]);
        self.trace(edges, &weighted, &mut rows[parts.weighted()]);
        rows[parts.work()].copy_from_slice(&self.inertial_work(displacement));
        rows[parts.weighted_work()].copy_from_slice(&self.inertial_work(&weighted));
        rows[parts.strains()].copy_from_slice(&edges.node_strains(&self.elements.blocks, displacement));
    }

    /// The load as its products with the trace and with the work: applied forces, then the negative acceleration.
    pub(in crate::elasticity) fn restricted_load(&self, load: &NodalLoad) -> Vec<f64> {
        let mut rows = vec![0.0; self.size() + 6];
        for (node, force) in &load.applied {
            rows[3 * *node as usize..][..3].copy_from_slice(force.as_slice());
        }
        let acceleration = load.acceleration.iter().flatten();
        rows[self.size()..].iter_mut().zip(acceleration).for_each(|(row, own)| *row = -own);
        rows
    }

    fn trace(&self, edges: &EdgeFunctions, vector: &[f64], trace: &mut [f64]) {
        let (nodes, edge_part) = vector.split_at(self.size());
        trace.copy_from_slice(nodes);
        for &node in &self.boundary.nodes {
            let own = &mut trace[3 * node as usize..][..3];
            edges.loaded(&self.boundary, node, |edge, share| {
                own.iter_mut().zip(&edge_part[3 * edge..]).for_each(|(own, c)| *own += share * c);
            });
        }
    }

    /// Products of `vector` with the inertial forces of six unit accelerations.
    pub(in crate::elasticity) fn inertial_work(&self, vector: &[f64]) -> [f64; 6] {
        std::array::from_fn(|axis| dot(self.inertial_forces(axis).as_slice(), vector))
    }

    /// Inertial forces of unit acceleration number `axis`.
    pub(in crate::elasticity) fn inertial_forces(&self, axis: usize) -> Vec<f64> {
        let acceleration = unit(axis);
        let nodes = (0..self.size() / 3).map(|node| self.inertia.force(node, &acceleration));
        let edges = self.edges.iter().flat_map(|edges| (0..edges.count()).map(move |edge| (edges, edge)));
        let edge_part = edges.map(|(edges, edge)| edges.inertial_force(edge, &acceleration));
        nodes.chain(edge_part).flat_map(|force| force.data.0[0]).collect()
    }

    /// Inverse of the diagonal of the stiffness, one entry per unknown; 0 where anchors hold, which carry any force.
    pub(in crate::elasticity) fn inverse_diagonal(&self) -> Vec<f64> {
        let edges = self.edges.iter().flat_map(|edges| &edges.diagonal);
        let mut inverse: Vec<f64> = self.stiffness.diagonal().iter().chain(edges).map(|own| 1.0 / own).collect();
        if let Support::Anchored(nodes) = &self.support {
            nodes.iter().for_each(|node| inverse[3 * *node as usize..][..3].fill(0.0));
            self.edges.iter().for_each(|edges| self.drop_held_edges(edges, nodes, &mut inverse[self.size()..]));
        }
        inverse
    }
}
