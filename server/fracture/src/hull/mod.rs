//! Convex bodies that stand for fragments in collisions: few vertices, as much of the fragment as they can hold, as little as they
//! must of its neighbors.
//!
//! [`ConvexHull::of`] makes one around points, [`clipped`] says which points are left of a body within some planes, [`ConvexHull::coverage`] and
//! [`ConvexHull::depth`] measure what has become of it. All of it is sequential arithmetic in a fixed order: same input, same bytes.

mod clip;
mod measure;
mod quickhull;

#[cfg(test)]
mod tests;

pub use clip::clipped;

use nalgebra::{Point3, Vector3};

/// Most triangles of a hull, and more than it has vertices (of which a closed triangulation with 64 faces has 34): what the
/// pipelines of physics engines take. A set of faces is a word.
pub const FACES_MAX: usize = u64::BITS as usize;

/// A plane with an outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Of length one, outwards.
    pub normal: Vector3<f64>,
    /// Distance of the plane from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// Through three points, counter-clockwise seen from outside; `None` where they lie on a line.
    pub fn through([a, b, c]: [Point3<f64>; 3]) -> Option<Self> {
        Self::at(&a, (b - a).cross(&(c - a)))
    }

    /// Through a point, across a direction of any length but zero.
    pub fn at(point: &Point3<f64>, direction: Vector3<f64>) -> Option<Self> {
        let normal = direction.try_normalize(0.0).filter(|normal| normal.iter().all(|x| x.is_finite()))?;
        Some(Self { normal, offset: normal.dot(&point.coords) })
    }

    /// How far outside a point lies; negative inside.
    pub fn beyond(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }
}

/// A closed surface: triangles over points, counter-clockwise seen from outside. Points may be listed more than once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosedTriangles {
    /// The points.
    pub points: Vec<Point3<f64>>,
    /// Indices into them.
    pub triangles: Vec<[u32; 3]>,
}

impl ClosedTriangles {
    /// The first `count` points moved by `distance` along the mean normals of their triangles, as soup: triangles of others stay
    /// where they are.
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

    /// The corners of its triangles.
    fn corners(&self) -> impl Iterator<Item = [Point3<f64>; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|point| self.points[point as usize]))
    }
}

/// Smallest and largest coordinate per axis; infinite the wrong way round without points.
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
    /// Its corners; every one is a corner of a triangle.
    pub vertices: Vec<Point3<f64>>,
    /// Indices into them, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The farthest that a point lies beyond it of those that it was made around.
    pub left_out: f64,
    /// The plane of each triangle.
    planes: Vec<Plane>,
}

impl ConvexHull {
    /// Its diagonal: that of its bounding box.
    pub fn size(&self) -> f64 {
        let [low, high] = bounds(&self.vertices);
        (high - low).norm()
    }
}
