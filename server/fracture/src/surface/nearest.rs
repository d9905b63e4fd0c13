//! Nearest of many points or triangles.

use super::closest;
use super::tree::TriangleTree;
use crate::triangle::closest_point;
use nalgebra::Point3;

/// Point set with nearest-point queries.
pub struct NearestPoints(TriangleTree);

impl NearestPoints {
    /// Builds the search structure of `points`.
    pub fn new(points: &[Point3<f64>]) -> Self {
        let triangles: Vec<[Point3<f64>; 3]> = points.iter().map(|point| [*point; 3]).collect();
        Self(TriangleTree::new(&triangles))
    }

    /// Index of the point nearest to `point`; 0 if there are none.
    pub fn to(&self, point: &Point3<f64>) -> usize {
        closest::nearest(&self.0, point).1 as usize
    }
}

/// Triangle set with nearest-triangle queries.
pub struct NearestTriangles {
    tree: TriangleTree,
    triangles: Vec<[Point3<f64>; 3]>,
}

impl NearestTriangles {
    /// Builds the search structure of `triangles`.
    pub fn new(triangles: &[[Point3<f64>; 3]]) -> Self {
        Self { tree: TriangleTree::new(triangles), triangles: triangles.to_vec() }
    }

    /// Index of the triangle nearest to `point`, and the barycentric coordinates of the closest point on it.
    ///
    /// A triangle without area yields its first corner. Without triangles the index is 0.
    pub fn to(&self, point: &Point3<f64>) -> (usize, [f64; 3]) {
        let triangle = closest::nearest(&self.tree, point).1 as usize;
        let weights = self.triangles.get(triangle).map(|corners| barycentric(corners, &closest_point(corners, point)));
        (triangle, weights.unwrap_or([1.0, 0.0, 0.0]))
    }
}

impl NearestTriangles {
    /// Distance from `point` to the nearest triangle; infinite without triangles.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        closest::nearest(&self.tree, point).0.sqrt()
    }
}

/// Barycentric coordinates of a point of a triangle, none negative. A triangle without area yields its first corner.
pub(crate) fn barycentric([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>) -> [f64; 3] {
    let normal = (b - a).cross(&(c - a));
    let part = |from: &Point3<f64>, to: &Point3<f64>| (to - from).cross(&(point - from)).dot(&normal).max(0.0);
    let own = [part(b, c), part(c, a), part(a, b)];
    let sum: f64 = own.iter().sum();
    if sum > 0.0 { own.map(|x| x / sum) } else { [1.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::RandomStream;

    #[test]
    fn the_nearest_is_the_one_that_a_search_through_all_finds() {
        let mut random = RandomStream::new(7, 7);
        let mut point = || Point3::new(random.uniform(), random.uniform(), random.uniform());
        let points: Vec<Point3<f64>> = (0..300).map(|_| point()).collect();
        let nearest = NearestPoints::new(&points);
        for _ in 0..300 {
            let at = point();
            let distance = |index: usize| (points[index] - at).norm_squared();
            let best = (0..points.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap();
            assert_eq!(nearest.to(&at), best);
        }
    }

    #[test]
    fn the_nearest_triangle_tells_the_place_on_it() {
        let corner = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        let low = [corner(0.0, 0.0, 0.0), corner(1.0, 0.0, 0.0), corner(0.0, 1.0, 0.0)];
        let high = low.map(|corner| corner + nalgebra::Vector3::z());
        let nearest = NearestTriangles::new(&[low, high]);
        let (triangle, weights) = nearest.to(&corner(0.25, 0.5, 0.9));
        assert_eq!(triangle, 1);
        for (weight, expected) in weights.iter().zip([0.25, 0.25, 0.5]) {
            assert!((weight - expected).abs() < 1e-15);
        }
        assert_eq!(nearest.to(&corner(3.0, -1.0, 0.1)), (0, [0.0, 1.0, 0.0]));
    }
}
