//! Fragments of all bodies, laid out in tables.

use super::cut::MeshSources;
use super::cut_domain::{cut_mesh, cutting};
use super::hulls::FragmentHulls;
use super::outer_attributes::{OuterRunAttributes, outer_attributes};
use super::release_velocity::ReleaseVelocity;
use super::rows::{BondRow, BulkCounts, FragmentRow, OUTER, RunRow, WORLD};
use super::skins::FragmentSkins;
use super::vertex_attributes::VertexAttributes;
use super::world_bonds;
use crate::lattice::Lattice;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::scene::{EffectKind, EffectSet};
use crate::skin::Skin;
use crate::surface::LocalFrame;
use crate::tessellation::{BisectorSites, HostFrame, LocalToMeters, MeterFrame, TessellationWorkspace};
use std::cell::OnceCell;
use std::sync::Arc;

/// Meshes of all bodies, ready to be emitted, with exactly known sizes.
pub struct FractureMeshes {
    pub(in crate::pipeline) bodies: Vec<BodyMeshes>,
    pub(in crate::pipeline) transform: LocalToMeters,
    pub(in crate::pipeline) frame: LocalFrame,
    pub(in crate::pipeline) crack_spacing: f64,
    pub(in crate::pipeline) seed: u64,
    /// True if bodies are cut on meshes of the input surface.
    pub(in crate::pipeline) is_exact: bool,
    /// Attributes of the outer runs, by body and fragment, if bodies are cut on those meshes and an effect needs them.
    outer: Vec<Vec<OuterRunAttributes>>,
    /// Bonds with the world, by fragment, with the effect `bonds`.
    pub(in crate::pipeline) world: Vec<BondRow>,
    /// Fragments, one row each, by body, then site, then lowest node.
    pub fragments: Vec<FragmentRow>,
    /// Runs, one row each; those of a fragment are consecutive.
    pub runs: Vec<RunRow>,
    /// Release velocities, one per fragment, with the effect `release`.
    pub velocities: Vec<ReleaseVelocity>,
    /// Hulls; empty without the effect `hulls`.
    pub hulls: FragmentHulls,
    /// Attributes of vertices; empty without the effect `attributes`.
    pub attributes: VertexAttributes,
    /// Skins; empty without the effect `skin`.
    pub skins: FragmentSkins,
    /// Effects of the request.
    pub effects: EffectSet,
    /// Lengths of the bulk sections.
    pub counts: BulkCounts,
}

impl FractureMeshes {
    /// Cuts every body that has cells; the others stay intact.
    pub(in crate::pipeline) fn new(
        sources: MeshSources<'_>,
        workspace: &mut TessellationWorkspace,
    ) -> Result<Self, FractureError> {
        let RequestContext { prepared, request, cancel, observer } = sources.context;
        let mut bodies: Vec<BodyMeshes> = Vec::with_capacity(prepared.bodies.len());
        let (mut velocities, mut world, mut first) = (Vec::new(), Vec::new(), 0);
        let held = prepared.held(request.effects)?;
        for (index, body) in prepared.bodies.iter().enumerate() {
            cancel.check()?;
            let meshes = sources.cut(index, workspace)?;
            let held = held.filter(|held| held.body(index).is_some());
            let mesh = cut_mesh(body, request.surface);
            let found = OnceCell::new();
            let ties = |held| found.get_or_init(|| world_bonds::bonds(&meshes, mesh, held, &prepared.frame));
            if let Some(held) = held.filter(|_| request.effects.has(EffectKind::Bonds)) {
                let _bonds = observer.effect(EffectKind::Bonds);
                let numbered = |bond: &BondRow| BondRow { fragments: [first + bond.fragments[0], WORLD], ..*bond };
                world.extend(ties(held).iter().map(numbered));
            }
            if request.effects.has(EffectKind::Release) {
                let release = observer.effect(EffectKind::Release);
                let mut own = sources.velocities(index, &meshes);
                let still = held.map(ties).into_iter().flatten();
                still.for_each(|bond| own[bond.fragments[0] as usize] = ReleaseVelocity::default());
                release.produced(&own);
                velocities.extend(own);
            }
            first += meshes.properties.len() as u32;
            bodies.push(meshes);
        }
        let lattices: Vec<&Lattice> = prepared.bodies.iter().map(|body| cut_mesh(body, request.surface)).collect();
        let mut meshes = Self::of(bodies, velocities, world, sources.context)?;
        if request.effects.has(EffectKind::Skin) {
            let of_fragments: Vec<Vec<u32>> = meshes.bodies.iter().map(|own| own.sites.clone()).collect();
            let sites = sources.sites(&of_fragments)?;
            meshes = meshes.with_skins(prepared.skin.as_ref(), &sites, sources.context)?;
        }
        meshes.with_hulls(&lattices, sources.context)
    }

    /// The meshes of `bodies`, laid out, with the attributes of outer faces if the request asks for them.
    ///
    /// # Errors
    /// [`FractureError::AttributesUnprepared`].
    pub(in crate::pipeline) fn of(
        mut bodies: Vec<BodyMeshes>,
        velocities: Vec<ReleaseVelocity>,
        world: Vec<BondRow>,
        context: RequestContext<'_>,
    ) -> Result<Self, FractureError> {
        let RequestContext { prepared, request, .. } = context;
        let is_exact = prepared.bodies.iter().any(|body| cutting(body, request.surface).is_some());
        let effect = [EffectKind::Attributes, EffectKind::Skin].into_iter().find(|own| request.effects.has(*own));
        // The skin of fragments with the lattice's surface is cut by itself.
        let effect = effect.filter(|effect| is_exact || *effect == EffectKind::Attributes);
        let span = effect.map(|effect| (effect, context.observer.effect(effect)));
        let mut outer = Vec::new();
        // Copies vertices on seams, so it precedes the layout of the sections.
        if let Some((effect, _)) = &span {
            let of = |own: &mut BodyMeshes| {
                let body = &prepared.bodies[own.body];
                outer_attributes(own, body, request.surface, *effect)
            };
            outer = bodies.iter_mut().map(of).collect::<Result<_, _>>()?;
        }
        let has_attributes = request.effects.has(EffectKind::Attributes);
        let attributes =
            if has_attributes { VertexAttributes::of(&bodies, &outer) } else { VertexAttributes::default() };
        if let Some((_, span)) = span {
            span.produced_bytes(attributes.bytes() as u64);
        }
        let mut pieces = Self {
            bodies,
            transform: LocalToMeters { meters_per_unit: prepared.frame.diagonal_m },
            frame: prepared.frame,
            crack_spacing: prepared.parameters.crack_spacing,
            seed: request.seed,
            is_exact,
            outer,
            world,
            fragments: Vec::new(),
            runs: Vec::new(),
            velocities,
            hulls: FragmentHulls::default(),
            attributes,
            skins: FragmentSkins::default(),
            effects: request.effects,
            counts: BulkCounts::default(),
        };
        pieces.lay_out(prepared);
        Ok(pieces)
    }

    /// True if the outer faces of the fragments are triangles of the input surface.
    pub fn has_exact_surface(&self) -> bool {
        self.is_exact
    }

    /// Adds the skins of the fragments, cut from `skin`. `sites`: the diagram of each body, if it has one.
    ///
    /// # Errors
    /// [`FractureError::AttributesUnprepared`] without `skin`.
    pub(in crate::pipeline) fn with_skins(
        mut self,
        skin: Option<&Arc<Skin>>,
        sites: &[Option<BisectorSites<'_>>],
        context: RequestContext<'_>,
    ) -> Result<Self, FractureError> {
        let effect = context.observer.effect(EffectKind::Skin);
        self.skins = if self.is_exact {
            FragmentSkins::of_outer_runs(&self.bodies, &self.outer, self.transform.meters_per_unit)
        } else {
            let skin = skin.ok_or(FractureError::AttributesUnprepared { effect: EffectKind::Skin })?;
            FragmentSkins::clip(&self.bodies, skin, context, sites)
        };
        effect.produced_bytes(self.skins.bytes() as u64);
        Ok(self)
    }

    /// Adds the hulls of the fragments, with the effect `hulls`. `lattices` are those that the bodies were cut on.
    pub(in crate::pipeline) fn with_hulls(
        mut self,
        lattices: &[&Lattice],
        context: RequestContext<'_>,
    ) -> Result<Self, FractureError> {
        if self.effects.has(EffectKind::Hulls) {
            let hulls = context.observer.effect(EffectKind::Hulls);
            self.hulls = FragmentHulls::fit(&self.bodies, lattices, self.transform, context.cancel)?;
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
        }
    }

    /// Writes positions, indices and merge pairs into memory of the lengths [`Self::counts`].
    ///
    /// Positions are relative to each fragment's center of mass, m. Indices and pairs are relative to the fragment's
    /// first vertex. With other lengths, nothing is written.
    ///
    /// # Errors
    /// [`FractureError::SectionLengths`] for slices of other lengths.
    pub fn emit(
        &self,
        positions: &mut [[f32; 3]],
        indices: &mut [u32],
        merges: &mut [[u32; 2]],
    ) -> Result<(), FractureError> {
        self.emit_for(&MeterFrame, positions, indices, merges)
    }

    /// [`Self::emit`] in the coordinates and the winding of `host`.
    ///
    /// # Errors
    /// Those of [`Self::emit`].
    pub fn emit_for(
        &self,
        host: &impl HostFrame,
        positions: &mut [[f32; 3]],
        indices: &mut [u32],
        merges: &mut [[u32; 2]],
    ) -> Result<(), FractureError> {
        let given = BulkCounts { vertices: positions.len(), indices: indices.len(), merges: merges.len() };
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
