//! Common parts of the tests that cross crates.

pub mod glb;
