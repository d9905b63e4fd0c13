//! Everything that depends on the object alone: built by baking, loaded at start-up, shared and never changed.

use super::anchored::AnchoredObject;
use super::energy_bound::EnergyUpperBound;
use super::example::TrainingExample;
use super::learned::LearnedModel;
use super::parameters::{BakeParameters, BakeReport};
use super::reduction::ReductionErrors;
use super::warped_body::WarpedBody;
use crate::cancel_token::CancelToken;
use crate::centroidal::Clusters;
use crate::degree::Slenderness;
use crate::elasticity::{BoundaryNodes, Elasticity, ElasticityError, ReducedBasis};
use crate::lattice::{EnergyTransfer, Lattice};
use crate::lift::{LiftKind, LiftedLattice};
use crate::pipeline::error::FractureError;
use crate::skin::{BoundaryAttributes, Skin};
use crate::sparse::Precision;
use crate::surface::LocalFrame;
use crate::tessellation::Topology;
use std::sync::Arc;

/// What a body's elasticity needs; an object that is not asked for its deformation does without.
pub struct ElasticModel {
    /// Coarser lattice: elasticity.
    pub lattice: Lattice,
    /// Energy from it to the crack lattice.
    pub transfer: EnergyTransfer,
    /// Factored stiffness.
    pub elasticity: Elasticity,
    /// A few displacements that span those of most impacts; `None`: every strike is solved.
    pub reduced: Option<ReducedBasis>,
}

impl ElasticModel {
    /// Assembles the stiffness, which is factored at first need; without a reduced basis, which whoever has one adds.
    ///
    /// # Errors
    /// [`ElasticityError`] for a lattice without an assembly, or a cancelled `token`.
    pub fn new(
        lattice: Lattice,
        transfer: EnergyTransfer,
        poisson: f64,
        factor: Precision,
        token: &CancelToken,
    ) -> Result<Self, ElasticityError> {
        let elasticity = Elasticity::assembled(&lattice, poisson, token)?.of_precision(factor);
        Ok(Self { lattice, transfer, elasticity, reduced: None })
    }
}

/// One connected component of the object.
pub struct PreparedBody {
    /// Finer lattice: cracks.
    pub crack: Lattice,
    /// Elasticity; `None`: not prepared.
    pub solid: Option<ElasticModel>,
    /// The lift with interior distances, on the crack lattice; `None`: not prepared.
    pub interior: Option<LiftedLattice>,
    /// The lift with diffusion distances on the surface, on the crack lattice; `None`: not prepared.
    pub surface_diffusion: Option<LiftedLattice>,
    /// The lift with straight distances, on the crack lattice.
    pub euclidean: LiftedLattice,
    /// Lumped volumes of the crack lattice's nodes, local.
    pub volumes: Vec<f64>,
    /// Edges, faces and boundary of the crack lattice.
    pub topology: Topology,
    /// Groups of its nodes, for diagrams.
    pub clusters: Clusters,
    /// Thickness and section, for the closed form.
    pub slenderness: Slenderness,
    /// Surface of the crack lattice: which body a contact is nearest to.
    pub boundary: BoundaryNodes,
    /// What an artist's controls make of it, if there are any.
    pub warped: Option<WarpedBody>,
    /// How the input looks on the crack lattice's boundary; `None`: not prepared.
    pub outer: Option<BoundaryAttributes>,
    /// What bounds its E_1; `None`: nothing does.
    pub bound: Option<EnergyUpperBound>,
}

impl PreparedBody {
    /// Derives everything that follows from the crack lattice; without elasticity and lifts, which whoever has them adds.
    pub fn new(crack: Lattice) -> Self {
        let topology = Topology::new(&crack);
        Self {
            clusters: Clusters::new(topology.nodes, |node| topology.neighbors(node)),
            euclidean: LiftedLattice::euclidean(&crack),
            volumes: crack.node_volumes(),
            topology,
            slenderness: Slenderness::of(&crack),
            boundary: BoundaryNodes::new(&crack),
            solid: None,
            interior: None,
            surface_diffusion: None,
            warped: None,
            outer: None,
            bound: None,
            crack,
        }
    }

    /// The lift of that kind, if the body was prepared for it.
    pub fn lift(&self, kind: LiftKind) -> Option<&LiftedLattice> {
        match kind {
            LiftKind::Euclidean => Some(&self.euclidean),
            LiftKind::Interior => self.interior.as_ref(),
            LiftKind::SurfaceDiffusion => self.surface_diffusion.as_ref(),
        }
    }

    /// Its reduced basis, if it has one.
    pub fn reduced(&self) -> Option<&ReducedBasis> {
        self.solid.as_ref().and_then(|solid| solid.reduced.as_ref())
    }
}

/// An object ready to be struck.
pub struct PreparedObject {
    /// Its name.
    pub name: String,
    /// Local frame.
    pub frame: LocalFrame,
    /// What it was baked from.
    pub parameters: BakeParameters,
    /// Threshold γ, J·m².
    pub gamma_j_m2: f64,
    /// κ: calibrated degree over the closed form's n₀.
    pub kappa: f64,
    /// What baking found.
    pub report: BakeReport,
    /// Its components.
    pub bodies: Vec<PreparedBody>,
    /// Impacts that were drawn for the examples: the next is number `impacts`.
    pub impacts: u64,
    /// Impacts whose fracture degree is known, by their numbers.
    pub examples: Vec<TrainingExample>,
    /// What they taught, if they are enough.
    pub learned: Option<LearnedModel>,
    /// How well the reduced bases do, if there are any.
    pub reduction: Option<ReductionErrors>,
    /// What a scene's anchors make of it; no part of its database.
    pub held: Option<AnchoredObject>,
    /// The input's own triangles; `None`: not prepared.
    pub skin: Option<Arc<Skin>>,
}

impl PreparedObject {
    /// The lift of that kind of body `body`.
    ///
    /// # Errors
    /// [`FractureError::LiftUnprepared`].
    pub fn lift(&self, body: usize, kind: LiftKind) -> Result<&LiftedLattice, FractureError> {
        self.bodies[body].lift(kind).ok_or(FractureError::LiftUnprepared { body, lift: kind })
    }

    /// What the elasticity of body `body` needs.
    ///
    /// # Errors
    /// [`FractureError::ElasticityUnprepared`].
    pub fn solid(&self, body: usize) -> Result<&ElasticModel, FractureError> {
        self.bodies[body].solid.as_ref().ok_or(FractureError::ElasticityUnprepared { body })
    }

    /// Factors the stiffness of every body that is not factored yet, so that no strike has to.
    ///
    /// # Errors
    /// [`FractureError::Elasticity`], what every strike that needs that factor will be told.
    pub fn factor(&self) -> Result<(), FractureError> {
        let solids = self.bodies.iter().enumerate().filter_map(|(body, own)| Some((body, own.solid.as_ref()?)));
        for (body, own) in solids {
            own.elasticity.factor().map_err(|source| FractureError::Elasticity { body, source })?;
        }
        Ok(())
    }

    /// Nodes of all elastic lattices.
    pub fn elastic_nodes(&self) -> usize {
        self.bodies.iter().filter_map(|body| body.solid.as_ref()).map(|solid| solid.lattice.nodes.len()).sum()
    }

    /// Tetrahedra of all elastic lattices.
    pub fn elastic_tets(&self) -> usize {
        self.bodies.iter().filter_map(|body| body.solid.as_ref()).map(|solid| solid.lattice.tets.len()).sum()
    }

    /// Nodes of all crack lattices.
    pub fn crack_nodes(&self) -> usize {
        self.bodies.iter().map(|body| body.crack.nodes.len()).sum()
    }

    /// Tetrahedra of all crack lattices.
    pub fn crack_tets(&self) -> usize {
        self.bodies.iter().map(|body| body.crack.tets.len()).sum()
    }
}
