//! Measures of a lattice: dihedral angles, area, deviation from the surface; and a transformed copy.

use super::{EDGES, FACES, Lattice};
use nalgebra::{Isometry3, Point3, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Smallest and largest dihedral angle, degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DihedralRange {
    /// Smallest angle.
    pub min_deg: f64,
    /// Largest angle.
    pub max_deg: f64,
}

impl DihedralRange {
    /// Angles of one tetrahedron; `None` if its volume is not positive.
    pub(crate) fn of(corners: &[Point3<f64>; 4]) -> Option<Self> {
        let [a, b, c, d] = corners;
        let volume = (b - a).dot(&(c - a).cross(&(d - a)));
        (volume > 0.0).then(|| Self::from_cosines(cosines(corners)))
    }

    /// Returns true if both angles are within `bounds_deg`, or no farther outside than those of `before`.
    pub(super) fn within(&self, bounds_deg: [f64; 2], before: Option<Self>) -> bool {
        let [least, most] =
            before.map_or(bounds_deg, |own| [own.min_deg.min(bounds_deg[0]), own.max_deg.max(bounds_deg[1])]);
        self.min_deg >= least && self.max_deg <= most
    }

    /// Converts the largest and the smallest cosine.
    fn from_cosines([smallest, largest]: [f64; 2]) -> Self {
        let degrees = |cosine: f64| cosine.clamp(-1.0, 1.0).acos().to_degrees();
        Self { min_deg: degrees(smallest), max_deg: degrees(largest) }
    }
}

/// Largest and smallest cosine of a tetrahedron's dihedral angles.
fn cosines(corners: &[Point3<f64>; 4]) -> [f64; 2] {
    let normals = FACES.map(|[i, j, k]| area_vector(&[corners[i], corners[j], corners[k]]).normalize());
    // Two outward normals enclose the supplement of the dihedral angle.
    let all = EDGES.map(|[i, j]| -normals[i].dot(&normals[j]));
    all.iter().fold([-1.0, 1.0], |[most, least]: [f64; 2], own| [most.max(*own), least.min(*own)])
}

impl Lattice {
    /// Extreme dihedral angles of all tetrahedra; (180, 0) for an empty lattice.
    pub fn dihedral(&self) -> DihedralRange {
        let cosines = (0..self.tets.len()).map(|tet| cosines(&self.corners(tet)));
        DihedralRange::from_cosines(cosines.fold([-1.0, 1.0], |sum, own| [sum[0].max(own[0]), sum[1].min(own[1])]))
    }

    /// Area of the boundary, local.
    pub fn boundary_area(&self) -> f64 {
        self.boundary().iter().map(|face| area_vector(&face.nodes.map(|node| self.nodes[node as usize])).norm()).sum()
    }

    /// Largest magnitude of `distance` over the boundary's nodes, edge midpoints and face centroids; local.
    pub fn deviation(&self, distance: &(dyn Fn(&Point3<f64>) -> f64 + Sync)) -> f64 {
        let mut places = Vec::new();
        for face in self.boundary() {
            let [a, b, c] = face.nodes.map(|node| (node, self.nodes[node as usize]));
            places.push(Point3::from((a.1.coords + b.1.coords + c.1.coords) / 3.0));
            // On a closed boundary every edge runs from its lower to its higher node in exactly one of its two faces.
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if from.0 < to.0 {
                    places.push(nalgebra::center(&from.1, &to.1));
                }
            }
        }
        let mut rim: Vec<u32> = self.boundary().iter().flat_map(|face| face.nodes).collect();
        rim.sort_unstable();
        rim.dedup();
        places.extend(rim.into_iter().map(|node| self.nodes[node as usize]));
        places.par_iter().map(|place| distance(place).abs()).reduce(|| 0.0, f64::max)
    }

    /// Copy of the lattice, transformed by `isometry`.
    pub fn transformed(&self, isometry: &Isometry3<f64>) -> Self {
        Self { nodes: self.nodes.iter().map(|node| isometry * node).collect(), tets: self.tets.clone() }
    }
}

/// Area vector of a triangle: half the cross product of two edges.
pub(crate) fn area_vector([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a)) / 2.0
}
