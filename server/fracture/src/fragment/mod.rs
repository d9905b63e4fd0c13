//! Properties of a fragment that follow from its surface: rigid-body properties and closedness.

mod closed;
mod properties;

#[cfg(test)]
mod tests;

pub use closed::{OpenMesh, closed};
pub use properties::{NotRigid, RigidProperties, properties};
