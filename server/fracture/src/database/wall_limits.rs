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

/// Factors by which a sheet is made thicker: the first with at most about [`SHEET_NODES`] elastic nodes, or the last.
///
/// Long cells make sheets too stiff where curvature changes, as between anchors. Energies of a pane of 1 m × 1 m with two
/// held edges, struck in the middle, over the converged one: 4 mm thick 0.92 with 8 (11,400 nodes) and 0.99 with 6 (19,700);
/// 8 mm thick 0.83 with 8 (2,900) and 1.00 with 4 (11,400).
pub(super) const STRETCHES: [f64; 5] = [2.0, 3.0, 4.0, 6.0, 8.0];

/// Largest factor by which a sheet is made thicker.
pub(super) const STRETCH_MAX: f64 = STRETCHES[STRETCHES.len() - 1];

/// Number of elastic nodes that a sheet on stretched cells may have, unless the largest factor has more.
pub(super) const SHEET_NODES: usize = 25_000;
