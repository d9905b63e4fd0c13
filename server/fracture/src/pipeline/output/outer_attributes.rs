//! Attributes of outer runs, from those at the corners of the boundary: one set per node on a lattice, one per side of a
//! seam on a mesh of the input surface.

use super::cut_domain::cutting;
use crate::cutting::OuterCorners;
use crate::lattice::Lattice;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedBody;
use crate::pipeline::prepared::parameters::SurfaceKind;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::scene::EffectKind;
use crate::skin::{AttributeKinds, BoundaryAttributes, PointAttributeLists, PointAttributes, blended};
use crate::surface::barycentric;
use crate::tessellation::{OuterCopies, OuterVertex, Tessellation, Topology, outer_sources, outer_vertices};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;

/// Marks a missing index.
const NONE: u32 = u32::MAX;

/// Attributes of one fragment's outer run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::pipeline) struct OuterRunAttributes {
    /// Attributes of its vertices.
    pub vertices: PointAttributeLists,
    /// Materials of its triangles; empty if the input has none.
    pub materials: Vec<u32>,
}

/// Boundary of the mesh on which one body is cut, with attributes at the corners of its faces.
struct AttributedBoundary<'a> {
    mesh: &'a Lattice,
    topology: &'a Topology,
    points: &'a PointAttributeLists,
    kinds: AttributeKinds,
    materials: &'a [u32],
    /// Index of the attributes at each corner of [`Topology::boundary`].
    corners: Cow<'a, [[u32; 3]]>,
}

impl<'a> AttributedBoundary<'a> {
    fn of(body: &'a PreparedBody, surface: SurfaceKind) -> Option<Self> {
        if let Some(cutting) = cutting(body, surface) {
            let OuterCorners { points, corners, materials } = cutting.outer.as_ref()?;
            let (mesh, topology, corners) = (&cutting.mesh, &cutting.topology, Cow::Borrowed(corners.as_slice()));
            return Some(Self { mesh, topology, points, kinds: points.kinds(), materials, corners });
        }
        let BoundaryAttributes { points, materials } = body.outer.as_ref()?;
        let topology = &body.topology;
        let mut places = vec![NONE; topology.nodes];
        for (place, &node) in topology.boundary_nodes.iter().enumerate() {
            places[node as usize] = place as u32;
        }
        let corners = topology.boundary.iter().map(|face| face.nodes.map(|node| places[node as usize])).collect();
        let (mesh, kinds, corners) = (&body.crack, points.kinds(), Cow::Owned(corners));
        Some(Self { mesh, topology, points, kinds, materials, corners })
    }

    /// Index of the attributes at a node of boundary face `face`; [`NONE`] if it is no corner of it.
    fn corner(&self, face: usize, node: u32) -> u32 {
        let nodes = &self.topology.boundary[face].nodes;
        nodes.iter().position(|own| *own == node).map_or(NONE, |corner| self.corners[face][corner])
    }

    /// Indices that determine the attributes of a vertex on boundary face `face`: equal ones on one side of a seam.
    fn side(&self, origin: &OuterVertex, face: usize) -> [u32; 2] {
        match *origin {
            OuterVertex::Node(node) => [self.corner(face, node), NONE],
            OuterVertex::Edge(edge, _) => self.topology.edges[edge as usize].map(|node| self.corner(face, node)),
            // Such a vertex lies on one face.
            OuterVertex::Face(..) => [NONE - 1; 2],
        }
    }

    /// The attributes of a vertex on boundary face `face`.
    fn at(&self, origin: &OuterVertex, face: usize) -> PointAttributes {
        let place = |node: u32| self.mesh.nodes[node as usize];
        match *origin {
            OuterVertex::Node(node) => self.mean(face, [node], [1.0]),
            OuterVertex::Edge(edge, point) => {
                let nodes = self.topology.edges[edge as usize];
                let [a, b] = nodes.map(place);
                let share = (point - a).dot(&(b - a)) / (b - a).norm_squared();
                self.mean(face, nodes, [1.0 - share, share])
            }
            OuterVertex::Face(own, point) => {
                let nodes = self.topology.faces[own as usize];
                self.mean(face, nodes, barycentric(&nodes.map(place), &point))
            }
        }
    }

    fn mean<const N: usize>(&self, face: usize, nodes: [u32; N], weights: [f64; N]) -> PointAttributes {
        blended(nodes.map(|node| self.points.get(self.corner(face, node) as usize)), weights)
    }
}

/// The attributes of the outer runs of `pieces`, fragments of `body`, by fragment. Vertices on seams are copied.
///
/// # Errors
/// [`FractureError::AttributesUnprepared`] for `effect`.
pub(in crate::pipeline) fn outer_attributes(
    pieces: &mut BodyMeshes,
    body: &PreparedBody,
    surface: SurfaceKind,
    effect: EffectKind,
) -> Result<Vec<OuterRunAttributes>, FractureError> {
    let boundary = AttributedBoundary::of(body, surface).ok_or(FractureError::AttributesUnprepared { effect })?;
    let fragments = pieces.tessellation.fragments().len();
    let origins = outer_vertices(boundary.topology, &pieces.labels, &pieces.points, fragments);
    let sources = outer_sources(boundary.topology, &pieces.labels, fragments);
    let own = (0..fragments).into_par_iter();
    let found = own.map(|k| of_fragment(&boundary, &pieces.tessellation, k, &origins[k], &sources[k]));
    let (attributes, copies): (Vec<OuterRunAttributes>, Vec<OuterCopies>) = found.unzip();
    pieces.tessellation.copy_outer(&copies);
    Ok(attributes)
}

/// The attributes of one fragment's outer run, and the copies of its vertices on seams. `origins`: places of its vertices;
/// `sources`: boundary face of each of its triangles.
fn of_fragment(
    boundary: &AttributedBoundary<'_>,
    tessellation: &Tessellation,
    fragment: usize,
    origins: &[OuterVertex],
    sources: &[u32],
) -> (OuterRunAttributes, OuterCopies) {
    let (mut attributes, mut copies) = (OuterRunAttributes::default(), OuterCopies::default());
    let runs = &tessellation.runs()[tessellation.fragments()[fragment].runs.clone()];
    let Some(run) = runs.first().filter(|run| !run.crack) else { return (attributes, copies) };
    if !boundary.materials.is_empty() {
        attributes.materials = sources.iter().map(|&face| boundary.materials[face as usize]).collect();
    }
    let mut points = vec![PointAttributes::default(); origins.len()];
    let mut first = vec![[NONE; 2]; origins.len()];
    let mut others: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
    for (triangle, (vertices, &face)) in tessellation.run_triangles(run).zip(sources).enumerate() {
        for (corner, &vertex) in vertices.iter().enumerate() {
            let origin = &origins[vertex as usize];
            let side = boundary.side(origin, face as usize);
            let known = &mut first[vertex as usize];
            if *known == [NONE; 2] {
                *known = side;
                points[vertex as usize] = boundary.at(origin, face as usize);
            } else if *known != side {
                let copy = *others.entry((vertex, side)).or_insert_with(|| {
                    copies.vertices.push(vertex);
                    points.push(boundary.at(origin, face as usize));
                    points.len() as u32 - 1
                });
                copies.corners.push((triangle as u32, corner as u8, copy));
            }
        }
    }
    points.iter().for_each(|own| attributes.vertices.push(own, boundary.kinds));
    (attributes, copies)
}
