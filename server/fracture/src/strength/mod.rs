//! Onset of fracture by strength and energy.
//!
//! Both are necessary (D. Leguillon, *Strength or toughness? A criterion for crack onset at a notch*, European Journal
//! of Mechanics A 21, 2002). Small bodies have little energy and break by toughness, large ones break at their strength.

mod material;

pub use material::{ConstantsOrigin, StrengthConstants};
