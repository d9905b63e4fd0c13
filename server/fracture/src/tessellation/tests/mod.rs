//! The guarantee and the geometry of the tessellation.

mod geometry;
mod guarantee;
mod hard;
mod layout;
mod support;
