//! Why nothing was measured.

use crate::cancel_token::Cancelled;
use crate::tessellation::TessellationError;

/// Why nothing was measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AccuracyError {
    /// An array does not fit the lattice or the lift.
    #[error("{array} has {found} entries, {expected} fit")]
    Length {
        /// Which array.
        array: &'static str,
        /// Entries that fit.
        expected: usize,
        /// Entries found.
        found: usize,
    },
    /// Labels that cannot be tessellated.
    #[error(transparent)]
    Tessellation(#[from] TessellationError),
    /// Cancelled at a checkpoint.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl AccuracyError {
    /// Refuses an array of another length.
    pub(super) fn check(array: &'static str, expected: usize, found: usize) -> Result<(), Self> {
        if expected == found { Ok(()) } else { Err(Self::Length { array, expected, found }) }
    }
}
