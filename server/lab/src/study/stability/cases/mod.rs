//! Implementations of the cases. The catalog holds bounds and reasons.

pub mod cells;
pub mod degree;
pub mod lift;
pub mod load;
pub mod material;
pub mod mesh;
pub mod neck;
pub mod poisson;
pub mod reference;
pub mod scale;
pub mod tessellation;
