//! Cutting meshes: tetrahedra whose boundary is the input surface, on which labels and tessellation run.
//!
//! Elasticity, lift and diagram stay on the crack lattice. A *carrier* joins each node of the cutting mesh to a
//! tetrahedron of that lattice: lifted coordinates and labels are carried from its corners. The tessellator then closes
//! the fragments as it does on the lattice, so that their outer faces are triangles of the input.
//!
//! | module | what it does |
//! |---|---|
//! | `build` | mesh of one body from the input surface and the nodes of its crack lattice |
//! | `edge_defects` | count and places of edges that keep a surface from being closed |
//! | `films`, `slits` | close the holes of the surface |
//! | `short_edges` | collapses edges that single precision cannot represent |
//! | `united` | unites parts that intersect or contain one another |
//! | `separated` | moves parts apart that touch in a vertex |
//! | `meshed_surface`, `surface_repair` | the surface after these steps; a step for the report |
//! | `carriers` | tetrahedron of the crack lattice that carries each node |
//! | `contact_surface` | the boundary as the surface that contacts and rays meet |
//! | `outer_corners` | attributes of the input at the corners of the boundary |
//!
//! The idea is ours. The mesher is [`conforming_mesh`](crate::conforming::conforming_mesh).

mod build;
mod carriers;
mod contact_surface;
mod edge_defects;
#[cfg(test)]
mod exposed_tests;
mod films;
mod meshed_surface;
mod outer_corners;
#[cfg(test)]
mod repair_tests;
mod separated;
mod short_edges;
mod slits;
mod surface_repair;
#[cfg(test)]
mod tests;
mod united;

pub use build::{CuttingError, CuttingMeshes, cutting_meshes};
pub use carriers::Carrier;
pub use edge_defects::{EdgeDefectKind, EdgeDefects};
pub use films::FilledSurface;
pub use outer_corners::OuterCorners;
pub(crate) use surface_repair::LISTED_MAX;
pub use surface_repair::{RepairKind, SurfaceRepair};

use crate::elasticity::FaceBoxes;
use crate::lattice::Lattice;
use crate::lift::{LiftKind, LiftedLattice};
use crate::memory::held;
use crate::tessellation::{Topology, preference};
use rayon::prelude::*;

/// Nodes per task.
const GRAIN: usize = 1024;

/// Mesh of one body for labels and tessellation. Its boundary lies on the input surface.
#[derive(Clone, Debug, PartialEq)]
pub struct CuttingMesh {
    /// Nodes and tetrahedra, local.
    pub mesh: Lattice,
    /// Edges, faces and boundary of the mesh.
    pub topology: Topology,
    /// Lumped volumes of the nodes, local.
    pub volumes: Vec<f64>,
    /// Carrier of each node.
    pub carriers: Vec<Carrier>,
    /// Attributes of the boundary, if they were selected.
    pub outer: Option<OuterCorners>,
    /// Corners of the carrier's tetrahedron at each node, for requests: most nodes need no more.
    carrier_corners: Vec<[u32; 4]>,
    /// Node that represents each node of the crack lattice.
    representatives: Vec<u32>,
    /// Nodes on edges too short to be cut, each with the lowest node of its group.
    groups: Vec<[u32; 2]>,
    /// Carried coordinates of the lifts that the body has.
    lifts: Vec<LiftedLattice>,
    /// Boxes of the boundary's faces.
    boxes: FaceBoxes,
}

impl CuttingMesh {
    /// Joins `mesh` to the crack lattice. `tets`: the lattice's tetrahedron that carries each node.
    pub fn new(mesh: Lattice, crack: &Lattice, tets: &[u32]) -> Self {
        let carriers = carriers::weights(&mesh, crack, tets);
        let topology = Topology::new(&mesh);
        let corners = |face: usize| topology.boundary[face].nodes.map(|node| mesh.nodes[node as usize]);
        let boxes = FaceBoxes::new(topology.boundary.len(), corners);
        Self {
            volumes: mesh.node_volumes(),
            representatives: carriers::representatives(crack, &carriers),
            groups: short_edges::groups(&mesh.nodes, &topology.edges),
            carriers,
            carrier_corners: tets.iter().map(|&tet| crack.tets[tet as usize]).collect(),
            topology,
            mesh,
            outer: None,
            lifts: Vec::new(),
            boxes,
        }
    }

    /// The first node whose carrier lies much farther away than another tetrahedron of the crack lattice; a bake leaves none.
    pub fn misplaced(&self, crack: &Lattice) -> Option<usize> {
        carriers::misplaced(&self.mesh, crack, &self.carriers)
    }

    /// Carries the lifts of the crack lattice to the nodes, once for all requests.
    pub fn carry_lifts<'a>(&mut self, crack: &Lattice, lifts: impl Iterator<Item = &'a LiftedLattice>) {
        self.lifts = lifts.map(|lift| self.carried(crack, lift)).collect();
    }

    /// The carried lift of the given kind, if the body has it.
    pub fn lift(&self, kind: LiftKind) -> Option<&LiftedLattice> {
        self.lifts.iter().find(|lift| lift.kind == kind)
    }

    /// Lifted coordinates at the nodes: those of the carrier's corners, interpolated. Cells are not measured.
    pub fn carried(&self, crack: &Lattice, lift: &LiftedLattice) -> LiftedLattice {
        let mut coordinates = vec![0.0; self.mesh.nodes.len() * lift.dimension];
        let nodes = coordinates.par_chunks_mut(lift.dimension).zip(&self.carriers).with_min_len(GRAIN);
        nodes.for_each(|(out, carrier)| {
            for (&node, weight) in crack.tets[carrier.tet as usize].iter().zip(carrier.weights) {
                out.iter_mut().zip(lift.at(node as usize)).for_each(|(sum, x)| *sum += weight * x);
            }
        });
        let (first_moment, second_moment, density) = (Vec::new(), Vec::new(), Vec::new());
        LiftedLattice { kind: lift.kind, dimension: lift.dimension, coordinates, first_moment, second_moment, density }
    }

    /// Site of each node: the one with the least distance in `lift` among the sites of the carrier's corners.
    ///
    /// `lift` is carried to this mesh, `sites` are coordinates in it, and `labels` are the sites of the lattice's nodes.
    /// Equal labels at all corners need no distance, because cells are convex in a carrier, where the lift is linear.
    /// The ends of a short edge have one site, so that no crack point lies between them. Opposite corners of a flat
    /// quadrilateral of the surface are not joined below what divides them above.
    pub fn label(&self, lift: &LiftedLattice, sites: &[f64], labels: &[u32], out: &mut Vec<u32>) {
        let site = |label: u32| &sites[label as usize * lift.dimension..][..lift.dimension];
        let nearest = |(node, corners): (usize, &[u32; 4])| {
            let corners = corners.map(|corner| labels[corner as usize]);
            let nearer = |best: u32, other: u32| {
                if other == best {
                    return best;
                }
                let (low, high) = (best.min(other), best.max(other));
                if preference(lift.at(node), site(high), site(low)) < 0.0 { high } else { low }
            };
            corners[1..].iter().fold(corners[0], |best, &other| nearer(best, other))
        };
        self.carrier_corners.par_iter().enumerate().with_min_len(GRAIN).map(nearest).collect_into_vec(out);
        self.topology.join_opposite_corners(out);
        self.join_short_edges(out);
    }

    /// Gives both ends of each short edge one site, so that no crack point lies between them.
    pub fn join_short_edges(&self, sites: &mut [u32]) {
        self.groups.iter().for_each(|&[node, lowest]| sites[node as usize] = sites[lowest as usize]);
    }

    /// Number of parts into which `nodes`, ascending, can be divided: nodes on one short edge stay together.
    pub fn group_count(&self, nodes: &[u32]) -> usize {
        let joined = self.groups.iter().filter(|[node, _]| nodes.binary_search(node).is_ok());
        nodes.len() - joined.count()
    }

    /// Labels of the crack lattice's nodes: those of the nodes that represent them.
    pub fn lattice_labels(&self, labels: &[u32]) -> Vec<u32> {
        self.representatives.iter().map(|&node| labels[node as usize]).collect()
    }

    /// Number of nodes that are too far outside the crack lattice to be extrapolated.
    pub fn anchored_count(&self) -> usize {
        self.carriers.iter().filter(|carrier| carrier.is_anchored).count()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { mesh, topology, volumes, carriers, carrier_corners, outer, representatives, groups, .. } = self;
        let Self { lifts, boxes, .. } = self;
        let lifts = lifts.iter().map(|lift| held(&lift.coordinates)).sum::<usize>() + held(lifts);
        let nodes = held(volumes) + held(carriers) + held(carrier_corners) + held(representatives) + held(groups);
        let outer = outer.as_ref().map_or(0, OuterCorners::bytes);
        held(&mesh.nodes) + held(&mesh.tets) + topology.bytes() + boxes.bytes() + nodes + lifts + outer
    }
}
