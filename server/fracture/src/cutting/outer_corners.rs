//! Attributes of the input at the corners of a cutting mesh's boundary. On a seam, a node has one set for each side.

use super::meshed_surface::MeshedSurface;
use crate::conforming::{ConformingMesh, SurfacePlace};
use crate::memory::held;
use crate::skin::{AttributeKinds, PointAttributeLists, PointAttributes, blended};
use crate::surface::Surface;
use crate::tessellation::OuterFace;
use std::collections::HashMap;

/// Attributes and materials of the boundary of one body's cutting mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OuterCorners {
    /// Attributes of points, without duplicates at a node.
    pub points: PointAttributeLists,
    /// Index of the attributes at each corner of [`Topology::boundary`](crate::tessellation::Topology::boundary).
    pub corners: Vec<[u32; 3]>,
    /// Material of each triangle of the boundary; empty if the input has none.
    pub materials: Vec<u32>,
}

impl OuterCorners {
    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { points, corners, materials } = self;
        points.bytes() + held(corners) + held(materials)
    }
}

/// Attributes of the input surface, found by the triangles of a conforming mesh's boundary.
pub(super) struct SurfaceAttributes<'a> {
    surface: &'a Surface,
    meshed: &'a MeshedSurface,
    places: &'a [SurfacePlace],
    /// Triangle of `meshed` by the nodes of a boundary triangle, ascending.
    meshed_triangles: HashMap<[u32; 3], u32>,
}

impl<'a> SurfaceAttributes<'a> {
    /// The attributes on the boundary of `mesh`, which was made of `meshed`, whose triangles come from `surface`.
    pub fn new(surface: &'a Surface, meshed: &'a MeshedSurface, mesh: &'a ConformingMesh) -> Self {
        let sources = mesh.boundary.iter().zip(&mesh.boundary_sources);
        let meshed_triangles = sources.map(|(nodes, &own)| (ascending(*nodes), own)).collect();
        Self { surface, meshed, places: &mesh.places, meshed_triangles }
    }

    /// The attributes of a body's boundary. `names`: node of the conforming mesh for each node of the body's mesh.
    pub fn of(&self, boundary: &[OuterFace], names: &[u32]) -> OuterCorners {
        let (materials, kinds) = (&self.surface.attributes.materials, AttributeKinds::of(&self.surface.attributes));
        let mut outer = OuterCorners::default();
        let mut known: HashMap<(u32, [u32; 8]), u32> = HashMap::new();
        for face in boundary {
            let nodes = face.nodes.map(|node| names[node as usize]);
            let Some(&triangle) = self.meshed_triangles.get(&ascending(nodes)) else { continue };
            let source = self.meshed.sources[triangle as usize];
            let corner = |node: u32| {
                let attributes = self.at(node, triangle as usize);
                *known.entry((node, attributes.bits())).or_insert_with(|| {
                    outer.points.push(&attributes, kinds);
                    outer.points.len() as u32 - 1
                })
            };
            outer.corners.push(nodes.map(corner));
            outer.materials.extend(materials.get(source as usize));
        }
        outer
    }

    /// Attributes of a triangle at a boundary node.
    fn at(&self, node: u32, triangle: usize) -> PointAttributes {
        let place = &self.places[node as usize];
        let weight = |vertex: u32| {
            let own = place.vertices.iter().zip(place.weights).filter(|(other, _)| **other == vertex);
            own.map(|(_, weight)| weight).sum::<f64>()
        };
        let (corners, weights) = (self.meshed.corners[triangle], self.meshed.triangles[triangle].map(weight));
        match corners.iter().zip(weights).find(|(_, weight)| *weight == 1.0) {
            Some((corner, _)) => *corner,
            None => blended(corners, weights),
        }
    }
}

fn ascending(mut nodes: [u32; 3]) -> [u32; 3] {
    nodes.sort_unstable();
    nodes
}
