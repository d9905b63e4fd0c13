//! Convex hulls as collision proxies of fragments: few vertices, large coverage of the fragment, small overlap with
//! neighbors.
//!
//! [`ConvexHull::of`] computes a hull of points, and [`clipped`] the points of a body within planes.
//! [`ConvexHull::coverage`] and [`ConvexHull::depth`] measure the hull. All arithmetic is sequential in a fixed order:
//! same input, same bytes.

mod clip;
mod measure;
mod quickhull;

#[cfg(test)]
mod tests;

pub use clip::clipped;

use nalgebra::{Point3, Vector3};

/// Largest number of triangles of a hull, within the limits of common physics engines.
///
/// A closed triangulation with 64 faces has 34 vertices. A set of faces fits into one 64-bit word.
pub const FACES_MAX: usize = u64::BITS as usize;

/// An oriented plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Outward unit normal.
    pub normal: Vector3<f64>,
    /// Distance of the plane from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// The plane through three points, counter-clockwise seen from outside; `None` if they are collinear.
    pub fn through([a, b, c]: [Point3<f64>; 3]) -> Option<Self> {
        Self::at(&a, (b - a).cross(&(c - a)))
    }

    /// The plane through a point, orthogonal to a direction of any length above zero.
    pub fn at(point: &Point3<f64>, direction: Vector3<f64>) -> Option<Self> {
        let normal = direction.try_normalize(0.0).filter(|normal| normal.iter().all(|x| x.is_finite()))?;
        Some(Self { normal, offset: normal.dot(&point.coords) })
    }

    /// Signed distance of a point from the plane, negative inside.
    pub fn beyond(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }
}

/// A closed triangulated surface, counter-clockwise seen from outside. Points may occur more than once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosedTriangles {
    /// Points.
    pub points: Vec<Point3<f64>>,
    /// Indices into the points.
    pub triangles: Vec<[u32; 3]>,
}

impl ClosedTriangles {
    /// Moves the first `count` points by `distance` along the mean normals of their triangles.
    ///
    /// Other points stay, so the triangles may no longer close the surface.
    pub fn outset(&self, count: usize, distance: f64) -> Self {
        let mut normals = vec![Vector3::zeros(); self.points.len()];
        for (triangle, [a, b, c]) in self.triangles.iter().zip(self.corners()) {
            let area = (b - a).cross(&(c - a));
            triangle.iter().for_each(|&point| normals[point as usize] += area);
        }
        let mut points = self.points.clone();
        for (point, normal) in points.iter_mut().zip(&normals).take(count) {
            *point += normal.try_normalize(0.0).unwrap_or_default() * distance;
        }
        Self { points, triangles: self.triangles.clone() }
    }

    /// The corners of each triangle.
    fn corners(&self) -> impl Iterator<Item = [Point3<f64>; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|point| self.points[point as usize]))
    }
}

/// Smallest and largest coordinate per axis; (∞, −∞) without points.
pub fn bounds(points: &[Point3<f64>]) -> [Point3<f64>; 2] {
    let start = [Point3::from(Vector3::repeat(f64::INFINITY)), Point3::from(Vector3::repeat(f64::NEG_INFINITY))];
    points.iter().fold(start, |[low, high], point| [low.inf(point), high.sup(point)])
}

/// True if two boxes have a point in common.
pub fn meet([low, high]: &[Point3<f64>; 2], [other_low, other_high]: &[Point3<f64>; 2]) -> bool {
    (0..3).all(|axis| low[axis] <= other_high[axis] && other_low[axis] <= high[axis])
}

/// A convex body: a closed triangulation with at most [`FACES_MAX`] triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexHull {
    /// Vertices, each used by a triangle.
    pub vertices: Vec<Point3<f64>>,
    /// Vertex indices of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Largest distance of an input point beyond the hull.
    pub left_out: f64,
    /// Plane of each triangle.
    planes: Vec<Plane>,
}

impl ConvexHull {
    /// Diagonal of the bounding box.
    pub fn size(&self) -> f64 {
        let [low, high] = bounds(&self.vertices);
        (high - low).norm()
    }
}
