//! Mesh on which a struck fragment is cut, with the lift of the fragment and the sites of its nodes.

use super::parent::{NO_REPRESENTATIVE, ParentFragment};
use crate::cutting::{Carrier, CuttingMesh};
use crate::lattice::Lattice;
use crate::lift::LiftedLattice;
use crate::pipeline::output::retained::RetainedBody;
use crate::pipeline::prepared::object::PreparedBody;
use crate::pipeline::stages::cells::BodyCells;
use crate::tessellation::{Topology, preference};
use std::collections::VecDeque;

/// Mesh of the body that contains the fragment, the fragment's lift at its nodes, and their sites.
pub(super) struct ChildDomain<'a> {
    /// Nodes and tetrahedra, local.
    pub mesh: &'a Lattice,
    /// Edges, faces and boundary.
    pub topology: &'a Topology,
    /// Lift of the fragment; zero at nodes of other fragments.
    pub lift: LiftedLattice,
    /// Site of each node of the fragment; [`NO_REPRESENTATIVE`] at nodes of other fragments.
    pub sites: Vec<u32>,
}

/// Fragment that is struck, in the body that contains it.
#[derive(Clone, Copy)]
pub(super) struct StruckFragment<'a> {
    /// Body of the object.
    pub body: &'a PreparedBody,
    /// Mesh of the input surface, if the fragment was cut on it.
    pub cutting: Option<&'a CuttingMesh>,
    /// Fragments of the earlier result.
    pub old: &'a RetainedBody,
    /// Label of the fragment there.
    pub label: u32,
    /// The fragment as an object.
    pub parent: &'a ParentFragment,
}

impl<'a> ChildDomain<'a> {
    /// The domain of a struck fragment with the lift `own` and the diagram of `cells`, both on the fragment's lattice.
    pub fn of(fragment: StruckFragment<'a>, own: &LiftedLattice, cells: &BodyCells) -> Self {
        let StruckFragment { body, cutting, parent, .. } = fragment;
        let Some(cutting) = cutting else {
            let (lift, sites) = represented(parent, own, cells);
            return Self { mesh: &body.crack, topology: &body.topology, lift, sites };
        };
        if parent.is_of_nodes {
            let (lift, mut sites) = represented(parent, own, cells);
            cutting.join_short_edges(&mut sites);
            return Self { mesh: &cutting.mesh, topology: &cutting.topology, lift, sites };
        }
        let (mut lift, mut sites) = empty(own, cutting.mesh.nodes.len());
        let carried = CarriedFragment { fragment, cutting, own, cells };
        let mut front = VecDeque::new();
        for node in carried.nodes() {
            if let Some(site) = carried.at(node, lift.at_mut(node)) {
                sites[node] = site;
                front.push_back(node);
            }
        }
        carried.spread(front, &mut lift, &mut sites);
        cutting.join_short_edges(&mut sites);
        Self { mesh: &cutting.mesh, topology: &cutting.topology, lift, sites }
    }
}

/// The lift `own` and the sites of `cells` at the nodes of the fragment, from those that represent them.
fn represented(parent: &ParentFragment, own: &LiftedLattice, cells: &BodyCells) -> (LiftedLattice, Vec<u32>) {
    let (mut lift, mut sites) = empty(own, parent.representative.len());
    for (node, &representative) in parent.representative.iter().enumerate() {
        if representative != NO_REPRESENTATIVE {
            lift.at_mut(node).copy_from_slice(own.at(representative as usize));
            sites[node] = cells.diagram.labels[representative as usize];
        }
    }
    (lift, sites)
}

/// A lift of the kind of `own` with zeros at all nodes, and no sites.
fn empty(own: &LiftedLattice, nodes: usize) -> (LiftedLattice, Vec<u32>) {
    let (first_moment, second_moment, density) = (Vec::new(), Vec::new(), Vec::new());
    let (kind, dimension, coordinates) = (own.kind, own.dimension, vec![0.0; nodes * own.dimension]);
    let lift = LiftedLattice { kind, dimension, coordinates, first_moment, second_moment, density };
    (lift, vec![NO_REPRESENTATIVE; nodes])
}

/// A fragment on the mesh of the input surface.
struct CarriedFragment<'a> {
    fragment: StruckFragment<'a>,
    cutting: &'a CuttingMesh,
    own: &'a LiftedLattice,
    cells: &'a BodyCells,
}

impl CarriedFragment<'_> {
    /// Nodes of the fragment, ascending.
    fn nodes(&self) -> impl Iterator<Item = usize> {
        let labels = self.fragment.old.labels.iter().enumerate();
        labels.filter(|(_, label)| **label == self.fragment.label).map(|(node, _)| node)
    }

    /// Writes the lifted coordinates of a node, interpolated between those corners of its carrier that belong to the
    /// fragment. Returns its site: the nearest of those corners' sites. `None` without such corners.
    fn at(&self, node: usize, out: &mut [f64]) -> Option<u32> {
        let Carrier { tet, weights, .. } = self.cutting.carriers[node];
        let corners = self.fragment.body.crack.tets[tet as usize];
        let representatives = corners.map(|corner| self.fragment.parent.representative[corner as usize]);
        let share =
            |k: usize| if representatives[k] == NO_REPRESENTATIVE { 0.0 } else { weights[k].max(f64::MIN_POSITIVE) };
        let shares = [0, 1, 2, 3].map(share);
        let sum: f64 = shares.iter().sum();
        let known = || representatives.iter().zip(shares).filter(|(_, share)| *share > 0.0);
        for (&representative, share) in known() {
            out.iter_mut().zip(self.own.at(representative as usize)).for_each(|(out, x)| *out += share / sum * x);
        }
        let sites = known().map(|(&representative, _)| self.cells.diagram.labels[representative as usize]);
        sites.reduce(|best, other| self.nearer(out, best, other))
    }

    fn nearer(&self, place: &[f64], best: u32, other: u32) -> u32 {
        if best == other {
            return best;
        }
        let dimension = self.own.dimension;
        let site = |site: u32| &self.cells.diagram.sites[site as usize * dimension..][..dimension];
        let (low, high) = (best.min(other), best.max(other));
        if preference(place, site(high), site(low)) < 0.0 { high } else { low }
    }

    /// Gives the nodes of the fragment that have no site the coordinates and the site of the nearest node that has, along
    /// edges.
    fn spread(&self, mut front: VecDeque<usize>, lift: &mut LiftedLattice, sites: &mut [u32]) {
        let StruckFragment { old, label, .. } = self.fragment;
        while let Some(node) = front.pop_front() {
            for &next in self.cutting.topology.neighbors(node) {
                let next = next as usize;
                if old.labels[next] == label && sites[next] == NO_REPRESENTATIVE {
                    sites[next] = sites[node];
                    let place = node * lift.dimension;
                    lift.coordinates.copy_within(place..place + lift.dimension, next * lift.dimension);
                    front.push_back(next);
                }
            }
        }
    }
}
