//! Training on impacts during a bake: examples, reduced bases, degrees.

pub(super) mod anchored;
pub(super) mod calibrate;
pub(super) mod compare;
pub(super) mod discretization;
#[cfg(test)]
mod discretization_tests;
pub(super) mod examples;
pub(super) mod learn;
pub(super) mod reduce;
pub(super) mod sample;
