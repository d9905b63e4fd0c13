//! What the tessellation refuses, one noun per rule.

/// An input that does not belong to the lattice, or memory of the wrong size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TessellationError {
    /// One label per lattice node is needed.
    #[error("{labels} labels for {nodes} lattice nodes")]
    LabelCount {
        /// Lattice nodes.
        nodes: usize,
        /// Labels given.
        labels: usize,
    },
    /// Labels are dense: there cannot be more of them than nodes.
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
        /// The fragment.
        fragment: usize,
    },
    /// A node has no site, or its site has no coordinates.
    #[error("lattice node {node} has no site")]
    NodeSite {
        /// The node.
        node: usize,
    },
    /// A fixed edge point names no edge or is not finite.
    #[error("fixed point of edge {edge} is out of range or not finite")]
    FixedEdge {
        /// Edge index given.
        edge: u32,
    },
    /// A fixed face point names no face or is not finite.
    #[error("fixed point of face {face} is out of range or not finite")]
    FixedFace {
        /// Face index given.
        face: u32,
    },
    /// A fixed tetrahedron point names no tetrahedron or is not finite.
    #[error("fixed point of tetrahedron {tet} is out of range or not finite")]
    FixedTet {
        /// Tetrahedron index given.
        tet: u32,
    },
    /// The crack points were found for other labels or another lattice.
    #[error("crack points are not those of the labels")]
    Points,
    /// The slice for positions is not of the tessellation's size.
    #[error("{given} positions given, {needed} needed")]
    Positions {
        /// Exact length needed.
        needed: usize,
        /// Length given.
        given: usize,
    },
    /// The slice for indices is not of the tessellation's size.
    #[error("{given} indices given, {needed} needed")]
    Indices {
        /// Exact length needed.
        needed: usize,
        /// Length given.
        given: usize,
    },
    /// The slice for merge pairs is not of the tessellation's size.
    #[error("{given} merge pairs given, {needed} needed")]
    Merges {
        /// Exact length needed.
        needed: usize,
        /// Length given.
        given: usize,
    },
    /// One center per fragment is needed.
    #[error("{given} centers given for {needed} fragments")]
    Centers {
        /// Fragments.
        needed: usize,
        /// Centers given.
        given: usize,
    },
}
