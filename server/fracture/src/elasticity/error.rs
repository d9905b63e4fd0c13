//! What this room refuses, one noun per rule.

use crate::cancel_token::Cancelled;
use crate::sparse::SparseError;

/// The largest Poisson's ratio accepted: linear tetrahedra lock towards ½.
///
/// Measured shortfall of the energy in pure bending, eight cells across, cubes cut into six tetrahedra (the worst
/// case): 5 % at ν = 0, 6 % at 0.3, 9 % at 0.4, 14 % at 0.45, 36 % at 0.49, 72 % at 0.499. Cubes with nodes in their
/// centers and faces hardly lock: six across, 2.2 %, 1.9 %, 2.0 %, 2.1 %, 2.2 % and 2.2 %.
pub const POISSON_MAX: f64 = 0.45;

/// The largest relative residual ‖f − K u‖ / ‖f‖ that is returned as a solution, unless it is rounding
/// ([`ROUNDING_MAX`](super::ROUNDING_MAX)). Compact bodies leave 1e-14, a needle of 1:100 2e-8. A mechanism or a load out of equilibrium
/// leaves about 1.
pub const RESIDUAL_MAX: f64 = 1e-6;

/// Why a body was not prepared or an impact was not solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ElasticityError {
    /// No tetrahedron.
    #[error("the lattice has no tetrahedra")]
    EmptyLattice,
    /// A tetrahedron without positive, finite volume.
    #[error("tetrahedron {tet} has no positive volume")]
    DegenerateTet {
        /// Its index.
        tet: usize,
    },
    /// Poisson's ratio outside −1 < ν < ½, where no isotropic solid is.
    #[error("Poisson's ratio {poisson} is not in −1 < ν < 0.5")]
    PoissonOutOfRange {
        /// The offender.
        poisson: f64,
    },
    /// Poisson's ratio so close to ½ that linear tetrahedra lock.
    #[error("Poisson's ratio {poisson} exceeds {POISSON_MAX}: linear tetrahedra lock there and would be too stiff")]
    LockingPoisson {
        /// The offender.
        poisson: f64,
    },
    /// An anchored node that is not there.
    #[error("anchored node {node} is not in the lattice")]
    UnknownAnchor {
        /// Its index.
        node: u32,
    },
    /// Anchored nodes about which the body can still turn.
    #[error("{nodes} nodes are anchored, and all lie on a line: the body can turn about it")]
    AnchorsInLine {
        /// How many.
        nodes: usize,
    },
    /// The stiffness could not be factored.
    #[error("the stiffness matrix cannot be factored")]
    Stiffness(#[from] SparseError),
    /// Parts of the body hang together by an edge or a node only, or not at all.
    #[error("the lattice is a mechanism: a probing load left a residual of {residual:e}")]
    Mechanism {
        /// Relative residual of the probing solve.
        residual: f64,
    },
    /// Nothing touches the body.
    #[error("no contacts were given")]
    NoContacts,
    /// A contact point with a coordinate that is infinite or not a number.
    #[error("the point of contact {contact} is not finite")]
    NonFinitePoint {
        /// Index of the contact.
        contact: usize,
    },
    /// An impulse with a component that is infinite or not a number.
    #[error("the impulse of contact {contact} is not finite")]
    NonFiniteImpulse {
        /// Index of the contact.
        contact: usize,
    },
    /// An impulse of length zero.
    #[error("the impulse of contact {contact} is zero")]
    ZeroImpulse {
        /// Index of the contact.
        contact: usize,
    },
    /// A contact radius that is not positive and finite.
    #[error("the radius {radius} of contact {contact} is not positive and finite")]
    RadiusOutOfRange {
        /// Index of the contact.
        contact: usize,
        /// The offender, local.
        radius: f64,
    },
    /// A contact point farther from the boundary than its own radius.
    #[error("contact {contact} is {distance} away from the body, its radius is {radius}")]
    TooFar {
        /// Index of the contact.
        contact: usize,
        /// Distance to the nearest boundary point, local.
        distance: f64,
        /// The radius that was asked for, local.
        radius: f64,
    },
    /// An array whose length does not fit the prepared lattice.
    #[error("{what} has {found} entries, the prepared lattice needs {expected}")]
    OtherLattice {
        /// Which array.
        what: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries found.
        found: usize,
    },
    /// The displacement does not balance the forces; they were not in equilibrium, or not finite.
    #[error(
        "the solve left a residual of {residual:e}, {RESIDUAL_MAX:e} is allowed: the forces are not in equilibrium"
    )]
    Residual {
        /// ‖f − K u‖ / ‖f‖.
        residual: f64,
    },
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
