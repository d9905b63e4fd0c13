//! Errors of lift computation.

use crate::cancel_token::Canceled;
use crate::dense::DenseError;

/// Error of computing a lift. Deterministic: a retry with the same input fails the same way.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LiftError {
    /// The lattice has fewer non-constant functions than the requested eigenpairs, or no tetrahedron.
    #[error("too few nodes: {wanted} eigenpairs need {needed} nodes, but the lattice has {nodes}")]
    TooFewNodes {
        /// Number of nodes of the lattice.
        nodes: usize,
        /// Number of requested eigenpairs.
        wanted: usize,
        /// Smallest number of nodes needed.
        needed: usize,
    },
    /// More eigenpairs than [`super::MODES_MAX`] were requested.
    #[error("too many modes: {modes} requested, at most {max} are computed")]
    TooManyModes {
        /// Number of requested modes.
        modes: usize,
        /// Largest number, [`super::MODES_MAX`].
        max: usize,
    },
    /// α is negative or not finite.
    #[error("alpha must be finite and not negative, not {alpha}")]
    InvalidAlpha {
        /// Requested α.
        alpha: f64,
    },
    /// A tetrahedron has no positive, finite volume.
    #[error("tetrahedron {tet} has no positive, finite volume")]
    DegenerateTet {
        /// Index of the first such tetrahedron.
        tet: usize,
    },
    /// A boundary triangle has no positive, finite area.
    #[error("boundary triangle {face} has no positive, finite area")]
    DegenerateFace {
        /// Index of the first such triangle.
        face: usize,
    },
    /// The boundary has more shells (the outer one and cavities) than a surface lift distinguishes.
    #[error("the boundary has {shells} shells, at most {max} are supported")]
    TooManyShells {
        /// Number of shells of the boundary.
        shells: usize,
        /// Largest number, [`super::SHELLS_MAX`].
        max: usize,
    },
    /// The lift collapses half of the body or more to something without volume, so it has no scale.
    #[error("the lift is flat: half of the body is stretched {stretch:e} times as much in one direction as in another")]
    Flat {
        /// Median of σ₁/σ₃; infinite if σ₃ vanishes.
        stretch: f64,
    },
    /// The lattice is not connected, so distances between its parts are infinite.
    #[error("the lattice has {components} components; a lift needs one")]
    Disconnected {
        /// Number of connected components. A node of no tetrahedron counts as one.
        components: usize,
    },
    /// The Laplacian could not be assembled, or its shifted form not factored.
    #[error("the Laplacian could not be assembled or factored")]
    Sparse(#[from] crate::sparse::SparseError),
    /// The operator returned a number that is not finite.
    #[error("the eigenvalue iteration produced a number that is not finite")]
    NotFinite,
    /// The iteration reached its limit.
    #[error("{converged} of {wanted} eigenpairs converged within the iteration's limit")]
    NotConverged {
        /// Number of leading eigenpairs that converged.
        converged: usize,
        /// Number of requested eigenpairs.
        wanted: usize,
    },
    /// The work was canceled.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}

impl From<DenseError> for LiftError {
    fn from(error: DenseError) -> Self {
        match error {
            DenseError::NotFinite => Self::NotFinite,
            DenseError::NotConverged { order } => Self::NotConverged { converged: 0, wanted: order },
        }
    }
}
