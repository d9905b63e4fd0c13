//! Forces on the edge functions.

use super::EdgeFunctions;
use crate::elasticity::BoundaryNodes;
use nalgebra::Vector3;

impl EdgeFunctions {
    /// Adds to `forces` (three per edge) those of the `applied` forces on boundary nodes, ordered by node.
    ///
    /// A force on a node is a traction that is its force over its area there, and falls linearly to 0 at the nodes
    /// around it. ∫ 4 λ_j λ_k λ_i over a triangle of area A is A/15, and twice that if i is j or k.
    pub(in crate::elasticity) fn add_applied(
        &self,
        boundary: &BoundaryNodes,
        applied: &[(u32, Vector3<f64>)],
        forces: &mut [f64],
    ) {
        for (node, force) in applied {
            self.loaded(boundary, *node, |edge, share| {
                forces[3 * edge..][..3].iter_mut().zip(force.iter()).for_each(|(sum, force)| *sum += share * force);
            });
        }
    }

    /// Calls `add` with the edges that a force on lattice node `node` loads, and the share of it on each. Edges may repeat.
    pub(in crate::elasticity) fn loaded(&self, boundary: &BoundaryNodes, node: u32, mut add: impl FnMut(usize, f64)) {
        let Ok(dense) = boundary.nodes.binary_search(&node) else { return };
        for &face in boundary.around(dense as u32) {
            let share = boundary.area(face as usize) / (15.0 * boundary.areas[dense]);
            for (edge, opposite) in self.faces[face as usize].iter().zip(boundary.faces[face as usize]) {
                add(*edge as usize, if opposite == dense as u32 { share } else { 2.0 * share });
            }
        }
    }

    /// Subtracts the inertial forces of `acceleration` from `forces` (three per edge).
    pub(in crate::elasticity) fn subtract_inertia(&self, acceleration: &[Vector3<f64>; 2], forces: &mut [f64]) {
        for (edge, own) in forces.chunks_exact_mut(3).enumerate() {
            let inertial = self.inertial_force(edge, acceleration);
            own.iter_mut().zip(inertial.iter()).for_each(|(own, force)| *own -= force);
        }
    }
}
