//! Lifts X: Ω → R^m, which turn an interior distance into a straight one, d(x, y) = |X(x) − X(y)|.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014), section
//! 3. Scale and cell moments are our own.

mod basis;
mod boundary;
mod error;
mod extension;
mod gap;
mod interior;
mod lanczos;
mod laplacian;
mod mean_value;
mod metric;
mod spectrum;
mod stretch;
mod surface_diffusion;
#[cfg(test)]
mod tests;
mod warp;

pub use boundary::{BoundaryShell, BoundarySurface};
pub use error::LiftError;
pub use extension::{Extension, carry_harmonic, carry_mean_value};
pub use interior::{ALPHA_DEFAULT, MODES_DEFAULT, MODES_MAX, interior};
pub use spectrum::Spectrum;
pub use stretch::{Stretch, stretch};
pub use surface_diffusion::{SHELLS_MAX, SURFACE_MODES_DEFAULT, surface_diffusion};
pub use warp::SpaceWarp;

use crate::lattice::Lattice;
use serde::{Deserialize, Serialize};

/// Kind of a lift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LiftKind {
    /// X = x, the ablation. Cells leak across concavities.
    Euclidean,
    /// X = s·[x; α·ψ(x)] with ψ_k = φ_k/λ_k from the Neumann eigenpairs of the tetrahedral Laplacian.
    Interior,
    /// X = s·v*: diffusion coordinates e^(−λ_k t)·φ_k of the boundary surface, extended
    /// inside by barycentric coordinates.
    SurfaceDiffusion,
}

impl std::fmt::Display for LiftKind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Euclidean => "euclidean",
            Self::Interior => "interior",
            Self::SurfaceDiffusion => "surface_diffusion",
        })
    }
}

/// Lifted lattice: coordinates on nodes, linear on each tetrahedron, with the cell moments that the criterion needs.
///
/// Scaled so that the volume mean of (det g)^(1/5), g = JᵀJ, is 1. The degree of a uniform field
/// then does not depend on the lift.
#[derive(Clone, Debug, PartialEq)]
pub struct LiftedLattice {
    /// Kind of this lift.
    pub kind: LiftKind,
    /// Dimension m, at least 3.
    pub dimension: usize,
    /// Lifted coordinates, node-major, `nodes × dimension`; local lengths.
    pub coordinates: Vec<f64>,
    /// First moments b_v: mean of X − X_v over node v's barycentric cell; local lengths.
    ///
    /// Node-major, `nodes × dimension`. On the boundary it is of the size of the spacing; inside
    /// a regular lattice it vanishes.
    pub first_moment: Vec<f64>,
    /// Second moments m_v: mean of |X − X_v|² over node v's barycentric cell; local length squared. Length `nodes`.
    pub second_moment: Vec<f64>,
    /// Volume mean of (det g)^(1/5) over node v's cell; dimensionless. Length `nodes`.
    pub density: Vec<f64>,
}

impl LiftedLattice {
    /// Scales `coordinates` (node-major, `nodes × dimension`) to unit mean of (det g)^(1/5), and measures the cells.
    pub fn scaled(kind: LiftKind, lattice: &Lattice, dimension: usize, coordinates: Vec<f64>) -> Self {
        let mut lift = Self::unmeasured(kind, lattice, dimension, coordinates);
        metric::scale(&mut lift, lattice);
        metric::measure(&mut lift, lattice);
        lift
    }

    /// Measures the cells of coordinates that are already scaled. A stored lift yields the
    /// same bits as when it was made.
    pub fn measured(kind: LiftKind, lattice: &Lattice, dimension: usize, coordinates: Vec<f64>) -> Self {
        let mut lift = Self::unmeasured(kind, lattice, dimension, coordinates);
        metric::measure(&mut lift, lattice);
        lift
    }

    fn unmeasured(kind: LiftKind, lattice: &Lattice, dimension: usize, coordinates: Vec<f64>) -> Self {
        debug_assert_eq!(coordinates.len(), lattice.nodes.len() * dimension);
        let (first_moment, second_moment, density) = (Vec::new(), Vec::new(), Vec::new());
        Self { kind, dimension, coordinates, first_moment, second_moment, density }
    }

    /// Euclidean lift, X = x.
    pub fn euclidean(lattice: &Lattice) -> Self {
        let coordinates = lattice.nodes.iter().flat_map(|node| [node.x, node.y, node.z]).collect();
        Self::scaled(LiftKind::Euclidean, lattice, 3, coordinates)
    }

    /// The lift at these nodes only, in this order.
    pub(crate) fn of_nodes(&self, nodes: &[u32]) -> Self {
        let rows = |values: &[f64]| {
            nodes
                .iter()
                .flat_map(|&node| &values[node as usize * self.dimension..][..self.dimension])
                .copied()
                .collect()
        };
        let entries = |values: &[f64]| nodes.iter().map(|&node| values[node as usize]).collect();
        Self {
            kind: self.kind,
            dimension: self.dimension,
            coordinates: rows(&self.coordinates),
            first_moment: rows(&self.first_moment),
            second_moment: entries(&self.second_moment),
            density: entries(&self.density),
        }
    }

    /// Lifted coordinates X of node `node`, length `dimension`.
    pub fn at(&self, node: usize) -> &[f64] {
        &self.coordinates[node * self.dimension..][..self.dimension]
    }

    /// [`Self::at`], to be written.
    pub(crate) fn at_mut(&mut self, node: usize) -> &mut [f64] {
        &mut self.coordinates[node * self.dimension..][..self.dimension]
    }
}
