//! Hard cases: required properties, each with a figure and a bound with its reason.
//!
//! [`CASES`] is data: a case has a name, an item of the list, a bound with its reason, and a function that returns one figure or an
//! error. [`judge`] checks all of them.

mod case;
mod cases;
mod catalog;
mod page;
mod portrait;
mod real;
mod trial;

pub use case::{Case, CaseOutcome, CaseRow, Expect, judge};
pub use cases::neck::{Neck, neck_over_impulses, neck_portraits};
pub use cases::poisson::{BendingDeficit, bending_deficits};
pub use catalog::{CASES, LIST};
pub use page::StabilityFindings;
pub use portrait::damaged_statues;
pub use real::{REAL, real};
pub use trial::TrialFault;
