//! Quasi-static linear elasticity: from contacts to the strain energy of every tetrahedron.
//!
//! An impact runs `load` → `solve` → `tet_energy`. Young's modulus is 1 and forces are relative. With
//! forces in newtons, lengths in meters and Young's modulus E, displacements and energies of this module
//! are those values divided by E.
//!
//! Based on: T. J. R. Hughes, *The Finite Element Method* (1987), linear tetrahedra, section 3.I; C. Miehe, M. Hofacker
//! & F. Welschinger, *A phase field model for rate-independent crack propagation* (CMAME 199, 2010), equation 20, for
//! the tensile part of the energy. Inertia relief is the d'Alembert load of a free body in consistent mass.

mod blocks;
mod boundary;
mod eigenvalue_bound;
mod element;
mod energy;
mod enriched;
mod error;
mod face_search;
mod force_sums;
mod inertia;
mod linear_part;
mod load;
mod load_front;
mod load_patch;
mod mass;
mod modes;
mod near_field;
mod prepare;
mod quadratic;
mod ray;
mod recovery;
mod reduced;
mod refined;
mod residual;
mod rigid_support;
mod row_products;
mod snapshots;
mod solve;
mod strain;
mod stress;
#[cfg(test)]
mod tests;
mod traction;
mod workspace;

pub use boundary::BoundaryNodes;
pub use eigenvalue_bound::EigenvalueLowerBound;
pub use energy::DrivingEnergy;
pub use enriched::{CompletedEnergy, CompletionTables};
pub use error::{ElasticityError, POISSON_MAX, RESIDUAL_MAX};
pub use face_search::{FaceBoxes, FaceSearch, NearestBoundaryPoint, SurfaceFaces};
pub use load::{AppliedContact, ContactLoad, NodalLoad, RADIUS_SPACINGS_MIN};
pub use load_patch::{BELL_CUT, BELL_RADII, bell};
pub use modes::{ModalResponse, Pulse, PulseLoad, RESPONSE_MAX, ReducedModes};
pub(crate) use near_field::bell_indentation;
pub use prepare::Elasticity;
pub use quadratic::ElementOrder;
pub use ray::{ClosestApproach, RayHit};
pub use reduced::{ErrorEstimate, QuadraticTables, ReducedBasis};
pub use refined::{RefinedBody, RefinedEnergy};
pub use rigid_support::{PinnedNodes, Support};
pub use row_products::ScaledRows;
pub use solve::{NARROW_RESIDUAL_MAX, ROUNDING_MAX, SolveReport};
pub use stress::{StrainComponents, tension_direction};
pub use workspace::ElasticWorkspace;
