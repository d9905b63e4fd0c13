//! Requests and results over the science, without a transport: what a daemon and an in-process interface share.
//!
//! [`wire`] turns wire types into those of `shatter-fracture` and back, [`scene`] says what is loaded and simulated of each object, and
//! [`object`] is what a daemon sees of an object.

pub mod cost;
pub mod object;
pub mod scene;
pub mod stage_profiler;
pub mod wire;
