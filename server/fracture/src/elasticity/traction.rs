//! Loads as tractions instead of forces on nodes.

use super::{Elasticity, Support};
use nalgebra::Vector3;

impl Elasticity {
    /// Forces (length [`Self::unknowns`]) of a traction, in equilibrium unless the body is anchored.
    ///
    /// The traction at a node is the `applied` force on it (ordered by node) over its area, and linear in between.
    /// [`Self::balance`] lumps it on the nodes instead, and quadratic elements see that as a roughness of the load.
    /// ∫ λ_i λ_j over a triangle of area A is A/12, and twice that if i is j.
    pub fn traction_forces(&self, applied: &[(u32, Vector3<f64>)]) -> Vec<f64> {
        let (boundary, size) = (&self.boundary, self.size());
        let mut forces = vec![0.0; self.unknowns()];
        for (node, force) in applied {
            let Ok(dense) = boundary.nodes.binary_search(node) else { continue };
            for &face in boundary.around(dense as u32) {
                let share = boundary.area(face as usize) / (12.0 * boundary.areas[dense]);
                for corner in boundary.faces[face as usize] {
                    let share = if corner == dense as u32 { 2.0 * share } else { share };
                    let own = &mut forces[3 * boundary.nodes[corner as usize] as usize..][..3];
                    own.iter_mut().zip(force.iter()).for_each(|(sum, force)| *sum += share * force);
                }
            }
        }
        if let Some(edges) = &self.edges {
            edges.add_applied(boundary, applied, &mut forces[size..]);
        }
        if let Support::Free(_) = self.support {
            self.relieve(&mut forces);
        }
        forces
    }
}
