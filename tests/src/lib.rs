//! Common parts of the tests that cross crates.

pub mod glb;
pub mod real;
pub mod statistics;
pub mod struck;
