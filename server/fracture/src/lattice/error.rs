//! Errors of lattice construction from a signed distance.

use crate::cancel_token::Canceled;
use crate::scene::number;
use nalgebra::Point3;

/// Error of lattice construction.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LatticeError {
    /// The spacing is outside [`super::SPACING_RANGE`], or not a number.
    #[error("{level} spacing {} is outside {spacing_min} to {spacing_max} of the bounding-box diagonal", number(*.spacing))]
    SpacingOutOfRange {
        /// Name of the level: "elastic" or "crack", or "lattice" for a lattice by itself.
        level: &'static str,
        /// Requested spacing, local.
        spacing: f64,
        /// Lowest accepted spacing, local.
        spacing_min: f64,
        /// Highest accepted spacing, local.
        spacing_max: f64,
    },
    /// The grid over the shape's bounding box would exceed [`super::GRID_NODES_MAX`].
    #[error("spacing {spacing} needs {nodes:.0} grid nodes, more than {nodes_max}")]
    GridTooLarge {
        /// Number of grid nodes.
        nodes: f64,
        /// Largest accepted number.
        nodes_max: usize,
        /// Requested spacing, local.
        spacing: f64,
    },
    /// A level would have more nodes than [`super::ELASTIC_NODES_MAX`] or [`super::CRACK_NODES_MAX`].
    #[error(
        "{level} spacing {spacing} yields about {nodes:.0} nodes, more than {nodes_max}; use {spacing_needed:.4} or more"
    )]
    TooManyNodes {
        /// Name of the level: "elastic" or "crack".
        level: &'static str,
        /// Requested spacing, local.
        spacing: f64,
        /// Approximate number of nodes.
        nodes: f64,
        /// Largest accepted number.
        nodes_max: usize,
        /// Finest spacing within the limit, local.
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
    /// The shape's bounding box is not finite, or its corners are swapped.
    #[error("the shape's bounding box is not finite, or its lowest corner exceeds its highest")]
    BoundsNotFinite,
    /// The requested volume is not finite and positive.
    #[error("volume {volume} is not finite and positive")]
    VolumeNotPositive {
        /// Requested volume, local.
        volume: f64,
    },
    /// The signed distance is not finite at some point.
    #[error("the signed distance at {place} is not finite")]
    DistanceNotFinite {
        /// Position of that point, local.
        place: Point3<f64>,
    },
    /// No tetrahedron lies inside the shape: it is thinner than the spacing, or empty.
    #[error("nothing lies inside the shape at spacing {spacing}")]
    NothingInside {
        /// Spacing of the lattice, local.
        spacing: f64,
    },
    /// The work was canceled.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}
