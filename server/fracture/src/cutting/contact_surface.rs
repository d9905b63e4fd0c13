//! The boundary of a cutting mesh as the surface that contacts and rays meet.

use super::{Carrier, CuttingMesh};
use crate::elasticity::{FaceSearch, NearestBoundaryPoint, SurfaceFaces};
use crate::lattice::Lattice;
use nalgebra::{Point3, Vector3};

impl SurfaceFaces for CuttingMesh {
    fn count(&self) -> usize {
        self.topology.boundary.len()
    }

    fn corners(&self, face: usize) -> [Point3<f64>; 3] {
        self.topology.boundary[face].nodes.map(|node| self.mesh.nodes[node as usize])
    }
}

impl CuttingMesh {
    /// The boundary, to be searched.
    pub fn surface(&self) -> FaceSearch<'_> {
        FaceSearch { faces: self, boxes: &self.boxes }
    }

    /// Position at which a load at `nearest` acts on the lattice: the same, or the anchor of a part that the lattice lost.
    pub fn load_place(&self, crack: &Lattice, nearest: &NearestBoundaryPoint) -> Point3<f64> {
        let nodes = self.topology.boundary[nearest.face].nodes;
        let carriers = nodes.map(|node| self.carriers[node as usize]);
        if carriers.iter().all(|carrier| !carrier.is_anchored) {
            return nearest.place;
        }
        let anchor = |Carrier { tet, weights, .. }: &Carrier| {
            let corners = crack.corners(*tet as usize);
            corners.iter().zip(weights).map(|(corner, weight)| corner.coords * *weight).sum::<Vector3<f64>>()
        };
        let shares = shares(&self.corners(nearest.face), &nearest.place);
        carriers.iter().zip(shares).map(|(carrier, share)| anchor(carrier) * share).sum::<Vector3<f64>>().into()
    }
}

/// Barycentric coordinates of a point of a triangle; equal ones for a triangle without area.
fn shares([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>) -> [f64; 3] {
    let normal = (b - a).cross(&(c - a));
    let share = |p: &Point3<f64>, q: &Point3<f64>| (q - p).cross(&(point - p)).dot(&normal) / normal.norm_squared();
    let shares = [share(b, c), share(c, a), share(a, b)];
    if shares.iter().all(|share| share.is_finite()) { shares } else { [1.0 / 3.0; 3] }
}
