//! From a mesh file to a surface with an inside.

mod frame;

pub use frame::Frame;
