//! Walls of the slots of existing cracks, which are not part of the input's surface.

use super::{AttributeKinds, PointAttributes, Skin, SkinPoint};
use crate::lattice::{Lattice, LatticePoint, area_vector};
use crate::surface::{NO_MATERIAL, NearestTriangles};
use crate::tessellation::Topology;
use nalgebra::{Point3, Vector3};

/// Distance from the input, in spacings, beyond which a face of the lattice's boundary is not part of the input's
/// surface.
pub(super) const APART: f64 = 0.5;

impl Skin {
    /// Adds the faces of the lattices' boundaries that are not part of the input's surface: the walls of existing cracks.
    ///
    /// They have no material, flat normals, zero texture coordinates, and white as color.
    #[must_use]
    pub fn with_walls(mut self, bodies: &[(&Lattice, &Topology)], spacing: f64) -> Self {
        let corners: Vec<[Point3<f64>; 3]> = (0..self.triangles.len()).map(|triangle| self.corners(triangle)).collect();
        let (nearest, kinds) = (NearestTriangles::new(&corners), self.attributes.kinds());
        for (body, (lattice, topology)) in bodies.iter().enumerate() {
            for face in &topology.boundary {
                let corners = face.nodes.map(|node| lattice.nodes[node as usize]);
                let middle = Point3::from(corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 3.0);
                if nearest.distance(&middle) > APART * spacing {
                    let places = face.nodes.map(|node| corner(lattice, face.tet, node));
                    self.add(corners, places.map(|place| SkinPoint { body: body as u32, place }), kinds);
                }
            }
        }
        self
    }

    fn add(&mut self, corners: [Point3<f64>; 3], spots: [SkinPoint; 3], kinds: AttributeKinds) {
        let (point, vertex) = (self.points.len() as u32, self.vertices.len() as u32);
        let area = area_vector(&corners);
        let normal = area.try_normalize(0.0).unwrap_or(Vector3::z()).map(|x| x as f32).into();
        self.points.extend(corners);
        self.spots.extend(spots);
        self.vertices.extend([0, 1, 2].map(|k| point + k));
        (0..3).for_each(|_| self.attributes.push(&PointAttributes::plain(normal), kinds));
        self.triangles.push([vertex, vertex + 1, vertex + 2]);
        if !self.materials.is_empty() {
            self.materials.push(NO_MATERIAL);
        }
    }
}

/// A node of a tetrahedron as a lattice point.
fn corner(lattice: &Lattice, tet: u32, node: u32) -> LatticePoint {
    let nodes = lattice.tets[tet as usize];
    LatticePoint { tet, barycentric: nodes.map(|own| if own == node { 1.0 } else { 0.0 }) }
}
