//! Why a lift could not be made.

use crate::cancel_token::Cancelled;
use crate::dense::DenseError;

/// Why a lift could not be made. Every variant names what it is about; none is a matter of luck, so none is worth a
/// retry with the same input.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LiftError {
    /// More eigenpairs than the lattice has non-constant functions, or no tetrahedron at all.
    #[error("too few nodes: {wanted} eigenpairs need {needed} nodes, the lattice has {nodes}")]
    TooFewNodes {
        /// Nodes of the lattice.
        nodes: usize,
        /// Eigenpairs asked for.
        wanted: usize,
        /// Nodes needed at least.
        needed: usize,
    },
    /// More eigenpairs than [`super::MODES_MAX`].
    #[error("too many modes: {modes} asked for, at most {max} are computed")]
    TooManyModes {
        /// Modes asked for.
        modes: usize,
        /// [`super::MODES_MAX`].
        max: usize,
    },
    /// α is negative or not finite.
    #[error("alpha must be finite and not negative, not {alpha}")]
    InvalidAlpha {
        /// The α given.
        alpha: f64,
    },
    /// A tetrahedron without positive, finite volume.
    #[error("tetrahedron {tet} has no positive, finite volume")]
    DegenerateTet {
        /// Index of the first such tetrahedron.
        tet: usize,
    },
    /// A triangle of the boundary without positive, finite area.
    #[error("boundary triangle {face} has no positive, finite area")]
    DegenerateFace {
        /// Index of the first such triangle.
        face: usize,
    },
    /// The boundary has more shells (the outer one and cavities) than a surface lift tells apart.
    #[error("the boundary has {shells} shells, at most {max} are told apart")]
    TooManyShells {
        /// Shells of the boundary.
        shells: usize,
        /// [`super::SHELLS_MAX`].
        max: usize,
    },
    /// The lift folds half of the body or more onto something without volume, so that it has no scale.
    #[error("the lift is flat: half of the body is stretched {stretch:e} times as much one way as another")]
    Flat {
        /// Median of σ₁/σ₃; infinite where σ₃ vanishes.
        stretch: f64,
    },
    /// The lattice is not connected: distances between its parts are infinite.
    #[error("the lattice has {components} components; a lift needs one")]
    Disconnected {
        /// Connected components, nodes that belong to no tetrahedron counted too.
        components: usize,
    },
    /// The Laplacian could not be assembled or, shifted, not be factored.
    #[error("the Laplacian could not be assembled or factored")]
    Sparse(#[from] crate::sparse::SparseError),
    /// The operator gave a number that is not finite.
    #[error("the eigenvalue iteration met a number that is not finite")]
    NotFinite,
    /// The iteration reached its limit.
    #[error("{converged} of {wanted} eigenpairs converged within the iteration's limit")]
    NotConverged {
        /// Leading eigenpairs that had converged.
        converged: usize,
        /// Eigenpairs asked for.
        wanted: usize,
    },
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<DenseError> for LiftError {
    fn from(error: DenseError) -> Self {
        match error {
            DenseError::NotFinite => Self::NotFinite,
            DenseError::NotConverged { order } => Self::NotConverged { converged: 0, wanted: order },
        }
    }
}
