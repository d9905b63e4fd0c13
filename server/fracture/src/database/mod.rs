//! Databases: one object per file, baked once, verified before use.

mod bake;
mod container;
mod error;
#[cfg(test)]
mod hostile_tests;
mod learned;
mod object;
mod parts;
mod thin;

pub use bake::{BakeError, BakeRequest, Step, add_examples, bake, input_hash};
pub use error::DatabaseError;
pub use learned::EXAMPLES_MAX;
pub use object::{BODIES_MAX, NODES_MAX, load, save};

/// The format that this program writes and reads; a whole number, raised by every incompatible change.
pub const FORMAT: &str = "1";

/// The ending of database files.
pub const EXTENSION: &str = "shatter";
