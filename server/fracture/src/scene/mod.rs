//! What a scene says about an object: what it is made of, how it is held, how it is struck by default.

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
pub use names::{brief, is_invisible, nearest, toml_error};
pub use region::Region;

/// Contact duration where the caller gives none, s: a hard ball of a few centimeters on a stiff body stays for about
/// this long.
pub const DEFAULT_DURATION_S: f64 = 2.0e-4;

/// Contact radius where the caller gives none, over the object's bounding-box diagonal.
pub const DEFAULT_RADIUS_DIAGONALS: f64 = 0.04;

/// Reference fragment size d where the caller gives none, over the bounding-box diagonal.
pub const DEFAULT_FRAGMENT_DIAGONALS: f64 = 0.1;
