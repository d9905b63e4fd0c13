//! The object before it breaks: the boundaries of the meshes from which the fragments' outer faces are cut.

use super::object::PreparedObject;
use crate::fragment::RigidProperties;
use crate::surface::RawMesh;

/// One intact body.
#[derive(Clone, Debug)]
pub struct IntactBody {
    /// Boundary surface, coordinates of the mesh file, m: closed, counter-clockwise seen from outside, without
    /// duplicate vertices.
    pub mesh: RawMesh,
    /// Volume, m³.
    pub volume_m3: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Center of mass, coordinates of the mesh file, m.
    pub center_m: [f64; 3],
    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz.
    pub inertia_kg_m2: [f64; 6],
}

impl PreparedObject {
    /// All bodies, intact, in order.
    ///
    /// A host displays them until the object breaks. The fragments in their original positions look the same.
    pub fn intact(&self) -> Vec<IntactBody> {
        let bodies = self.bodies.iter().map(|body| {
            // Boundary nodes are in ascending order.
            let (mesh, topology) =
                body.cutting.as_ref().map_or((&body.crack, &body.topology), |own| (&own.mesh, &own.topology));
            let nodes = &topology.boundary_nodes;
            let vertex = |node: u32| nodes.partition_point(|own| *own < node) as u32;
            let positions_m: Vec<_> =
                nodes.iter().map(|&node| self.frame.to_meters(&mesh.nodes[node as usize])).collect();
            let triangles: Vec<[u32; 3]> = topology.boundary.iter().map(|face| face.nodes.map(vertex)).collect();
            let RigidProperties { volume, center, inertia } =
                RigidProperties::of_surface(&positions_m, triangles.iter().copied());
            let density_kg_m3 = self.parameters.material.density_kg_m3;
            let inertia = inertia * density_kg_m3;
            IntactBody {
                mesh: RawMesh::new(positions_m, triangles),
                volume_m3: volume,
                mass_kg: volume * density_kg_m3,
                center_m: center.coords.into(),
                inertia_kg_m2: [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|entry| inertia[entry]),
            }
        });
        bodies.collect()
    }
}
