//! Scene data of an object: material, anchors, controls, effects, defaults of impacts.

mod anchors;
mod controls;
mod effect;
mod material;
mod names;
mod region;

pub use anchors::{Anchors, DEFAULT_GRAVITY_M_S2};
pub use controls::{Grain, Paint, WarpControls, Waves};
pub use effect::{EffectKind, EffectSet};
pub use material::{MATERIALS, Material, MaterialError, Materials};
pub use names::{brief, counted, fixed, is_invisible, nearest, number, rounded, table_error, toml_error};
pub use region::Region;

/// Default contact duration, s: about that of a hard ball of a few centimeters on a stiff body.
pub const DEFAULT_DURATION_S: f64 = 2.0e-4;

/// Default contact radius, over the object's bounding-box diagonal.
pub const DEFAULT_RADIUS_DIAGONALS: f64 = 0.04;

/// Default reference fragment size d, over the bounding-box diagonal.
pub const DEFAULT_FRAGMENT_DIAGONALS: f64 = 0.1;
