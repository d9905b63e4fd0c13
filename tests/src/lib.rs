//! Common parts of the tests that cross crates.

#![allow(clippy::missing_errors_doc, clippy::missing_panics_doc, reason = "not published")]

pub mod baked_once;
mod command_errors;
pub mod fixture;
pub mod fuzz;
pub mod glb;
pub mod golden;
pub mod imports;
pub mod json_keys;
pub mod model;
pub mod pages;
pub mod peers;
pub mod prose;
pub mod real;
pub mod reference;
pub mod sources;
pub mod statistics;
pub mod struck;
pub mod timed;
