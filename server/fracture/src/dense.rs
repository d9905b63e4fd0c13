//! Dense symmetric eigenpairs by faer, on the calling thread alone.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, MatRef, Par};

/// Why there are no eigenpairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum DenseError {
    /// An entry is not finite.
    #[error("an entry of the matrix is not finite")]
    NotFinite,
    /// faer's capped iteration gave up.
    #[error("the eigenpairs of a matrix of order {order} did not converge")]
    NotConverged {
        /// Rows of the matrix.
        order: usize,
    },
}

/// All eigenpairs of a symmetric matrix, ascending.
pub(crate) struct DenseEigen {
    /// Eigenvalues, ascending.
    pub(crate) values: Vec<f64>,
    /// Orthonormal eigenvectors, column k belongs to `values[k]`.
    pub(crate) vectors: Mat<f64>,
}

/// All eigenpairs of the symmetric matrix whose lower triangle is given.
///
/// # Errors
/// See [`DenseError`].
pub(crate) fn symmetric(matrix: MatRef<'_, f64>) -> Result<DenseEigen, DenseError> {
    let order = matrix.nrows();
    if (0..order).any(|column| (column..order).any(|row| !matrix[(row, column)].is_finite())) {
        return Err(DenseError::NotFinite);
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
        .map_err(|_| DenseError::NotConverged { order })?;
    }
    Ok(DenseEigen { values: values.column_vector().iter().copied().collect(), vectors })
}
