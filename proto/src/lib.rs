//! The vocabulary that `shatterd` and its clients share: plain data alone.
//!
//! A **request** ([`request::RequestWire`], [`control::ControlRequestWire`]) is fixed-size plain old data. The daemon copies it
//! once and then validates the copy into a typed value: the sender can still write to its own memory.
//!
//! A **result** is a header ([`result::ResultHeader`]), a section table, and sections of 64-byte [`result::Block`]s.
//! [`layout::Layout`] computes every offset from counts before a byte is written; [`view::CheckedLayout`] checks every offset,
//! alignment, count and index before a byte is used.
//!
//! An **error** ([`error::Error`]) has a kind: one noun per rule. It never travels in a result: after a request that was closed without
//! one, the control service has the reason. So an exhausted pool of results suppresses no error.
//!
//! On the wire: little-endian (both ends run on one machine), right-handed, +Y up, meters, kilograms, seconds,
//! counter-clockwise seen from outside. A request may name another [`convention::Convention`]: the daemon then reads contacts and writes
//! results in it, whatever unit a field's name ends with. Types whose names end with `Wire` or `Row` are what travels; hosts see the
//! plain types beside them.

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

pub use error::{Error, ErrorKind, Fault, exit};

/// Version of everything in this crate that travels. Any change of size or meaning raises it.
pub const PROTOCOL_VERSION: u32 = 6;
