//! Distribution of a contact's force over the nodes around it.
//!
//! Node i carries the weight w_i = b(ρ_i) Σ_f s_f A_f / 3, scaled to Σ w_i = 1: b is a bell of the distance ρ along the
//! boundary, A_f the areas of the faces around the node, and s_f the share of a face that faces the contact (below). The
//! weighted center c = Σ w_i x_i is off the line of the force F through the contact's place p near edges and between
//! irregular nodes, by up to 0.7 radii at corners. A couple makes up for it:
//!
//!   f_i = w_i (F + ω × r_i),  r_i = x_i − c,  S ω = (p − c) × F,  S = Σ w_i (|r_i|² I − r_i r_iᵀ).
//!
//! Because Σ w_i r_i = 0, the couple has no net force. Its moment is Σ w_i r_i × (ω × r_i) = S ω, so the moment of all
//! f_i about p vanishes. Of all corrections with that moment and no net force, it is the least one in Σ |g_i|² / w_i. The
//! forces are linear in F, so opposite forces cancel exactly and those along three axes span all of them.
//!
//! On the edge of a block of five cells, the energy under a contact of 1.5 spacings is 8.2 % below its limit under
//! uniform refinement, at one radius from the edge 2.3 %. Without the couple it was 4.9 % and 1.4 % below the limits of
//! other loads, whose energies are 35 % and 6 % smaller.
//!
//! Based on: the distributing coupling of finite element programs (rigid spiders with weights, RBE3); the same pattern
//! distributes a moment over a group of fasteners.

use super::BoundaryNodes;
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

/// Radius of the bell of a contact, in contact radii, beyond which it is cut off.
pub const BELL_RADII: f64 = 3.0;

/// exp(−9/2): what the bell of a contact is lowered by, so that it ends at 0.
pub const BELL_CUT: f64 = 0.011_108_996_538_242_306;

/// Cosine of the angle between the normals of a face and of the patch below which it carries nothing.
///
/// Faces at up to a right angle carry their full share, so a contact that moves over the edge of a block keeps its load.
/// Between, the share falls linearly. Measured share of the force on the far side of a plate 0.5 radii thick: 0 in the
/// middle, 2.8 % at one radius from the rim, all of it on nodes of the rim (8.0 % without this). With faces below a right
/// angle alone, a force along the touched face at an edge is met by pull on nodes: 23 % of it, and 43 % at a corner,
/// instead of 0 and 3 %; its energy on a fine lattice is up to 80 % higher.
const FACING_AWAY: f64 = -0.5;

/// Length of the mean normal of a patch, over its area, below which the patch is as good as the whole closed surface. Then
/// no face is turned away.
const CLOSED: f64 = 1e-6;

/// Eigenvalue of S, over the largest, below which nodes count as in line. They carry no moment about that line.
const IN_LINE: f64 = 1e-3;

/// A node that a contact loads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LoadedNode {
    /// Lattice node.
    node: u32,
    /// Boundary node.
    own: u32,
    /// Share of the force.
    weight: f64,
    /// Position relative to the weighted center.
    arm: Vector3<f64>,
}

/// Nodes that a contact loads; reused between contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct LoadPatch {
    nodes: Vec<LoadedNode>,
    /// Weighted center of the nodes, relative to the contact's place.
    center: Vector3<f64>,
    /// Inverse of S, without the axes that have no arm.
    inverse: Matrix3<f64>,
    /// Mean outward normal of the faces around the nodes; zero if they have none.
    pub(super) normal: Vector3<f64>,
    /// Length of the mean of the normals by area: 1 if the patch is even.
    pub(super) evenness: f64,
}

impl LoadPatch {
    /// Fills the patch with the nodes that a contact of this radius loads: those `reached` with a positive weight.
    ///
    /// `reached` are boundary nodes and their distances from the contact's place.
    pub(super) fn fill(&mut self, boundary: &BoundaryNodes, place: Point3<f64>, radius: f64, reached: &[(u32, f64)]) {
        let bells = reached.iter().map(|&(node, distance)| (node, bell(distance / radius)));
        let (normal, evenness) = mean_normal(boundary, bells.clone());
        (self.normal, self.evenness) = (normal, evenness);
        self.nodes.clear();
        self.nodes.extend(bells.map(|(node, bell)| LoadedNode {
            node: boundary.nodes[node as usize],
            own: node,
            weight: facing_area(boundary, node, &normal) * bell,
            arm: boundary.positions[node as usize] - place,
        }));
        self.nodes.retain(|own| own.weight > 0.0);
        let total: f64 = self.nodes.iter().map(|own| own.weight).sum();
        self.nodes.iter_mut().for_each(|own| own.weight /= total);
        self.center = self.nodes.iter().map(|own| own.arm * own.weight).sum();
        let mut tensor = Matrix3::zeros();
        for own in &mut self.nodes {
            own.arm -= self.center;
            let square = Matrix3::from_diagonal_element(own.arm.norm_squared());
            tensor += (square - own.arm * own.arm.transpose()) * own.weight;
        }
        self.inverse = inverse(tensor);
    }

    /// Forces of a contact with this force: (lattice node, force).
    pub(super) fn forces(&self, force: Vector3<f64>) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        let spin = self.inverse * force.cross(&self.center);
        self.nodes.iter().map(move |own| (own.node, (force + spin.cross(&own.arm)) * own.weight))
    }

    /// Shares of the force: (boundary node, share).
    pub(super) fn shares(&self) -> impl Iterator<Item = (u32, f64)> {
        self.nodes.iter().map(|own| (own.own, own.weight))
    }
}

/// Inverse of a symmetric positive matrix, zero along axes with an eigenvalue of nearly zero.
fn inverse(tensor: Matrix3<f64>) -> Matrix3<f64> {
    let SymmetricEigen { eigenvectors, eigenvalues } = tensor.symmetric_eigen();
    let least = IN_LINE * eigenvalues.max();
    let inverted = eigenvalues.map(|own| if own > least { 1.0 / own } else { 0.0 });
    eigenvectors * Matrix3::from_diagonal(&inverted) * eigenvectors.transpose()
}

/// Mean normal of the faces around boundary nodes, by area and the weights `bell` of the nodes, and its length before it is
/// normalized; zero if it has none.
///
/// Unlike the normal of the face that the contact touches, it is a continuous function of the contact's place.
fn mean_normal(boundary: &BoundaryNodes, bell: impl Iterator<Item = (u32, f64)>) -> (Vector3<f64>, f64) {
    let (mut sum, mut size) = (Vector3::zeros(), 0.0);
    for (node, bell) in bell {
        let around = boundary.around(node).iter().map(|&face| boundary.doubled_area(face as usize));
        sum += around.sum::<Vector3<f64>>() * bell;
        size += boundary.areas[node as usize] * bell;
    }
    let length = sum.norm();
    if length > CLOSED * size { (sum / length, length / (6.0 * size)) } else { (Vector3::zeros(), 0.0) }
}

/// Area of boundary node `node`, a third of that of the faces around it, as far as these face along `normal`.
fn facing_area(boundary: &BoundaryNodes, node: u32, normal: &Vector3<f64>) -> f64 {
    let share = |&face: &u32| {
        let doubled = boundary.doubled_area(face as usize);
        let size = doubled.norm();
        let cosine = doubled.dot(normal) / size;
        // The comparison is false for NaN, so a face without area counts for nothing.
        if cosine > FACING_AWAY { size / 6.0 * (1.0 - cosine / FACING_AWAY).min(1.0) } else { 0.0 }
    };
    boundary.around(node).iter().map(share).sum()
}

/// The bell of a contact at t radii from its middle. A node's weight starts at 0 when it enters the patch.
pub fn bell(t: f64) -> f64 {
    ((-0.5 * t * t).exp() - BELL_CUT).max(0.0)
}
