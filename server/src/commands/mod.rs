//! The commands of `shatterd`, one file each.

pub mod bake;
pub mod demo;
mod failure;
pub mod inspect;
pub(crate) mod out;
pub mod serve;
pub mod study;

pub use failure::Failure;
