//! Commands of `shatter-lab`, one file each.

mod accuracy;
pub mod demo;
pub mod examples;
mod failure;
pub mod study;
