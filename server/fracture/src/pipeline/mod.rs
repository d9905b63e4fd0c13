//! The one walk from an impact to fragments, in the order of the method.

mod again;
mod calibrate;
mod cells;
mod compare;
mod energy;
mod error;
mod examples;
mod falloff;
mod impact;
mod kept;
mod learned;
mod memory;
mod outcome;
mod outputs;
mod parent;
mod pieces;
mod plan;
mod prepared;
mod reduce;
mod release;
mod sample;
mod settle;
mod slivers;
mod stage;
mod strike;
mod threshold;
mod walk;
mod workspace;

pub use again::strike_again;
pub use calibrate::calibrate;
pub use cells::{BodyCells, divide};
pub use compare::{CompareError, Comparison, LiftRow};
pub use energy::{BodyEnergy, REDUCED_ERROR_MAX, strain_energy};
pub use error::{CONTACTS_MAX, StrikeError};
pub use examples::{Example, ExamplePoint, examples};
pub use impact::Impact;
pub use kept::Kept;
pub(crate) use learned::lessons;
pub use learned::{Learned, Quality, learn, sampled};
pub use outcome::{Counts, DegreeSource, FragmentRow, OUTER, Outcome, RunRow};
pub use outputs::{Bond, Debris};
pub use parent::{SOLVED_NODES_MAX, TETS_MIN};
pub use pieces::Pieces;
pub use prepared::{BakeReport, Body, Parameters, Prepared, Solid, Unprepared};
pub use reduce::{RANK_MAX, Reduction, reduce};
pub use release::{RELEASE_SHARE, Velocity};
pub use sample::Sampler;
pub use slivers::SLIVER_CUBES;
pub use stage::{Stage, Watch};
pub use strike::{Contact, DegreeRequest, ElasticRequest, Strike};
pub use threshold::Verdict;
pub use walk::strike;
pub use workspace::Workspace;

/// Most sites of one strike.
pub const DEGREE_MAX: u32 = 512;
