//! A fragment with too few whole tetrahedra of the crack lattice, as an object whose points are its nodes in the mesh of
//! the input surface.
//!
//! Ours. Fragments of thin parts, and fragments of a few cells, have no lattice of their own:
//!
//! - Distances are straight between the nodes. Each node has its lumped volume in the mesh.
//! - Energy densities are those of the cells around the fragment: the tetrahedra of the crack lattice that carry its
//!   nodes, and their neighbors. The impact deforms these cells as a free body, across earlier cracks. Their energy may have
//!   nothing to do with that of the fragment, so the told error is 1.

use super::parent::{NO_REPRESENTATIVE, ParentFragment, StruckLabels, alone, largest};
use crate::centroidal::Clusters;
use crate::cutting::CuttingMesh;
use crate::degree::Slenderness;
use crate::elasticity::{BoundaryNodes, ElementOrder};
use crate::lattice::{EnergyTransfer, Lattice, NO_INDEX};
use crate::lift::{LiftKind, LiftedLattice};
use crate::pipeline::error::{FractureError, NODES_MIN, SOLVED_NODES_MAX};
use crate::pipeline::prepared::object::{ElasticModel, PreparedBody};
use crate::pipeline::prepared::parameters::ElasticReport;
use crate::pipeline::request::context::RequestContext;
use crate::scene::EffectKind;
use crate::sparse::Precision;
use crate::tessellation::Topology;

/// The tetrahedra of the mesh around one of its fragments, as a lattice: those with a node of the fragment.
struct FragmentRim {
    /// Nodes and tetrahedra, local.
    pub lattice: Lattice,
    /// Nodes of the fragment in the mesh, ascending.
    pub nodes: Vec<u32>,
    /// The same nodes in `lattice`, in the same order.
    own: Vec<u32>,
}

impl FragmentRim {
    /// The rim of fragment `label`; `labels` are those of the nodes of `mesh`.
    pub fn of(mesh: &Lattice, labels: &[u32], label: u32) -> Self {
        let is_own = |node: &u32| labels[*node as usize] == label;
        let touches = |tet: &u32| mesh.tets[*tet as usize].iter().any(is_own);
        let tets: Vec<u32> = (0..mesh.tets.len() as u32).filter(touches).collect();
        let mut used = vec![false; mesh.nodes.len()];
        tets.iter().flat_map(|&tet| mesh.tets[tet as usize]).for_each(|node| used[node as usize] = true);
        // The nodes of a part keep their order.
        let names = (0..used.len() as u32).filter(|&node| used[node as usize]);
        let (own, nodes) = (0..).zip(names).filter(|(_, node)| is_own(node)).unzip();
        Self { lattice: mesh.part(&tets), nodes, own }
    }
}

impl ParentFragment {
    /// Prepares a fragment without a lattice of its own, cut on `cutting`.
    ///
    /// # Errors
    /// [`FractureError::FragmentUndivided`], [`FractureError::FragmentLarge`], [`FractureError::FragmentLiftKind`],
    /// [`FractureError::ElasticityUnprepared`], [`FractureError::Elasticity`], [`FractureError::Canceled`].
    pub(super) fn of_nodes(
        struck: StruckLabels<'_>,
        cutting: &CuttingMesh,
        context: RequestContext<'_>,
    ) -> Result<Self, FractureError> {
        let RequestContext { prepared, request, cancel, .. } = context;
        let StruckLabels { body, fragment, label, old, .. } = struck;
        if request.lift == LiftKind::SurfaceDiffusion {
            return Err(FractureError::FragmentLiftKind { fragment, lift: request.lift });
        }
        let rim = FragmentRim::of(&cutting.mesh, old.labels, label);
        if cutting.group_count(&rim.nodes) < NODES_MIN {
            return Err(FractureError::FragmentUndivided { fragment });
        }
        cancel.check()?;
        let mut own = point_body(&rim, cutting);
        own.fragment_surface = struck.surface(Some(cutting));
        if request.effects.has(EffectKind::Elastic) {
            prepared.solid(body)?;
            let cells = SurroundingCells::of(&prepared.bodies[body].crack, cutting, &rim.nodes);
            let nodes = cells.lattice.nodes.len();
            if nodes > SOLVED_NODES_MAX {
                return Err(FractureError::FragmentLarge { fragment, nodes });
            }
            let transfer = cells.transfer(cutting, &rim.nodes);
            let poisson = prepared.parameters.material.poisson;
            let solid =
                ElasticModel::new(cells.lattice, transfer, (poisson, Precision::F64), ElementOrder::Linear, cancel);
            own.solid = Some(solid.map_err(|source| FractureError::of_body(0, source))?);
        }
        let elements = prepared.report.elastic.get(body).cloned();
        let elastic = elements.map(|elements| ElasticReport { discretization_error: Some(1.0), ..elements });
        let mut representative = vec![NO_REPRESENTATIVE; cutting.mesh.nodes.len()];
        (0..).zip(&rim.nodes).for_each(|(own, &node)| representative[node as usize] = own);
        Ok(Self { prepared: alone(context, body, own, elastic), nodes: rim.nodes, representative, is_of_nodes: true })
    }
}

/// A body whose points are the nodes of a fragment. Its lattice has no tetrahedra.
fn point_body(rim: &FragmentRim, cutting: &CuttingMesh) -> PreparedBody {
    PreparedBody {
        crack: Lattice {
            nodes: rim.own.iter().map(|&node| rim.lattice.nodes[node as usize]).collect(),
            tets: Vec::new(),
        },
        euclidean: LiftedLattice::euclidean(&rim.lattice).of_nodes(&rim.own),
        volumes: rim.nodes.iter().map(|&node| cutting.volumes[node as usize]).collect(),
        slenderness: Slenderness::of(&rim.lattice),
        boundary: BoundaryNodes::new(&rim.lattice),
        fragment_surface: None,
        topology: Topology::default(),
        clusters: Clusters::default(),
        solid: None,
        interior: None,
        surface_diffusion: None,
        warped: None,
        outer: None,
        bound: None,
        cutting: None,
    }
}

/// The cells of the crack lattice around a fragment, of which a free body is made.
struct SurroundingCells {
    lattice: Lattice,
    /// Index in `lattice` of each tetrahedron of the crack lattice; [`NO_INDEX`] for others.
    names: Vec<u32>,
}

impl SurroundingCells {
    /// The largest face-connected part of the tetrahedra that share a corner with one that carries a node of `nodes`.
    fn of(crack: &Lattice, cutting: &CuttingMesh, nodes: &[u32]) -> Self {
        let mut carries = vec![false; crack.nodes.len()];
        let carriers = nodes.iter().map(|&node| cutting.carriers[node as usize].tet);
        carriers.flat_map(|tet| crack.tets[tet as usize]).for_each(|corner| carries[corner as usize] = true);
        let tets = largest(crack, |tet| crack.tets[tet].iter().any(|&corner| carries[corner as usize]));
        let tets = tets.unwrap_or_default();
        let mut names = vec![NO_INDEX; crack.tets.len()];
        (0..).zip(&tets).for_each(|(name, &tet)| names[tet as usize] = name);
        Self { lattice: crack.part(&tets), names }
    }

    /// Each node takes the energy density of the tetrahedron that carries it. Nodes carried by other parts take none.
    fn transfer(&self, cutting: &CuttingMesh, nodes: &[u32]) -> EnergyTransfer {
        EnergyTransfer::of_densities(nodes.iter().map(|&node| {
            let name = self.names[cutting.carriers[node as usize].tet as usize];
            let volume = cutting.volumes[node as usize];
            (name != NO_INDEX).then(|| (name, volume / self.lattice.tet_volume(name as usize)))
        }))
    }
}
