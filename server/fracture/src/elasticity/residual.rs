//! Residual of a reduced displacement, without expanding the displacement.
//!
//! Based on: C. Prud'homme, D. V. Rovas, K. Veroy, L. Machiels, Y. Maday, A. T. Patera & G. Turinici, *Reliable
//! real-time solution of parametrized partial differential equations: reduced-basis output bound methods*
//! (Journal of Fluids Engineering 124, 2002): the square of a residual f − K B q is a quadratic form whose large
//! part depends on the body alone.
//!
//! Here the norm is that of D⁻¹, with D the diagonal of K. Forces are a few applied ones less the inertial ones of a
//! rigid acceleration: f'D⁻¹f − 2 f'D⁻¹KB q + q'(B'KD⁻¹KB) q.

use super::force_sums::ForceSums;
use super::quadratic::EdgeFunctions;
use super::{ElasticWorkspace, Elasticity, NodalLoad};
use crate::memory::held;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use nalgebra::{Matrix6, Vector3, Vector6};
use rayon::prelude::*;

/// Nodes whose rows of K B are computed together.
const NODES: usize = 512;

/// Quadratic form of the residual for one basis.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualForm {
    /// B'KD⁻¹KB, `rank × rank`.
    gram: Vec<f64>,
    /// B'KD⁻¹m of the inertial forces m of the six unit accelerations, `rank` entries each.
    inertial: [Vec<f64>; 6],
    /// m'D⁻¹m, 6 × 6.
    inertia: Matrix6<f64>,
    /// 1/K_ii, one entry per component.
    inverse_diagonal: Vec<f64>,
}

/// B'KD⁻¹KB of a basis (one row of `rank` per component) of `body`, on all threads of the current pool.
pub(super) fn gram(body: &Elasticity, rank: usize, basis: &[f32]) -> Vec<f64> {
    let nodes: Vec<usize> = (0..body.size() / 3).collect();
    let inverse_diagonal = body.inverse_diagonal();
    let part = |nodes: &[usize]| {
        let mut rows = vec![0.0; 3 * nodes.len() * rank];
        for (own, node) in rows.chunks_exact_mut(3 * rank).zip(nodes) {
            let (columns, blocks) = body.stiffness.row(*node);
            for (column, block) in columns.iter().zip(blocks) {
                let other = &basis[3 * *column as usize * rank..][..3 * rank];
                for (axis, own) in own.chunks_exact_mut(rank).enumerate() {
                    let scale = inverse_diagonal[3 * node + axis].sqrt();
                    for (k, other) in other.chunks_exact(rank).enumerate() {
                        let factor = scale * block[(axis, k)];
                        own.iter_mut().zip(other).for_each(|(own, b)| *own += factor * f64::from(*b));
                    }
                }
            }
        }
        let rows = MatRef::from_row_major_slice(&rows, 3 * nodes.len(), rank);
        let mut gram = Mat::<f64>::zeros(rank, rank);
        matmul(&mut gram, Accum::Replace, rows.transpose(), rows, 1.0, Par::Seq);
        gram
    };
    let parts: Vec<Mat<f64>> = nodes.par_chunks(NODES).map(part).collect();
    let mut sum = vec![0.0; rank * rank];
    let mut total = MatMut::from_column_major_slice_mut(&mut sum, rank, rank);
    // Summed in a fixed order for any number of threads.
    parts.iter().for_each(|part| total += part);
    sum
}

impl ResidualForm {
    /// Builds the form of a basis of `body` with this `gram`.
    pub(super) fn new(body: &Elasticity, rank: usize, basis: &[f32], gram: Vec<f64>) -> Self {
        let inverse_diagonal = body.inverse_diagonal();
        // D⁻¹m, then K D⁻¹m.
        let weighted = weighted_inertia(body, &inverse_diagonal);
        let inertial = weighted.each_ref().map(|weighted| {
            let mut stiff = vec![0.0; body.size()];
            body.stiffness.multiply(weighted, &mut stiff);
            let mut sum = vec![0.0; rank];
            stiff.iter().zip(basis.chunks_exact(rank)).for_each(|(k, row)| {
                sum.iter_mut().zip(row).for_each(|(sum, b)| *sum += k * f64::from(*b));
            });
            sum
        });
        Self { gram, inertial, inertia: inertia(body, &weighted), inverse_diagonal }
    }

    /// Builds the form of a basis of quadratic displacements of `body` from its stored `gram` and `inertial` products.
    pub(super) fn quadratic(body: &Elasticity, gram: Vec<f64>, inertial: [Vec<f64>; 6]) -> Self {
        let inverse_diagonal = body.inverse_diagonal();
        let inertia = inertia(body, &weighted_inertia(body, &inverse_diagonal));
        Self { gram, inertial, inertia, inverse_diagonal }
    }

    /// B'KD⁻¹KB, `rank × rank`.
    pub(super) fn gram(&self) -> &[f64] {
        &self.gram
    }

    /// Bytes of memory that it holds.
    pub(super) fn bytes(&self) -> usize {
        held(&self.gram) + held(&self.inverse_diagonal) + self.inertial.iter().map(held).sum::<usize>()
    }

    /// ½ r'D⁻¹r of the displacement of `body` with these coordinates under `load`. `gather` adds B'f of forces.
    pub(super) fn energy(
        &self,
        body: &Elasticity,
        load: &NodalLoad,
        coordinates: &[f64],
        gather: impl Fn(&ForceSums, &mut [f64]),
        workspace: &mut ElasticWorkspace,
    ) -> f64 {
        let acceleration = Vector6::from_iterator(load.acceleration.iter().flatten().copied());
        let mut forces = acceleration.dot(&(self.inertia * acceleration));
        let ElasticWorkspace { pulled, gathered, .. } = workspace;
        pulled.begin(body.size() / 3);
        for (node, applied) in load.applied.iter().map(|(node, applied)| (*node as usize, applied)) {
            let inverse = Vector3::from_column_slice(&self.inverse_diagonal[3 * node..3 * node + 3]);
            let inertial = body.inertia.force(node, &load.acceleration);
            let whole = applied - inertial;
            forces += inverse.dot(&(whole.component_mul(&whole) - inertial.component_mul(&inertial)));
            let weighted = (whole + inertial).component_mul(&inverse);
            let (columns, blocks) = body.stiffness.row(node);
            columns.iter().zip(blocks).for_each(|(column, block)| pulled.add(*column, block.tr_mul(&weighted)));
        }
        gathered.clear();
        gathered.resize(coordinates.len(), 0.0);
        gather(pulled, gathered);
        self.sum(forces, gathered, coordinates, &acceleration)
    }

    /// As [`Self::energy`] for quadratic elements. `gather` adds the products of forces on nodes with the trace of D⁻¹KB.
    pub(super) fn quadratic_energy(
        &self,
        (body, edges): (&Elasticity, &EdgeFunctions),
        load: &NodalLoad,
        coordinates: &[f64],
        gather: impl Fn(&mut [f64]),
        workspace: &mut ElasticWorkspace,
    ) -> f64 {
        let acceleration = Vector6::from_iterator(load.acceleration.iter().flatten().copied());
        let mut forces = acceleration.dot(&(self.inertia * acceleration));
        let ElasticWorkspace { pulled, gathered, .. } = workspace;
        let mut add = |place: usize, applied: &Vector3<f64>, inertial: &Vector3<f64>| {
            let inverse = Vector3::from_column_slice(&self.inverse_diagonal[place..place + 3]);
            let whole = applied - inertial;
            forces += inverse.dot(&(whole.component_mul(&whole) - inertial.component_mul(inertial)));
        };
        pulled.begin(edges.count());
        for (node, applied) in &load.applied {
            add(3 * *node as usize, applied, &body.inertia.force(*node as usize, &load.acceleration));
            edges.loaded(&body.boundary, *node, |edge, share| pulled.add(edge as u32, applied * share));
        }
        for (edge, applied) in pulled.iter() {
            add(body.size() + 3 * edge, &applied, &edges.inertial_force(edge, &load.acceleration));
        }
        gathered.clear();
        gathered.resize(coordinates.len(), 0.0);
        gather(gathered);
        self.sum(forces, gathered, coordinates, &acceleration)
    }

    /// Half of f'D⁻¹f − 2 f'D⁻¹KB q + q'(B'KD⁻¹KB) q, with the first part of the second term gathered.
    fn sum(&self, forces: f64, gathered: &[f64], coordinates: &[f64], acceleration: &Vector6<f64>) -> f64 {
        let mut cross = dot(gathered, coordinates);
        for (inertial, acceleration) in self.inertial.iter().zip(acceleration) {
            cross -= acceleration * dot(inertial, coordinates);
        }
        let rows = self.gram.chunks_exact(coordinates.len()).zip(coordinates);
        let displacement: f64 = rows.map(|(row, q)| q * dot(row, coordinates)).sum();
        // Rounding may leave a negative value for balanced forces.
        0.5 * (forces - 2.0 * cross + displacement).max(0.0)
    }
}

/// D⁻¹m of the inertial forces of six unit accelerations.
fn weighted_inertia(body: &Elasticity, inverse_diagonal: &[f64]) -> [Vec<f64>; 6] {
    let weighted = |(force, inverse): (f64, &f64)| force * inverse;
    std::array::from_fn(|axis| body.inertial_forces(axis).into_iter().zip(inverse_diagonal).map(weighted).collect())
}

/// m'D⁻¹m, 6 × 6.
fn inertia(body: &Elasticity, weighted: &[Vec<f64>; 6]) -> Matrix6<f64> {
    let product = |(force, weighted): (f64, &f64)| force * weighted;
    Matrix6::from_fn(|i, j| body.inertial_forces(i).into_iter().zip(&weighted[j]).map(product).sum())
}

/// Lanes of a sum. They fix the order of summation and allow SIMD.
const LANES: usize = 8;

/// Dot product of two rows of equal length.
pub(super) fn dot<T: Copy + Into<f64>>(a: &[T], b: &[f64]) -> f64 {
    let (chunks, others) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = chunks.remainder().iter().zip(others.remainder()).map(|(a, b)| (*a).into() * b).sum::<f64>();
    let mut lanes = [0.0; LANES];
    for (a, b) in chunks.zip(others) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += (*a).into() * b;
        }
    }
    lanes.iter().sum::<f64>() + rest
}

/// Unit acceleration number `axis`: linear x, y, z, angular x, y, z.
pub(super) fn unit(axis: usize) -> [Vector3<f64>; 2] {
    let mut unit = [Vector3::zeros(); 2];
    unit[axis / 3][axis % 3] = 1.0;
    unit
}
