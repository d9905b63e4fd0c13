//! Accuracy measures: each error with its formula and unit, and the exact diagram to which tessellations are compared.
//!
//! | error | compared quantities |
//! |---|---|
//! | [`energy_error`], [`density_error`] | strain energy of the body; its distribution |
//! | [`degree_error`] | number of fragments of the criterion |
//! | [`cvd_gap`], [`size_distance`] | diagrams of one field and one number of sites; two good ones differ in a fifth of their labels |
//! | [`label_fraction`], [`misplaced`], [`volume_l1`], [`crack_distance`] | tessellations of the *same sites* |
//! | [`BakeReport::surface_deviation`](crate::pipeline::BakeReport::surface_deviation) | the lattice's boundary and the input's surface |
//! | [`NormalShares`] | their normals |
//!
//! **The same sites on another lattice.** Sites live in R^m, off the embedded body, so no position in space carries
//! them to another lattice. Their coordinates are kept, and the *lift* is carried instead: [`carried`] interpolates the
//! coordinates of the finer lattice linearly at the nodes of the coarser one. Both then approximate one embedding of
//! one body. Eigenfunctions that each lattice computed for itself would differ by signs and rotations, and their
//! embeddings would not be comparable.
//!
//! **Energies of two elastic lattices.** Each lattice's own conservative
//! [`EnergyTransfer`](crate::lattice::EnergyTransfer) transfers its energies to the nodes of one common crack lattice,
//! where they are compared. Nothing is sampled, and both keep their totals.

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
