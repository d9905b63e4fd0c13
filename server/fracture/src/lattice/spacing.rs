//! Which spacing gives about how many nodes.

use super::grid::SPACING_RANGE;

/// Crack nodes that a bake aims at by default, boundary included.
pub const CRACK_NODES_DEFAULT: usize = 12_000;

/// Elastic nodes that a bake aims at by default, boundary included.
pub const ELASTIC_NODES_DEFAULT: usize = 3_000;

/// Thickness of the layer that stands for the boundary's nodes, in spacings; fitted to spheres, boxes and the horse.
const LAYER: f64 = 0.75;

/// Surface area over volume^(2/3) of the typical object: between a ball (4.8) and an animal on legs.
const COMPACTNESS: f64 = 8.0;

/// [`spacing_for`] where the area is not known, from that of a typical object of this volume.
pub fn default_spacing(volume: f64, nodes: usize) -> f64 {
    spacing_for(volume, COMPACTNESS * volume.powf(2.0 / 3.0), nodes)
}

/// The spacing (local) at which a solid of this volume and surface area (local) gets about `nodes` nodes, boundary
/// included, clamped to [`SPACING_RANGE`].
///
/// A body-centred cubic grid has two nodes per cube; the boundary adds those of a layer of 0.4 spacings.
pub fn spacing_for(volume: f64, area: f64, nodes: usize) -> f64 {
    let [mut low, mut high] = SPACING_RANGE;
    let count = |spacing: f64| 2.0 * (volume + area * LAYER * spacing) / spacing.powi(3);
    // The count falls with the spacing; 40 halvings are far finer than the estimate.
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if count(middle) > nodes as f64 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
