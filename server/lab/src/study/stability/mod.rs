//! Hard cases: what must hold, the figure that shows it, and the bound with its reason.
//!
//! [`CASES`] is data: a case is a name, the item of the list that it stands for, a bound with its reason, and a function
//! that returns one figure or a refusal. [`judge`] is the one check for all of them.

mod case;
mod cases;
mod catalogue;
mod page;
mod portrait;
mod real;
mod trial;

pub use case::{Case, CaseOutcome, CaseRow, Expect, judge};
pub use cases::neck::{Neck, neck_over_impulses, neck_portraits};
pub use cases::poisson::{Locking, locking};
pub use catalogue::{CASES, LIST};
pub use page::StabilityFindings;
pub use portrait::spoiled_statues;
pub use real::{REAL, real};
pub use trial::TrialFault;
