//! Attributes of the fragments' outer faces, taken from the input, with the effect `attributes`.

use super::outer_attributes::OuterRunAttributes;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::{PreparedBody, PreparedObject};
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::scene::EffectKind;
use crate::skin::BoundaryAttributes;
use crate::surface::{NO_MATERIAL, barycentric};
use crate::tessellation::{OuterVertex, Topology, outer_vertices};
use nalgebra::Vector3;
use std::collections::HashMap;

/// Attributes of a vertex of an outer face; zero on crack faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VertexAttribute {
    /// Unit normal.
    pub normal: [f32; 3],
    /// Texture coordinates of the input; zero if it has none.
    pub uv: [f32; 2],
}

/// Attributes of all fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexAttributes {
    /// Attributes, one per vertex of the result.
    pub vertices: Vec<VertexAttribute>,
    /// Material of the input, or [`NO_MATERIAL`], for each triangle of the result; empty if the input has none.
    pub materials: Vec<u32>,
}

impl VertexAttributes {
    /// The attributes of the outer faces of `bodies`, fragments of `prepared`.
    pub(in crate::pipeline) fn of(bodies: &[BodyMeshes], prepared: &PreparedObject) -> Result<Self, FractureError> {
        let mut attributes = Self::default();
        for pieces in bodies {
            let body = &prepared.bodies[pieces.body];
            let outer =
                body.outer.as_ref().ok_or(FractureError::AttributesUnprepared { effect: EffectKind::Attributes })?;
            BodyBoundary::new(body, outer, pieces).append_body(&mut attributes);
        }
        Ok(attributes)
    }

    /// The attributes of fragments whose outer runs have `outer`, by body and fragment.
    pub(in crate::pipeline) fn of_outer_runs(bodies: &[BodyMeshes], outer: &[Vec<OuterRunAttributes>]) -> Self {
        let mut attributes = Self::default();
        let has_materials = outer.iter().flatten().any(|own| !own.materials.is_empty());
        for (pieces, outer) in bodies.iter().zip(outer) {
            for run in pieces.tessellation.runs() {
                let own = &outer[run.fragment as usize];
                if !run.crack {
                    attributes.vertices.extend_from_slice(&own.vertices);
                    attributes.materials.extend_from_slice(&own.materials);
                    continue;
                }
                attributes.vertices.resize(attributes.vertices.len() + run.vertices.len(), VertexAttribute::default());
                if has_materials {
                    attributes.materials.resize(attributes.materials.len() + run.triangles.len(), NO_MATERIAL);
                }
            }
        }
        attributes
    }
}

/// The boundary of one body, and its fragments.
struct BodyBoundary<'a> {
    body: &'a PreparedBody,
    outer: &'a BoundaryAttributes,
    pieces: &'a BodyMeshes,
    /// Vertices of the outer run of each fragment.
    origins: Vec<Vec<OuterVertex>>,
    /// Index among the boundary's nodes, by node.
    places: Vec<u32>,
}

impl<'a> BodyBoundary<'a> {
    fn new(body: &'a PreparedBody, outer: &'a BoundaryAttributes, pieces: &'a BodyMeshes) -> Self {
        let fragments = pieces.tessellation.fragments().len();
        let origins = outer_vertices(&body.topology, &pieces.labels, &pieces.points, fragments);
        let mut places = vec![0; body.topology.nodes];
        for (place, &node) in body.topology.boundary_nodes.iter().enumerate() {
            places[node as usize] = place as u32;
        }
        Self { body, outer, pieces, origins, places }
    }

    /// Appends the attributes of this body's fragments.
    fn append_body(&self, attributes: &mut VertexAttributes) {
        let tessellation = &self.pieces.tessellation;
        let first = attributes.vertices.len();
        attributes.vertices.resize(first + tessellation.vertex_count(), VertexAttribute::default());
        tessellation.each_run(&mut attributes.vertices[first..], |run, out| {
            if !run.crack {
                let origins = &self.origins[run.fragment as usize];
                out.iter_mut().zip(origins).for_each(|(out, origin)| *out = self.vertex(origin));
            }
        });
        if self.outer.materials.is_empty() {
            return;
        }
        let faces = faces(&self.body.topology);
        for run in tessellation.runs() {
            if run.crack {
                attributes.materials.resize(attributes.materials.len() + run.triangles.len(), NO_MATERIAL);
                continue;
            }
            let origins = &self.origins[run.fragment as usize];
            let material = |triangle: [u32; 3]| {
                let nodes = self.face_of(triangle.map(|vertex| &origins[vertex as usize]));
                nodes.and_then(|nodes| faces.get(&nodes)).map_or(NO_MATERIAL, |&face| self.outer.materials[face])
            };
            attributes.materials.extend(tessellation.run_triangles(run).map(material));
        }
    }

    fn vertex(&self, origin: &OuterVertex) -> VertexAttribute {
        let topology = &self.body.topology;
        match *origin {
            OuterVertex::Node(node) => self.mean([node], [1.0]),
            OuterVertex::Edge(edge, place) => {
                let nodes = topology.edges[edge as usize];
                let [a, b] = nodes.map(|node| self.body.crack.nodes[node as usize]);
                let share = (place - a).dot(&(b - a)) / (b - a).norm_squared();
                self.mean(nodes, [1.0 - share, share])
            }
            OuterVertex::Face(face, place) => {
                let nodes = topology.faces[face as usize];
                let corners = nodes.map(|node| self.body.crack.nodes[node as usize]);
                self.mean(nodes, barycentric(&corners, &place))
            }
        }
    }

    fn mean<const N: usize>(&self, nodes: [u32; N], weights: [f64; N]) -> VertexAttribute {
        let places = nodes.map(|node| self.places[node as usize] as usize);
        let sum = |of: &dyn Fn(usize) -> f32| -> f64 { (0..N).map(|k| f64::from(of(places[k])) * weights[k]).sum() };
        let normal = Vector3::from([0, 1, 2].map(|axis| sum(&|place| self.outer.normals[place][axis])));
        let first = Vector3::from(self.outer.normals[places[0]]).cast();
        let normal = normal.try_normalize(0.0).unwrap_or(first).map(|x| x as f32).into();
        let uv = |axis: usize| sum(&|place| self.outer.uvs.get(place).map_or(0.0, |uv| uv[axis])) as f32;
        VertexAttribute { normal, uv: [uv(0), uv(1)] }
    }

    /// The nodes, ascending, of the boundary face that contains these vertices; `None` if they span several.
    fn face_of(&self, triangle: [&OuterVertex; 3]) -> Option<[u32; 3]> {
        let topology = &self.body.topology;
        let mut nodes = [0; 9];
        let mut count = 0;
        for origin in triangle {
            let own: &[u32] = match origin {
                OuterVertex::Node(node) => std::slice::from_ref(node),
                OuterVertex::Edge(edge, _) => &topology.edges[*edge as usize],
                OuterVertex::Face(face, _) => &topology.faces[*face as usize],
            };
            nodes[count..count + own.len()].copy_from_slice(own);
            count += own.len();
        }
        let nodes = &mut nodes[..count];
        nodes.sort_unstable();
        let mut unique = [0; 3];
        let mut found = 0;
        for pair in 0..count {
            if pair == 0 || nodes[pair] != nodes[pair - 1] {
                *unique.get_mut(found)? = nodes[pair];
                found += 1;
            }
        }
        (found == 3).then_some(unique)
    }
}

/// Indices of the boundary's faces by their nodes, ascending.
fn faces(topology: &Topology) -> HashMap<[u32; 3], usize> {
    let key = |outer: &crate::tessellation::OuterFace| topology.faces[outer.face as usize];
    topology.boundary.iter().enumerate().map(|(place, outer)| (key(outer), place)).collect()
}
