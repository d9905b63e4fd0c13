//! Requests and results over the simulation, without a transport: shared by the daemon and in-process interfaces.
//!
//! [`wire`] converts wire types to those of `shatter-fracture` and back, [`scene`] defines what is loaded and simulated of each object,
//! and [`object`] is the daemon's interface to an object.

pub mod cost;
pub mod object;
pub mod scene;
pub mod stage_profiler;
pub mod wire;
