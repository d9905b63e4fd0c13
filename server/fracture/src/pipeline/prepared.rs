//! Everything that depends on the object alone: built by baking, loaded at start-up, shared and never changed.

use super::{
    AnchoredObject, ContactSet, ElasticRequest, EnergyUpperBound, Example, FractureError, FractureRequest,
    LearnedModel, Preset, ReductionErrors, WarpedBody,
};
use crate::cancel_token::CancelToken;
use crate::centroidal::Clusters;
use crate::degree::Slenderness;
use crate::elasticity::{BoundaryNodes, Elasticity, ElasticityError, ReducedBasis};
use crate::lattice::{EnergyTransfer, Lattice};
use crate::lift::{LiftKind, LiftedLattice};
use crate::scene::Material;
use crate::skin::{BoundaryAttributes, Skin};
use crate::sparse::Precision;
use crate::surface::{Defect, LocalFrame};
use crate::tessellation::Topology;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What an object was baked from; with the mesh it determines the database.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeParameters {
    /// Name of the material.
    pub material_name: String,
    /// The material's numbers at that time.
    pub material: Material,
    /// Reference fragment size d, m.
    pub fragment_size_m: f64,
    /// Spacing of the elastic lattice over the bounding-box diagonal.
    pub elastic_spacing: f64,
    /// Spacing of the crack lattice over the bounding-box diagonal.
    pub crack_spacing: f64,
    /// Neumann modes asked of the interior lift (the spectrum is cut at a gap near it).
    pub modes: usize,
    /// Weight α of the modes beside the coordinates.
    pub alpha: f64,
    /// Everything random while baking follows from it.
    pub seed: u64,
    /// Whether its impacts give it a reduced basis; without one every strike is solved.
    pub elastic: ElasticRequest,
    /// Of the factors of its stiffness that are exact enough in it.
    pub factor: Precision,
    /// Which preset it was baked as.
    pub quality: Preset,
}

/// What baking found out about the mesh and the lattices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// BLAKE3 of the normalised input (positions and triangles, those of existing cracks among them), hexadecimal.
    pub input_hash: String,
    /// Volume inside the input surface (generalised winding number above one half), m³.
    pub input_volume_m3: f64,
    /// Volume of the crack lattices, m³.
    pub lattice_volume_m3: f64,
    /// Largest distance from the crack lattice's boundary to the input surface, over the diagonal. The films on which the
    /// winding number is one half close the surface's holes and count as surface; slots of existing cracks are left out: it is
    /// that of the lattice before they are cut.
    pub surface_deviation: f64,
    /// What was wrong with the input and what was done about it.
    pub defects: Vec<Defect>,
    /// Names of the input's materials; attributes and skins tell them by their places.
    pub materials: Vec<String>,
    /// The cracks that it carries from the beginning, if it was given any.
    pub cracks: Option<ExistingCracks>,
    /// Lifts that a body does without, and why.
    pub unprepared: Vec<MissingLift>,
}

/// Cracks that an object carries from the beginning: sheets without width, along which its lattices have slots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExistingCracks {
    /// Triangles of the sheets.
    pub triangles: u64,
    /// Their area, in the object or not, m².
    pub area_m2: f64,
    /// Width of the slots in the crack lattices, m.
    pub width_m: f64,
    /// The same in the elastic lattices.
    pub elastic_width_m: f64,
    /// Volume that the crack lattices lose by them, m³.
    pub volume_m3: f64,
}

/// A lift that could not be made for a body; strikes that ask for it are refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissingLift {
    /// Which body.
    pub body: usize,
    /// Which lift.
    pub lift: LiftKind,
    /// Why.
    pub reason: String,
}

impl BakeReport {
    /// Signed volume error of the crack lattices, relative to the input's volume; slots of existing cracks are no error.
    pub fn volume_error(&self) -> f64 {
        let slots_m3 = self.cracks.map_or(0.0, |cracks| cracks.volume_m3);
        (self.lattice_volume_m3 + slots_m3) / self.input_volume_m3 - 1.0
    }
}

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
    pub examples: Vec<Example>,
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
    /// Errors: [`FractureError::LiftUnprepared`].
    pub fn lift(&self, body: usize, kind: LiftKind) -> Result<&LiftedLattice, FractureError> {
        self.bodies[body].lift(kind).ok_or(FractureError::LiftUnprepared { body, lift: kind })
    }

    /// The lift of body `body` that the cells of `strike` are straight in.
    ///
    /// Errors: [`FractureError::LiftUnprepared`].
    pub fn lift_for(&self, body: usize, strike: &FractureRequest) -> Result<&LiftedLattice, FractureError> {
        let bent = self.controls(body, strike).and_then(|warped| warped.lift(strike.lift));
        bent.map_or_else(|| self.lift(body, strike.lift), Ok)
    }

    /// What the elasticity of body `body` needs.
    ///
    /// Errors: [`FractureError::ElasticityUnprepared`].
    pub fn solid(&self, body: usize) -> Result<&ElasticModel, FractureError> {
        self.bodies[body].solid.as_ref().ok_or(FractureError::ElasticityUnprepared { body })
    }

    /// Joules per unit of local energy under `impact`: F²/(E·L).
    pub fn unit_j(&self, impact: &ContactSet) -> f64 {
        impact.peak_force_n.powi(2) / (self.parameters.material.young_pa * self.frame.diagonal_m)
    }

    /// Factors the stiffness of every body that is not factored yet, so that no strike has to.
    ///
    /// Errors: [`FractureError::Elasticity`], what every strike that needs that factor will be told.
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
