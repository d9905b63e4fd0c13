//! The commands of `shatterd`, one file each.

pub mod bake;
mod bake_scene;
mod baked;
mod bar;
pub mod check;
mod failure;
pub mod inspect;
mod inspect_memory;
mod intact;
pub mod interrupt;
mod log;
pub mod lookup;
pub mod merge;
mod mistaken;
pub mod out;
pub mod serve;
mod shares;
mod size;
pub mod upgrade;

pub use failure::CommandError;
