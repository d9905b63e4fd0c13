//! Studies: measurements by which users judge the service.

pub mod accuracy;
pub mod bars;
pub mod effects;
pub mod examples;
pub mod exploded;
pub mod gallery;
pub mod mesh_fuzz;
pub mod paper;
pub mod plot;
pub mod precision;
pub mod stability;
mod ticks;
