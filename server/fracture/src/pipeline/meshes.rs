//! Labels, tessellation, fragments: cells become closed meshes that know their mass.

use super::buffer_pool::BufferPool;
use super::cells::{BodyCells, Division};
use super::hulls::FragmentHulls;
use super::outputs::{bond_count, debris_count};
use super::release_velocity::{self, ReleaseVelocity};
use super::{
    BodyEnergy, BondRow, BulkCounts, FractureError, FragmentRow, FragmentSkins, OUTER, PreparedObject, RunRow, Stage,
    StrikeContext, VertexAttributes, WORLD, slivers, world_bonds,
};
use crate::centroidal::EnergyField;
use crate::fragment::{RigidProperties, properties};
use crate::lattice::Lattice;
use crate::scene::{EffectKind, EffectSet};
use crate::surface::LocalFrame;
use crate::tessellation::{
    BisectorSites, Components, CrackPoints, FixedPoints, HostFrame, MeterFrame, Tessellation, TessellationWorkspace,
    Transform,
};
use nalgebra::Point3;
use std::mem::take;

/// The meshes of one body, whole or broken, or of one fragment that was struck again.
pub(super) struct BodyMeshes {
    pub(super) body: usize,
    pub(super) tessellation: Tessellation,
    /// Fragment of each node of the body; those that are answered come first.
    pub(super) labels: Vec<u32>,
    /// The crack points of these labels.
    pub(super) points: CrackPoints,
    pub(super) properties: Vec<RigidProperties>,
    /// Site of each fragment.
    pub(super) sites: Vec<u32>,
    centers: Vec<Point3<f64>>,
    energies_j_m2: Vec<f64>,
    /// Where its memory goes.
    spare: BufferPool,
}

impl Drop for BodyMeshes {
    fn drop(&mut self) {
        let components = Components::from_memory(take(&mut self.labels), take(&mut self.sites));
        let (points, tessellation) = (take(&mut self.points), take(&mut self.tessellation));
        self.spare.give(CutBuffers { components, points, tessellation, measured: take(&mut self.properties) });
    }
}

/// The meshes of all bodies, ready to be emitted: their size is known to the byte.
pub struct FractureMeshes {
    pub(super) bodies: Vec<BodyMeshes>,
    pub(super) transform: Transform,
    pub(super) frame: LocalFrame,
    pub(super) crack_spacing: f64,
    pub(super) seed: u64,
    /// Bonds with the world, by fragment, if bonds are asked for.
    pub(super) world: Vec<BondRow>,
    /// One row per fragment, by body, then by site, then by lowest node.
    pub fragments: Vec<FragmentRow>,
    /// One row per run; a fragment's rows follow each other.
    pub runs: Vec<RunRow>,
    /// One per fragment, if release is asked for.
    pub velocities: Vec<ReleaseVelocity>,
    /// Empty unless hulls are asked for.
    pub hulls: FragmentHulls,
    /// Empty unless attributes are asked for.
    pub looks: VertexAttributes,
    /// Empty unless skins are asked for.
    pub skins: FragmentSkins,
    /// What is asked for.
    pub effects: EffectSet,
    /// Lengths of the bulk sections.
    pub counts: BulkCounts,
}

/// What the fragments of a strike are made of.
#[derive(Clone, Copy)]
pub(super) struct MeshSources<'a> {
    pub context: StrikeContext<'a>,
    pub energies: &'a [BodyEnergy],
    pub fields: &'a [EnergyField<'a>],
    pub division: &'a Division,
    pub spare: &'a BufferPool,
}

impl FractureMeshes {
    /// Cuts every body: those with cells along them, the others stay whole.
    pub(super) fn new(sources: MeshSources<'_>, workspace: &mut TessellationWorkspace) -> Result<Self, FractureError> {
        let StrikeContext { prepared, request, cancel, observer } = sources.context;
        let mut bodies: Vec<BodyMeshes> = Vec::with_capacity(prepared.bodies.len());
        let (mut velocities, mut world, mut first) = (Vec::new(), Vec::new(), 0);
        let held = prepared.held(request.effects)?;
        for (index, body) in prepared.bodies.iter().enumerate() {
            cancel.check()?;
            let meshes = sources.cut(index, workspace)?;
            let held = held.filter(|held| held.body(index).is_some());
            let ties = |held| world_bonds::bonds(&meshes, &body.crack, held, &prepared.frame);
            if let Some(held) = held.filter(|_| request.effects.has(EffectKind::Bonds)) {
                let _bonds = observer.effect(EffectKind::Bonds);
                let numbered = |bond: BondRow| BondRow { fragments: [first + bond.fragments[0], WORLD], ..bond };
                world.extend(ties(held).into_iter().map(numbered));
            }
            if request.effects.has(EffectKind::Release) {
                let release = observer.effect(EffectKind::Release);
                let mut own = sources.velocities(index, &meshes);
                let still = held.map_or(Vec::new(), ties);
                still.iter().for_each(|bond| own[bond.fragments[0] as usize] = ReleaseVelocity::default());
                release.produced(&own);
                velocities.extend(own);
            }
            first += meshes.properties.len() as u32;
            bodies.push(meshes);
        }
        let lattices: Vec<&Lattice> = prepared.bodies.iter().map(|body| &body.crack).collect();
        let meshes = Self::of(bodies, velocities, world, sources.context);
        let mut meshes = meshes.with_looks(sources.context)?;
        if request.effects.has(EffectKind::Skin) {
            let of_fragments: Vec<Vec<u32>> = meshes.bodies.iter().map(|own| own.sites.clone()).collect();
            let sites = sources.sites(&of_fragments)?;
            meshes = meshes.with_skins(prepared.skin.as_ref(), prepared, &sites, observer)?;
        }
        meshes.with_hulls(&lattices, sources.context)
    }

    /// The meshes of `bodies`, laid out.
    pub(super) fn of(
        bodies: Vec<BodyMeshes>,
        velocities: Vec<ReleaseVelocity>,
        world: Vec<BondRow>,
        context: StrikeContext<'_>,
    ) -> Self {
        let StrikeContext { prepared, request, .. } = context;
        let mut pieces = Self {
            bodies,
            transform: Transform { meters_per_unit: prepared.frame.diagonal_m },
            frame: prepared.frame,
            crack_spacing: prepared.parameters.crack_spacing,
            seed: request.seed,
            world,
            fragments: Vec::new(),
            runs: Vec::new(),
            velocities,
            hulls: FragmentHulls::default(),
            looks: VertexAttributes::default(),
            skins: FragmentSkins::default(),
            effects: request.effects,
            counts: BulkCounts::default(),
        };
        pieces.lay_out(prepared);
        pieces
    }

    /// The same with hulls of the fragments, if they are asked for. `lattices`: those that the bodies were cut on.
    pub(super) fn with_hulls(
        mut self,
        lattices: &[&Lattice],
        context: StrikeContext<'_>,
    ) -> Result<Self, FractureError> {
        if self.effects.has(EffectKind::Hulls) {
            let hulls = context.observer.effect(EffectKind::Hulls);
            self.hulls = self.fit_hulls(lattices, context.cancel)?;
            hulls.produced_bytes(self.hulls.bytes() as u64);
        }
        Ok(self)
    }

    /// Fills the tables; offsets continue from body to body.
    fn lay_out(&mut self, prepared: &PreparedObject) {
        let density = prepared.parameters.material.density_kg_m3;
        let meter = prepared.frame.diagonal_m;
        for pieces in &self.bodies {
            let base = self.counts;
            let (first_fragment, first_run) = (self.fragments.len() as u32, self.runs.len() as u32);
            for (local, fragment) in pieces.tessellation.fragments().iter().enumerate() {
                let measured = &pieces.properties[local];
                let volume_m3 = measured.volume * meter.powi(3);
                let inertia = measured.inertia * (density * meter.powi(5));
                self.fragments.push(FragmentRow {
                    id: first_fragment + local as u32,
                    body: pieces.body as u32,
                    vertex_first: (base.vertices + fragment.vertices.start) as u32,
                    vertex_count: fragment.vertices.len() as u32,
                    index_first: (base.indices + 3 * fragment.triangles.start) as u32,
                    index_count: 3 * fragment.triangles.len() as u32,
                    run_first: first_run + fragment.runs.start as u32,
                    run_count: fragment.runs.len() as u32,
                    merge_first: (base.merges + fragment.merges.start) as u32,
                    merge_count: fragment.merges.len() as u32,
                    volume_m3,
                    mass_kg: volume_m3 * density,
                    center_m: prepared.frame.to_meters(&measured.center).coords.into(),
                    inertia_kg_m2: [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|entry| inertia[entry]),
                    energy_j_m2: pieces.energies_j_m2[local],
                });
            }
            self.runs.extend(pieces.tessellation.runs().iter().map(|run| RunRow {
                fragment: first_fragment + run.fragment,
                neighbor: run.neighbor.map_or(OUTER, |neighbor| first_fragment + neighbor),
                crack: run.crack,
                vertex_first: (base.vertices + run.vertices.start) as u32,
                vertex_count: run.vertices.len() as u32,
                index_first: (base.indices + 3 * run.triangles.start) as u32,
                index_count: 3 * run.triangles.len() as u32,
            }));
            self.counts.vertices += pieces.tessellation.vertex_count();
            self.counts.indices += pieces.tessellation.index_count();
            self.counts.merges += pieces.tessellation.merge_count();
            if self.effects.has(EffectKind::Bonds) {
                self.counts.bonds += bond_count(&pieces.tessellation);
            }
            if self.effects.has(EffectKind::Debris) {
                self.counts.debris += debris_count(&pieces.tessellation);
            }
        }
        self.counts.bonds += self.world.len();
    }

    /// Writes positions (relative to each fragment's center of mass, m), indices and merge pairs (both relative to the
    /// fragment's first vertex) into the caller's memory; lengths exactly [`Self::counts`], or nothing is written.
    pub fn emit(
        &self,
        positions: &mut [[f32; 3]],
        indices: &mut [u32],
        merges: &mut [[u32; 2]],
    ) -> Result<(), FractureError> {
        self.emit_for(&MeterFrame, positions, indices, merges)
    }

    /// [`Self::emit`] in the coordinates and the winding of `host`.
    pub fn emit_for(
        &self,
        host: &impl HostFrame,
        positions: &mut [[f32; 3]],
        indices: &mut [u32],
        merges: &mut [[u32; 2]],
    ) -> Result<(), FractureError> {
        let given =
            BulkCounts { vertices: positions.len(), indices: indices.len(), merges: merges.len(), ..self.counts };
        if given != self.counts {
            return Err(FractureError::SectionLengths { given, needed: self.counts });
        }
        let (mut positions, mut indices, mut merges) = (positions, indices, merges);
        for pieces in &self.bodies {
            let tessellation = &pieces.tessellation;
            let (own_positions, other_positions) = positions.split_at_mut(tessellation.vertex_count());
            let (own_indices, other_indices) = indices.split_at_mut(tessellation.index_count());
            let (own_merges, other_merges) = merges.split_at_mut(tessellation.merge_count());
            tessellation.emit_for(host, &pieces.centers, self.transform, own_positions, own_indices, own_merges)?;
            (positions, indices, merges) = (other_positions, other_indices, other_merges);
        }
        Ok(())
    }
}

/// What cutting one body works on.
#[derive(Default)]
pub(super) struct CutBuffers {
    pub components: Components,
    pub points: CrackPoints,
    pub tessellation: Tessellation,
    pub measured: Vec<RigidProperties>,
}

impl CutBuffers {
    /// The pieces of body `body`, by the energy of a site, J·m².
    pub fn into_pieces(self, body: usize, spare: &BufferPool, energy_j_m2: impl Fn(u32) -> f64) -> BodyMeshes {
        let Self { components, points, tessellation, measured } = self;
        let energies_j_m2 = components.sites.iter().take(measured.len()).map(|&site| energy_j_m2(site)).collect();
        BodyMeshes {
            body,
            spare: spare.clone(),
            tessellation,
            points,
            energies_j_m2,
            centers: measured.iter().map(|measured| measured.center).collect(),
            labels: components.labels,
            properties: measured,
            sites: components.sites,
        }
    }
}

impl MeshSources<'_> {
    /// Velocities of the fragments of one body.
    fn velocities(&self, index: usize, pieces: &BodyMeshes) -> Vec<ReleaseVelocity> {
        let struck = self.energies.iter().position(|energy| energy.body == index);
        let energy_j = struck.map_or(0.0, |struck| self.energies[struck].energy_j);
        let (field, lattice) = (struck.map(|struck| &self.fields[struck]), &self.context.prepared.bodies[index].crack);
        let density = self.context.prepared.parameters.material.density_kg_m3;
        let (properties, labels, frame) = (&pieces.properties, &pieces.labels, &self.context.prepared.frame);
        release_velocity::velocities(properties, labels, lattice, field, energy_j, density, frame)
    }

    /// The diagrams of all bodies, of those that break; `of_fragments`: site of each fragment.
    fn sites<'b>(&'b self, of_fragments: &'b [Vec<u32>]) -> Result<Vec<Option<BisectorSites<'b>>>, FractureError> {
        let sites = |(body, of_fragment): (usize, &'b Vec<u32>)| {
            let lift = self.context.prepared.lift_for(body, self.context.request)?;
            let coordinates = |cells: &'b BodyCells| cells.diagram.sites.as_slice();
            let sites = |coordinates| BisectorSites { lift, coordinates, of_fragment, of_node: None };
            Ok(self.cells(body).map(coordinates).map(sites))
        };
        of_fragments.iter().enumerate().map(sites).collect()
    }

    /// The cells of one body, if it breaks.
    pub(super) fn cells(&self, body: usize) -> Option<&'_ BodyCells> {
        self.division.cells.iter().find(|cells| self.energies[cells.struck].body == body)
    }

    /// Cuts one body.
    fn cut(&self, index: usize, workspace: &mut TessellationWorkspace) -> Result<BodyMeshes, FractureError> {
        let StrikeContext { prepared, request, observer, .. } = self.context;
        let body = &prepared.bodies[index];
        let cells = self.cells(index);
        let merges = request.effects.has(EffectKind::Slivers) && cells.is_some();
        let mut cut = self.spare.take();
        let labels = observer.stage(Stage::Labels);
        let whole = vec![0; body.crack.nodes.len()];
        cut.components.split(&body.topology, cells.map_or(&whole, |cells| &cells.diagram.labels));
        labels.produced(&cut.components.labels);
        let tessellation = observer.stage(Stage::Tessellation);
        if merges {
            let _slivers = observer.effect(EffectKind::Slivers);
            self.merge_small(index, &mut cut);
        }
        self.tessellate(index, cells, &mut cut, workspace)?;
        tessellation.produced(cut.tessellation.runs());
        let fragments = observer.stage(Stage::Fragments);
        properties(&cut.tessellation, &mut cut.measured);
        if merges {
            let slivers = observer.effect(EffectKind::Slivers);
            slivers.produced_bytes(self.merge_slivers(index, cells, &mut cut, workspace)?);
        }
        fragments.produced(&cut.measured);
        Ok(cut.into_pieces(index, self.spare, |site| cells.map_or(0.0, |cells| self.energy_j_m2(cells, site))))
    }

    /// Energy of a cell, J·m².
    pub(super) fn energy_j_m2(&self, cells: &BodyCells, site: u32) -> f64 {
        let unit = self.energies[cells.struck].unit_j_m2(self.context.prepared.frame.diagonal_m);
        unit * cells.diagram.cell_energy[site as usize]
    }

    /// Merges pieces that are small by their nodes before the body is cut.
    fn merge_small(&self, index: usize, cut: &mut CutBuffers) {
        let body = &self.context.prepared.bodies[index];
        let least = slivers::least_volume(self.context);
        if let Some(volumes) = slivers::small_by_nodes(&cut.components, &body.volumes, least) {
            slivers::merge_by_nodes(&mut cut.components, &body.topology, volumes, least);
        }
    }

    /// Merges slivers, and cuts again where there were any; bytes of the new labels.
    fn merge_slivers(
        &self,
        index: usize,
        cells: Option<&BodyCells>,
        cut: &mut CutBuffers,
        workspace: &mut TessellationWorkspace,
    ) -> Result<u64, FractureError> {
        let least = slivers::least_volume(self.context);
        if !slivers::merge(&mut cut.components, &cut.tessellation, &cut.measured, least) {
            return Ok(0);
        }
        self.tessellate(index, cells, cut, workspace)?;
        properties(&cut.tessellation, &mut cut.measured);
        Ok(size_of_val(cut.components.labels.as_slice()) as u64)
    }

    /// Finds the crack points of the components, where the diagram has them whatever was merged, and builds the fragments.
    fn tessellate(
        &self,
        index: usize,
        cells: Option<&BodyCells>,
        cut: &mut CutBuffers,
        workspace: &mut TessellationWorkspace,
    ) -> Result<(), FractureError> {
        let StrikeContext { prepared, request, .. } = self.context;
        let (body, lift) = (&prepared.bodies[index], prepared.lift_for(index, request)?);
        let CutBuffers { components, points, tessellation, .. } = cut;
        let sites = cells.map(|cells| BisectorSites {
            lift,
            coordinates: &cells.diagram.sites,
            of_fragment: &components.sites,
            of_node: Some(&cells.diagram.labels),
        });
        points.find(&body.crack, &body.topology, &components.labels, sites, &FixedPoints::default())?;
        Ok(tessellation.build(&body.crack, &body.topology, &components.labels, points, workspace)?)
    }
}
