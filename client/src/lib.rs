//! Rust client of `shatterd`, the brittle-fracture daemon.
//!
//! ```no_run
//! use shatter_client::{Client, Contact, Deadline, Impact, Poll};
//!
//! # fn main() -> Result<(), shatter_client::Error> {
//! let service = Client::connect("default", Deadline::ms(50))?;
//! let mug = service.object("mug", Deadline::ms(50))?; // the README's first session bakes it
//! let contact = Contact::new([0.0, 0.05, 0.04]).impulse([0.0, 0.0, -2.0]);
//! let mut ticket = mug.strike(&Impact::new([contact]))?; // never blocks
//! loop {
//!     match ticket.poll()? {
//!         Poll::Pending => { /* draw a frame */ }
//!         Poll::Ready(broken) => {
//!             for fragment in broken.fragments() {
//!                 // borrowed straight from shared memory
//!                 let _ = (fragment.positions(), fragment.indices(), fragment.mass_kg());
//!             }
//!             break;
//!         }
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Nothing here waits without a bound: [`Ticket::poll`] never blocks, everything else takes a [`Deadline`]. A ticket can be
//! awaited, too, on any executor. Dropping a [`Ticket`] cancels its strike. Errors are [`Error`]s: a closed set of kinds with whose
//! fault it is and whether to try again.
//!
//! Hosts with other axes, another winding or another unit of length than glTF say so once, with [`Client::with_convention`], and the
//! service writes in theirs.
//!
//! Connections outlive the daemon. What was under way when it went away ends with `lost` (no answer will come, sending it again is
//! safe); what is sent next goes to the daemon that then serves.

mod aim;
mod client;
mod connection;
mod control;
mod deadline;
mod digest;
mod impact;
mod object;
mod prefracture;
mod result;
mod result_future;
mod result_in_meters;
mod session;
mod ticket;
mod visible;
mod write_files;

/// The code of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use aim::{Hit, Ray};
pub use client::{Client, RetainGuard, SERVICE_VARIABLE, default_service, place};
pub use control::{ObjectFacts, Status};
pub use deadline::Deadline;
pub use digest::{ResultDigest, SectionDigest};
pub use impact::Impact;
pub use object::Object;
pub use result::{FractureResult, Fragment, FragmentSkin, HullMesh, Run};
pub use result_future::ResultFuture;
pub use result_in_meters::ResultInMeters;
pub use shatter_export::{self as export, contact};
pub use shatter_proto::control::{Latency, ObjectState};
pub use shatter_proto::convention::{Convention, Hand, Up, Winding};
pub use shatter_proto::effect::{Effect, Effects};
pub use shatter_proto::request::{
    Contact, DegreeRule, DisplacementSource, Lift, Purpose, Quality, Request, RetainedFragment, SEED_DEFAULT,
};
pub use shatter_proto::result::MissedTime;
pub use shatter_proto::{Error, ErrorKind, Fault, exit};
pub use ticket::{Poll, Progress, Ticket};
