//! Largest eigenpairs of a symmetric operator, by block Lanczos with full reorthogonalization and thick restarts.
//!
//! Based on: R. G. Grimes, J. G. Lewis & H. D. Simon, *A shifted block Lanczos algorithm for solving sparse symmetric
//! generalized eigenproblems* (SIAM J. Matrix Anal. Appl. 15, 1994), sections 2 and 3 (blocks find multiplets that a
//! single vector misses); K. Wu & H. Simon, *Thick-restart Lanczos method for large symmetric eigenvalue problems*
//! (SIAM J. Matrix Anal. Appl. 22, 2000), for the restart.
//!
//! Termination: every pass of the loop applies the operator to one block, and there are at most [`CYCLES_MAX`] ·
//! [`DIMENSION_MAX`] / [`BLOCK`] passes. Orthogonalization is a fixed number of projections. A NaN ends the iteration
//! at once.

use super::LiftError;
use super::basis::{Basis, length};
use crate::cancel_token::CancelToken;
use crate::dense;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};

/// Vectors per block.
///
/// The operator's cost per vector falls by a factor of two to three up to this size. The first block already finds a
/// multiplet of eight completely.
pub(super) const BLOCK: usize = 8;
/// Number of columns of the Krylov basis before a restart.
pub(super) const DIMENSION_MAX: usize = 256;
/// Largest number of runs: the first and its restarts.
const CYCLES_MAX: usize = 4;
/// Largest residual of a converged pair, relative to its eigenvalue.
const TOLERANCE: f64 = 1e-11;
/// Share of the largest eigenvalue below which another is rounding noise of an operator of lower rank.
const NOISE: f64 = 1e-10;

/// Computes orthonormal eigenvectors of the `wanted` largest eigenvalues of a symmetric positive operator.
///
/// The operator must map the unit vector `deflated` to a multiple of itself; only vectors orthogonal to it are found.
/// The result is column-major, `order × wanted`, with the largest eigenvalue first. The Rayleigh quotients of the
/// vectors are better eigenvalues than those of the iteration. `apply` replaces a block (column-major, `order × width`,
/// width at most [`BLOCK`]) by its image. The token is polled before every application.
///
/// # Errors
/// [`LiftError::TooFewNodes`] unless `wanted` + 4 blocks fit both the space and [`DIMENSION_MAX`]; [`LiftError::NotConverged`],
/// also if the operator has fewer than `wanted` positive eigenvalues; [`LiftError::NotFinite`]; [`LiftError::Canceled`].
pub(super) fn largest(
    deflated: &[f64],
    wanted: usize,
    mut apply: impl FnMut(&mut [f64], usize),
    token: &CancelToken,
) -> Result<Vec<f64>, LiftError> {
    let order = deflated.len();
    let dimension = DIMENSION_MAX.min(order.saturating_sub(1 + BLOCK));
    if dimension < wanted + 4 * BLOCK {
        return Err(LiftError::TooFewNodes { nodes: order, wanted, needed: wanted + 5 * BLOCK + 1 });
    }
    let mut krylov = Krylov::new(deflated, dimension)?;
    let mut converged = 0;
    for _ in 0..CYCLES_MAX {
        while krylov.explored + BLOCK <= dimension {
            token.check()?;
            krylov.step(&mut apply)?;
            if krylov.explored >= wanted + BLOCK {
                let ritz = krylov.ritz()?;
                converged = ritz.converged(wanted);
                if converged >= wanted {
                    return Ok(krylov.vectors(&ritz, wanted));
                }
            }
        }
        krylov.restart(wanted + BLOCK)?;
    }
    Err(LiftError::NotConverged { converged, wanted })
}

/// Basis [deflated, explored columns, pending block], and the operator projected on the explored columns.
struct Krylov {
    basis: Basis,
    /// Number of columns to which the operator was applied.
    explored: usize,
    /// Qᵀ C Q of the explored columns; both triangles.
    projected: Mat<f64>,
    /// Coupling of the last explored block to the pending one: C Q_last = Q(…) + Q_pending · factor.
    factor: Mat<f64>,
}

/// Eigenpairs of the projected operator, ascending, with the residual of each.
struct Ritz {
    dense: dense::DenseEigen,
    residuals: Vec<f64>,
}

impl Ritz {
    /// Number of converged pairs among the `wanted` largest, counted from the largest to the first that is not.
    fn converged(&self, wanted: usize) -> usize {
        let noise = self.dense.values.last().map_or(0.0, |largest| NOISE * largest.max(0.0));
        let largest = self.dense.values.iter().zip(&self.residuals).rev().take(wanted);
        largest.take_while(|(value, residual)| **value > noise && **residual <= TOLERANCE * **value).count()
    }
}

impl Krylov {
    fn new(deflated: &[f64], dimension: usize) -> Result<Self, LiftError> {
        let mut basis = Basis::new(deflated, 1 + dimension + BLOCK);
        for _ in 0..BLOCK {
            basis.append_random()?;
        }
        let projected = Mat::zeros(dimension, dimension);
        Ok(Self { basis, explored: 0, projected, factor: Mat::zeros(BLOCK, BLOCK) })
    }

    /// Applies the operator to the pending block and makes the image the next pending block.
    fn step(&mut self, apply: &mut impl FnMut(&mut [f64], usize)) -> Result<(), LiftError> {
        let order = self.basis.order();
        let mut block = self.basis.tail(1 + self.explored).to_vec();
        apply(&mut block, BLOCK);
        let lengths: Vec<f64> = block.chunks_exact(order).map(length).collect();
        if lengths.iter().any(|length| !length.is_finite()) {
            return Err(LiftError::NotFinite);
        }
        let coefficients = self.basis.project(&mut block);
        for column in 0..BLOCK {
            for row in 0..self.explored + BLOCK {
                // Row 0 of the coefficients belongs to the deflated vector, which is no part of the projected operator.
                let value = coefficients[(row + 1, column)];
                self.projected[(row, self.explored + column)] = value;
                self.projected[(self.explored + column, row)] = value;
            }
        }
        self.factor = self.basis.append(&mut block, &lengths)?;
        self.explored += BLOCK;
        Ok(())
    }

    fn ritz(&self) -> Result<Ritz, LiftError> {
        let dense = dense::symmetric(self.projected.submatrix(0, 0, self.explored, self.explored))?;
        let last = dense.vectors.submatrix(self.explored - BLOCK, 0, BLOCK, self.explored);
        let mut coupled = Mat::<f64>::zeros(BLOCK, self.explored);
        matmul(&mut coupled, Accum::Replace, &self.factor, last, 1.0, Par::Seq);
        let residuals = (0..self.explored).map(|column| coupled.col(column).norm_l2()).collect();
        Ok(Ritz { dense, residuals })
    }

    /// Keeps the `kept` largest Ritz vectors and the pending block.
    fn restart(&mut self, kept: usize) -> Result<(), LiftError> {
        let Ritz { dense, .. } = self.ritz()?;
        let first = self.explored - kept;
        self.basis.restart(dense.vectors.submatrix(0, first, self.explored, kept), BLOCK);
        self.projected.fill(0.0);
        for (index, value) in dense.values[first..].iter().enumerate() {
            self.projected[(index, index)] = *value;
        }
        self.explored = kept;
        Ok(())
    }

    /// The `wanted` largest Ritz vectors, the largest first.
    fn vectors(&self, ritz: &Ritz, wanted: usize) -> Vec<f64> {
        let (order, first) = (self.basis.order(), self.explored - wanted);
        let chosen = ritz.dense.vectors.submatrix(0, first, self.explored, wanted).reverse_cols();
        let mut vectors = vec![0.0; order * wanted];
        let target = MatMut::from_column_major_slice_mut(&mut vectors, order, wanted);
        matmul(target, Accum::Replace, self.basis.view(1, self.explored), chosen, 1.0, Par::Seq);
        vectors
    }
}
