//! Eigenpairs of dense symmetric matrices, computed by faer on one thread.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, MatRef, Par};
use std::thread;

/// Error of a dense eigenvalue computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum DenseError {
    /// An entry is not finite.
    #[error("an entry of the matrix is not finite")]
    NotFinite,
    /// faer's iteration reached its limit.
    #[error("the eigenpairs of a matrix of order {order} did not converge")]
    NotConverged {
        /// Number of rows.
        order: usize,
    },
}

/// All eigenpairs of a symmetric matrix of order n.
pub(crate) struct DenseEigen {
    /// Eigenvalues, ascending, length n.
    pub(crate) values: Vec<f64>,
    /// Orthonormal eigenvectors, n × n. Column k belongs to `values[k]`.
    pub(crate) vectors: Mat<f64>,
}

/// Computes all eigenpairs of a symmetric matrix. Only its lower triangle is read.
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

/// Runs `compute` on a thread that ends with it, or on this one if the system gives no thread.
///
/// The matrix products of faer keep a buffer per thread, of up to twice the processor's last cache. It is released when the thread ends.
pub(crate) fn on_own_thread(mut compute: impl FnMut() + Send) {
    let thread = thread::scope(|scope| thread::Builder::new().spawn_scoped(scope, &mut compute).map(|own| own.join()));
    match thread {
        Ok(Ok(())) => (),
        Ok(Err(panic)) => std::panic::resume_unwind(panic),
        Err(_) => compute(),
    }
}
