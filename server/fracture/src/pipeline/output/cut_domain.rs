//! Mesh on which a body is cut: its crack lattice, or the mesh of the input surface.

use crate::cutting::CuttingMesh;
use crate::lattice::Lattice;
use crate::lift::LiftedLattice;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedBody;
use crate::pipeline::prepared::parameters::SurfaceKind;
use crate::pipeline::prepared::region_boundary::RegionBoundary;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::stages::cells::BodyCells;
use crate::tessellation::{BisectorSites, FixedPoints, Topology};
use std::borrow::Cow;

/// Nodes, tetrahedra and lift of the mesh on which one body is cut.
pub(in crate::pipeline) struct CutDomain<'a> {
    /// Nodes and tetrahedra, local.
    pub mesh: &'a Lattice,
    /// Edges, faces and boundary.
    pub topology: &'a Topology,
    /// Lumped volumes of the nodes, local.
    pub volumes: &'a [f64],
    /// Lift of the request at the nodes.
    pub lift: Cow<'a, LiftedLattice>,
    cutting: Option<&'a CuttingMesh>,
    /// Boundaries of protected regions on the mesh, if the request uses them.
    pub boundary: Option<&'a RegionBoundary>,
}

/// The mesh of the input surface, if the body has one and the request wants it.
pub(in crate::pipeline) fn cutting(body: &PreparedBody, surface: SurfaceKind) -> Option<&CuttingMesh> {
    body.cutting.as_ref().filter(|_| surface == SurfaceKind::Exact)
}

/// The mesh on which a body is cut.
pub(in crate::pipeline) fn cut_mesh(body: &PreparedBody, surface: SurfaceKind) -> &Lattice {
    cutting(body, surface).map_or(&body.crack, |cutting| &cutting.mesh)
}

impl<'a> CutDomain<'a> {
    /// The domain of body `index`.
    ///
    /// # Errors
    /// [`FractureError::LiftUnprepared`].
    pub fn of(context: RequestContext<'a>, index: usize) -> Result<Self, FractureError> {
        let RequestContext { prepared, request, .. } = context;
        let body = &prepared.bodies[index];
        let lift = request.lift_of(prepared, index)?;
        let controls = request.controls_of(prepared, index);
        let Some(cutting) = cutting(body, request.surface) else {
            let (mesh, topology, volumes) = (&body.crack, &body.topology, &body.volumes);
            let boundary = controls.and_then(|warped| warped.boundary.as_ref());
            return Ok(Self { mesh, topology, volumes, lift: Cow::Borrowed(lift), cutting: None, boundary });
        };
        let is_bent = body.lift(request.lift).is_some_and(|own| !std::ptr::eq(own, lift));
        let lift = match cutting.lift(lift.kind).filter(|_| !is_bent) {
            Some(carried) => Cow::Borrowed(carried),
            None => Cow::Owned(cutting.carried(&body.crack, lift)),
        };
        let CuttingMesh { mesh, topology, volumes, .. } = cutting;
        let boundary = controls.and_then(|warped| warped.cutting_boundary.as_ref());
        Ok(Self { mesh, topology, volumes, lift, cutting: Some(cutting), boundary })
    }

    /// Sites of the nodes of this domain. `carried` is memory for those of a mesh of the input surface.
    pub fn sites<'b>(&self, cells: &'b BodyCells, carried: &'b mut Vec<u32>) -> &'b [u32] {
        let labels = &cells.diagram.labels;
        let Some(cutting) = self.cutting else { return labels };
        cutting.label(&self.lift, &cells.diagram.sites, labels, carried);
        carried
    }

    /// As [`Self::sites`], with one site for each group of regions in `boundary`. Returns the crack points on it.
    pub fn enclosed_sites(
        &self,
        boundary: &RegionBoundary,
        of_group: &[u32],
        cells: &BodyCells,
        carried: &mut Vec<u32>,
    ) -> FixedPoints {
        match self.cutting {
            Some(cutting) => cutting.label(&self.lift, &cells.diagram.sites, &cells.diagram.labels, carried),
            None => carried.clone_from(&cells.diagram.labels),
        }
        let identity: Vec<u32> = (0..cells.diagram.count() as u32).collect();
        let coordinates = &cells.diagram.sites;
        let sites = BisectorSites { lift: &self.lift, coordinates, of_fragment: &identity, of_node: None };
        boundary.enclose((self.mesh, self.topology), sites, of_group, carried)
    }
}

/// Labels of the nodes of the crack lattice, from those of the nodes on which the body was cut.
pub(in crate::pipeline) fn lattice_labels<'a>(
    body: &PreparedBody,
    surface: SurfaceKind,
    labels: &'a [u32],
) -> Cow<'a, [u32]> {
    match cutting(body, surface) {
        Some(cutting) => Cow::Owned(cutting.lattice_labels(labels)),
        None => Cow::Borrowed(labels),
    }
}
