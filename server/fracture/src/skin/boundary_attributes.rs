//! Attributes of the input on the boundary of a lattice. Each boundary node and triangle takes those of the nearest
//! input point.

use super::walls::APART;
use super::{AttributeKinds, PointAttributeLists, PointAttributes, Skin, blended};
use crate::lattice::{Lattice, area_vector};
use crate::memory::held;
use crate::surface::{NO_MATERIAL, NearestTriangles};
use crate::tessellation::Topology;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Attributes of the boundary of one body's lattice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoundaryAttributes {
    /// Attributes of [`Topology::boundary_nodes`].
    pub points: PointAttributeLists,
    /// Materials of [`Topology::boundary`]; empty if the file has none.
    pub materials: Vec<u32>,
}

impl BoundaryAttributes {
    /// The attributes of `skin` on the boundaries of these lattices, by body. `spacing`: that of the lattices, local.
    pub fn of(skin: &Skin, bodies: &[(&Lattice, &Topology)], spacing: f64) -> Vec<Self> {
        let corners: Vec<[Point3<f64>; 3]> = (0..skin.triangles.len()).map(|triangle| skin.corners(triangle)).collect();
        let nearest = NearestTriangles::new(&corners);
        let kinds: AttributeKinds = skin.attributes.kinds();
        let look = |lattice: &Lattice, topology: &Topology| {
            let normals = own_normals(lattice, topology);
            let node = |node: &u32| {
                let place = &lattice.nodes[*node as usize];
                match nearest.distance(place) > APART * spacing {
                    // The wall of an existing crack has no counterpart in the input.
                    true => PointAttributes::plain(normals[*node as usize]),
                    false => look(skin, nearest.to(place)),
                }
            };
            let attributes: Vec<PointAttributes> = topology.boundary_nodes.par_iter().map(node).collect();
            let face = |nodes: [u32; 3]| {
                let middle = nodes.iter().map(|&node| lattice.nodes[node as usize].coords).sum::<Vector3<f64>>() / 3.0;
                let middle = Point3::from(middle);
                if nearest.distance(&middle) > APART * spacing {
                    NO_MATERIAL
                } else {
                    skin.materials[nearest.to(&middle).0]
                }
            };
            let materials = match skin.materials.is_empty() {
                true => Vec::new(),
                false => topology.boundary.par_iter().map(|outer| face(outer.nodes)).collect(),
            };
            let mut points = PointAttributeLists::default();
            attributes.iter().for_each(|own| points.push(own, kinds));
            Self { points, materials }
        };
        bodies.iter().map(|(lattice, topology)| look(lattice, topology)).collect()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { points, materials } = self;
        points.bytes() + held(materials)
    }
}

/// Normals by node; arbitrary off the boundary.
fn own_normals(lattice: &Lattice, topology: &Topology) -> Vec<[f32; 3]> {
    let mut sums = vec![Vector3::zeros(); lattice.nodes.len()];
    for face in &topology.boundary {
        let area = area_vector(&face.nodes.map(|node| lattice.nodes[node as usize]));
        face.nodes.iter().for_each(|&node| sums[node as usize] += area);
    }
    sums.iter().map(|sum| sum.try_normalize(0.0).unwrap_or(Vector3::z()).map(|x| x as f32).into()).collect()
}

/// Attributes at a point of a triangle.
fn look(skin: &Skin, (triangle, weights): (usize, [f64; 3])) -> PointAttributes {
    let corners = skin.triangles[triangle].map(|vertex| skin.attributes.get(vertex as usize));
    let mean = |of: &dyn Fn(usize) -> f32| (0..3).map(|k| f64::from(of(k)) * weights[k]).sum::<f64>();
    let normal = Vector3::from([0, 1, 2].map(|axis| mean(&|k| corners[k].normal[axis])));
    let normal = normal.try_normalize(0.0).unwrap_or(Vector3::z()).map(|x| x as f32);
    PointAttributes { normal: normal.into(), ..blended(corners, weights) }
}
