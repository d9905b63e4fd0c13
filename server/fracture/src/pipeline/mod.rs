//! The one walk from an impact to fragments, in the order of the method.

mod calibrate;
mod cells;
mod compare;
mod energy;
mod error;
mod impact;
mod outcome;
mod pieces;
mod prepared;
mod stage;
mod strike;
mod threshold;
mod walk;
mod workspace;

pub use calibrate::calibrate;
pub use cells::{BodyCells, divide};
pub use compare::{CompareError, Comparison, LiftRow};
pub use energy::{BodyEnergy, strain_energy};
pub use error::{CONTACTS_MAX, StrikeError};
pub use impact::Impact;
pub use outcome::{Counts, DegreeSource, FragmentRow, OUTER, Outcome, RunRow};
pub use pieces::Pieces;
pub use prepared::{BakeReport, Body, Parameters, Prepared, Unprepared};
pub use stage::{Stage, Watch};
pub use strike::{Contact, DegreeRequest, Strike};
pub use threshold::Verdict;
pub use walk::strike;
pub use workspace::Workspace;

/// Most sites of one strike.
pub const DEGREE_MAX: u32 = 512;
