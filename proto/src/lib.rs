//! What travels between `shatterd` and its clients: plain data, and nothing else.
//!
//! A **request** ([`request::RequestWire`], [`control::ControlRequestWire`]) is fixed-size plain old data. The daemon copies it
//! once and then validates the copy into a typed value: the sender can still write to its own memory.
//!
//! An **answer** is a header ([`result::ResultHeader`]), a section table, and sections of 64-byte [`result::Block`]s.
//! [`layout::Layout`] computes every offset from counts before a byte is written; [`view::CheckedLayout`] checks every offset,
//! alignment, count and index before a byte is used.
//!
//! A **refusal** ([`error::Error`]) has one noun per rule. It never travels in an answer: an unanswered request means
//! that the reason waits at the control service, so that an exhausted pool of answers silences no refusal.
//!
//! On the wire: little-endian (both ends run on one machine), right-handed, +Y up, meters, kilograms, seconds,
//! counter-clockwise seen from outside; unless the strike names another [`convention::Convention`], in which contacts are then read and answers
//! written, whatever unit a field's name ends with.

mod codes;
pub mod control;
pub mod convention;
mod costs;
pub mod effect;
pub mod error;
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
