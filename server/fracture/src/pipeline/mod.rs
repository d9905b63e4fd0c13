//! The one walk from an impact to fragments, in the order of the method.

mod outcome;
mod stage;
mod strike;

pub use outcome::{Counts, DegreeSource, FragmentRow, OUTER, RunRow};
pub use stage::{Stage, Watch};
pub use strike::{Contact, DegreeRequest, Strike};
