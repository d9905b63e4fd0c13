//! Symmetric sparse matrices of small node blocks, and their Cholesky factors.

mod cholesky;
mod signature;
mod symmetric;
#[cfg(test)]
mod tests;

pub use cholesky::{Cholesky, Precision, SolveScratch, SymbolicFactor};
pub use signature::Signature;
pub use symmetric::SymmetricMatrix;

/// Error while building or factoring a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SparseError {
    /// The matrix has no rows.
    #[error("the matrix has no rows")]
    Empty,
    /// An element or entry names a node outside the matrix.
    #[error("index {index} is outside a matrix of {nodes} nodes")]
    IndexOutOfRange {
        /// The node index.
        index: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// An entry is infinite or not a number.
    #[error("entry ({row}, {column}) of the matrix is not finite")]
    NonFinite {
        /// Scalar row.
        row: usize,
        /// Scalar column.
        column: usize,
    },
    /// A pivot was zero, negative or not a number.
    #[error("the matrix is not positive definite: elimination fails at row {pivot}")]
    NotPositiveDefinite {
        /// Scalar row, in the caller's numbering.
        pivot: usize,
    },
    /// Indices or memory do not suffice for the factor.
    #[error("the factor of a matrix of {size} rows is too large")]
    TooLarge {
        /// Scalar rows.
        size: usize,
    },
}
