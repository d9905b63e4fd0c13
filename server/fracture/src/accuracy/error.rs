//! Errors of accuracy measures.

use crate::cancel_token::Canceled;
use crate::tessellation::TessellationError;

/// Error of an accuracy measure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AccuracyError {
    /// An array does not fit the lattice or the lift.
    #[error("{array} has {found} entries, but {expected} are required")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// Required number of entries.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// The labels cannot be tessellated.
    #[error(transparent)]
    Tessellation(#[from] TessellationError),
    /// The work was canceled at a checkpoint.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}

impl AccuracyError {
    /// Fails if an array does not have the expected length.
    pub(super) fn check(array: &'static str, expected: usize, found: usize) -> Result<(), Self> {
        if expected == found { Ok(()) } else { Err(Self::Length { array, expected, found }) }
    }
}
