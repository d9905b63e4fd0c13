//! Bad meshes at scale: base meshes × twenty defects × seeds, each judged.
//!
//! A [`Mutant`] is named `mesh/defect/seed` and follows from its name alone. [`Judge`] bakes and strikes it and checks the
//! answer, [`run`] does so for many and tallies them, [`shrink`] reduces one that fails to few triangles, and
//! [`REGRESSIONS`] holds those that failed once.

mod base;
mod check;
mod cluster;
mod defects;
mod draw;
mod id;
mod inside;
mod judge;
mod kinds;
mod regressions;
mod run;
mod shrink;
mod table;
mod tally;

/// Share of the mutants that must be accepted that is, at least: each of their defects leaves an inside that a person would
/// point at, and the lattice of a mutant is coarse.
pub const MUST_ACCEPT_RATE_MIN: f64 = 0.95;

pub use base::{BaseMesh, FolderError, TRIANGLES_MAX, from_folder, generated};
pub use check::FuzzFault;
pub use defects::{FuzzDefect, UnknownDefect};
pub use id::{Mutant, MutantIdError};
pub use judge::{FuzzVerdict, Judge};
pub use regressions::REGRESSIONS;
pub use run::{FuzzPlan, run};
pub use shrink::{ShrunkMesh, shrink};
pub use tally::{FuzzCounts, FuzzReport, FuzzTally, NamedCounts};
