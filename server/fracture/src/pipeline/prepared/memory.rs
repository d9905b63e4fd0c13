//! Memory of a prepared object.

use super::anchored::{AnchoredBasis, AnchoredObject};
use super::energy_bound::EnergyUpperBound;
use super::example::TrainingExample;
use super::fragment_surface::FragmentSurface;
use super::learned::LearnedModel;
use super::object::{ElasticModel, PreparedBody, PreparedObject};
use super::region_boundary::RegionBoundary;
use super::warped_body::WarpedBody;
use crate::cutting::CuttingMesh;
use crate::elasticity::ReducedBasis;
use crate::lattice::{EnergyTransfer, Lattice};
use crate::lift::LiftedLattice;
use crate::memory::held;
use crate::skin::BoundaryAttributes;

/// Memory of an object by table, bytes. Rows of equal names are summed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MemoryRows(Vec<(&'static str, usize)>);

impl MemoryRows {
    /// The rows: name of the table, and bytes.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, usize)> {
        self.0.iter().copied()
    }

    /// Sum of all rows, bytes.
    pub fn total(&self) -> usize {
        self.0.iter().map(|(_, bytes)| bytes).sum()
    }

    /// Adds bytes to the row of the given name.
    fn add(&mut self, name: &'static str, bytes: usize) {
        match self.0.iter_mut().find(|(own, _)| *own == name) {
            Some((_, sum)) => *sum += bytes,
            None => self.0.push((name, bytes)),
        }
    }
}

impl PreparedObject {
    /// Memory of the object while it is loaded, bytes: lattices, operators, factors, lifts, examples.
    ///
    /// Allocator overhead and strings are not counted.
    pub fn bytes(&self) -> usize {
        self.memory().total()
    }

    /// The bytes of [`Self::bytes`] by table. Factors are counted before they are computed.
    pub fn memory(&self) -> MemoryRows {
        let mut rows = MemoryRows::default();
        self.bodies.iter().for_each(|body| body.count(&mut rows));
        rows.add("anchors and their factor", self.held.as_ref().map_or(0, AnchoredObject::bytes));
        rows.add("reduced basis", self.anchored_bases.iter().map(AnchoredBasis::bytes).sum());
        rows.add("appearance of the input", self.skin.as_ref().map_or(0, |skin| skin.bytes()));
        let examples = self.examples.iter().map(example).sum::<usize>() + held(&self.examples) + held(&self.bodies);
        rows.add(
            "examples",
            examples + self.learned.as_ref().map_or(0, |LearnedModel { network, .. }| network.bytes()),
        );
        rows
    }

    /// Number of bodies whose factors keep double precision although single precision was requested.
    pub fn double_precision_bodies(&self) -> usize {
        let solids = self.bodies.iter().filter_map(|body| body.solid.as_ref());
        solids.filter(|solid| solid.elasticity.rejects_single_precision()).count()
    }

    /// Memory that factors of the stiffness in single precision would save where they are accurate enough, bytes.
    pub fn single_precision_saving(&self) -> usize {
        let solids = self.bodies.iter().filter_map(|body| body.solid.as_ref());
        solids.map(|solid| solid.elasticity.single_precision_saving()).sum()
    }

    /// Memory of the meshes that give fragments the exact input surface, bytes.
    pub fn exact_surface_bytes(&self) -> usize {
        self.bodies.iter().filter_map(|body| body.cutting.as_ref()).map(CuttingMesh::bytes).sum()
    }
}

impl PreparedBody {
    /// Adds the body's tables. All fields are destructured, so the compiler reports a field that is not counted.
    fn count(&self, rows: &mut MemoryRows) {
        let Self { crack, solid, interior, surface_diffusion, euclidean, volumes, topology, clusters, .. } = self;
        let Self { slenderness: _, boundary, fragment_surface, warped, outer, bound, cutting, .. } = self;
        if let Some(solid) = solid {
            solid.count(rows);
        }
        let lifts = [interior, surface_diffusion].into_iter().flatten().map(lift).sum::<usize>() + lift(euclidean);
        rows.add("lifts", lifts + warped.as_ref().map_or(0, WarpedBody::bytes));
        rows.add("edges and faces of the crack lattice", topology.bytes());
        rows.add("crack lattice", lattice(crack) + held(volumes) + boundary.bytes() + clusters.bytes());
        rows.add("mesh of the input surface", fragment_surface.as_ref().map_or(0, FragmentSurface::bytes));
        rows.add("appearance of the input", outer.as_ref().map_or(0, BoundaryAttributes::bytes));
        rows.add("mesh of the input surface", cutting.as_ref().map_or(0, CuttingMesh::bytes));
        rows.add("elastic lattice", bound.as_ref().map_or(0, EnergyUpperBound::bytes));
    }
}

impl WarpedBody {
    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { lifts, protected, boundary, cutting_boundary, pins, factors, alike: _ } = self;
        let boundaries = [boundary, cutting_boundary].into_iter().flatten().map(RegionBoundary::bytes).sum::<usize>();
        let protected = protected.iter().map(held).sum::<usize>() + held(protected) + boundaries;
        lifts.iter().map(lift).sum::<usize>() + held(lifts) + protected + held(pins) + held(factors)
    }
}

impl ElasticModel {
    /// Adds the tables of the elasticity.
    fn count(&self, rows: &mut MemoryRows) {
        let Self { lattice: elastic, transfer, elasticity, reduced, .. } = self;
        rows.add("factor of the stiffness", elasticity.own_bytes());
        rows.add("stiffness", elasticity.stiffness_bytes());
        rows.add("elastic lattice", lattice(elastic) + elasticity.lattice_bytes() + self.strength_bytes());
        rows.add("energy transfer between the lattices", shares(transfer));
        rows.add("reduced basis", reduced.as_ref().map_or(0, ReducedBasis::bytes));
    }
}

fn lattice(Lattice { nodes, tets }: &Lattice) -> usize {
    held(nodes) + held(tets)
}

fn shares(EnergyTransfer { offsets, tets, shares }: &EnergyTransfer) -> usize {
    held(offsets) + held(tets) + held(shares)
}

fn lift(lift: &LiftedLattice) -> usize {
    let LiftedLattice { coordinates, first_moment, second_moment, density, kind: _, dimension: _ } = lift;
    held(coordinates) + held(first_moment) + held(second_moment) + held(density)
}

fn example(example: &TrainingExample) -> usize {
    held(&example.contacts) + held(&example.points) + held(&example.site_nodes)
}
