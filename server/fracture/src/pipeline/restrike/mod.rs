//! Second requests, which strike a fragment of an earlier result.
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3, which names crack concavity as a goal. The method is ours:
//!
//! - The tetrahedra that are entirely in the fragment form an object ([`ParentFragment`]). The usual stages run on
//!   it, up to the labels. Its volumes, and its elasticity, reach the earlier cracks (`elastic_domain`).
//! - The labels are transferred to the whole lattice of the body. A node of the fragment that belongs to none of
//!   these tetrahedra gets the label of the nearest node that does. Nodes of other fragments keep their labels.
//! - With exact surfaces, a fragment with too few such tetrahedra is divided by its nodes in the mesh of the input surface
//!   (`node_fragment`).
//! - Points of earlier cracks do not move, so the volumes of the new fragments add up to that of the struck one.
//!
//! Cost, in addition to that of a first request on an object with as many nodes:
//!
//! - the eigenpairs of the interior lift and the factor of the stiffness, which the database contains for a first
//!   request;
//! - one tessellation of the body's whole lattice.

mod child_domain;
mod elastic_domain;
mod node_fragment;
pub(super) mod parent;
pub(super) mod volume_correction;

use crate::fragment::properties;
use crate::lift::LiftKind;
use crate::pipeline::error::FractureError;
use crate::pipeline::output::cut::MeshSources;
use crate::pipeline::output::cut_domain::{cut_mesh, cutting, lattice_labels};
use crate::pipeline::output::meshes::FractureMeshes;
use crate::pipeline::output::release_velocity::{self, ReleaseVelocity};
use crate::pipeline::output::retained::{RetainedBody, RetainedFragments};
use crate::pipeline::output::slivers;
use crate::pipeline::prepared::object::{PreparedBody, PreparedObject};
use crate::pipeline::prepared::parameters::SurfaceKind;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::request::fracture_request::FractureRequest;
use crate::pipeline::request::observer::StageSpan;
use crate::pipeline::request::stage::Stage;
use crate::pipeline::result::FractureOutcome;
use crate::pipeline::stages::cells::BodyCells;
use crate::pipeline::walk::walk;
use crate::pipeline::workspace::Workspace;
use crate::pipeline::workspace::body_meshes::{BodyMeshes, CutBuffers};
use crate::scene::EffectKind;
use crate::skin::Skin;
use crate::tessellation::{BisectorSites, EarlierCracks, FixedPoints, TessellationWorkspace, seam};
use child_domain::{ChildDomain, StruckFragment};
use parent::{NO_REPRESENTATIVE, ParentFragment, StruckLabels};
use std::borrow::Cow;
use std::sync::Arc;
use volume_correction::correct_volume;

/// Relative error up to which the children's volumes add up to their parent's.
const VOLUME_ERROR: f64 = 1e-9;

/// Largest number of tessellations to reach it. One is enough unless earlier cracks are bent.
///
/// Fragments of a few nodes, which earlier cracks bound on all sides, took up to four on an ear of the bunny.
const TESSELLATIONS_MAX: usize = 8;

/// Strikes fragment `fragment` of the retained result `kept`; otherwise as [`super::strike`].
///
/// `prepared` is the object of the earlier request. The outcome contains only the children of the fragment. Faces that
/// they share with other fragments of the earlier result are cracks without a neighbor. Only the lifts `euclidean` and
/// `interior` are available, and the object's examples are not used.
///
/// # Errors
/// Those of [`strike`](super::strike), and [`FractureError::UnknownFragment`], [`FractureError::FragmentSmall`],
/// [`FractureError::FragmentUndivided`], [`FractureError::FragmentLarge`], [`FractureError::FragmentLift`],
/// [`FractureError::FragmentLiftKind`], [`FractureError::FragmentDynamics`], [`FractureError::OtherObject`].
pub fn strike_again(
    context: RequestContext<'_>,
    (kept, fragment): (&RetainedFragments, u32),
    workspace: &mut Workspace,
) -> Result<FractureOutcome, FractureError> {
    let RequestContext { prepared, request, cancel, observer } = context;
    // A fragment is free and undeformed, even if the object that it was part of was anchored or warped.
    let gone = [EffectKind::Anchored, EffectKind::Gravity, EffectKind::Warp];
    let effects = gone.into_iter().fold(request.effects, |effects, effect| effects.without(effect));
    let surface = kept.surface();
    let plan = FractureRequest { effects, surface, ..request.planned() };
    let (old, label) = kept.find(fragment)?;
    if effects.has(EffectKind::Dynamics) {
        return Err(FractureError::FragmentDynamics { fragment });
    }
    let fits = |body: &&PreparedBody| cut_mesh(body, surface).nodes.len() == old.labels.len();
    let body = prepared.bodies.get(old.body).filter(fits).ok_or(FractureError::OtherObject)?;
    let has_skin = effects.has(EffectKind::Skin) && surface == SurfaceKind::Lattice;
    let skin_cut = has_skin.then(|| kept.skin_cut(fragment)).transpose()?;
    let lattice_labels = lattice_labels(body, surface, &old.labels);
    let parent = {
        let _load = observer.stage(Stage::Load);
        let cracks = EarlierCracks { labels: &old.labels, points: &old.points };
        let labels = StruckLabels { body: old.body, fragment, label, lattice_labels: &lattice_labels, old: cracks };
        ParentFragment::new(labels, context.with_request(&plan))?
    };
    let parent = &parent;
    // Distances between nodes without a lattice are straight.
    let lift = if parent.is_of_nodes { LiftKind::Euclidean } else { plan.lift };
    let plan = FractureRequest { lift, ..plan };
    let begun_s = cancel.remaining_s();
    let plan = plan.degrade_for_budget(&parent.prepared, begun_s);
    let context = RequestContext { prepared: &parent.prepared, request: &plan, ..context };
    walk(context, begun_s, workspace, |sources, scratch| {
        let cells = sources.division.cells.first().ok_or(FractureError::OtherObject)?;
        cancel.check()?;
        let skin = skin_cut.map(|skin_cut| Arc::new(skin_cut.of(fragment)));
        let labels = observer.stage(Stage::Labels);
        let struck = StruckFragment { body, cutting: cutting(body, surface), old, label, parent };
        let domain = ChildDomain::of(struck, sources.fields[cells.struck].lift(), cells);
        Children { prepared, struck, domain, skin, sources, cells }.meshes(labels, scratch)
    })
}

/// Inputs of the children's meshes.
struct Children<'a> {
    /// The object that the fragment was part of.
    prepared: &'a PreparedObject,
    struck: StruckFragment<'a>,
    domain: ChildDomain<'a>,
    /// Skin of the fragment, if the request asks for skins.
    skin: Option<Arc<Skin>>,
    sources: MeshSources<'a>,
    cells: &'a BodyCells,
}

impl Children<'_> {
    fn meshes(
        &self,
        begun: StageSpan<'_>,
        workspace: &mut TessellationWorkspace,
    ) -> Result<FractureMeshes, FractureError> {
        // The children count as fragments of the original object.
        let context = RequestContext { prepared: self.prepared, ..self.sources.context };
        let RequestContext { request, observer, .. } = context;
        let mut cut = self.sources.spare.take();
        let children = self.label(&mut cut);
        begun.produced(&cut.components.labels);
        let tessellation = observer.stage(Stage::Tessellation);
        let RetainedBody { body, labels, points, .. } = self.struck.old;
        let old = EarlierCracks { labels, points };
        let of_fragment = self.sites_of(&cut.components.sites);
        let fixed = seam(self.domain.mesh, self.domain.topology, old, &cut.components.labels, self.sites(&of_fragment));
        self.tessellate(&mut cut, children, fixed, workspace)?;
        tessellation.produced(cut.tessellation.runs());
        let fragments = observer.stage(Stage::Fragments);
        if request.effects.has(EffectKind::Slivers) {
            let slivers = observer.effect(EffectKind::Slivers);
            let least = slivers::least_volume(context);
            slivers.produced_bytes(self.merge_slivers(least, &mut cut, workspace)?);
        } else {
            self.merge_slivers(slivers::flat_volume(self.prepared), &mut cut, workspace)?;
        }
        fragments.produced(&cut.measured);
        let meshes = cut.into_pieces(*body, self.sources.spare, |site| self.sources.energy_j_m2(self.cells, site));
        let mut velocities = Vec::new();
        if request.effects.has(EffectKind::Release) {
            let release = observer.effect(EffectKind::Release);
            velocities = self.velocities(&meshes);
            release.produced(&velocities);
        }
        let mut meshes = FractureMeshes::of(vec![meshes], velocities, Vec::new(), context)?;
        if request.effects.has(EffectKind::Skin) {
            let of_fragment = self.sites_of(&meshes.bodies[0].sites);
            let sites = self.sites(&of_fragment);
            meshes = meshes.with_skins(self.skin.as_ref(), &[Some(sites)], context)?;
        }
        meshes.with_hulls(&[self.domain.mesh], context)
    }

    /// The sites of the diagram on the nodes of the body.
    fn sites<'b>(&'b self, of_fragment: &'b [u32]) -> BisectorSites<'b> {
        BisectorSites { lift: &self.domain.lift, coordinates: &self.cells.diagram.sites, of_fragment, of_node: None }
    }

    /// Velocities of the children.
    fn velocities(&self, children: &BodyMeshes) -> Vec<ReleaseVelocity> {
        let StruckFragment { body, parent, .. } = self.struck;
        let own = &parent.prepared.bodies[0].crack;
        let of_nodes = match parent.is_of_nodes {
            true => Cow::Borrowed(children.labels.as_slice()),
            false => lattice_labels(body, self.sources.context.request.surface, &children.labels),
        };
        let labels: Vec<u32> = parent.nodes.iter().map(|&node| of_nodes[node as usize]).collect();
        let (field, energy_j) = (self.sources.fields.first(), self.sources.energies[0].energy_j);
        let density = self.prepared.parameters.material.density_kg_m3;
        release_velocity::velocities(&children.properties, &labels, own, field, energy_j, density, &self.prepared.frame)
    }

    /// Labels the whole body, children first and other fragments after them. Returns the number of children.
    fn label(&self, cut: &mut CutBuffers) -> usize {
        let sites = self.cells.diagram.count() as u32;
        let label = |(&site, &old): (&u32, &u32)| if site == NO_REPRESENTATIVE { sites + old } else { site };
        let labels: Vec<u32> = self.domain.sites.iter().zip(&self.struck.old.labels).map(label).collect();
        cut.components.split(self.domain.topology, &labels);
        cut.components.sites.partition_point(|site| *site < sites)
    }

    /// Site of every fragment; 0 for other fragments, whose site is never read.
    fn sites_of(&self, sites: &[u32]) -> Vec<u32> {
        let count = self.cells.diagram.count() as u32;
        sites.iter().map(|&site| if site < count { site } else { 0 }).collect()
    }

    /// Computes the crack points that are not fixed, builds all fragments, keeps only the children, and measures them.
    fn tessellate(
        &self,
        cut: &mut CutBuffers,
        children: usize,
        mut fixed: FixedPoints,
        workspace: &mut TessellationWorkspace,
    ) -> Result<(), FractureError> {
        let of_fragment = self.sites_of(&cut.components.sites);
        let sites = self.sites(&of_fragment);
        let (ChildDomain { mesh, topology, .. }, StruckFragment { old, label, .. }) = (&self.domain, self.struck);
        let volume = old.volumes[label as usize];
        for turn in 1.. {
            cut.points.find(mesh, topology, &cut.components.labels, Some(sites), &fixed)?;
            cut.tessellation.build(mesh, topology, &cut.components.labels, &cut.points, workspace)?;
            cut.tessellation.keep_first(children);
            properties(&cut.tessellation, &mut cut.measured);
            let missing = volume - cut.measured.iter().map(|child| child.volume).sum::<f64>();
            let far = missing.abs() > VOLUME_ERROR * volume && turn < TESSELLATIONS_MAX;
            if !(far && correct_volume(&mut fixed, &old.points, mesh, topology, &cut.tessellation, missing)) {
                break;
            }
        }
        Ok(())
    }

    /// Merges children smaller than `least` and tessellates again if there were any. Returns the size of the new labels in
    /// bytes.
    fn merge_slivers(
        &self,
        least: f64,
        cut: &mut CutBuffers,
        workspace: &mut TessellationWorkspace,
    ) -> Result<u64, FractureError> {
        let before = cut.components.sites.len();
        if !slivers::merge(&mut cut.components, &cut.tessellation, &cut.measured, least) {
            return Ok(0);
        }
        let children = cut.measured.len() - (before - cut.components.sites.len());
        let fixed = cut.points.to_fixed();
        self.tessellate(cut, children, fixed, workspace)?;
        Ok(size_of_val(cut.components.labels.as_slice()) as u64)
    }
}
