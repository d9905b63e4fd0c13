//! What a fragment is once its surface is known: a rigid body, and a closed one.

mod closed;
mod properties;

#[cfg(test)]
mod tests;

pub use closed::{OpenMesh, closed};
pub use properties::{NotRigid, RigidProperties, properties};
