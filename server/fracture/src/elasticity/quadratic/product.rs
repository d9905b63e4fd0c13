//! Products of the quadratic stiffness with a displacement, element by element, without a matrix.
//!
//! The strain is linear in a tetrahedron, so products of strains are integrated exactly: ∫ λ_i λ_j = V (1 + δ_ij) / 20.

use super::EdgeFunctions;
use crate::elasticity::blocks::{Elements, SIDE};
use crate::elasticity::element::{Element, Lame};
use crate::elasticity::strain::Strain;
use crate::lattice::EDGES;
use crate::simd::{SimdLanes, widest};
use pulp::NullaryFnOnce;

/// Numbers of [`SIDE`] tetrahedra.
type Lanes = SimdLanes<SIDE>;

/// Vectors of [`SIDE`] tetrahedra.
pub(super) type LaneVector = [Lanes; 3];

/// Matrix of [`SIDE`] tetrahedra, by row.
pub(super) type LaneMatrix = [LaneVector; 3];

/// Zeros.
const ZERO: LaneVector = [SimdLanes([0.0; SIDE]); 3];

/// Displacement gradients ∂u_i/∂x_j at the four corners of [`SIDE`] tetrahedra. They are linear in between.
#[inline(always)]
pub(super) fn corner_gradients(
    gradients: &[LaneVector; 4],
    (corners, edges): (&[[u32; 4]], &[[u32; 6]]),
    (nodes, edge_part): (&[f64], &[f64]),
) -> [LaneMatrix; 4] {
    gradients_of(gradients, &gathered(corners, nodes), &gathered(edges, edge_part))
}

/// As [`corner_gradients`], from the displacements `u` of the corners and the coefficients `c` of the edges.
#[inline(always)]
fn gradients_of(gradients: &[LaneVector; 4], u: &[LaneVector; 4], c: &[LaneVector; 6]) -> [LaneMatrix; 4] {
    let mut mean = [ZERO; 3];
    for node in 1..4 {
        for (i, row) in mean.iter_mut().enumerate() {
            let stretch = u[node][i] - u[0][i];
            row.iter_mut().zip(&gradients[node]).for_each(|(own, g)| *own = *own + stretch * *g);
        }
    }
    let mut all = [mean; 4];
    for (c, [a, b]) in c.iter().zip(EDGES) {
        for (corner, other) in [(a, b), (b, a)] {
            for (row, c) in all[corner].iter_mut().zip(c) {
                row.iter_mut().zip(&gradients[other]).for_each(|(own, g)| *own = *own + *c * *g * 4.0);
            }
        }
    }
    all
}

/// Forces of one tetrahedron on its corners and edges, under [`SIDE`] displacements of them.
#[inline(always)]
pub(in crate::elasticity) fn element_forces(
    lame: Lame,
    element: &Element,
    u: &[LaneVector; 4],
    c: &[LaneVector; 6],
) -> ([LaneVector; 4], [LaneVector; 6]) {
    let gradients = element.gradients.map(|own| [own.x, own.y, own.z].map(SimdLanes::all));
    let at_corners = gradients_of(&gradients, u, c);
    resultants(lame, SimdLanes::all(element.volume), &gradients, &at_corners)
}

/// Strain, the symmetric part of a displacement gradient.
#[inline(always)]
pub(super) fn strain(h: &LaneMatrix) -> Strain<SIDE> {
    let sheared = |i: usize, j: usize| (h[i][j] + h[j][i]) * 0.5;
    [h[0][0], h[1][1], h[2][2], sheared(0, 1), sheared(1, 2), sheared(0, 2)]
}

#[inline(always)]
fn gathered<const K: usize>(places: &[[u32; K]], values: &[f64]) -> [LaneVector; K] {
    let mut all = [ZERO; K];
    for (lane, places) in places.iter().enumerate().take(SIDE) {
        for (own, place) in all.iter_mut().zip(places) {
            let values = &values[3 * *place as usize..][..3];
            own.iter_mut().zip(values).for_each(|(own, value)| own.0[lane] = *value);
        }
    }
    all
}

#[inline(always)]
fn scatter<const K: usize>(places: &[[u32; K]], added: &[LaneVector; K], values: &mut [f64]) {
    for (lane, places) in places.iter().enumerate().take(SIDE) {
        for (own, place) in added.iter().zip(places) {
            let values = &mut values[3 * *place as usize..][..3];
            values.iter_mut().zip(own).for_each(|(value, own)| *value += own.0[lane]);
        }
    }
}

/// Kernel that adds K u of all tetrahedra.
struct Product<'a> {
    lame: Lame,
    elements: &'a Elements,
    edge_functions: &'a EdgeFunctions,
    displacement: (&'a [f64], &'a [f64]),
    forces: (&'a mut [f64], &'a mut [f64]),
}

impl NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let EdgeFunctions { corners, tets: edges, .. } = self.edge_functions;
        let places = corners.chunks(SIDE).zip(edges.chunks(SIDE));
        for (block, (corners, edges)) in self.elements.blocks.iter().zip(places) {
            let gradients = block.all_gradients();
            let at_corners = corner_gradients(&gradients, (corners, edges), self.displacement);
            let (nodes, edge_part) = resultants(self.lame, block.volumes, &gradients, &at_corners);
            scatter(corners, &nodes, self.forces.0);
            scatter(edges, &edge_part, self.forces.1);
        }
    }
}

/// Forces of the stresses on the functions of the corners and of the edges.
#[inline(always)]
fn resultants(
    lame: Lame,
    volumes: Lanes,
    gradients: &[LaneVector; 4],
    at_corners: &[LaneMatrix; 4],
) -> ([LaneVector; 4], [LaneVector; 6]) {
    let weight = volumes * (1.0 / 20.0);
    let own = at_corners.each_ref().map(|h| stress(lame, h, weight));
    let mut sum = [ZERO; 3];
    for own in &own {
        for (sum, own) in sum.iter_mut().zip(own) {
            sum.iter_mut().zip(own).for_each(|(sum, own)| *sum = *sum + *own);
        }
    }
    let mut nodes = [ZERO; 4];
    for node in 1..4 {
        let force = product(&sum, &gradients[node], 5.0);
        nodes[0] = difference(&nodes[0], &force);
        nodes[node] = force;
    }
    // ∫ λ_k σ.
    let moments = own.map(|mut own| {
        for (own, sum) in own.iter_mut().zip(&sum) {
            own.iter_mut().zip(sum).for_each(|(own, sum)| *own = *own + *sum);
        }
        own
    });
    let edges = EDGES.map(|[a, b]| {
        let (one, other) = (product(&moments[a], &gradients[b], 4.0), product(&moments[b], &gradients[a], 4.0));
        std::array::from_fn(|axis| one[axis] + other[axis])
    });
    (nodes, edges)
}

/// Stress of a displacement gradient, times `weight`.
#[inline(always)]
fn stress(lame: Lame, h: &LaneMatrix, weight: Lanes) -> LaneMatrix {
    let pressure = (h[0][0] + h[1][1] + h[2][2]) * weight * lame.lambda;
    let twice = weight * lame.mu;
    let mut stress: LaneMatrix = std::array::from_fn(|i| std::array::from_fn(|j| (h[i][j] + h[j][i]) * twice));
    for (i, row) in stress.iter_mut().enumerate() {
        row[i] = row[i] + pressure;
    }
    stress
}

#[inline(always)]
fn product(matrix: &LaneMatrix, vector: &LaneVector, factor: f64) -> LaneVector {
    matrix.map(|row| (row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2]) * factor)
}

#[inline(always)]
fn difference(a: &LaneVector, b: &LaneVector) -> LaneVector {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

impl EdgeFunctions {
    /// Writes K u to `forces`; both have three components per node, then three per edge.
    ///
    /// Runs on the calling thread alone, so that its sums do not depend on the number of threads.
    pub(in crate::elasticity) fn multiply(
        &self,
        lame: Lame,
        elements: &Elements,
        displacement: &[f64],
        forces: &mut [f64],
    ) {
        forces.fill(0.0);
        let nodes = forces.len() - 3 * self.count();
        let (displacement, forces) = (displacement.split_at(nodes), forces.split_at_mut(nodes));
        widest(Product { lame, elements, edge_functions: self, displacement, forces });
    }
}
