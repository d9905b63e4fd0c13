//! Regions of a tessellation's labels inside tetrahedra.
//!
//! Our own method. Crack points divide every edge, face and tetrahedron among its corners. With one point on each of
//! them, a tetrahedron is divided into 24 small ones, one per chain of corner, edge, face and interior. Those around a
//! corner are the region of its label.
//!
//! An edge without a crack point takes its middle, where any point is valid. A face or an interior without a crack
//! point of its own takes the mean of the crack points on its rim. Quadrilaterals of cracks that the margin has bent
//! are then fans about their middle, where the tessellation has two triangles: a difference of second order.

use super::AccuracyError;
use super::polytope::BarycentricWeights;
use crate::lattice::{EDGES, FACES, Lattice, LatticePoint};
use crate::lift::LiftedLattice;
use crate::tessellation::{BisectorSites, CrackPoints, FixedPoints, Topology, crack_points, tessellate};
use nalgebra::{Matrix4, Point3, Vector4};

/// Labels of the nodes of a lattice, with the crack points between them.
pub struct Regions<'a> {
    /// Lattice of the labels.
    pub(super) lattice: &'a Lattice,
    topology: &'a Topology,
    /// Label of each node.
    pub(super) labels: &'a [u32],
    points: CrackPoints,
    edges: Vec<Option<Point3<f64>>>,
    faces: Vec<Option<Point3<f64>>>,
    tets: Vec<Option<Point3<f64>>>,
}

/// Small tetrahedron, and the node whose region contains it.
pub(super) type Flag = (u32, [BarycentricWeights; 4]);

impl<'a> Regions<'a> {
    /// Regions that a request creates from `labels` (sites, one per node).
    ///
    /// Crack points lie on the bisectors of `sites` (site-major) in `lift`, within the tessellator's margin. Components
    /// of a label are not distinguished.
    ///
    /// # Errors
    /// [`AccuracyError::Tessellation`].
    pub fn new(
        lattice: &'a Lattice,
        topology: &'a Topology,
        lift: &LiftedLattice,
        sites: &[f64],
        labels: &'a [u32],
    ) -> Result<Self, AccuracyError> {
        let of_fragment: Vec<u32> = (0..(sites.len() / lift.dimension.max(1)) as u32).collect();
        let sites = BisectorSites { lift, coordinates: sites, of_fragment: &of_fragment, of_node: None };
        let points = crack_points(lattice, topology, labels, Some(sites), &FixedPoints::default())?;
        let found = points.to_fixed();
        let by_simplex = |count: usize, found: Vec<(u32, Point3<f64>)>| {
            let mut places = vec![None; count];
            found.into_iter().for_each(|(simplex, place)| places[simplex as usize] = Some(place));
            places
        };
        Ok(Self {
            lattice,
            topology,
            labels,
            edges: by_simplex(topology.edges.len(), found.edges),
            faces: by_simplex(topology.faces.len(), found.faces),
            tets: by_simplex(lattice.tets.len(), found.tets),
            points,
        })
    }

    /// Crack surface as triangles, local, each once.
    ///
    /// # Errors
    /// [`AccuracyError::Tessellation`].
    pub fn cracks(&self) -> Result<Vec<[Point3<f64>; 3]>, AccuracyError> {
        let tessellation = tessellate(self.lattice, self.topology, self.labels, &self.points)?;
        let mut triangles = Vec::new();
        for run in tessellation.runs().iter().filter(|run| run.neighbor.is_some_and(|other| run.fragment < other)) {
            let vertices = tessellation.run_vertices(run);
            triangles.extend(tessellation.run_triangles(run).map(|corners| corners.map(|at| vertices[at as usize])));
        }
        Ok(triangles)
    }

    /// Label at a point of the lattice.
    pub fn label(&self, place: &LatticePoint) -> u32 {
        let tet = place.tet as usize;
        let nodes = self.lattice.tets[tet];
        if self.is_uniform(tet) {
            return self.labels[nodes[0] as usize];
        }
        // The small tetrahedron with the largest least barycentric coordinate contains the point.
        let (mut best, mut label) = (f64::NEG_INFINITY, self.labels[nodes[0] as usize]);
        for (node, corners) in self.flags(tet) {
            let least = within(&corners, &place.barycentric);
            if least > best {
                (best, label) = (least, self.labels[node as usize]);
            }
        }
        label
    }

    /// Returns true if all corners of a tetrahedron have the same label.
    pub(super) fn is_uniform(&self, tet: usize) -> bool {
        let [first, rest @ ..] = self.lattice.tets[tet].map(|node| self.labels[node as usize]);
        rest.iter().all(|label| *label == first)
    }

    /// The 24 small tetrahedra of a tetrahedron.
    pub(super) fn flags(&self, tet: usize) -> Vec<Flag> {
        let points = self.tet_points(tet);
        let mut flags = Vec::with_capacity(24);
        for (face, corners) in FACES.iter().enumerate() {
            for side in 0..3 {
                let edge = [corners[side], corners[(side + 1) % 3]];
                let middle = points.edges[edge_between(edge)];
                for corner in edge {
                    flags.push((
                        self.lattice.tets[tet][corner],
                        [unit(corner), middle, points.faces[face], points.inside],
                    ));
                }
            }
        }
        flags
    }

    /// Points of a tetrahedron: one on every edge, on every face and inside.
    fn tet_points(&self, tet: usize) -> TetPoints {
        let corners = self.lattice.corners(tet);
        let inverse = Matrix4::from_fn(|row, k| if row == 0 { 1.0 } else { corners[k][row - 1] }).try_inverse();
        let inverse = inverse.unwrap_or_else(Matrix4::identity);
        let weights = |point: Point3<f64>| -> BarycentricWeights {
            (inverse * Vector4::new(1.0, point.x, point.y, point.z)).into()
        };
        let cut: [Option<BarycentricWeights>; 6] =
            std::array::from_fn(|edge| self.edges[self.topology.tet_edges[tet][edge] as usize].map(weights));
        let own: [Option<BarycentricWeights>; 4] =
            std::array::from_fn(|face| self.faces[self.topology.tet_faces[tet][face] as usize].map(weights));
        let rims = FACES.map(|[a, b, c]| [[a, b], [b, c], [c, a]].map(|edge| cut[edge_between(edge)]));
        let inside = match (self.tets[tet], own.iter().any(Option::is_some)) {
            (Some(point), _) => weights(point),
            (None, true) => mean(&own),
            (None, false) => mean(&cut),
        };
        TetPoints {
            edges: std::array::from_fn(|edge| cut[edge].unwrap_or_else(|| mean(&EDGES[edge].map(|k| Some(unit(k)))))),
            faces: std::array::from_fn(|face| match (own[face], rims[face].iter().any(Option::is_some)) {
                (Some(point), _) => point,
                (None, true) => mean(&rims[face]),
                (None, false) => mean(&FACES[face].map(|k| Some(unit(k)))),
            }),
            inside,
        }
    }
}

struct TetPoints {
    edges: [BarycentricWeights; 6],
    faces: [BarycentricWeights; 4],
    inside: BarycentricWeights,
}

fn unit(corner: usize) -> BarycentricWeights {
    std::array::from_fn(|k| f64::from(u8::from(k == corner)))
}

/// Mean of the points that are present; at least one must be.
fn mean(points: &[Option<BarycentricWeights>]) -> BarycentricWeights {
    let there = points.iter().flatten();
    let count = there.clone().count() as f64;
    std::array::from_fn(|k| there.clone().map(|point| point[k]).sum::<f64>() / count)
}

/// Index in [`EDGES`] of the edge between two corners.
fn edge_between([a, b]: [usize; 2]) -> usize {
    let edge = [a.min(b), a.max(b)];
    EDGES.iter().position(|known| *known == edge).unwrap_or(0)
}

/// Least barycentric coordinate of a point in a small tetrahedron.
fn within(corners: &[BarycentricWeights; 4], point: &BarycentricWeights) -> f64 {
    let matrix = Matrix4::from_fn(|row, k| corners[k][row]);
    matrix.try_inverse().map_or(f64::NEG_INFINITY, |inverse| (inverse * Vector4::from(*point)).min())
}
