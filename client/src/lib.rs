//! Rust client of `shatterd`, the brittle-fracture daemon.
//!
//! ```no_run
//! use shatter_client::{Client, Contact, Deadline, Impact, Poll};
//!
//! # fn main() -> Result<(), shatter_client::Error> {
//! let service = Client::connect("default", Deadline::ms(50))?;
//! let mug = service.object("mug", Deadline::ms(50))?; // the guide's first session bakes it
//! let contact = Contact::new([0.0, 0.05, 0.04]).impulse([0.0, 0.0, -2.0]);
//! let mut ticket = mug.strike(&Impact::new([contact]))?; // never blocks
//! loop {
//!     match ticket.poll()? {
//!         Poll::Pending => { /* draw a frame */ }
//!         Poll::Ready(result) => {
//!             for fragment in result.fragments() {
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
//! Every wait has a bound: [`Object::strike`] and [`Ticket::poll`] never block, and calls that wait take a [`Deadline`]. A ticket
//! can also be awaited, on any executor. Dropping a [`Ticket`] cancels its request. Every [`Error`] has a kind, names the side that
//! caused it, and states whether a retry can succeed.
//!
//! Coordinates are those of glTF by default. A host with other axes, another winding or another unit of length sets them once,
//! with [`Client::with_convention`]. The daemon then reads requests and writes results in that convention.
//!
//! A client reconnects when the daemon is restarted. Requests that were open then fail with `lost`: they get no result, and it is
//! safe to send them again. Later requests go to the new daemon.
//!
//! A [`FractureResult`] returns large arrays as slices of plain numbers in shared memory, and everything else as plain types
//! ([`Summary`], [`StageCost`], [`EffectCost`], [`Bond`], [`DebrisPoint`]).

mod aim;
mod client;
mod connection;
mod control;
mod deadline;
mod digest;
mod fragment;
mod impact;
mod object;
mod prefracture;
mod result;
mod result_future;
mod result_in_meters;
mod sent_requests;
mod session;
mod status;
mod ticket;
mod visible;
mod waiters;
mod write_files;

/// The code of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use aim::{Hit, Ray};
pub use client::{Client, RetainGuard, SERVICE_VARIABLE, default_service, service_paths};
pub use control::ObjectFacts;
pub use deadline::Deadline;
pub use digest::{ResultDigest, SectionDigest};
pub use fragment::{Fragment, FragmentSkin, HullMesh, Run};
pub use impact::Impact;
pub use object::Object;
pub use result::*;
pub use result_future::ResultFuture;
pub use result_in_meters::ResultInMeters;
pub use shatter_export::{self as export, SourceMaterials, contact};
pub use shatter_proto::control::{Latency, ObjectState};
pub use shatter_proto::convention::{Convention, Hand, Up, Winding};
pub use shatter_proto::effect::{Effect, Effects};
pub use shatter_proto::request::{
    CONTACTS_MAX, Contact, ContactPartner, DegreeRule, DisplacementSource, Lift, Quality, RequestedCriterion,
    RequestedSurface, RetainedFragment, SEED_DEFAULT,
};
pub use shatter_proto::{Error, ErrorKind, FaultParty, exit};
pub use shatter_transport::paths::ServicePaths;
pub use status::Status;
pub use ticket::{Poll, Progress, Ticket};
pub use write_files::read_materials;
