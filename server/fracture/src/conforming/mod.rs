//! Conforming tetrahedral meshes: closed triangle surfaces and points inside them become tetrahedra whose boundary is
//! exactly the surface.
//!
//! [`conforming_mesh`] checks that the surface is closed, oriented, manifold and free of intersections, splits its long
//! edges, and tetrahedralizes its vertices and the interior points. It then recovers the surface's edges and triangles:
//! local changes of the mesh do so where they can. Where they cannot, it splits the edge or the triangle and starts the
//! next round.
//!
//! Coordinates are final before the recovery begins: rounded vertices on split edges replace the exact ones, the
//! triangles between them are the constraints, and [`ConformingMesh::deviation`] measures how far they are from the input. All
//! signs are exact, so each tetrahedron has a positive volume in the coordinates that the caller receives.
//!
//! Memory and time are bounded by numbers of points, rounds, tetrahedra and steps (`work_limit`), which are equal on
//! every machine.
//!
//! The modules, in the order of the data. Literature calls the surface's edges *segments* and its triangles *facets*:
//!
//! | module | what it does |
//! |---|---|
//! | `input` | checks the surface |
//! | `split_surface` | splits long edges, and flips edges inside input triangles |
//! | `rounds` | repeats the next six rows, with Steiner points where constraints are missing |
//! | `hilbert`, `insertion_order`, `delaunay` | inserts all points into a Delaunay tetrahedralization |
//! | `segments`, `segment_set` | finds missing edges; recovers them by `remove_face` and `remove_edge` |
//! | `facets` | finds missing triangles and recovers them likewise, once all edges exist |
//! | `search` | order of the searches: short ones for all constraints before long ones |
//! | `edge_removal`, `recovery_target`, `edge_list` | local changes, and the obstacles that they must remove |
//! | `flat_tets` | removes tetrahedra without height |
//! | `inside` | keeps the tetrahedra inside the surface, and checks them |
//! | `tetrahedralization`, `predicates` | tetrahedra with neighbors and constraints; exact signs |
//!
//! Based on: H. Si, *TetGen, a Delaunay-based quality tetrahedral mesh generator* (2015); L. Diazzi, D. Panozzo, A. Vaxman,
//! M. Attene, *Constrained Delaunay tetrahedrization: a robust and practical approach* (2023).

mod delaunay;
mod edge_list;
mod edge_removal;
mod error;
mod facets;
mod flat_tets;
mod hilbert;
mod input;
mod insertion_order;
mod inside;
mod predicates;
mod recovery_target;
mod rounds;
mod search;
mod segment_set;
mod segments;
mod split_surface;
#[cfg(test)]
mod test_shapes;
#[cfg(test)]
mod tests;
mod tetrahedralization;
mod work_limit;

use crate::cancel_token::CancelToken;
use input::Input;
use nalgebra::Point3;
use split_surface::SplitSurface;

pub use error::{ConformingError, ConstraintKind};
pub(crate) use hilbert::hilbert_order;
pub use split_surface::SurfacePlace;

/// Longest edge of the surface after the split, relative to the spacing.
const EDGE_LENGTH_MAX: f64 = 0.7;

/// Number of boundary triangles of a mesh of this surface with interior points at `spacing`, without those that the
/// recovery adds.
///
/// If the mesh would have more points than the default limit allows, the number at which the limit is exceeded.
pub(crate) fn boundary_count(positions: &[Point3<f64>], triangles: &[[u32; 3]], spacing: f64) -> usize {
    let mut surface = SplitSurface::new(positions, triangles, spacing * EDGE_LENGTH_MAX);
    surface.split_long_edges(ConformingOptions::default().points_max);
    surface.triangles.len()
}

/// Default limit of the steps. A step takes 10 to 500 ns.
const STEPS_MAX: u64 = 300_000_000;

/// Settings of the mesher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConformingOptions {
    /// Spacing of the interior points, in the units of the coordinates. Edges of the surface longer than 0.7 spacings are
    /// split; infinity keeps all of them.
    pub spacing: f64,
    /// Largest number of repair rounds. Each splits the constraints that are still missing.
    pub rounds_max: u32,
    /// Largest number of points, those that are added included. Limits memory and, together with `steps_max`, time.
    pub points_max: usize,
    /// Largest number of steps in all rounds: signs computed and tetrahedra visited.
    pub steps_max: u64,
}

impl Default for ConformingOptions {
    fn default() -> Self {
        Self { spacing: f64::INFINITY, rounds_max: 20, points_max: 2_000_000, steps_max: STEPS_MAX }
    }
}

/// Step of the mesher, for display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConformingStep {
    /// Checks the surface.
    Check,
    /// Splits long edges.
    Split,
    /// Inserts points, in this repair round.
    Insert {
        /// Repair round, from 0.
        round: u32,
        /// Points inserted.
        done: usize,
        /// Points to insert.
        total: usize,
    },
    /// Recovers edges of the surface.
    Segments {
        /// Repair round, from 0.
        round: u32,
        /// Edges that the Delaunay mesh lacks.
        missing: usize,
    },
    /// Recovers triangles of the surface.
    Facets {
        /// Repair round, from 0.
        round: u32,
        /// Triangles that the mesh lacks.
        missing: usize,
    },
    /// Removes the outside.
    Extract,
}

impl ConformingStep {
    /// Repair round of the step; 0 before the first one, and for the end.
    pub fn round(self) -> u32 {
        match self {
            Self::Insert { round, .. } | Self::Segments { round, .. } | Self::Facets { round, .. } => round,
            Self::Check | Self::Split | Self::Extract => 0,
        }
    }
}

/// Tetrahedral mesh whose boundary is a given surface.
#[derive(Clone, Debug, PartialEq)]
pub struct ConformingMesh {
    /// Nodes: the vertices of the input surface, those on split edges, and the interior points inside the surface.
    pub nodes: Vec<Point3<f64>>,
    /// Corners of each tetrahedron. Each has a positive volume by an exact sign.
    pub tets: Vec<[u32; 4]>,
    /// Triangles of the boundary, counter-clockwise seen from outside.
    pub boundary: Vec<[u32; 3]>,
    /// Input triangle that contains each boundary triangle.
    pub boundary_sources: Vec<u32>,
    /// Place of each boundary node on the input surface. Boundary nodes are the first nodes.
    pub places: Vec<SurfacePlace>,
    /// Interior point of each node after the boundary nodes. Points outside the surface are dropped.
    pub interior_sources: Vec<u32>,
    /// Number of boundary nodes that the recovery added.
    pub steiner_count: usize,
    /// Repair rounds used; 0 if local changes recovered all constraints.
    pub rounds: u32,
    /// Steps used, without those that removed flat tetrahedra; see [`ConformingOptions::steps_max`].
    pub steps: u64,
    /// Largest distance of a boundary node from its place on the input.
    pub deviation: f64,
}

/// True if a tetrahedron has a positive volume, by an exact sign.
pub fn is_positive(corners: &[Point3<f64>; 4]) -> bool {
    let [a, b, c, d] = corners;
    predicates::orientation(a, b, c, d) > 0.0
}

/// Tetrahedralizes the inside of a closed surface and keeps the surface as boundary.
///
/// `triangles` are counter-clockwise seen from outside; several shells and cavities are allowed. `interior` points should
/// keep a distance from the surface. The same input gives the same mesh.
///
/// # Errors
/// [`ConformingError`] if the surface is refused, a limit is exceeded, constraints stay missing, or the work is canceled.
pub fn conforming_mesh(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    interior: &[Point3<f64>],
    options: &ConformingOptions,
    token: &CancelToken,
    progress: &mut dyn FnMut(ConformingStep),
) -> Result<ConformingMesh, ConformingError> {
    if options.spacing.is_nan() || options.spacing <= 0.0 {
        return Err(ConformingError::InvalidSpacing { spacing: options.spacing });
    }
    progress(ConformingStep::Check);
    token.check()?;
    input::check(&Input { positions, triangles, interior })?;
    progress(ConformingStep::Split);
    token.check()?;
    let mut surface = SplitSurface::new(positions, triangles, options.spacing * EDGE_LENGTH_MAX);
    let vertices_max = options.points_max.saturating_sub(interior.len());
    if !surface.split_long_edges(vertices_max) {
        let points = surface.positions.len() + interior.len();
        return Err(ConformingError::TooManyPoints { points, points_max: options.points_max });
    }
    surface.flip_inside_triangles();
    rounds::mesh_surface(surface, interior, options, token, progress)
}
