//! Types that `shatterd` and its clients share: plain data only.
//!
//! A **request** ([`request::RequestWire`], [`control::ControlRequestWire`]) is fixed-size plain old data. The daemon copies it
//! once, because the sender can still write to its own memory, and validates the copy into a typed value.
//!
//! A **result** is a header ([`result::ResultHeader`]), a section table, and sections of 64-byte [`result::AlignedBlock`]s.
//! [`layout::Layout`] computes every offset from the counts before a byte is written. [`view::CheckedLayout`] checks every
//! offset, alignment, count and index before a byte is used.
//!
//! An **error** ([`error::Error`]) has a kind: one word per rule. It is never sent as a result. If a request closes without a
//! result, the client asks the control service for the error. So errors arrive even if the pool of results is exhausted.
//!
//! In shared memory, numbers are little-endian, because both ends run on one machine. Coordinates are right-handed, +Y up, in
//! meters, kilograms and seconds; triangles are counter-clockwise seen from outside. A request may name another
//! [`convention::Convention`]. The daemon then reads contacts and writes results in it, whatever unit a field's name ends with.
//!
//! Types whose names end with `Wire` or `Row` are the rows of shared memory; hosts read the plain types beside them.

mod codes;
pub mod control;
pub mod convention;
mod costs;
pub mod effect;
pub mod error;
mod in_meters;
pub mod layout;
pub mod name;
mod output_rows;
pub mod request;
pub mod result;
mod sections;
mod summary;
pub mod text;
pub mod view;
mod zero_copy;

pub use error::{Error, ErrorKind, FaultParty, exit};

/// Version of everything in this crate that travels. Any change of size or meaning raises it.
pub const PROTOCOL_VERSION: u32 = 12;
