//! Errors and limits of elasticity.

use crate::cancel_token::Canceled;
use crate::sparse::SparseError;

/// Largest accepted Poisson's ratio. Linear tetrahedra lock toward ½.
///
/// Measured shortfall of the energy in pure bending, eight cells across, cubes cut into six tetrahedra (the worst
/// case): 5 % at ν = 0, 6 % at 0.3, 9 % at 0.4, 14 % at 0.45, 36 % at 0.49, 72 % at 0.499. Cubes with nodes in their
/// centers and faces hardly lock: six across, 2.2 %, 1.9 %, 2.0 %, 2.1 %, 2.2 % and 2.2 %.
pub const POISSON_MAX: f64 = 0.45;

/// Largest accepted relative residual ‖f − K u‖ / ‖f‖ of a solution, unless it is rounding
/// ([`ROUNDING_MAX`](super::ROUNDING_MAX)).
///
/// Compact bodies leave 1e-14, a needle of 1:100 leaves 2e-8. A mechanism or a load out of equilibrium leaves about 1.
pub const RESIDUAL_MAX: f64 = 1e-6;

/// Error of preparing or solving an elastic body.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElasticityError {
    /// The lattice has no tetrahedron.
    #[error("the lattice has no tetrahedra")]
    EmptyLattice,
    /// A tetrahedron has no positive, finite volume.
    #[error("tetrahedron {tet} has no positive volume")]
    DegenerateTet {
        /// Index of the tetrahedron.
        tet: usize,
    },
    /// Poisson's ratio is outside −1 < ν < ½, the range of isotropic solids.
    #[error("Poisson's ratio {poisson} is not in −1 < ν < 0.5")]
    PoissonOutOfRange {
        /// Poisson's ratio.
        poisson: f64,
    },
    /// Poisson's ratio is so close to ½ that linear tetrahedra lock.
    #[error("Poisson's ratio {poisson} exceeds {POISSON_MAX}: linear tetrahedra lock there and are too stiff")]
    LockingPoisson {
        /// Poisson's ratio.
        poisson: f64,
    },
    /// An anchored node does not exist.
    #[error("anchored node {node} is not in the lattice")]
    UnknownAnchor {
        /// Index of the node.
        node: u32,
    },
    /// The anchored nodes leave a rotation free.
    #[error("{nodes} anchored nodes all lie on a line, so the body can rotate about it: anchor a node off the line")]
    AnchorsInLine {
        /// Number of anchored nodes.
        nodes: usize,
    },
    /// The stiffness matrix could not be factored.
    #[error("the stiffness matrix cannot be factored")]
    Stiffness(#[from] SparseError),
    /// Parts of the body are connected by an edge or a node only, or not at all.
    #[error(
        "the lattice is a mechanism, or nearly one (parts share at most an edge or a node, or a joint too thin for their size): \
         residual {residual:e} of a test load"
    )]
    Mechanism {
        /// Relative residual of the test solve.
        residual: f64,
    },
    /// The load has no contacts.
    #[error("no contacts were given")]
    NoContacts,
    /// A contact point has a coordinate that is infinite or not a number.
    #[error("the point of contact {contact} is not finite")]
    NonFinitePoint {
        /// Index of the contact.
        contact: usize,
    },
    /// An impulse has a component that is infinite or not a number.
    #[error("the impulse of contact {contact} is not finite")]
    NonFiniteImpulse {
        /// Index of the contact.
        contact: usize,
    },
    /// An impulse has length zero.
    #[error("the impulse of contact {contact} is zero")]
    ZeroImpulse {
        /// Index of the contact.
        contact: usize,
    },
    /// A contact radius is not positive and finite.
    #[error("the radius {radius} of contact {contact} is not positive and finite")]
    RadiusOutOfRange {
        /// Index of the contact.
        contact: usize,
        /// Radius, local.
        radius: f64,
    },
    /// A contact point is farther from the boundary than its own radius.
    #[error("contact {contact} is {distance} away from the body, its radius is {radius}")]
    TooFar {
        /// Index of the contact.
        contact: usize,
        /// Distance to the nearest boundary point, local.
        distance: f64,
        /// Requested radius, local.
        radius: f64,
    },
    /// An array does not have the length that the prepared lattice requires.
    #[error("{what} has {found} entries, the prepared lattice needs {expected}")]
    OtherLattice {
        /// Name of the array.
        what: &'static str,
        /// Number of entries needed.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// The displacement does not balance the forces. They were not in equilibrium, or not finite.
    #[error(
        "the solve left a residual of {residual:e}, above the limit {RESIDUAL_MAX:e}: the forces are not in equilibrium"
    )]
    Residual {
        /// ‖f − K u‖ / ‖f‖.
        residual: f64,
    },
    /// The work was canceled.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}
