//! Labels, tessellation and fragments stages: closed meshes with mass properties from cells.

use super::cut_domain::{CutDomain, lattice_labels};
use super::release_velocity::{self, ReleaseVelocity};
use super::slivers;
use crate::centroidal::EnergyField;
use crate::fragment::properties;
use crate::pipeline::error::FractureError;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::request::stage::Stage;
use crate::pipeline::stages::cells::{BodyCells, CellPartition};
use crate::pipeline::stages::energy::BodyEnergy;
use crate::pipeline::workspace::body_meshes::{BodyMeshes, CutBuffers};
use crate::pipeline::workspace::buffer_pool::BufferPool;
use crate::scene::EffectKind;
use crate::strength::Criterion;
use crate::tessellation::{BisectorSites, FixedPoints, TessellationWorkspace};
/// Inputs of the fragments of a request.
#[derive(Clone, Copy)]
pub(in crate::pipeline) struct MeshSources<'a> {
    /// Context of the request.
    pub context: RequestContext<'a>,
    /// Strain energies of the struck bodies.
    pub energies: &'a [BodyEnergy],
    /// Energy densities of the struck bodies, without an artist's controls.
    pub fields: &'a [EnergyField<'a>],
    /// Degree and diagrams.
    pub division: &'a CellPartition,
    /// Pool of buffers.
    pub spare: &'a BufferPool,
}

/// Diagram of a body on the mesh on which it is cut.
#[derive(Clone, Copy)]
struct NodeSites<'a> {
    cells: &'a BodyCells,
    /// Site of each node.
    of_node: &'a [u32],
    /// Crack points on the boundaries of protected regions.
    fixed: &'a FixedPoints,
}

impl MeshSources<'_> {
    /// Release velocities of the fragments of one body.
    pub(super) fn velocities(&self, index: usize, pieces: &BodyMeshes) -> Vec<ReleaseVelocity> {
        let struck = self.energies.iter().position(|energy| energy.body == index);
        let released_j = |energy: &BodyEnergy| match self.context.request.criterion {
            Criterion::Paper => energy.energy_j,
            Criterion::Strength => energy.strain_j.unwrap_or(energy.energy_j),
        };
        let energy_j = struck.map_or(0.0, |struck| released_j(&self.energies[struck]));
        let body = &self.context.prepared.bodies[index];
        let (field, lattice) = (struck.map(|struck| &self.fields[struck]), &body.crack);
        let density = self.context.prepared.parameters.material.density_kg_m3;
        let (properties, frame) = (&pieces.properties, &self.context.prepared.frame);
        let labels = lattice_labels(body, self.context.request.surface, &pieces.labels);
        release_velocity::velocities(properties, &labels, lattice, field, energy_j, density, frame)
    }

    /// The diagram of each body, `None` if it stays intact. `of_fragments`: site of each fragment, by body.
    pub(super) fn sites<'b>(
        &'b self,
        of_fragments: &'b [Vec<u32>],
    ) -> Result<Vec<Option<BisectorSites<'b>>>, FractureError> {
        let sites = |(body, of_fragment): (usize, &'b Vec<u32>)| {
            let lift = self.context.request.lift_of(self.context.prepared, body)?;
            let coordinates = |cells: &'b BodyCells| cells.diagram.sites.as_slice();
            let sites = |coordinates| BisectorSites { lift, coordinates, of_fragment, of_node: None };
            Ok(self.cells(body).map(coordinates).map(sites))
        };
        of_fragments.iter().enumerate().map(sites).collect()
    }

    /// The cells of one body, if it breaks.
    pub(in crate::pipeline) fn cells(&self, body: usize) -> Option<&'_ BodyCells> {
        self.division.cells.iter().find(|cells| self.energies[cells.struck].body == body)
    }

    /// Cuts one body into fragments.
    pub(super) fn cut(&self, index: usize, workspace: &mut TessellationWorkspace) -> Result<BodyMeshes, FractureError> {
        let RequestContext { request, observer, .. } = self.context;
        let domain = CutDomain::of(self.context, index)?;
        let cells = self.cells(index);
        let merges = request.effects.has(EffectKind::Slivers) && cells.is_some();
        let mut cut = self.spare.take();
        let labels = observer.stage(Stage::Labels);
        // Taken out, since it is borrowed beside `cut`; put back below.
        let mut carried = std::mem::take(&mut cut.carried);
        if cells.is_none() {
            carried.clear();
            carried.resize(domain.mesh.nodes.len(), 0);
        }
        let fixed = cells.and_then(|cells| self.enclose(&domain, cells, &mut carried));
        let sites = match cells {
            Some(cells) if fixed.is_none() => domain.sites(cells, &mut carried),
            _ => &carried,
        };
        let fixed = &fixed.unwrap_or_default();
        cut.components.split(domain.topology, sites);
        labels.produced(&cut.components.labels);
        let tessellation = observer.stage(Stage::Tessellation);
        if merges {
            let _slivers = observer.effect(EffectKind::Slivers);
            self.merge_small(&domain, &mut cut);
        }
        let diagram = cells.map(|cells| NodeSites { cells, of_node: sites, fixed });
        self.tessellate(&domain, diagram, &mut cut, workspace)?;
        tessellation.produced(cut.tessellation.runs());
        let fragments = observer.stage(Stage::Fragments);
        properties(&cut.tessellation, &mut cut.measured);
        if merges {
            let slivers = observer.effect(EffectKind::Slivers);
            slivers.produced_bytes(self.merge_slivers(&domain, diagram, &mut cut, workspace)?);
        }
        fragments.produced(&cut.measured);
        cut.carried = carried;
        Ok(cut.into_pieces(index, self.spare, |site| cells.map_or(0.0, |cells| self.energy_j_m2(cells, site))))
    }

    /// Applies an artist's protected regions: writes the sites of the nodes to `carried`, and returns the crack points on
    /// the regions' boundaries. `None` without regions.
    fn enclose(&self, domain: &CutDomain<'_>, cells: &BodyCells, carried: &mut Vec<u32>) -> Option<FixedPoints> {
        let RequestContext { prepared, request, observer, .. } = self.context;
        let index = self.energies[cells.struck].body;
        let warped = request.controls_of(prepared, index)?;
        let effect = observer.effect(EffectKind::Warp);
        let fixed = domain.boundary.map(|boundary| {
            let (diagram, volumes) = (&cells.diagram, &prepared.bodies[index].volumes);
            let of_group = warped.protecting_labels(&diagram.labels, volumes, diagram.count());
            domain.enclosed_sites(boundary, &of_group, cells, carried)
        });
        effect.produced_bytes(warped.bytes() as u64);
        fixed
    }

    /// Distance-weighted energy of a cell, J·m².
    pub(in crate::pipeline) fn energy_j_m2(&self, cells: &BodyCells, site: u32) -> f64 {
        let unit = self.energies[cells.struck].unit_j_m2(self.context.prepared.frame.diagonal_m);
        unit * cells.diagram.cell_energy[site as usize]
    }

    /// Merges fragments that are small by the volumes of their nodes, before the body is cut.
    fn merge_small(&self, domain: &CutDomain<'_>, cut: &mut CutBuffers) {
        let least = slivers::least_volume(self.context);
        if let Some(volumes) = slivers::small_by_nodes(&cut.components, domain.volumes, least) {
            slivers::merge_by_nodes(&mut cut.components, domain.topology, volumes, least);
        }
    }

    /// Merges slivers and tessellates again if there were any. Returns the size of the new labels in bytes.
    fn merge_slivers(
        &self,
        domain: &CutDomain<'_>,
        diagram: Option<NodeSites<'_>>,
        cut: &mut CutBuffers,
        workspace: &mut TessellationWorkspace,
    ) -> Result<u64, FractureError> {
        let least = slivers::least_volume(self.context);
        if !slivers::merge(&mut cut.components, &cut.tessellation, &cut.measured, least) {
            return Ok(0);
        }
        self.tessellate(domain, diagram, cut, workspace)?;
        properties(&cut.tessellation, &mut cut.measured);
        Ok(size_of_val(cut.components.labels.as_slice()) as u64)
    }

    /// Computes the crack points of the components, at the diagram's positions even between merged cells, and builds
    /// the fragments.
    fn tessellate(
        &self,
        domain: &CutDomain<'_>,
        diagram: Option<NodeSites<'_>>,
        cut: &mut CutBuffers,
        workspace: &mut TessellationWorkspace,
    ) -> Result<(), FractureError> {
        let CutBuffers { components, points, tessellation, .. } = cut;
        let sites = diagram.map(|NodeSites { cells, of_node, .. }| BisectorSites {
            lift: &domain.lift,
            coordinates: &cells.diagram.sites,
            of_fragment: &components.sites,
            of_node: Some(of_node),
        });
        let none = FixedPoints::default();
        let fixed = diagram.map_or(&none, |diagram| diagram.fixed);
        points.find(domain.mesh, domain.topology, &components.labels, sites, fixed)?;
        Ok(tessellation.build(domain.mesh, domain.topology, &components.labels, points, workspace)?)
    }
}
