//! Mesh fuzzer: base meshes × twenty defects × seeds, each judged.
//!
//! A [`Mutant`] is named `mesh/defect/seed` and determined by its name. [`Judge`] bakes and strikes it and checks the result, [`run`]
//! does so for many and counts the outcomes, [`shrink`] reduces a failing mesh to few triangles, and [`REGRESSIONS`] lists mutants that
//! failed once.

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
mod simplify;
mod table;
mod tally;

/// Minimum accepted share of the mutants that must be accepted. Their defects leave an inside that a person would recognize, but the
/// lattice of a mutant is coarse.
pub const MUST_ACCEPT_RATE_MIN: f64 = 0.95;

pub use base::{BaseMesh, FolderError, MeshSize, TRIANGLES_MAX, from_folder, generated};
pub use check::FuzzFault;
pub use defects::{FuzzDefect, UnknownDefect};
pub use id::{Mutant, MutantIdError};
pub use judge::{FuzzVerdict, Judge};
pub use regressions::REGRESSIONS;
pub use run::{FuzzPlan, run};
pub use shrink::{ShrunkMesh, shrink};
pub use tally::{FuzzCounts, FuzzReport, FuzzTally, NamedCounts};
