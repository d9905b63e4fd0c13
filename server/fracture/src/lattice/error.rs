//! What can go wrong between a signed distance and a lattice.

use crate::cancel_token::Cancelled;
use nalgebra::Point3;

/// Why there is no lattice.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LatticeError {
    /// The spacing is outside [`super::SPACING_RANGE`], or not a number.
    #[error("spacing {spacing} is outside {spacing_min} to {spacing_max} of the bounding-box diagonal")]
    SpacingOutOfRange {
        /// What was asked for, local.
        spacing: f64,
        /// Lowest accepted.
        spacing_min: f64,
        /// Highest accepted.
        spacing_max: f64,
    },
    /// The grid over the shape's box would exceed [`super::GRID_NODES_MAX`].
    #[error("spacing {spacing} needs {nodes:.0} grid nodes, more than {nodes_max}")]
    GridTooLarge {
        /// Nodes of the grid.
        nodes: f64,
        /// The limit.
        nodes_max: usize,
        /// The spacing, local.
        spacing: f64,
    },
    /// A level would have more nodes than [`super::ELASTIC_NODES_MAX`] or [`super::CRACK_NODES_MAX`].
    #[error(
        "{level} spacing {spacing} gives about {nodes:.0} nodes, more than {nodes_max}; {spacing_needed:.4} is fine"
    )]
    TooManyNodes {
        /// "elastic" or "crack".
        level: &'static str,
        /// What was asked for, local.
        spacing: f64,
        /// About how many nodes.
        nodes: f64,
        /// The limit.
        nodes_max: usize,
        /// The finest spacing within the limit, local.
        spacing_needed: f64,
    },
    /// The crack level would be coarser than the elastic one.
    #[error("crack spacing {crack} is coarser than elastic spacing {elastic}")]
    CrackCoarser {
        /// Spacing of the crack level, local.
        crack: f64,
        /// Spacing of the elastic level, local.
        elastic: f64,
    },
    /// The shape's box is not finite, or inside out.
    #[error("the shape's bounds are not finite, or inside out")]
    BoundsNotFinite,
    /// The volume asked for is not finite and positive.
    #[error("volume {volume} is not finite and positive")]
    VolumeNotPositive {
        /// What was asked for, local.
        volume: f64,
    },
    /// The signed distance is not finite somewhere.
    #[error("the signed distance at {place} is not finite")]
    DistanceNotFinite {
        /// Where, local.
        place: Point3<f64>,
    },
    /// No tetrahedron lies inside the shape: it is thinner than the spacing, or empty.
    #[error("nothing lies inside the shape at spacing {spacing}")]
    NothingInside {
        /// The spacing, local.
        spacing: f64,
    },
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
