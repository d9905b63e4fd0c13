//! Stages of a request from contacts to cells, in the order of the method.

pub(super) mod cells;
pub(super) mod contact_set;
pub(super) mod controls;
pub(super) mod convergence_monitor;
mod dynamics;
#[cfg(test)]
mod dynamics_tests;
pub(super) mod energy;
pub(super) mod falloff;
pub(super) mod impactor;
pub(super) mod indentation;
pub(super) mod onset;
pub(super) mod search;
pub(super) mod strain;
pub(super) mod termination;
pub(super) mod threshold;
pub(super) mod threshold_bound;
