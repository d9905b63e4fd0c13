//! Quadratic elements on one level of a refined body.
//!
//! Elements are those of `Elasticity` with quadratic elements. The preconditioner is that of its solver as well, with
//! the V-cycle in place of the factor.
//!
//! The functions of a level are among those of the next one. A function of an edge is quadratic along any line, so its
//! coefficient on a finer edge with the barycentric vector δ is −Σ c_ij δ_i δ_j, over the edges ij of the coarse
//! tetrahedron. Midpoints move by the mean of both ends and c. Ours.

use super::cycle::{NodeRow, WIDTH, ZERO, times};
use super::level::RefinedLevel;
use crate::elasticity::element::{Element, Lame};
use crate::elasticity::inertia::Inertia;
use crate::elasticity::quadratic::{EdgeFunctions, element_forces};
use crate::elasticity::{BoundaryNodes, ElasticityError};
use crate::lattice::{CHILD_COUNT, EDGES, Lattice};
use crate::simd::{SimdLanes, widest};
use nalgebra::Vector3;
use pulp::NullaryFnOnce;
use rayon::prelude::*;

/// Elements and edge functions of a level. Vectors have the rows of all nodes, then those of all edges.
pub(super) struct QuadraticLevel {
    lame: Lame,
    elements: Vec<Element>,
    edges: EdgeFunctions,
    nodes: usize,
}

impl QuadraticLevel {
    pub(super) fn new(lattice: &Lattice, lame: Lame, inertia: &Inertia) -> Result<Self, ElasticityError> {
        let element = |tet| Element::new(lattice, tet).ok_or(ElasticityError::DegenerateTet { tet });
        let elements = (0..lattice.tets.len()).into_par_iter().map(element).collect::<Result<_, _>>()?;
        let edges = EdgeFunctions::new(lattice, lame, |node| inertia.arm(node));
        let edges = edges.ok_or(ElasticityError::DegenerateTet { tet: 0 })?;
        Ok(Self { lame, elements, edges, nodes: lattice.nodes.len() })
    }

    /// Number of rows of a vector.
    pub(super) fn rows(&self) -> usize {
        self.nodes + self.edges.count()
    }

    /// Appends the forces on the edges to those on the nodes, which the `applied` forces make.
    pub(super) fn extend(
        &self,
        forces: &mut Vec<f64>,
        applied: &[(u32, Vector3<f64>)],
        (boundary, inertia): (&BoundaryNodes, &Inertia),
    ) {
        forces.resize(3 * self.rows(), 0.0);
        let edge_part = &mut forces[3 * self.nodes..];
        self.edges.add_applied(boundary, applied, edge_part);
        self.edges.subtract_inertia(&inertia.acceleration_of(applied), edge_part);
    }

    /// The load `forces` of the finer level `fine`, with the linear part `level`, on the functions of this one.
    pub(super) fn restricted(&self, level: &RefinedLevel, fine: &Self, forces: &[f64]) -> Vec<f64> {
        let (on_nodes, on_edges) = forces.split_at(3 * fine.nodes);
        let mut found = level.restricted(on_nodes);
        found.extend_from_slice(&on_nodes[3 * self.nodes..]);
        let mut is_done = vec![false; fine.edges.count()];
        for (tet, edges) in fine.edges.tets.iter().enumerate() {
            let parent = tet / CHILD_COUNT;
            for (&edge, ends) in edges.iter().zip(EDGES) {
                if std::mem::replace(&mut is_done[edge as usize], true) {
                    continue;
                }
                let [a, b] =
                    ends.map(|end| self.coordinates(&level.refined.parents, parent, fine.edges.corners[tet][end]));
                let force = &on_edges[3 * edge as usize..][..3];
                for (&coarse, [i, j]) in self.edges.tets[parent].iter().zip(EDGES) {
                    let share = -(b[i] - a[i]) * (b[j] - a[j]);
                    let own = &mut found[3 * (self.nodes + coarse as usize)..][..3];
                    own.iter_mut().zip(force).for_each(|(own, force)| *own += share * force);
                }
            }
        }
        found
    }

    /// Barycentric coordinates in tetrahedron `tet` of a node of the finer level, whose midpoints have these `parents`.
    fn coordinates(&self, parents: &[[u32; 2]], tet: usize, node: u32) -> [f64; 4] {
        let ends = (node as usize).checked_sub(self.nodes).map_or([node; 2], |midpoint| parents[midpoint]);
        self.edges.corners[tet].map(|corner| ends.map(|end| if end == corner { 0.5 } else { 0.0 }).iter().sum())
    }

    /// K x.
    pub(super) fn multiply(&self, x: &[NodeRow], out: &mut [NodeRow]) {
        widest(Product { level: self, x, out });
    }

    /// Divides the rows of the edges by their own blocks of the stiffness.
    pub(super) fn precondition_edges(&self, right: &[NodeRow], x: &mut [NodeRow]) {
        let rows = x[self.nodes..].iter_mut().zip(&right[self.nodes..]);
        rows.zip(&self.edges.inverse_blocks).for_each(|((x, right), block)| *x = times(block, right));
    }

    /// Number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.nodes
    }

    /// Energy in the tetrahedra `tets`.
    pub(super) fn energy(&self, tets: std::ops::Range<usize>, x: &[NodeRow]) -> SimdLanes<WIDTH> {
        let mut twice = SimdLanes::all(0.0);
        for tet in tets {
            let (u, c) = self.gathered(tet, x);
            let (on_nodes, on_edges) = element_forces(self.lame, &self.elements[tet], &u, &c);
            for (x, force) in u.iter().zip(&on_nodes).chain(c.iter().zip(&on_edges)) {
                x.iter().zip(force).for_each(|(x, force)| twice = twice + *x * *force);
            }
        }
        twice * 0.5
    }

    #[inline(always)]
    fn gathered(&self, tet: usize, x: &[NodeRow]) -> ([NodeRow; 4], [NodeRow; 6]) {
        let u = self.edges.corners[tet].map(|node| x[node as usize]);
        (u, self.edges.tets[tet].map(|edge| x[self.nodes + edge as usize]))
    }
}

/// Kernel of a product with the stiffness.
struct Product<'a> {
    level: &'a QuadraticLevel,
    x: &'a [NodeRow],
    out: &'a mut [NodeRow],
}

impl NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { level, x, out } = self;
        out.fill(ZERO);
        for (tet, element) in level.elements.iter().enumerate() {
            let (u, c) = level.gathered(tet, x);
            let (on_nodes, on_edges) = element_forces(level.lame, element, &u, &c);
            let nodes = level.edges.corners[tet].map(|node| node as usize);
            let edges = level.edges.tets[tet].map(|edge| level.nodes + edge as usize);
            for (row, force) in nodes.iter().zip(&on_nodes).chain(edges.iter().zip(&on_edges)) {
                out[*row].iter_mut().zip(force).for_each(|(sum, force)| *sum = *sum + *force);
            }
        }
    }
}
