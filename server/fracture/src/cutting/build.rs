//! Cutting meshes of all bodies, from the input surface and the interior nodes of the crack lattices.

use super::edge_defects::EdgeDefects;
use super::films::FilledSurface;
use super::meshed_surface::MeshedSurface;
use super::outer_corners::SurfaceAttributes;
use super::short_edges::{LENGTH_MIN, collapse};
use super::surface_repair::{RepairKind, SurfaceRepair};
use super::united::{PAIRS_MAX, UnitedSurface, united};
use super::{CuttingMesh, carriers};
use crate::cancel_token::{CancelToken, Canceled};
use crate::conforming::{
    ConformingError, ConformingMesh, ConformingOptions, ConformingStep, conforming_mesh, hilbert_order,
};
use crate::lattice::{Lattice, NonManifold, check_manifold};
use crate::scene::counted;
use crate::surface::{InsideTest, LocalFrame};
use crate::tessellation::Topology;
use nalgebra::Point3;
use std::mem::take;

/// Distance of interior nodes from the surface, in spacings of the crack lattice.
const DEPTH: f64 = 0.5;

/// Reason why an object has no cutting meshes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CuttingError {
    /// The work was canceled.
    #[error(transparent)]
    Canceled(#[from] Canceled),
    /// The mesher refused the surface, or did not finish within its limits.
    #[error("{error}")]
    Mesh {
        /// Defect or limit; its coordinates and indices are those of the mesher.
        error: ConformingError,
        /// Coordinates of the defect on the surface, local.
        at: Option<Point3<f64>>,
    },
    /// The surface is not closed.
    #[error("the mesh is not closed, at {}", counted(.0.groups as u64, "place"))]
    NotClosed(EdgeDefects),
    /// More triangles of the surface cross than are resolved.
    #[error(
        "{pairs} pairs of triangles cross, and at most {PAIRS_MAX} are resolved; unite the parts of the mesh and bake again"
    )]
    Crossings {
        /// Number of pairs.
        pairs: usize,
    },
    /// The surface has other parts than the crack lattices.
    #[error(
        "the surface and the lattice fall into different numbers of parts: {parts} and {bodies}; a finer preset may keep them {}",
        if parts < bodies { "together" } else {
            "apart, or find those that are smaller than a cell; parts that touch without common triangles have to be united \
             in the mesh"
        }
    )]
    Parts {
        /// Separate parts of the mesh.
        parts: usize,
        /// Bodies of the lattice.
        bodies: usize,
    },
    /// A part of the mesh has no node of the crack lattice inside, or none of a body's nodes is deep enough.
    #[error("body {body} has a part that is too thin for the lattice")]
    Unreached {
        /// Index of the body.
        body: usize,
    },
    /// The boundary of the mesh is no closed surface.
    #[error("body {body}: {source}")]
    NonManifold {
        /// Index of the body.
        body: usize,
        /// Defect of the boundary.
        source: NonManifold,
    },
}

impl CuttingError {
    /// The reason in words, with the place of the defect in the coordinates of `frame`, and the remedy.
    pub fn reason(&self, frame: &LocalFrame) -> String {
        let reason = match self {
            Self::Mesh { error, .. } => match error {
                ConformingError::NonManifoldVertex { .. } => "parts of the mesh touch in one vertex".to_owned(),
                ConformingError::SelfIntersection { .. } => "triangles of the mesh intersect or touch".to_owned(),
                ConformingError::DuplicatePoint { .. } => "two vertices of the mesh have one position".to_owned(),
                ConformingError::PointOnSurface { .. } => "the mesh touches itself".to_owned(),
                ConformingError::WrongOrientation { .. } => "shells of the mesh lie in one another".to_owned(),
                ConformingError::Unrecovered { .. } => "edges or triangles could not be kept".to_owned(),
                other => other.to_string(),
            },
            other => other.to_string(),
        };
        match self {
            Self::Mesh { at: Some(at), .. } => {
                let at = frame.to_meters(at);
                format!("{reason} near ({:.4}, {:.4}, {:.4}) m; mend the mesh there and bake again", at.x, at.y, at.z)
            }
            Self::NotClosed(edges) => {
                format!("{}; mend the mesh there and bake again", edges.describe(|place| frame.to_meters(place)))
            }
            _ => reason,
        }
    }
}

/// Nodes of the crack lattices that are deep enough inside the surface.
struct InteriorNodes {
    points: Vec<Point3<f64>>,
    /// Body and node of each point.
    sources: Vec<(usize, u32)>,
}

impl InteriorNodes {
    fn of(inside: &InsideTest, cracks: &[&Lattice], spacing: f64) -> Self {
        let (mut points, mut sources) = (Vec::new(), Vec::new());
        for (body, crack) in cracks.iter().enumerate() {
            let distances = inside.signed_distances(&crack.nodes);
            for (node, place) in crack.nodes.iter().enumerate().filter(|(node, _)| distances[*node] <= -DEPTH * spacing)
            {
                points.push(*place);
                sources.push((body, node as u32));
            }
        }
        Self { points, sources }
    }

    /// The first of `bodies` without a node here.
    fn missing(&self, bodies: usize) -> Option<usize> {
        (0..bodies).find(|body| self.sources.iter().all(|(own, _)| own != body))
    }
}

/// Cutting meshes of all bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct CuttingMeshes {
    /// Meshes, one per body.
    pub meshes: Vec<CuttingMesh>,
    /// Largest distance of a boundary node from the input surface, local.
    pub deviation: f64,
    /// Number of edges of the input that were too short for single precision and were collapsed.
    pub collapsed_edges: u64,
    /// Repairs of the surface.
    pub repairs: Vec<SurfaceRepair>,
}

/// Cutting meshes of the bodies whose crack lattices are `cracks`, in the same order, which end on the surface `filled`.
/// `spacing`: that of the lattices, local. `has_attributes`: whether the attributes of the surface are added.
///
/// # Errors
/// [`CuttingError`] if the surface does not conform or `token` cancels. The fragments then have the lattice's surface.
pub fn cutting_meshes(
    filled: &FilledSurface,
    cracks: &[&Lattice],
    spacing: f64,
    has_attributes: bool,
    token: &CancelToken,
    progress: &mut dyn FnMut(ConformingStep),
) -> Result<CuttingMeshes, CuttingError> {
    let FilledSurface { surface, repairs, input_triangles } = filled;
    let mut repairs = repairs.clone();
    let inside = InsideTest::new(surface);
    let interior = InteriorNodes::of(&inside, cracks, spacing);
    if let Some(body) = interior.missing(cracks.len()) {
        return Err(CuttingError::Unreached { body });
    }
    let options = ConformingOptions { spacing, ..ConformingOptions::default() };
    let mut mesh = |meshed: &MeshedSurface| {
        conforming_mesh(&meshed.positions, &meshed.triangles, &interior.points, &options, token, progress)
    };
    let (meshed, mut collapsed) = collapse(MeshedSurface::new(surface, has_attributes));
    let repaired = match mesh(&meshed) {
        Ok(conforming) => Ok((meshed, conforming)),
        Err(ConformingError::Canceled(canceled)) => return Err(canceled.into()),
        Err(error) => match repaired(&meshed, &mut mesh, token)? {
            Some(RepairedSurface { united, conforming, collapsed: more }) => {
                let before = meshed;
                let UnitedSurface { meshed, crossings, hidden, divided } = united;
                let is_film = |source: &u32| *source as usize >= *input_triangles;
                let films = meshed.area(is_film);
                repairs.retain(|repair| repair.kind != RepairKind::FilledHoles || films > 0.0);
                for repair in repairs.iter_mut().filter(|repair| repair.kind == RepairKind::FilledHoles) {
                    let whole = surface.area(*input_triangles) + films;
                    *repair = repair.clone().of_area(films, whole, &surface.frame);
                }
                let (hidden, areas): (Vec<Point3<f64>>, Vec<f64>) =
                    hidden.iter().filter(|own| !is_film(&own.source)).map(|own| (own.place, own.area)).unzip();
                let hidden_area: f64 = areas.iter().sum();
                let [whole, left] = [&before, &meshed].map(|own| own.area(|source| !is_film(source)));
                let cut_area = (whole - left - hidden_area).max(0.0);
                let found = [
                    (RepairKind::UnitedParts, crossings, cut_area),
                    (RepairKind::HiddenTriangles, hidden, hidden_area),
                    (RepairKind::DividedVertices, divided, 0.0),
                ];
                for (kind, places, area) in found.iter().filter(|(_, places, _)| !places.is_empty()) {
                    let repair = SurfaceRepair::new(*kind, places, &surface.frame);
                    repairs.push(repair.of_area(*area, surface.area(*input_triangles), &surface.frame));
                }
                collapsed.extend(more);
                Ok((meshed, conforming))
            }
            None => Err(match EdgeDefects::find(&meshed.positions, &meshed.triangles) {
                Some(edges) => CuttingError::NotClosed(edges),
                None => CuttingError::Mesh { error, at: error.location(&meshed.positions, &meshed.triangles) },
            }),
        },
    };
    let (meshed, mut conforming) = repaired?;
    if !collapsed.is_empty() {
        repairs.push(SurfaceRepair::new(RepairKind::CollapsedEdges, &collapsed, &surface.frame));
    }
    let whole = Lattice { nodes: take(&mut conforming.nodes), tets: take(&mut conforming.tets) };
    let ConformingMesh { interior_sources, places, deviation, .. } = &conforming;
    let on_surface = places.len();
    let known: Vec<Option<(usize, u32)>> = (0..whole.nodes.len())
        .map(|node| node.checked_sub(on_surface).map(|own| interior.sources[interior_sources[own] as usize]))
        .collect();
    let attributes = has_attributes.then(|| SurfaceAttributes::new(surface, &meshed, &conforming));
    let parts = whole.components();
    if parts.len() != cracks.len() {
        return Err(CuttingError::Parts { parts: parts.len(), bodies: cracks.len() });
    }
    let mut meshes: Vec<Option<CuttingMesh>> = vec![None; cracks.len()];
    for (index, part) in parts.iter().enumerate() {
        token.check()?;
        let (mesh, names) = ordered_part(&whole, part);
        let known: Vec<Option<(usize, u32)>> = names.iter().map(|&node| known[node as usize]).collect();
        let found = body_mesh(mesh, &known, cracks);
        let (body, mut mesh) = found.ok_or(CuttingError::Unreached { body: index })?;
        check_manifold(&mesh.mesh).map_err(|source| CuttingError::NonManifold { body, source })?;
        mesh.outer = attributes.as_ref().map(|own| own.of(&mesh.topology.boundary, &names));
        meshes[body] = Some(mesh);
    }
    let missing = |body: usize, mesh: Option<CuttingMesh>| mesh.ok_or(CuttingError::Unreached { body });
    let meshes = meshes.into_iter().enumerate().map(|(body, mesh)| missing(body, mesh)).collect::<Result<_, _>>()?;
    let moved = if collapsed.is_empty() { 0.0 } else { LENGTH_MIN };
    Ok(CuttingMeshes { meshes, deviation: *deviation + moved, collapsed_edges: collapsed.len() as u64, repairs })
}

/// A surface after its parts were united.
struct RepairedSurface {
    united: UnitedSurface,
    conforming: ConformingMesh,
    /// Places of the edges that were collapsed then, local.
    collapsed: Vec<Point3<f64>>,
}

/// The surface after its parts were united, and its mesh; `None` if that helps not.
fn repaired(
    meshed: &MeshedSurface,
    mesh: &mut impl FnMut(&MeshedSurface) -> Result<ConformingMesh, ConformingError>,
    token: &CancelToken,
) -> Result<Option<RepairedSurface>, CuttingError> {
    if !meshed.is_balanced() {
        return Ok(None);
    }
    let united = united(meshed, token)?;
    let (meshed, collapsed) = collapse(united.meshed);
    match mesh(&meshed) {
        Ok(conforming) => {
            Ok(Some(RepairedSurface { united: UnitedSurface { meshed, ..united }, conforming, collapsed }))
        }
        Err(ConformingError::Canceled(canceled)) => Err(canceled.into()),
        Err(_) => Ok(None),
    }
}

/// The tetrahedra `part` as a mesh of their own, and the node of `whole` that each of its nodes is.
///
/// Nodes and tetrahedra follow a Hilbert curve, because neighbors are then near each other in memory, too.
fn ordered_part(whole: &Lattice, part: &[u32]) -> (Lattice, Vec<u32>) {
    let used = nodes_of(whole, part);
    let places: Vec<Point3<f64>> = used.iter().map(|&node| whole.nodes[node as usize]).collect();
    let order = hilbert_order(&places);
    let names: Vec<u32> = order.iter().map(|&node| used[node as usize]).collect();
    let mut renamed = vec![0; whole.nodes.len()];
    (0..).zip(&names).for_each(|(node, &name)| renamed[name as usize] = node);
    let renamed_tet = |tet: &u32| whole.tets[*tet as usize].map(|node| renamed[node as usize]);
    let mut tets: Vec<[u32; 4]> = part.iter().map(renamed_tet).collect();
    tets.sort_by_key(|tet| {
        let mut ascending = *tet;
        ascending.sort_unstable();
        ascending
    });
    (Lattice { nodes: order.iter().map(|&node| places[node as usize]).collect(), tets }, names)
}

/// Nodes of the tetrahedra `part`, ascending.
fn nodes_of(whole: &Lattice, part: &[u32]) -> Vec<u32> {
    let mut used = vec![false; whole.nodes.len()];
    part.iter().for_each(|&tet| whole.tets[tet as usize].iter().for_each(|&node| used[node as usize] = true));
    (0..whole.nodes.len() as u32).filter(|&node| used[node as usize]).collect()
}

/// `mesh` joined to the crack lattice of the body to which its interior nodes belong, and that body; `None` without such
/// nodes. `known`: body and node of the lattice at the same position.
fn body_mesh(mesh: Lattice, known: &[Option<(usize, u32)>], cracks: &[&Lattice]) -> Option<(usize, CuttingMesh)> {
    let body = known.iter().flatten().next()?.0;
    let known: Vec<Option<u32>> =
        known.iter().map(|known| known.filter(|(own, _)| *own == body).map(|(_, node)| node)).collect();
    let topology = Topology::new(&mesh);
    let tets = carriers::find(&mesh, cracks[body], &known, |node| topology.neighbors(node))?;
    Some((body, CuttingMesh::new(mesh, cracks[body], &tets)))
}
