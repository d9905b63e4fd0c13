//! Onset of fracture by strength and energy.
//!
//! Both are necessary (D. Leguillon, *Strength or toughness? A criterion for crack onset at a notch*, European Journal
//! of Mechanics A 21, 2002). Small bodies have little energy and break by toughness, large ones break at their strength.

mod average;
mod contacts;
mod material;
mod near_field;
mod onset;
mod recovery;
mod section;
mod sliding;
mod stress;
mod tables;

pub use contacts::{ContactStress, SurfaceForce};
pub use material::{ConstantsOrigin, StrengthConstants};
pub use onset::{Criterion, Onset, affordable_count, cell_dimension};
pub use section::{PlaneSection, SectionLattice, SectionSearch, normals_across, normals_around};
pub use sliding::SlidingStress;
pub use tables::{ContactZone, Deformation, HotSpot, StrengthTables};

#[cfg(test)]
mod tests;
