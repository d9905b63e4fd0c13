//! How far a result is from a better one: every error once, with its formula and unit, and the exact diagram that errors of the
//! tessellation are measured against.
//!
//! | error | what it compares |
//! |---|---|
//! | [`energy_error`], [`density_error`] | strain energy of the body; where it is |
//! | [`degree_error`] | number of fragments of the criterion |
//! | [`cvd_gap`], [`size_distance`] | diagrams of one field and one number of sites; two good ones differ in a fifth of their labels |
//! | [`label_fraction`], [`misplaced`], [`volume_l1`], [`crack_distance`] | tessellations of the *same sites* |
//! | [`BakeReport::surface_deviation`](crate::pipeline::BakeReport::surface_deviation) | the lattice's boundary and the input's surface |
//! | [`NormalShares`] | their normals |
//!
//! **The same sites on another lattice.** Sites live in R^m, off the embedded body, so there is no place in space to carry them by. They
//! are kept as they are, and the *lift* is carried instead: [`carried`] interpolates the coordinates of the finer lattice linearly at
//! the nodes of the coarser one. Both then approximate one embedding of one body. Eigenfunctions that each lattice computes for itself
//! would be another embedding each, up to signs and rotations, and nothing to compare.
//!
//! **Energies of two elastic lattices.** Both are carried by their own conservative [`EnergyTransfer`](crate::lattice::EnergyTransfer) to the nodes
//! of one common crack lattice, and compared there: nothing is sampled, and both add up to their own totals.

mod candidate_sites;
mod distance;
mod error;
mod exact_cells;
mod label_errors;
mod normals;
mod polytope;
mod regions;
mod scalar;
#[cfg(test)]
mod tests;

pub use distance::{CrackDistance, crack_distance};
pub use error::AccuracyError;
pub use exact_cells::{ExactCells, exact};
pub use label_errors::{LabelErrors, carried, label_fraction, misplaced, nearest};
pub use normals::{NORMAL_DEG, NormalShares, ShadedLattice, ShadedTriangle};
pub use regions::Regions;
pub use scalar::{cvd_gap, degree_error, density_error, energy_error, size_distance, volume_l1};
