//! Commands of `shatterd`, one file each.

pub mod bake;
mod bake_progress;
mod bake_report;
mod bake_scene;
pub mod check;
mod command_error;
pub mod expected_file;
pub mod inspect;
mod inspect_memory;
mod inspect_text;
mod intact_mesh;
pub mod interrupt;
mod log;
pub mod lookup;
pub mod merge;
pub mod mesh_file;
pub mod output;
pub mod serve;
mod shares;
mod size;
mod stdin;

pub use command_error::CommandError;
