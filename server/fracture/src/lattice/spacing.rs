//! Choice of lattice spacings from node counts, and the accepted range of spacings.

use super::LatticeError;
use super::grid::{SPACING_RANGE, is_allowed};
use nalgebra::Vector3;

/// Default number of crack nodes of a bake, boundary included.
pub const CRACK_NODES_DEFAULT: usize = 9_000;

/// Default number of elastic nodes of a bake, boundary included.
pub const ELASTIC_NODES_DEFAULT: usize = 3_000;

/// Largest number of crack nodes of a bake. Computing the eigenpairs of the lift takes minutes there.
pub const CRACK_NODES_MAX: usize = 250_000;

/// Largest number of elastic nodes of a bake. The factor takes gigabytes and minutes there.
pub const ELASTIC_NODES_MAX: usize = 100_000;

/// Thickness of a layer with as many nodes as the boundary adds, in spacings.
///
/// Measured 0.63 to 0.80 on balls, boxes, tori, slabs, the horse and the bunny, at 1 000 to 12 000 nodes.
const LAYER: f64 = 0.7;

/// Estimated number of nodes at `spacing` of a solid with this volume and surface area (local), boundary included.
///
/// A body-centered cubic grid has two nodes per cube. The boundary adds those of a layer of 0.7 spacings.
fn nodes_at(spacing: f64, volume: f64, area: f64) -> f64 {
    2.0 * (volume + area * LAYER * spacing) / spacing.powi(3)
}

/// Spacing (local) at which a solid of this volume and surface area (local) has about `nodes` nodes.
///
/// The count includes the boundary. The spacing is clamped to [`SPACING_RANGE`].
pub fn default_spacing(volume: f64, area: f64, nodes: usize) -> f64 {
    let [low, high] = SPACING_RANGE;
    let (mut below, mut above) = (low, high);
    // The count falls with the spacing. Forty halvings are far more accurate than the estimate.
    for _ in 0..40 {
        let middle = 0.5 * (below + above);
        if nodes_at(middle, volume, area) > nodes as f64 { below = middle } else { above = middle }
    }
    0.5 * (below + above)
}

/// Finest spacing (local) whose grid over a box of this extent (local) has at most [`super::GRID_NODES_MAX`] nodes.
pub fn finest_grid_spacing(extent: &Vector3<f64>) -> f64 {
    let [mut below, mut above] = SPACING_RANGE;
    if is_allowed(extent, below) {
        return below;
    }
    for _ in 0..40 {
        let middle = 0.5 * (below + above);
        if is_allowed(extent, middle) { above = middle } else { below = middle }
    }
    above
}

/// Elastic and crack spacing (local) for a solid of this volume and surface area (local).
///
/// Each is the requested one, or else yields about as many nodes as `nodes` states (elastic, crack). A default never
/// makes the crack level the coarser one.
///
/// # Errors
/// [`LatticeError::SpacingOutOfRange`], [`LatticeError::TooManyNodes`], [`LatticeError::CrackCoarser`].
pub fn spacings(
    volume: f64,
    area: f64,
    nodes: [usize; 2],
    elastic: Option<f64>,
    crack: Option<f64>,
) -> Result<[f64; 2], LatticeError> {
    let default = |level: usize| default_spacing(volume, area, nodes[level]);
    let chosen = match (elastic, crack) {
        (None, None) => [default(0), default(1)],
        (Some(elastic), None) => [elastic, default(1).min(elastic)],
        (None, Some(crack)) => [default(0).max(crack), crack],
        (Some(elastic), Some(crack)) => [elastic, crack],
    };
    let [spacing_min, spacing_max] = SPACING_RANGE;
    let [elastic_level, crack_level] =
        [("elastic", chosen[0], ELASTIC_NODES_MAX), ("crack", chosen[1], CRACK_NODES_MAX)];
    // The error names the requested level, not the one that follows it.
    let levels = if elastic.is_some() { [elastic_level, crack_level] } else { [crack_level, elastic_level] };
    for (level, spacing, nodes_max) in levels {
        if !(spacing_min..=spacing_max).contains(&spacing) {
            return Err(LatticeError::SpacingOutOfRange { level, spacing, spacing_min, spacing_max });
        }
        let nodes = nodes_at(spacing, volume, area);
        if nodes > nodes_max as f64 {
            // Rounded up to the digits of the message, so that the spacing that it names is accepted.
            let spacing_needed = (default_spacing(volume, area, nodes_max) * 1e4).ceil() / 1e4;
            return Err(LatticeError::TooManyNodes { level, spacing, nodes, nodes_max, spacing_needed });
        }
    }
    match chosen {
        [elastic, crack] if crack > elastic => Err(LatticeError::CrackCoarser { crack, elastic }),
        chosen => Ok(chosen),
    }
}
