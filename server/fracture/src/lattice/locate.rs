//! Point location in a lattice, and the nearest point of its boundary.

use super::tree::{Aabb, AabbTree};
use super::{BoundaryFace, Lattice};
use crate::triangle::ClosestFeature;
use nalgebra::{Matrix3, Point3, Vector3};

/// Tolerance of barycentric coordinates below 0, for rounding on shared faces.
const ROUNDING: f64 = 1e-10;

/// Point in a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticePoint {
    /// Tetrahedron of the point.
    pub tet: u32,
    /// Barycentric coordinates, in the order of the tetrahedron's nodes. Their sum is 1; none
    /// is below 0 except by rounding.
    pub barycentric: [f64; 4],
}

/// Nearest point of the boundary to a given one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnBoundary {
    /// Index of its face in [`Locator::faces`].
    pub face: u32,
    /// Position, local.
    pub point: Point3<f64>,
    /// Barycentric coordinates on the face, in the order of its nodes. Their sum is 1; none is negative.
    pub barycentric: [f64; 3],
    /// Distance from the given point, local.
    pub distance: f64,
}

/// Point location and nearest-boundary queries on one lattice.
///
/// Build it once and query it from any thread. Equal queries return equal results.
#[derive(Clone, Debug)]
pub struct Locator {
    /// First corner, and inverse of the edge matrix, of each tetrahedron.
    frames: Vec<(Point3<f64>, Matrix3<f64>)>,
    tets: AabbTree,
    faces: Vec<BoundaryFace>,
    triangles: Vec<[Point3<f64>; 3]>,
    boundary: AabbTree,
    /// Rounding error of positions, local.
    margin: f64,
}

impl Locator {
    /// Builds the search structures.
    pub fn new(lattice: &Lattice) -> Self {
        let frame = |tet| {
            let [a, ..] = lattice.corners(tet);
            // Every tetrahedron has positive volume, so its edge matrix has an inverse.
            (a, lattice.edge_matrix(tet).try_inverse().unwrap_or_else(Matrix3::zeros))
        };
        let boxes: Vec<Aabb> = (0..lattice.tets.len()).map(|tet| Aabb::around(&lattice.corners(tet))).collect();
        let faces = lattice.boundary();
        let triangles: Vec<[Point3<f64>; 3]> =
            faces.iter().map(|face| face.nodes.map(|node| lattice.nodes[node as usize])).collect();
        let rims: Vec<Aabb> = triangles.iter().map(|triangle| Aabb::around(triangle)).collect();
        let reach = lattice.nodes.iter().map(|node| node.coords.amax()).fold(0.0, f64::max);
        Self {
            frames: (0..lattice.tets.len()).map(frame).collect(),
            tets: AabbTree::new(&boxes),
            boundary: AabbTree::new(&rims),
            faces,
            triangles,
            margin: ROUNDING * reach,
        }
    }

    /// Faces of the boundary, in the order of [`Lattice::boundary`].
    pub fn faces(&self) -> &[BoundaryFace] {
        &self.faces
    }

    /// Barycentric coordinates of `point` in tetrahedron `tet`, inside or not.
    pub fn barycentric(&self, tet: u32, point: &Point3<f64>) -> [f64; 4] {
        let (origin, inverse) = &self.frames[tet as usize];
        let weights = inverse * (point - origin);
        [1.0 - weights.sum(), weights.x, weights.y, weights.z]
    }

    /// Tetrahedron that contains `point`, if any. Tries `hint` first; a correct hint avoids the search.
    pub fn containing(&self, point: &Point3<f64>, hint: Option<u32>) -> Option<LatticePoint> {
        let place = |tet| LatticePoint { tet, barycentric: self.barycentric(tet, point) };
        let lowest = |place: &LatticePoint| place.barycentric.iter().copied().fold(f64::INFINITY, f64::min);
        if let Some(place) = hint.map(place).filter(|place| lowest(place) >= 0.0) {
            return Some(place);
        }
        let (mut best, mut least) = (None, -ROUNDING);
        self.tets.containing(point, self.margin, |tet| {
            let candidate = place(tet);
            if lowest(&candidate) >= least {
                least = lowest(&candidate);
                best = Some(candidate);
            }
            least >= 0.0
        });
        best
    }

    /// Nearest point of the boundary to `point`. `None` for an empty lattice.
    pub fn nearest(&self, point: &Point3<f64>) -> Option<NearestOnBoundary> {
        let on = |face: u32| {
            let triangle = &self.triangles[face as usize];
            let barycentric = ClosestFeature::of(triangle, point).barycentric();
            let foot =
                triangle.iter().zip(barycentric).map(|(corner, weight)| corner.coords * weight).sum::<Vector3<_>>();
            (Point3::from(foot), barycentric)
        };
        let face = self.boundary.nearest(point, f64::INFINITY, |face| (on(face).0 - point).norm_squared())?;
        let (foot, barycentric) = on(face);
        Some(NearestOnBoundary { face, point: foot, barycentric, distance: (foot - point).norm() })
    }

    /// Tetrahedron that contains `point`, or else the location of the nearest boundary
    /// point. `None` for an empty lattice.
    pub fn locate(&self, point: &Point3<f64>, hint: Option<u32>) -> Option<LatticePoint> {
        if let Some(place) = self.containing(point, hint) {
            return Some(place);
        }
        let nearest = self.nearest(point)?;
        let tet = self.faces[nearest.face as usize].tet;
        let clamped = self.barycentric(tet, &nearest.point).map(|weight| weight.max(0.0));
        let sum: f64 = clamped.iter().sum();
        Some(LatticePoint { tet, barycentric: clamped.map(|weight| weight / sum) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;
    use crate::random::RandomStream;

    fn points(seed: u64, reach: f64) -> Vec<Point3<f64>> {
        let mut stream = RandomStream::new(seed, 0);
        let mut coordinate = move || reach * (2.0 * stream.uniform() - 1.0);
        (0..500).map(|_| Point3::new(coordinate(), coordinate(), coordinate())).collect()
    }

    #[test]
    fn points_inside_are_found_with_coordinates_that_give_them_back() {
        let lattice = block([3, 4, 2], 0.25);
        let locator = Locator::new(&lattice);
        let mut hint = None;
        for point in points(1, 0.3) {
            let inside = point.x.abs() < 0.375 && point.y.abs() < 0.5 && point.z.abs() < 0.25;
            let place = locator.containing(&point, hint);
            assert_eq!(place.is_some(), inside);
            if let Some(place) = place {
                let corners = lattice.corners(place.tet as usize);
                let back: Vector3<f64> = corners.iter().zip(place.barycentric).map(|(c, w)| c.coords * w).sum();
                assert!((back - point.coords).norm() < 1e-14);
                assert!(place.barycentric.iter().all(|weight| *weight >= -1e-10));
                hint = Some(place.tet);
            }
        }
    }

    #[test]
    fn nodes_and_points_on_faces_are_found() {
        let lattice = block([2, 2, 2], 0.3);
        let locator = Locator::new(&lattice);
        assert!(lattice.nodes.iter().all(|node| locator.containing(node, None).is_some()));
        for tet in 0..lattice.tets.len() {
            let [a, b, c, _] = lattice.corners(tet);
            let on = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            assert!(locator.containing(&on, None).is_some());
        }
    }

    #[test]
    fn the_nearest_boundary_point_is_that_of_the_box() {
        let lattice = block([3, 4, 2], 0.25);
        let locator = Locator::new(&lattice);
        let half = Vector3::new(0.375, 0.5, 0.25);
        for point in points(2, 1.0) {
            let nearest = locator.nearest(&point).unwrap();
            let outside = (point.coords.abs() - half).sup(&Vector3::zeros()).norm();
            let inside = (half - point.coords.abs()).min().max(0.0);
            assert!((nearest.distance - outside.max(inside)).abs() < 1e-14);
            assert!((nearest.barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let place = locator.locate(&point, None).unwrap();
            assert!(outside == 0.0 || place.tet == locator.faces()[nearest.face as usize].tet);
        }
        assert!(Locator::new(&Lattice::default()).locate(&Point3::origin(), None).is_none());
    }
}
