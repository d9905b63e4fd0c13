//! Difference of shading normals between the result and the input.

use crate::lattice::{Lattice, area_vector};
use crate::pipeline::PreparedObject;
use crate::surface::NearestTriangles;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Shares of the area of outer faces whose normals are near those of the input, 0 ..= 1.
///
/// Three points sample each face, each for a third of its area. Normals there are compared with those of the nearest
/// point of the input: normals of flat faces with that of the triangle there, normals of nodes with the input's
/// shading normal. Hosts shade with normals of nodes. The input's shading normals are its own, or smooth ones of its
/// triangles.
///
/// Cracks do not change the shares: they divide outer faces but rotate none. Walls of
/// existing cracks count as outer faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalShares {
    /// Share by normals of the faces, against those of triangles.
    pub faces: f64,
    /// Share by normals of nodes, interpolated. They are area-weighted means over the faces around.
    pub smooth: f64,
    /// Share by normals of nodes that are carried from the input ([`crate::skin::BoundaryAttributes`]), interpolated.
    ///
    /// `None` if some body has none.
    pub carried: Option<f64>,
}

/// Largest angle between normals that count as near, degrees.
pub const NORMAL_DEG: f64 = 10.0;

/// Barycentric coordinates of the sample points of a face.
const PLACES: [[f64; 3]; 3] =
    [[2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]];

/// Lattice, with normals by node if it has carried ones.
pub type ShadedLattice<'a> = (&'a Lattice, Option<Vec<Vector3<f64>>>);

/// Triangle of the input, local and outward, with the shading normals of its corners.
pub type ShadedTriangle = ([Point3<f64>; 3], [Vector3<f64>; 3]);

impl NormalShares {
    /// Computes the shares of a prepared object against the triangles of its skin; `None` without a skin or its triangles.
    pub fn of(prepared: &PreparedObject, degrees: f64) -> Option<Self> {
        let skin = prepared.skin.as_ref().filter(|skin| !skin.triangles.is_empty())?;
        let normal = |vertex: u32| Vector3::from(skin.attributes.normals[vertex as usize]).cast();
        let lit = |triangle: usize| (skin.corners(triangle), skin.triangles[triangle].map(normal));
        let input: Vec<ShadedTriangle> = (0..skin.triangles.len()).map(lit).collect();
        let shaded = |body: &crate::pipeline::PreparedBody| {
            let mut normals = vec![Vector3::zeros(); body.crack.nodes.len()];
            for (&node, normal) in body.topology.boundary_nodes.iter().zip(&body.outer.as_ref()?.points.normals) {
                normals[node as usize] = Vector3::from(*normal).cast();
            }
            Some(normals)
        };
        let bodies: Vec<ShadedLattice> = prepared.bodies.iter().map(|body| (&body.crack, shaded(body))).collect();
        Some(Self::new(&bodies, &input, degrees))
    }

    /// Computes the shares within `degrees` of `input`; 1 if there is no area.
    pub fn new(bodies: &[ShadedLattice], input: &[ShadedTriangle], degrees: f64) -> Self {
        let nearest = NearestTriangles::new(&input.iter().map(|(corners, _)| *corners).collect::<Vec<_>>());
        let least = degrees.to_radians().cos();
        let sums: Vec<[f64; 4]> = bodies.iter().map(|body| sums(body, input, &nearest, least)).collect();
        let total = |k: usize| sums.iter().map(|sum| sum[k]).sum::<f64>();
        let area = total(0);
        let share = |k: usize| if area > 0.0 { total(k) / area } else { 1.0 };
        let carried = bodies.iter().all(|(_, carried)| carried.is_some());
        Self { faces: share(1), smooth: share(2), carried: carried.then(|| share(3)) }
    }
}

/// Area of one body's boundary, and its parts that are near by face, smooth and carried normals.
fn sums(
    (lattice, carried): &ShadedLattice,
    input: &[ShadedTriangle],
    nearest: &NearestTriangles,
    least: f64,
) -> [f64; 4] {
    let boundary = lattice.boundary();
    let area = |nodes: [u32; 3]| area_vector(&nodes.map(|node| lattice.nodes[node as usize]));
    let mut smooth = vec![Vector3::zeros(); lattice.nodes.len()];
    for face in &boundary {
        let own = area(face.nodes);
        face.nodes.iter().for_each(|&node| smooth[node as usize] += own);
    }
    smooth.iter_mut().for_each(|normal| *normal = normal.try_normalize(0.0).unwrap_or_default());
    let of = |nodes: [u32; 3]| {
        let own = area(nodes);
        let third = own.norm() / 3.0;
        let mut sums = [0.0; 4];
        for weights in PLACES {
            let mean =
                |of: &dyn Fn(u32) -> Vector3<f64>| (0..3).map(|k| of(nodes[k]) * weights[k]).sum::<Vector3<f64>>();
            let place = Point3::from(mean(&|node| lattice.nodes[node as usize].coords));
            let (at, there) = nearest.to(&place);
            let (corners, lit) = &input[at];
            let flat = area_vector(corners);
            let shown: Vector3<f64> = (0..3).map(|k| lit[k] * there[k]).sum();
            let near = |normal: Vector3<f64>, wanted: &Vector3<f64>| {
                if normal.dot(wanted) >= least * normal.norm() * wanted.norm() { third } else { 0.0 }
            };
            sums[0] += third;
            sums[1] += near(own, &flat);
            sums[2] += near(mean(&|node| smooth[node as usize]), &shown);
            sums[3] += carried.as_ref().map_or(0.0, |normals| near(mean(&|node| normals[node as usize]), &shown));
        }
        sums
    };
    let all: Vec<[f64; 4]> = boundary.par_iter().map(|face| of(face.nodes)).collect();
    all.iter().fold([0.0; 4], |sum, own| [0, 1, 2, 3].map(|k| sum[k] + own[k]))
}

#[cfg(test)]
#[path = "normals_tests.rs"]
mod tests;
