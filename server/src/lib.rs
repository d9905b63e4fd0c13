//! `shatterd`: the brittle-fracture daemon, and what people look at.

pub mod picture;
pub mod report;
