//! Commands of `shatter-lab`, one file each.

pub mod demo;
pub mod examples;
mod failure;
pub mod study;
