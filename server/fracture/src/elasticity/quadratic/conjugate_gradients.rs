//! Solution with quadratic elements by conjugate gradients on several right-hand sides at once.
//!
//! Based on: M. R. Hestenes & E. Stiefel, *Methods of conjugate gradients for solving linear systems* (1952), with the
//! preconditioner of R. E. Bank, *Hierarchical bases and the finite element method* (Acta Numerica 5, 1996): the factor
//! of the linear stiffness on the node functions, and the inverse of its own block on every edge function. The number
//! of steps does not depend on the spacing. No quadratic stiffness is stored or factored: its factor would take tens of
//! times the memory of the linear one.
//!
//! Every step adds a known part to the energy, and the parts of all further steps are the energy that is missing (Z.
//! Strakoš & P. Tichý, *On error estimation in the conjugate gradient method*, ETNA 13, 2002). A column ends when its last
//! few steps together added less than a share of its energy.

use super::EdgeFunctions;
use crate::cancel_token::CancelToken;
use crate::elasticity::residual::dot;
use crate::elasticity::{ElasticWorkspace, Elasticity, ElasticityError, SolveReport, Support};
use crate::sparse::Cholesky;
use nalgebra::Vector3;

/// Number of the last steps whose parts of the energy are added up.
const DELAY: usize = 3;

/// Decrease of the preconditioned norm of the residual, squared, that rounding allows.
const ROUNDING: f64 = 1e-16;

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
    /// Twice the energy, and the parts that the last steps added.
    energy: f64,
    gains: [f64; DELAY],
}

impl Column {
    fn has_converged(&self, accuracy: f64) -> bool {
        self.square <= ROUNDING * self.first || self.gains.iter().sum::<f64>() <= accuracy * self.energy
    }
}

impl Elasticity {
    /// Solves with quadratic elements for any number of columns in place, to the accuracy [`SOLVED`](super::SOLVED) or
    /// [`SNAPSHOT`](super::SNAPSHOT).
    ///
    /// Returns the residuals f − K u of all columns, too.
    ///
    /// # Errors
    /// [`ElasticityError::Residual`], [`ElasticityError::Canceled`], those of [`Self::factor`].
    pub(in crate::elasticity) fn iterate(
        &self,
        edges: &EdgeFunctions,
        columns: &mut [f64],
        accuracy: f64,
        workspace: &mut ElasticWorkspace,
        token: &CancelToken,
    ) -> Result<(SolveReport, Vec<Vec<f64>>), ElasticityError> {
        let (factor, unknowns) = (self.factor()?, self.unknowns());
        let mut states: Vec<Column> = columns.chunks_exact(unknowns).map(|forces| self.begin(edges, forces)).collect();
        columns.fill(0.0);
        let mut active: Vec<(&mut Column, &mut [f64])> =
            states.iter_mut().zip(columns.chunks_exact_mut(unknowns)).collect();
        let (mut preconditioned, mut worst) = (Vec::new(), 0.0_f64);
        for step in 0..STEPS_MAX {
            token.check()?;
            self.precondition(factor, edges, &active, &mut preconditioned, workspace);
            for ((state, _), z) in active.iter_mut().zip(preconditioned.chunks_exact(unknowns)) {
                turn(state, z, step == 0);
            }
            active.retain(|(state, _)| {
                let is_done = state.has_converged(accuracy);
                worst = if is_done { worst.max(relative(state)) } else { worst };
                !is_done
            });
            if active.is_empty() {
                let residuals = states.into_iter().map(|state| state.residual).collect();
                return Ok((SolveReport { residual: worst, sweeps: step }, residuals));
            }
            for (state, displacement) in &mut active {
                state.gains[step % DELAY] = self.advance(edges, state, displacement);
            }
        }
        Err(ElasticityError::Residual { residual: active.iter().map(|(state, _)| relative(state)).fold(0.0, f64::max) })
    }

    fn begin(&self, edges: &EdgeFunctions, forces: &[f64]) -> Column {
        let mut residual = forces.to_vec();
        self.drop_held(edges, &mut residual);
        let zeros = || vec![0.0; forces.len()];
        Column {
            residual,
            direction: zeros(),
            image: zeros(),
            square: 0.0,
            first: 0.0,
            energy: 0.0,
            gains: [f64::INFINITY; DELAY],
        }
    }

    /// One step along the direction of `state`. Returns twice the energy that it added.
    fn advance(&self, edges: &EdgeFunctions, state: &mut Column, displacement: &mut [f64]) -> f64 {
        let Column { residual, direction, image, square, energy, .. } = state;
        edges.multiply(self.lame, &self.elements, direction, image);
        self.drop_held(edges, image);
        let length = *square / dot(direction.as_slice(), image);
        displacement.iter_mut().zip(direction).for_each(|(u, p)| *u += length * *p);
        residual.iter_mut().zip(image).for_each(|(r, q)| *r -= length * *q);
        let gain = length * *square;
        *energy += gain;
        gain
    }

    /// Drops what the anchors carry: the forces on their nodes, and on edges between two of them.
    pub(in crate::elasticity) fn drop_held(&self, edges: &EdgeFunctions, forces: &mut [f64]) {
        let (nodes, edge_part) = forces.split_at_mut(self.size());
        self.support.drop_reactions(nodes);
        if let Support::Anchored(held) = &self.support {
            self.drop_held_edges(edges, held, edge_part);
        }
    }

    /// Sets the entries of the edges between two of the `held` nodes (ascending) to 0.
    pub(in crate::elasticity) fn drop_held_edges(&self, edges: &EdgeFunctions, held: &[u32], edge_part: &mut [f64]) {
        let is_held = |node: &u32| held.binary_search(node).is_ok();
        for (own, _) in edge_part.chunks_exact_mut(3).zip(&edges.ends).filter(|(_, ends)| ends.iter().all(is_held)) {
            own.fill(0.0);
        }
    }

    /// Fills `out` with the preconditioned residuals of all columns.
    fn precondition(
        &self,
        factor: &Cholesky,
        edges: &EdgeFunctions,
        states: &[(&mut Column, &mut [f64])],
        out: &mut Vec<f64>,
        workspace: &mut ElasticWorkspace,
    ) {
        let (size, unknowns) = (self.size(), self.unknowns());
        let mut nodes: Vec<f64> = states.iter().flat_map(|(state, _)| &state.residual[..size]).copied().collect();
        self.back_substitute(factor, &mut nodes, workspace);
        out.resize(unknowns * states.len(), 0.0);
        for ((out, nodes), (state, _)) in out.chunks_exact_mut(unknowns).zip(nodes.chunks_exact(size)).zip(states) {
            let (out_nodes, out_edges) = out.split_at_mut(size);
            out_nodes.copy_from_slice(nodes);
            let residuals = state.residual[size..].chunks_exact(3);
            for ((own, residual), block) in out_edges.chunks_exact_mut(3).zip(residuals).zip(&edges.inverse_blocks) {
                own.copy_from_slice((block * Vector3::from_column_slice(residual)).as_slice());
            }
        }
    }
}

/// The residual over that of the beginning, in the preconditioned norm.
fn relative(state: &Column) -> f64 {
    if state.first > 0.0 { (state.square / state.first).sqrt() } else { 0.0 }
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
