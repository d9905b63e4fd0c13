//! Tetrahedral lattices: the type, its measures and its boundary, and their construction from signed distances.

mod adjacency;
mod block;
mod boundary_fit;
mod crack_slot;
mod crossing_repair;
mod cut;
mod energy_transfer;
mod error;
mod grid;
mod level;
mod levels;
mod locate;
mod manifold_repair;
mod measure;
mod overlap;
#[cfg(test)]
mod shapes;
mod spacing;
mod stencil;
mod stretch;
mod stuffing;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod thin_tests;
mod tree;
mod turned_box;
mod uniform_refinement;

pub use adjacency::{NO_TET, NodeStars};
pub use block::block;
pub use crack_slot::{SLOT_HALF, SlotDepth, slotted_levels, stuff_slotted};
pub use energy_transfer::{EnergyTransfer, NO_INDEX};
pub use error::LatticeError;
pub use grid::{GRID_NODES_MAX, SPACING_RANGE};
pub use level::{BODY_SHARE_MIN, BODY_TETS_MIN, DroppedComponent, LatticeLevel, VOLUME_TOLERANCE, stuff};
pub use levels::{
    BodyLattice, LatticeLevelReport, LatticeLevels, OVERLAP_MIN, ReplacedBody, Replacement, Spacings, fitted_levels,
    levels,
};
pub use locate::{LatticePoint, Locator, NearestOnBoundary};
pub use manifold_repair::{NonManifold, check_manifold};
pub use measure::DihedralRange;
pub(crate) use measure::area_vector;
pub use spacing::{
    CRACK_NODES_DEFAULT, CRACK_NODES_MAX, ELASTIC_NODES_DEFAULT, ELASTIC_NODES_MAX, default_spacing,
    finest_grid_spacing, spacings,
};
pub use stretch::LatticeStretch;
pub use turned_box::TurnedBox;
pub use uniform_refinement::{CHILD_COUNT, RefinedLattice, refined_node_count, refinements};

use nalgebra::{Matrix3, Point3};

/// Solid given by its signed distance, in local lengths.
pub trait SignedDistance: Sync {
    /// Distance from `point` to the surface, negative inside.
    ///
    /// The sign may jump away from the surface where the surface has holes. The magnitude must
    /// not exceed the true distance.
    fn signed_distance(&self, point: &Point3<f64>) -> f64;

    /// True if every magnitude is the distance to a place where the sign may change, or less. Points nearer than it then have the same sign.
    fn has_exact_sign(&self) -> bool {
        false
    }

    /// Lowest and highest corner of a box that contains the solid.
    fn bounds(&self) -> (Point3<f64>, Point3<f64>);

    /// Box in other directions that contains the solid, for a grid where that over [`Self::bounds`] is too large.
    fn turned_box(&self) -> Option<TurnedBox> {
        None
    }
}

/// Tetrahedral lattice in local coordinates.
///
/// All constructors in this module ensure these invariants:
///
/// - every tetrahedron has positive volume, det(b−a, c−a, d−a) > 0;
/// - every node belongs to a tetrahedron;
/// - the tetrahedra are connected through faces;
/// - the boundary is a closed 2-manifold: every boundary edge has two boundary faces, every boundary node one fan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lattice {
    /// Node positions, local.
    pub nodes: Vec<Point3<f64>>,
    /// Four node indices of each tetrahedron.
    pub tets: Vec<[u32; 4]>,
}

/// Faces of a positively oriented tetrahedron (a, b, c, d), counter-clockwise seen from outside.
///
/// Face k is opposite node k.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Edges of a tetrahedron, by local node index, lower first.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Triangle of a lattice's boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryFace {
    /// Node indices, counter-clockwise seen from outside.
    pub nodes: [u32; 3],
    /// Tetrahedron behind the face.
    pub tet: u32,
}

impl Lattice {
    /// Four corners of tetrahedron `tet`, local.
    pub fn corners(&self, tet: usize) -> [Point3<f64>; 4] {
        self.tets[tet].map(|node| self.nodes[node as usize])
    }

    /// Edge matrix [b−a, c−a, d−a] of tetrahedron `tet`; its columns are local lengths.
    pub fn edge_matrix(&self, tet: usize) -> Matrix3<f64> {
        let [a, b, c, d] = self.corners(tet);
        Matrix3::from_columns(&[b - a, c - a, d - a])
    }

    /// Volume of tetrahedron `tet`, local.
    pub fn tet_volume(&self, tet: usize) -> f64 {
        self.edge_matrix(tet).determinant() / 6.0
    }

    /// Volume of the whole lattice, local.
    pub fn volume(&self) -> f64 {
        (0..self.tets.len()).map(|tet| self.tet_volume(tet)).sum()
    }

    /// Node volumes: a quarter of each tetrahedron's volume for each of its nodes; local.
    ///
    /// Has length `nodes.len()` and sum [`Self::volume`].
    pub fn node_volumes(&self) -> Vec<f64> {
        let mut volumes = vec![0.0; self.nodes.len()];
        for (tet, nodes) in self.tets.iter().enumerate() {
            let quarter = self.tet_volume(tet) / 4.0;
            for &node in nodes {
                volumes[node as usize] += quarter;
            }
        }
        volumes
    }

    /// Faces without a neighbor ([`Self::neighbors`]), oriented outward, ordered by (tetrahedron, face).
    pub fn boundary(&self) -> Vec<BoundaryFace> {
        let mut boundary = Vec::new();
        for (tet, around) in self.neighbors().iter().enumerate() {
            for (face, _) in around.iter().enumerate().filter(|(_, other)| **other == NO_TET) {
                boundary.push(BoundaryFace { nodes: FACES[face].map(|c| self.tets[tet][c]), tet: tet as u32 });
            }
        }
        boundary
    }

    /// Edges as (lower node, higher node), each once, sorted.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = self
            .tets
            .iter()
            .flat_map(|nodes| EDGES.map(|[i, j]| [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])]))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }
}
