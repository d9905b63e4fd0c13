//! Data that depends on the object only: built by baking, loaded at startup, shared and never changed.

use super::anchored::{AnchoredBasis, AnchoredObject};
use super::energy_bound::EnergyUpperBound;
use super::example::TrainingExample;
use super::fragment_surface::FragmentSurface;
use super::learned::LearnedModel;
use super::parameters::{BakeParameters, BakeReport, SurfaceKind};
use super::reduction::ReductionErrors;
use super::warped_body::WarpedBody;
use crate::cancel_token::CancelToken;
use crate::centroidal::Clusters;
use crate::cutting::CuttingMesh;
use crate::degree::Slenderness;
use crate::elasticity::{
    BoundaryNodes, Elasticity, ElasticityError, ElementOrder, FaceSearch, NearestBoundaryPoint, ReducedBasis,
};
use crate::fragment::RigidProperties;
use crate::lattice::{EnergyTransfer, Lattice};
use crate::lift::{LiftKind, LiftedLattice};
use crate::pipeline::error::FractureError;
use crate::skin::{AttributeKinds, BoundaryAttributes, Skin};
use crate::sparse::Precision;
use crate::strength::{StrengthConstants, StrengthTables};
use crate::surface::LocalFrame;
use crate::tessellation::Topology;
use nalgebra::Point3;
use std::sync::{Arc, OnceLock};

/// Elasticity tables of a body. Objects whose requests need no deformation do without them.
pub struct ElasticModel {
    /// Coarser lattice, for elasticity.
    pub lattice: Lattice,
    /// Transfer of energies from the elastic to the crack lattice.
    pub transfer: EnergyTransfer,
    /// Factored stiffness.
    pub elasticity: Elasticity,
    /// Basis of displacements that approximates those of most impacts; `None`: every request is solved.
    pub reduced: Option<ReducedBasis>,
    /// Tables of the criterion by strength and energy, made on first use.
    strength: OnceLock<StrengthTables>,
}

impl ElasticModel {
    /// Assembles the stiffness for Poisson's ratio and a precision of the factor, which is factored when first needed. The caller adds a reduced basis.
    ///
    /// # Errors
    /// [`ElasticityError`] for a lattice without an assembly, or a canceled `token`.
    pub fn new(
        lattice: Lattice,
        transfer: EnergyTransfer,
        (poisson, factor): (f64, Precision),
        order: ElementOrder,
        token: &CancelToken,
    ) -> Result<Self, ElasticityError> {
        let elasticity =
            Elasticity::assembled(&lattice, poisson, token)?.of_precision(factor).of_order(order, &lattice)?;
        Ok(Self { lattice, transfer, elasticity, reduced: None, strength: OnceLock::new() })
    }

    /// Returns the same body with elements of this order. A factor that exists remains.
    ///
    /// # Errors
    /// Those of [`Elasticity::of_order`].
    pub(crate) fn of_order(self, order: ElementOrder) -> Result<Self, ElasticityError> {
        if order == self.elasticity.order() {
            return Ok(self);
        }
        Ok(Self { elasticity: self.elasticity.of_order(order, &self.lattice)?, strength: OnceLock::new(), ..self })
    }

    /// Tables of the criterion by strength and energy. The first caller makes them.
    pub fn strength_tables(&self) -> &StrengthTables {
        self.strength.get_or_init(|| StrengthTables::new(&self.elasticity, &self.lattice))
    }

    /// Bytes of these tables; 0 until they are made.
    pub(super) fn strength_bytes(&self) -> usize {
        self.strength.get().map_or(0, StrengthTables::bytes)
    }
}

/// One connected component of the object.
pub struct PreparedBody {
    /// Finer lattice, for cracks.
    pub crack: Lattice,
    /// Elasticity tables; `None`: not prepared.
    pub solid: Option<ElasticModel>,
    /// Lift of interior distances, on the crack lattice; `None`: not prepared.
    pub interior: Option<LiftedLattice>,
    /// Lift of surface diffusion distances, on the crack lattice; `None`: not prepared.
    pub surface_diffusion: Option<LiftedLattice>,
    /// Lift of Euclidean distances, on the crack lattice.
    pub euclidean: LiftedLattice,
    /// Lumped volumes of the crack lattice's nodes, local.
    pub volumes: Vec<f64>,
    /// Edges, faces and boundary of the crack lattice.
    pub topology: Topology,
    /// Clusters of the crack lattice's nodes, for diagrams.
    pub clusters: Clusters,
    /// Thickness and cross-section, for the closed form.
    pub slenderness: Slenderness,
    /// Boundary of the crack lattice, to find the body nearest to a contact.
    pub boundary: BoundaryNodes,
    /// Surface of a fragment that was cut on the mesh of the input surface; `None` for other bodies.
    pub fragment_surface: Option<FragmentSurface>,
    /// Results of an artist's controls, if there are any.
    pub warped: Option<WarpedBody>,
    /// Appearance of the input on the crack lattice's boundary; `None`: not prepared.
    pub outer: Option<BoundaryAttributes>,
    /// Upper bound of E_1; `None`: no bound.
    pub bound: Option<EnergyUpperBound>,
    /// Mesh of the input surface for labels and tessellation; `None`: they run on the crack lattice.
    pub cutting: Option<CuttingMesh>,
}

impl PreparedBody {
    /// Derives all tables that follow from the crack lattice. The caller adds elasticity and lifts.
    pub fn new(crack: Lattice) -> Self {
        let topology = Topology::new(&crack);
        Self {
            clusters: Clusters::new(topology.nodes, |node| topology.neighbors(node)),
            euclidean: LiftedLattice::euclidean(&crack),
            volumes: crack.node_volumes(),
            topology,
            slenderness: Slenderness::of(&crack),
            boundary: BoundaryNodes::new(&crack),
            fragment_surface: None,
            solid: None,
            interior: None,
            surface_diffusion: None,
            warped: None,
            outer: None,
            bound: None,
            cutting: None,
            crack,
        }
    }

    /// The lift of the given kind, if the body has it.
    pub fn lift(&self, kind: LiftKind) -> Option<&LiftedLattice> {
        match kind {
            LiftKind::Euclidean => Some(&self.euclidean),
            LiftKind::Interior => self.interior.as_ref(),
            LiftKind::SurfaceDiffusion => self.surface_diffusion.as_ref(),
        }
    }

    /// Adds the mesh of the input surface, after the lifts.
    pub fn set_cutting(&mut self, mut cutting: CuttingMesh) {
        let lifts = [Some(&self.euclidean), self.interior.as_ref(), self.surface_diffusion.as_ref()];
        cutting.carry_lifts(&self.crack, lifts.into_iter().flatten());
        self.cutting = Some(cutting);
    }

    /// The surface onto which contacts are projected, and which rays hit.
    pub fn contact_surface(&self, kind: SurfaceKind) -> FaceSearch<'_> {
        match (&self.fragment_surface, &self.cutting) {
            (Some(own), _) => own.search(),
            (None, Some(cutting)) if kind == SurfaceKind::Exact => cutting.surface(),
            (None, _) => self.boundary.search(),
        }
    }

    /// Position at which a contact at `point` loads the body; `nearest` is the nearest point of [`Self::contact_surface`].
    ///
    /// On the lattice's surface, the load is projected when it is applied.
    pub fn load_place(&self, kind: SurfaceKind, point: Point3<f64>, nearest: &NearestBoundaryPoint) -> Point3<f64> {
        match (&self.fragment_surface, &self.cutting) {
            (Some(_), _) => nearest.place,
            (None, Some(cutting)) if kind == SurfaceKind::Exact => cutting.load_place(&self.crack, nearest),
            (None, _) => point,
        }
    }

    /// Volume, center and inertia of the body (local): of the fragment's surface, of the input's, or of the crack lattice's.
    pub fn rigid_properties(&self) -> RigidProperties {
        if let Some(own) = &self.fragment_surface {
            return own.rigid_properties();
        }
        let (mesh, topology) =
            self.cutting.as_ref().map_or((&self.crack, &self.topology), |own| (&own.mesh, &own.topology));
        RigidProperties::of_surface(&mesh.nodes, topology.boundary.iter().map(|face| face.nodes))
    }

    /// The reduced basis, if the body has one.
    pub fn reduced(&self) -> Option<&ReducedBasis> {
        self.solid.as_ref().and_then(|solid| solid.reduced.as_ref())
    }
}

/// An object ready to be struck.
pub struct PreparedObject {
    /// Name of the object.
    pub name: String,
    /// Local frame of all positions and lengths.
    pub frame: LocalFrame,
    /// Parameters of the bake.
    pub parameters: BakeParameters,
    /// Threshold γ, J·m².
    pub gamma_j_m2: f64,
    /// κ: ratio of the calibrated degree to the closed form's n₀.
    pub kappa: f64,
    /// Report of the bake.
    pub report: BakeReport,
    /// Connected components.
    pub bodies: Vec<PreparedBody>,
    /// Number of impacts drawn for the examples; the next has this number.
    pub impacts: u64,
    /// Impacts whose fracture degree is known, by number.
    pub examples: Vec<TrainingExample>,
    /// Degree model learned from them, if they suffice.
    pub learned: Option<LearnedModel>,
    /// Errors of the reduced bases, if there are any.
    pub reduction: Option<ReductionErrors>,
    /// Bases of bodies that anchors hold.
    pub anchored_bases: Vec<AnchoredBasis>,
    /// The object held by a scene's anchors; not part of its database.
    pub held: Option<AnchoredObject>,
    /// Triangles of the input; `None`: not prepared.
    pub skin: Option<Arc<Skin>>,
}

impl PreparedObject {
    /// The lift of the given kind of body `body`.
    ///
    /// # Errors
    /// [`FractureError::LiftUnprepared`].
    pub fn lift(&self, body: usize, kind: LiftKind) -> Result<&LiftedLattice, FractureError> {
        self.bodies[body].lift(kind).ok_or(FractureError::LiftUnprepared { body, lift: kind })
    }

    /// The elasticity tables of body `body`.
    ///
    /// # Errors
    /// [`FractureError::ElasticityUnprepared`].
    pub fn solid(&self, body: usize) -> Result<&ElasticModel, FractureError> {
        self.bodies[body].solid.as_ref().ok_or(FractureError::ElasticityUnprepared { body })
    }

    /// Constants of the material that decide when it breaks.
    pub fn strength_constants(&self) -> StrengthConstants {
        StrengthConstants::of(&self.parameters.material_name, &self.parameters.material)
    }

    /// Factors every stiffness that has no factor yet, so that no request has to.
    ///
    /// # Errors
    /// [`FractureError::Elasticity`], the error that every request needing that factor gets.
    pub fn factor(&self) -> Result<(), FractureError> {
        let solids = self.bodies.iter().enumerate().filter_map(|(body, own)| Some((body, own.solid.as_ref()?)));
        for (body, own) in solids {
            own.elasticity.factor().map_err(|source| FractureError::Elasticity { body, source })?;
        }
        Ok(())
    }

    /// Makes the tables of the criterion by strength and energy, so that no request with [`Criterion::Strength`] has to.
    ///
    /// [`Criterion::Strength`]: crate::strength::Criterion::Strength
    pub fn prepare_strength(&self) {
        for solid in self.bodies.iter().filter_map(|body| body.solid.as_ref()) {
            solid.strength_tables();
        }
    }

    /// Total number of nodes of the elastic lattices.
    pub fn elastic_nodes(&self) -> usize {
        self.bodies.iter().filter_map(|body| body.solid.as_ref()).map(|solid| solid.lattice.nodes.len()).sum()
    }

    /// True if a body has quadratic elements.
    pub fn has_quadratic_elements(&self) -> bool {
        let mut solids = self.bodies.iter().filter_map(|body| body.solid.as_ref());
        solids.any(|solid| solid.elasticity.order() == ElementOrder::Quadratic)
    }

    /// True if the object is a sheet whose cells are longer along it than across.
    ///
    /// Linear elements hold next to nothing of what a basis of its displacements misses, but about the same share of it
    /// in all impacts: a fourth to a twentieth of it on a pane of 1 m × 1 m × 4 mm, free or with two held edges. So
    /// displacements are always completed by a linear solve, and what that adds tells their errors. Of 24 impacts on each,
    /// with radii of 1 to 14 % of the diagonal, 22 and 20 were then told within a factor of two; by the residuals, 17 and 12.
    pub fn has_long_cells(&self) -> bool {
        self.report.stretch.is_some()
    }

    /// Total number of tetrahedra of the elastic lattices.
    pub fn elastic_tets(&self) -> usize {
        self.bodies.iter().filter_map(|body| body.solid.as_ref()).map(|solid| solid.lattice.tets.len()).sum()
    }

    /// Total number of nodes of the crack lattices.
    pub fn crack_nodes(&self) -> usize {
        self.bodies.iter().map(|body| body.crack.nodes.len()).sum()
    }

    /// Total number of tetrahedra that can be cut: those of the meshes of the input surface, or of the crack lattices.
    pub fn cut_tets(&self) -> usize {
        let tets = |body: &PreparedBody| body.cutting.as_ref().map_or(0, |cutting| cutting.mesh.tets.len());
        self.bodies.iter().map(|body| tets(body).max(body.crack.tets.len())).sum()
    }

    /// Kinds of attributes of the input that requests can return.
    pub fn attribute_kinds(&self) -> AttributeKinds {
        let skin = self.skin.iter().map(|skin| skin.attributes.kinds());
        let lattices = self.bodies.iter().filter_map(|body| Some(body.outer.as_ref()?.points.kinds()));
        let exact = self.bodies.iter().filter_map(|body| Some(body.cutting.as_ref()?.outer.as_ref()?.points.kinds()));
        skin.chain(lattices).chain(exact).fold(AttributeKinds::default(), AttributeKinds::or)
    }

    /// Total number of tetrahedra of the crack lattices.
    pub fn crack_tets(&self) -> usize {
        self.bodies.iter().map(|body| body.crack.tets.len()).sum()
    }
}
