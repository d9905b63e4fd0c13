//! Attributes of outer runs on the mesh of the input surface: exactly those of the input, on both sides of every seam.

use super::vertex_attributes::VertexAttribute;
use crate::cutting::{CuttingMesh, OuterCorners};
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::surface::barycentric;
use crate::tessellation::{OuterCopies, OuterVertex, Tessellation, Topology, outer_sources, outer_vertices};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Marks a missing index.
const NONE: u32 = u32::MAX;

/// Attributes of one fragment's outer run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::pipeline) struct OuterRunAttributes {
    /// Attributes of its vertices.
    pub vertices: Vec<VertexAttribute>,
    /// Materials of its triangles; empty if the input has none.
    pub materials: Vec<u32>,
}

/// Corners of boundary faces whose attributes determine those of a vertex.
type Corners = [u32; 2];

/// One body, its fragments, and the attributes of its boundary.
struct OuterRuns<'a> {
    cutting: &'a CuttingMesh,
    outer: &'a OuterCorners,
    tessellation: &'a Tessellation,
    origins: Vec<Vec<OuterVertex>>,
    sources: Vec<Vec<u32>>,
}

/// The attributes of the outer runs of `pieces`, by fragment. Vertices on seams are copied.
pub(in crate::pipeline) fn outer_attributes(
    pieces: &mut BodyMeshes,
    cutting: &CuttingMesh,
    outer: &OuterCorners,
) -> Vec<OuterRunAttributes> {
    let (topology, fragments) = (&cutting.topology, pieces.tessellation.fragments().len());
    let runs = OuterRuns {
        cutting,
        outer,
        tessellation: &pieces.tessellation,
        origins: outer_vertices(topology, &pieces.labels, &pieces.points, fragments),
        sources: outer_sources(topology, &pieces.labels, fragments),
    };
    let found = (0..fragments).into_par_iter().map(|fragment| runs.of(fragment));
    let (attributes, copies): (Vec<OuterRunAttributes>, Vec<OuterCopies>) = found.unzip();
    pieces.tessellation.copy_outer(&copies);
    attributes
}

impl OuterRuns<'_> {
    fn of(&self, fragment: usize) -> (OuterRunAttributes, OuterCopies) {
        let (origins, sources) = (&self.origins[fragment], &self.sources[fragment]);
        let mut attributes = OuterRunAttributes::default();
        let mut copies = OuterCopies::default();
        let runs = &self.tessellation.runs()[self.tessellation.fragments()[fragment].runs.clone()];
        let Some(run) = runs.first().filter(|run| !run.crack) else { return (attributes, copies) };
        if !self.outer.materials.is_empty() {
            attributes.materials = sources.iter().map(|&face| self.outer.materials[face as usize]).collect();
        }
        attributes.vertices.resize(origins.len(), VertexAttribute::default());
        let mut first: Vec<Corners> = vec![[NONE; 2]; origins.len()];
        let mut others: HashMap<(u32, Corners), u32> = HashMap::new();
        for (triangle, (vertices, &face)) in self.tessellation.run_triangles(run).zip(sources).enumerate() {
            for (corner, &vertex) in vertices.iter().enumerate() {
                let origin = &origins[vertex as usize];
                let corners = self.corners(origin, face as usize);
                let known = &mut first[vertex as usize];
                if *known == corners {
                    continue;
                }
                if *known == [NONE; 2] {
                    *known = corners;
                    attributes.vertices[vertex as usize] = self.at(origin, face as usize);
                    continue;
                }
                let copy = *others.entry((vertex, corners)).or_insert_with(|| {
                    copies.vertices.push(vertex);
                    attributes.vertices.push(self.at(origin, face as usize));
                    attributes.vertices.len() as u32 - 1
                });
                copies.corners.push((triangle as u32, corner as u8, copy));
            }
        }
        (attributes, copies)
    }

    /// The corners of boundary face `face` that determine the attributes of a vertex on it.
    fn corners(&self, origin: &OuterVertex, face: usize) -> Corners {
        let corners = &self.outer.corners[face];
        let of = |node: u32| self.corner(face, node).map_or(NONE - 1, |corner| corners[corner]);
        match *origin {
            OuterVertex::Node(node) => [of(node), NONE],
            OuterVertex::Edge(edge, _) => self.topology().edges[edge as usize].map(of),
            OuterVertex::Face(..) => corners[..2].try_into().unwrap_or([NONE - 1; 2]),
        }
    }

    fn topology(&self) -> &Topology {
        &self.cutting.topology
    }

    /// Corner of boundary face `face` at a node.
    fn corner(&self, face: usize, node: u32) -> Option<usize> {
        self.topology().boundary[face].nodes.iter().position(|own| *own == node)
    }

    /// The attributes of a vertex on boundary face `face`.
    fn at(&self, origin: &OuterVertex, face: usize) -> VertexAttribute {
        let node = |node: u32| self.cutting.mesh.nodes[node as usize];
        let mut weights = [0.0; 3];
        match *origin {
            OuterVertex::Node(node) => {
                if let Some(corner) = self.corner(face, node) {
                    let (normals, uvs) = (&self.outer.normals, &self.outer.uvs);
                    let own = self.outer.corners[face][corner] as usize;
                    return VertexAttribute { normal: normals[own], uv: uvs.get(own).copied().unwrap_or_default() };
                }
            }
            OuterVertex::Edge(edge, place) => {
                let ends = self.topology().edges[edge as usize];
                let [a, b] = ends.map(node);
                let share = (place - a).dot(&(b - a)) / (b - a).norm_squared();
                for (end, weight) in ends.into_iter().zip([1.0 - share, share]) {
                    if let Some(corner) = self.corner(face, end) {
                        weights[corner] = weight;
                    }
                }
            }
            OuterVertex::Face(_, place) => {
                weights = barycentric(&self.topology().boundary[face].nodes.map(node), &place);
            }
        }
        self.blended(self.outer.corners[face], weights)
    }

    fn blended(&self, corners: [u32; 3], weights: [f64; 3]) -> VertexAttribute {
        let OuterCorners { normals, uvs, .. } = self.outer;
        let sum = |of: &dyn Fn(usize) -> f32| -> f64 {
            corners.iter().zip(weights).map(|(&corner, weight)| f64::from(of(corner as usize)) * weight).sum()
        };
        let normal = Vector3::from([0, 1, 2].map(|axis| sum(&|own| normals[own][axis])));
        let first = Vector3::from(normals[corners[0] as usize]).cast();
        let normal = normal.try_normalize(0.0).unwrap_or(first).map(|x| x as f32).into();
        let uv = |axis: usize| sum(&|own| uvs.get(own).map_or(0.0, |uv| uv[axis])) as f32;
        VertexAttribute { normal, uv: [uv(0), uv(1)] }
    }
}
