//! Dense symmetric eigenpairs by faer, on the calling thread alone.

use super::LiftError;
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, MatRef, Par};

/// All eigenpairs of a symmetric matrix, ascending.
pub(super) struct Dense {
    /// Eigenvalues, ascending.
    pub(super) values: Vec<f64>,
    /// Orthonormal eigenvectors, column k belongs to `values[k]`.
    pub(super) vectors: Mat<f64>,
}

/// All eigenpairs of the symmetric matrix whose lower triangle is given.
///
/// Errors: [`LiftError::NotFinite`] if an entry is not finite; [`LiftError::NotConverged`] if faer's capped iteration
/// gives up.
pub(super) fn symmetric(matrix: MatRef<'_, f64>) -> Result<Dense, LiftError> {
    let order = matrix.nrows();
    if (0..order).any(|column| (column..order).any(|row| !matrix[(row, column)].is_finite())) {
        return Err(LiftError::NotFinite);
    }
    let mut values = Diag::<f64>::zeros(order);
    let mut vectors = Mat::<f64>::zeros(order, order);
    if order > 0 {
        let scratch = self_adjoint_evd_scratch::<f64>(order, ComputeEigenvectors::Yes, Par::Seq, Default::default());
        self_adjoint_evd(
            matrix,
            values.as_mut(),
            Some(vectors.as_mut()),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        )
        .map_err(|_| LiftError::NotConverged { converged: 0, wanted: order })?;
    }
    Ok(Dense { values: values.column_vector().iter().copied().collect(), vectors })
}
