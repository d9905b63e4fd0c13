//! Accuracy measures: the formula and unit of each error, and the exact diagram to which tessellations are compared.
//!
//! | error | compared quantities |
//! |---|---|
//! | [`energy_error`], [`density_error`] | strain energy of the body; its distribution |
//! | [`degree_error`] | number of fragments of the criterion |
//! | [`cvd_gap`], [`size_distance`] | diagrams of one field and one number of sites; two good ones differ in a fifth of their labels |
//! | [`label_fraction`], [`misplaced`], [`volume_l1`], [`crack_distance`] | tessellations of the *same sites* |
//! | [`BakeReport::surface_deviation`](crate::pipeline::BakeReport::surface_deviation) | the lattice's boundary and the input's surface |
//! | [`NormalShares`] | normals of the same two surfaces |
//!
//! **The same sites on another lattice.** Sites are points of R^m outside the embedded body, so they have no position
//! in space. Their coordinates are kept, and the *lift* is transferred: [`carried`] interpolates the coordinates of
//! the finer lattice linearly at the nodes of the coarser one. Both lattices then approximate one embedding of one
//! body. If each lattice computed its own eigenfunctions, these would differ by signs and rotations, and the
//! embeddings could not be compared.
//!
//! **Elastic references.** [`RefinedBody`](crate::elasticity::RefinedBody) solves on a lattice refined uniformly, and
//! [`Extrapolation`] takes its energies to spacing 0, with an error bar.
//!
//! **Energies of two elastic lattices.** Each lattice's own conservative
//! [`EnergyTransfer`](crate::lattice::EnergyTransfer) transfers its energies to the nodes of one common crack lattice,
//! where they are compared. The transfer does not sample, so both totals are preserved.

mod candidate_sites;
mod distance;
mod error;
mod exact_cells;
mod extrapolation;
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
pub use extrapolation::{BARS_MIN, Extrapolation, is_hidden};
pub use label_errors::{LabelErrors, carried, label_fraction, misplaced, nearest};
pub use normals::{NORMAL_DEG, NormalShares, ShadedLattice, ShadedTriangle};
pub use regions::Regions;
pub use scalar::{cvd_gap, degree_error, density_error, energy_error, size_distance, volume_l1};
