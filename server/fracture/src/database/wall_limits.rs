//! Limits of walls, which errors, remedies and warnings share.

/// Largest measured width, local. Default spacings preserve anything thicker.
pub(super) const WIDTH_MAX: f64 = 0.1;

/// Ratios of thickness to spacing, tried in order; the second applies if the first needs too many nodes.
///
/// Measured on rotated shapes: rods of ratio 1.5 and plates of ratio 1.25 were preserved completely, rods of 1.25 to 97
/// %, plates of 1.0 to 31 %.
pub(super) const WALL_SPACINGS: [f64; 2] = [1.5, 1.25];

/// Price of a finer crack spacing, which remedies tell.
pub const HALF_SPACING_COST: &str = "half the spacing takes about eight times the time and memory";

/// Factor by which a sheet is made thicker.
///
/// Energies of strips of 1:500 in three orientations, over those of beams: 0.979 to 0.987 with 8 and 4,600 to 5,700 nodes,
/// 0.991 to 1.000 with 4 and 18,600 to 22,200. A pane of 1 m × 1 m × 4 mm has 11,400 and 44,900 nodes.
pub(super) const STRETCH_MAX: f64 = 8.0;
