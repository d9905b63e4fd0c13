//! Attributes of the input at the corners of a cutting mesh's boundary. On a seam, a node has one set for each side.

use crate::conforming::{ConformingMesh, SurfacePlace};
use crate::memory::held;
use crate::skin::{RefinedCorner, blended, surface_corners};
use crate::surface::Surface;
use crate::tessellation::OuterFace;
use std::collections::HashMap;

/// Normals, texture coordinates and materials of the boundary of one body's cutting mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OuterCorners {
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one per normal; empty if the input has none.
    pub uvs: Vec<[f32; 2]>,
    /// Index of the normal at each corner of [`Topology::boundary`](crate::tessellation::Topology::boundary).
    pub corners: Vec<[u32; 3]>,
    /// Material of each triangle of the boundary; empty if the input has none.
    pub materials: Vec<u32>,
}

impl OuterCorners {
    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { normals, uvs, corners, materials } = self;
        held(normals) + held(uvs) + held(corners) + held(materials)
    }
}

/// Attributes of the input surface, found by the triangles of a conforming mesh's boundary.
pub(super) struct SurfaceAttributes<'a> {
    surface: &'a Surface,
    places: &'a [SurfacePlace],
    corners: Vec<[RefinedCorner; 3]>,
    /// Triangle of the surface, and its vertices as the mesher knew them, by the nodes of a boundary triangle, ascending.
    sources: HashMap<[u32; 3], (u32, [u32; 3])>,
}

impl<'a> SurfaceAttributes<'a> {
    /// The attributes of `surface` on the boundary of `mesh`. `triangles` are those that were meshed, and `sources` their
    /// numbers in `surface`.
    pub fn new(surface: &'a Surface, mesh: &'a ConformingMesh, triangles: &[[u32; 3]], sources: &[u32]) -> Self {
        let source = |(nodes, &meshed): (&[u32; 3], &u32)| {
            (ascending(*nodes), (sources[meshed as usize], triangles[meshed as usize]))
        };
        Self {
            surface,
            places: &mesh.places,
            corners: surface_corners(surface),
            sources: mesh.boundary.iter().zip(&mesh.boundary_sources).map(source).collect(),
        }
    }

    /// The attributes of a body's boundary. `names`: node of the conforming mesh for each node of the body's mesh.
    pub fn of(&self, boundary: &[OuterFace], names: &[u32]) -> OuterCorners {
        let (materials, uvs) = (&self.surface.attributes.materials, &self.surface.attributes.uvs);
        let mut outer = OuterCorners::default();
        let mut known: HashMap<(u32, [u32; 3], [u32; 2]), u32> = HashMap::new();
        for face in boundary {
            let nodes = face.nodes.map(|node| names[node as usize]);
            let Some(&(source, vertices)) = self.sources.get(&ascending(nodes)) else { continue };
            let corner = |node: u32| {
                let (normal, uv) = self.at(node, source, vertices);
                *known.entry((node, normal.map(f32::to_bits), uv.map(f32::to_bits))).or_insert_with(|| {
                    outer.normals.push(normal);
                    if !uvs.is_empty() {
                        outer.uvs.push(uv);
                    }
                    outer.normals.len() as u32 - 1
                })
            };
            outer.corners.push(nodes.map(corner));
            outer.materials.extend(materials.get(source as usize));
        }
        outer
    }

    /// Normal and texture coordinates of triangle `source` at a boundary node.
    fn at(&self, node: u32, source: u32, vertices: [u32; 3]) -> ([f32; 3], [f32; 2]) {
        let place = &self.places[node as usize];
        let weight = |vertex: u32| {
            let own = place.vertices.iter().zip(place.weights).filter(|(other, _)| **other == vertex);
            own.map(|(_, weight)| weight).sum::<f64>()
        };
        let (corners, weights) = (&self.corners[source as usize], vertices.map(weight));
        match corners.iter().zip(weights).find(|(_, weight)| *weight == 1.0) {
            Some((corner, _)) => (corner.normal, corner.uv),
            None => blended(corners.map(|corner| (corner.normal, corner.uv)), weights),
        }
    }
}

fn ascending(mut nodes: [u32; 3]) -> [u32; 3] {
    nodes.sort_unstable();
    nodes
}
