//! What a fragment is once its surface is known: a rigid body, and a closed one.

mod closed;
mod properties;

#[cfg(test)]
mod tests;

pub use closed::{Open, closed};
pub use properties::{NotRigid, Properties, properties};
