//! Consistent mass of a body of unit density, element by element, without a matrix.
//!
//! With barycentric coordinates λ and edge functions b_e = 4 λ_i λ_j of a tetrahedron of volume V, all products follow
//! from ∫ λ_1^a λ_2^b λ_3^c λ_4^d = 6V a! b! c! d! / (a + b + c + d + 3)!.
//!
//! Based on: T. J. R. Hughes, *The Finite Element Method* (1987), section 7.3, consistent mass; M. A. Eisenberg & L. E.
//! Malvern, *On finite element integration in natural co-ordinates* (International Journal for Numerical Methods in
//! Engineering 7, 1973), for the integrals.

use super::Elasticity;
use crate::lattice::EDGES;
use nalgebra::Vector3;

/// ∫ b_e b_f over V of the same edge, of edges that share a node, and of opposite edges.
const EDGE_PRODUCTS: [f64; 3] = [8.0 / 105.0, 4.0 / 105.0, 2.0 / 105.0];

impl Elasticity {
    /// Writes M u to `product`; both have [`Self::unknowns`] entries. `corners` are the tetrahedra of the body's lattice.
    ///
    /// Runs on the calling thread alone, so that its sums do not depend on the number of threads.
    ///
    /// # Panics
    /// If a length does not fit the body.
    pub(super) fn multiply_mass(&self, corners: &[[u32; 4]], displacement: &[f64], product: &mut [f64]) {
        assert_eq!(corners.len(), self.tets, "corners fit the lattice");
        assert_eq!(displacement.len(), self.unknowns(), "displacement fits the elements");
        assert_eq!(product.len(), self.unknowns(), "product fits the elements");
        product.fill(0.0);
        let at = |place: usize| Vector3::from_column_slice(&displacement[3 * place..][..3]);
        let first_edge = self.size() / 3;
        let volumes = self.elements.blocks.iter().flat_map(|block| block.volumes.0);
        for (tet, (nodes, volume)) in corners.iter().zip(volumes).enumerate() {
            let edges = self.edges.as_ref().map(|edges| edges.tets[tet].map(|edge| first_edge + edge as usize));
            let own = nodes.map(|node| at(node as usize));
            let curved = edges.map_or([Vector3::zeros(); 6], |edges| edges.map(at));
            let (forces, edge_forces) = inertial_forces(&own, &curved);
            let mut add = |place: usize, force: Vector3<f64>| {
                product[3 * place..][..3].iter_mut().zip(force.iter()).for_each(|(own, f)| *own += volume * f);
            };
            nodes.iter().zip(forces).for_each(|(node, force)| add(*node as usize, force));
            edges.into_iter().flatten().zip(edge_forces).for_each(|(edge, force)| add(edge, force));
        }
    }
}

/// Products of the mass of a tetrahedron of unit volume with the displacements of its corners and edges.
fn inertial_forces(nodes: &[Vector3<f64>; 4], edges: &[Vector3<f64>; 6]) -> ([Vector3<f64>; 4], [Vector3<f64>; 6]) {
    let [node_sum, edge_sum]: [Vector3<f64>; 2] = [nodes.iter().sum(), edges.iter().sum()];
    // Sums of the edges at every corner.
    let mut around = [Vector3::zeros(); 4];
    for (edge, ends) in edges.iter().zip(EDGES) {
        ends.into_iter().for_each(|end| around[end] += edge);
    }
    // ∫ λ_i λ_j = (1 + δ_ij) / 20, ∫ λ_k b_e = 1/15 at an end of e and 1/30 elsewhere.
    let forces = std::array::from_fn(|k| (node_sum + nodes[k]) / 20.0 + (edge_sum + around[k]) / 30.0);
    let [same, adjacent, opposite] = EDGE_PRODUCTS;
    let edge_forces = std::array::from_fn(|e| {
        let [i, j] = EDGES[e];
        // Every other edge shares a node but the opposite one, and the sums at both ends contain the edge itself.
        let shared = around[i] + around[j] - edges[e] * 2.0;
        let across = edge_sum - shared - edges[e];
        let bent = edges[e] * same + shared * adjacent + across * opposite;
        bent + (node_sum + nodes[i] + nodes[j]) / 30.0
    });
    (forces, edge_forces)
}
