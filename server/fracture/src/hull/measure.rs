//! Coverage of a body by a hull, and depth of other bodies in it.
//!
//! Ours. Coverage is exact: a body is the signed sum of the cones from a point to its triangles. Each cone is clipped
//! by the planes of the hull that it crosses. Depth is a concave function with Lipschitz constant 1, so values at the
//! corners bound it on a triangle, and branch and bound finds the largest.

use super::clip::six_volumes_within;
use super::{ClosedTriangles, ConvexHull, Plane, bounds, meet};
use nalgebra::{Point3, Vector3, center};

/// Largest overestimation of a depth, over the diagonal of the hull.
const DEPTH_SLACK: f64 = 1e-3;

/// Largest number of subdivisions of a triangle. The remaining parts count with their bounds.
const DIVISIONS: u32 = 8;

/// Search for the deepest point.
struct Search<'a> {
    planes: &'a [Plane],
    /// Largest depth so far.
    deepest: f64,
    slack: f64,
    /// Index of the plane that excluded the last triangle.
    last: usize,
}

impl ConvexHull {
    /// Share of the volume of `body` inside the hull, 0 ..= 1; 0 for a body without volume.
    pub fn coverage(&self, body: &ClosedTriangles) -> f64 {
        let apex = Point3::from(
            self.vertices.iter().map(|vertex| vertex.coords).sum::<Vector3<f64>>() / self.vertices.len().max(1) as f64,
        );
        let bit = |(place, plane): (usize, &Plane), point: &Point3<f64>| u64::from(plane.beyond(point) > 0.0) << place;
        let outside = |point: &Point3<f64>| self.planes.iter().enumerate().fold(0, |bits, own| bits | bit(own, point));
        let outside: Vec<u64> = body.points.iter().map(outside).collect();
        let (mut inside, mut whole) = (0.0, 0.0);
        for triangle in &body.triangles {
            let [a, b, c] = triangle.map(|point| body.points[point as usize]);
            let cone = (a - apex).dot(&(b - apex).cross(&(c - apex)));
            let bits = triangle.iter().fold(0, |bits, &point| bits | outside[point as usize]);
            whole += cone;
            inside += match bits {
                0 => cone,
                bits => six_volumes_within(&[apex, a, b, c], &self.planes, bits).copysign(cone),
            };
        }
        if whole > 0.0 { (inside / whole).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The largest depth of the surfaces of `others` below the hull's surface; 0 if none is inside.
    ///
    /// Overestimated by at most a thousandth of the hull's diagonal, never underestimated.
    pub fn depth<'a>(&self, others: impl Iterator<Item = &'a ClosedTriangles>) -> f64 {
        let slack = DEPTH_SLACK * self.size();
        let own = bounds(&self.vertices);
        let mut search = Search { planes: &self.planes, deepest: -slack, slack, last: 0 };
        for corners in others.flat_map(ClosedTriangles::corners) {
            if meet(&bounds(&corners), &own) {
                search.visit(corners, DIVISIONS);
            }
        }
        search.deepest + slack
    }
}

impl Search<'_> {
    /// Searches a triangle for a deeper point.
    fn visit(&mut self, corners: [Point3<f64>; 3], divisions: u32) {
        let Some(bound) = self.bound(&corners) else { return };
        for corner in &corners {
            let depth = self.planes.iter().map(|plane| -plane.beyond(corner)).fold(f64::INFINITY, f64::min);
            self.deepest = self.deepest.max(depth);
        }
        if bound <= self.deepest + self.slack {
            return;
        }
        if divisions == 0 {
            self.deepest = bound;
            return;
        }
        let [a, b, c] = corners;
        let [ab, bc, ca] = [center(&a, &b), center(&b, &c), center(&c, &a)];
        for part in [[ab, bc, ca], [a, ab, ca], [ab, b, bc], [ca, bc, c]] {
            self.visit(part, divisions - 1);
        }
    }

    /// Upper bound of the depth in a triangle; `None` if it exceeds the largest depth so far by at most the slack.
    fn bound(&mut self, corners: &[Point3<f64>; 3]) -> Option<f64> {
        let mut bound = f64::INFINITY;
        let count = self.planes.len();
        for place in std::iter::once(self.last).chain(0..count) {
            let plane = self.planes.get(place)?;
            let most = corners.iter().map(|corner| -plane.beyond(corner)).fold(f64::NEG_INFINITY, f64::max);
            bound = bound.min(most);
            if bound <= self.deepest + self.slack {
                self.last = place;
                return None;
            }
        }
        Some(bound)
    }
}
