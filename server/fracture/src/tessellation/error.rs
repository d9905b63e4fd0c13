//! Errors of the tessellation.

/// An input that does not belong to the lattice, or memory of the wrong size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TessellationError {
    /// The number of labels differs from that of the lattice's nodes.
    #[error("{labels} labels for {nodes} lattice nodes; one per node is needed")]
    LabelCount {
        /// Number of lattice nodes.
        nodes: usize,
        /// Number of labels.
        labels: usize,
    },
    /// A label is not below the number of nodes, so labels cannot be consecutive.
    #[error("node {node} has label {label}, which is not below the number of nodes")]
    LabelOutOfRange {
        /// The first such node.
        node: usize,
        /// Its label.
        label: u32,
    },
    /// A label has no site, or its site has no coordinates.
    #[error("fragment {fragment} has no site")]
    Site {
        /// Index of the fragment.
        fragment: usize,
    },
    /// A node has no site, or its site has no coordinates.
    #[error("lattice node {node} has no site")]
    NodeSite {
        /// Index of the node.
        node: usize,
    },
    /// The edge of a fixed point does not exist, or the point is not finite.
    #[error("fixed point of edge {edge} is out of range or not finite")]
    FixedEdge {
        /// Given edge index.
        edge: u32,
    },
    /// The face of a fixed point does not exist, or the point is not finite.
    #[error("fixed point of face {face} is out of range or not finite")]
    FixedFace {
        /// Given face index.
        face: u32,
    },
    /// The tetrahedron of a fixed point does not exist, or the point is not finite.
    #[error("fixed point of tetrahedron {tet} is out of range or not finite")]
    FixedTet {
        /// Given tetrahedron index.
        tet: u32,
    },
    /// The crack points were computed for other labels or another lattice.
    #[error("the crack points were computed for other labels or another lattice")]
    Points,
    /// The slice for positions has the wrong length.
    #[error("{given} positions given, {needed} needed")]
    Positions {
        /// Needed length.
        needed: usize,
        /// Given length.
        given: usize,
    },
    /// The slice for indices has the wrong length.
    #[error("{given} indices given, {needed} needed")]
    Indices {
        /// Needed length.
        needed: usize,
        /// Given length.
        given: usize,
    },
    /// The slice for merge pairs has the wrong length.
    #[error("{given} merge pairs given, {needed} needed")]
    Merges {
        /// Needed length.
        needed: usize,
        /// Given length.
        given: usize,
    },
    /// The number of centers differs from that of the fragments.
    #[error("{given} centers given for {needed} fragments")]
    Centers {
        /// Number of fragments.
        needed: usize,
        /// Given number of centers.
        given: usize,
    },
}
