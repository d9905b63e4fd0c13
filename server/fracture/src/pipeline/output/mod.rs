//! Closed meshes and tables from cells, with the additions of effects.

pub(super) mod cut;
pub(super) mod cut_domain;
pub(super) mod emitted_effects;
pub(super) mod emitted_meshes;
pub(super) mod faces;
pub(super) mod hulls;
pub(super) mod ledger;
pub(super) mod meshes;
pub(super) mod outer_attributes;
pub(super) mod release_velocity;
pub(super) mod retained;
pub(super) mod rows;
mod skin_regions;
pub(super) mod skins;
pub(super) mod slivers;
pub(super) mod vertex_attributes;
pub(super) mod world_bonds;
