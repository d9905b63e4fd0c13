//! Solution with quadratic elements by conjugate gradients on several right-hand sides at once.
//!
//! Based on: M. R. Hestenes & E. Stiefel, *Methods of conjugate gradients for solving linear systems* (1952), with the
//! preconditioner of R. E. Bank, *Hierarchical bases and the finite element method* (Acta Numerica 5, 1996): the factor
//! of the linear stiffness on the node functions, and the inverse of its own block on every edge function. The number
//! of steps does not depend on the spacing. No quadratic stiffness is stored or factored: its factor would take tens of
//! times the memory of the linear one.

use super::EdgeFunctions;
use crate::cancel_token::CancelToken;
use crate::elasticity::residual::dot;
use crate::elasticity::{ElasticWorkspace, Elasticity, ElasticityError, SolveReport, Support};
use crate::sparse::Cholesky;
use nalgebra::Vector3;

/// Decrease of the preconditioned norm of the residual, squared, at which a column has converged.
///
/// The norm is about that of the energy, so the energy is then exact to about this value.
const CONVERGED: f64 = 1e-8;

/// Largest number of steps. Strips of 1:100 need 40.
const STEPS_MAX: usize = 1000;

/// One right-hand side.
struct Column {
    residual: Vec<f64>,
    direction: Vec<f64>,
    image: Vec<f64>,
    /// r'M⁻¹r now and at the beginning.
    square: f64,
    first: f64,
}

impl Column {
    fn has_converged(&self) -> bool {
        self.square <= CONVERGED * self.first
    }
}

impl Elasticity {
    /// Solves with quadratic elements for any number of columns in place.
    ///
    /// # Errors
    /// [`ElasticityError::Residual`], [`ElasticityError::Canceled`], those of [`Self::factor`].
    pub(in crate::elasticity) fn iterate(
        &self,
        edges: &EdgeFunctions,
        columns: &mut [f64],
        workspace: &mut ElasticWorkspace,
        token: &CancelToken,
    ) -> Result<SolveReport, ElasticityError> {
        let (factor, unknowns) = (self.factor()?, self.unknowns());
        let mut states: Vec<Column> = columns.chunks_exact(unknowns).map(|forces| self.begin(edges, forces)).collect();
        columns.fill(0.0);
        let mut preconditioned = Vec::new();
        for step in 0..STEPS_MAX {
            token.check()?;
            self.precondition(factor, edges, &states, &mut preconditioned, workspace);
            for (state, z) in states.iter_mut().zip(preconditioned.chunks_exact(unknowns)) {
                turn(state, z, step == 0);
            }
            if states.iter().all(Column::has_converged) {
                return Ok(SolveReport { residual: worst(&states), sweeps: step });
            }
            for (state, displacement) in states.iter_mut().zip(columns.chunks_exact_mut(unknowns)) {
                if !state.has_converged() {
                    self.advance(edges, state, displacement);
                }
            }
        }
        Err(ElasticityError::Residual { residual: worst(&states) })
    }

    fn begin(&self, edges: &EdgeFunctions, forces: &[f64]) -> Column {
        let mut residual = forces.to_vec();
        self.drop_held(edges, &mut residual);
        let zeros = || vec![0.0; forces.len()];
        Column { residual, direction: zeros(), image: zeros(), square: 0.0, first: 0.0 }
    }

    /// One step along the direction of `state`.
    fn advance(&self, edges: &EdgeFunctions, state: &mut Column, displacement: &mut [f64]) {
        let Column { residual, direction, image, square, .. } = state;
        edges.multiply(self.lame, &self.elements, direction, image);
        self.drop_held(edges, image);
        let length = *square / dot(direction.as_slice(), image);
        displacement.iter_mut().zip(direction).for_each(|(u, p)| *u += length * *p);
        residual.iter_mut().zip(image).for_each(|(r, q)| *r -= length * *q);
    }

    /// Drops what the anchors carry: the forces on their nodes, and on edges between two of them.
    pub(in crate::elasticity) fn drop_held(&self, edges: &EdgeFunctions, forces: &mut [f64]) {
        let (nodes, edge_part) = forces.split_at_mut(self.size());
        self.support.drop_reactions(nodes);
        if let Support::Anchored(held) = &self.support {
            let is_held = |node: &u32| held.binary_search(node).is_ok();
            for (own, _) in edge_part.chunks_exact_mut(3).zip(&edges.ends).filter(|(_, ends)| ends.iter().all(is_held))
            {
                own.fill(0.0);
            }
        }
    }

    /// Fills `out` with the preconditioned residuals of all columns.
    fn precondition(
        &self,
        factor: &Cholesky,
        edges: &EdgeFunctions,
        states: &[Column],
        out: &mut Vec<f64>,
        workspace: &mut ElasticWorkspace,
    ) {
        let (size, unknowns) = (self.size(), self.unknowns());
        let mut nodes: Vec<f64> = states.iter().flat_map(|state| &state.residual[..size]).copied().collect();
        self.back_substitute(factor, &mut nodes, workspace);
        out.resize(unknowns * states.len(), 0.0);
        for ((out, nodes), state) in out.chunks_exact_mut(unknowns).zip(nodes.chunks_exact(size)).zip(states) {
            let (out_nodes, out_edges) = out.split_at_mut(size);
            out_nodes.copy_from_slice(nodes);
            let residuals = state.residual[size..].chunks_exact(3);
            for ((own, residual), block) in out_edges.chunks_exact_mut(3).zip(residuals).zip(&edges.inverse_blocks) {
                own.copy_from_slice((block * Vector3::from_column_slice(residual)).as_slice());
            }
        }
    }
}

/// The largest relative residual of any column, in the preconditioned norm.
fn worst(states: &[Column]) -> f64 {
    let loaded = states.iter().filter(|state| state.first > 0.0);
    loaded.map(|state| (state.square / state.first).sqrt()).fold(0.0, f64::max)
}

/// Turns the direction of `state` to the preconditioned residual `z`, conjugate to the one before.
fn turn(state: &mut Column, z: &[f64], is_first: bool) {
    let square = dot(z, &state.residual);
    let ratio = if is_first || state.square == 0.0 { 0.0 } else { square / state.square };
    if is_first {
        state.first = square;
    }
    state.square = square;
    state.direction.iter_mut().zip(z).for_each(|(p, z)| *p = z + ratio * *p);
}
