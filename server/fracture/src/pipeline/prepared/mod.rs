//! Prepared objects: lattices, factors, lifts, tables, and additions of a scene.

pub(super) mod anchor;
pub(super) mod anchored;
pub(super) mod energy_bound;
pub(super) mod example;
pub(super) mod fragment_surface;
pub(super) mod intact_body;
pub(super) mod learned;
pub(super) mod memory;
pub(super) mod object;
pub(super) mod parameters;
pub(super) mod preset;
pub(super) mod reduction;
pub(super) mod region_boundary;
pub(super) mod warp;
pub(super) mod warped_body;
