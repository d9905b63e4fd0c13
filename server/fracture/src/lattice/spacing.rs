//! Which spacing gives about how many nodes.

use super::grid::SPACING_RANGE;

/// Crack nodes that a bake aims at by default, boundary included.
pub const CRACK_NODES_DEFAULT: usize = 12_000;

/// Elastic nodes that a bake aims at by default, boundary included.
pub const ELASTIC_NODES_DEFAULT: usize = 3_000;

/// Thickness of the layer that stands for the boundary's nodes, in spacings: measured 0.63 to 0.80 on balls, boxes,
/// tori, slabs, the horse and the bunny, at 1 000 to 12 000 nodes.
const LAYER: f64 = 0.7;

/// The spacing (local) at which a solid of this volume and surface area (local) gets about `nodes` nodes, boundary
/// included, clamped to [`SPACING_RANGE`].
///
/// A body-centred cubic grid has two nodes per cube; the boundary adds what a layer of 0.7 spacings would.
pub fn default_spacing(volume: f64, area: f64, nodes: usize) -> f64 {
    let [low, high] = SPACING_RANGE;
    let count = |spacing: f64| 2.0 * (volume + area * LAYER * spacing) / spacing.powi(3);
    let (mut below, mut above) = (low, high);
    // The count falls with the spacing; a thousandth of a percent is far finer than the estimate.
    for _ in 0..40 {
        let middle = 0.5 * (below + above);
        if count(middle) > nodes as f64 { below = middle } else { above = middle }
    }
    0.5 * (below + above)
}
