//! How much of a body a hull holds, and how deep others reach into it.
//!
//! Ours. Coverage is exact: a body is the signed sum of the cones from a point to its triangles, each of which is clipped by the
//! planes of the hull that it reaches beyond. Depth is concave and changes no faster than the place, so that bounds at corners tell
//! which triangles need a closer look (branch and bound).

use super::clip::six_volumes_within;
use super::{ClosedTriangles, ConvexHull, Plane, bounds, meet};
use nalgebra::{Point3, Vector3, center};

/// How far a depth may be told too large, over the diagonal of the hull.
const DEPTH_SLACK: f64 = 1e-3;

/// A triangle is divided at most that often; what is left is told by its bound.
const DIVISIONS: u32 = 8;

/// The search for the deepest point.
struct Search<'a> {
    planes: &'a [Plane],
    /// Deepest so far.
    deepest: f64,
    slack: f64,
    /// The plane that the last triangle was found beyond of.
    last: usize,
}

impl ConvexHull {
    /// Volume of the part of `body` inside the hull over that of the body, 0 ..= 1; zero for a body without volume.
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

    /// The largest depth below the hull's surface of any point of the surface of `others`: told too large by at most a thousandth of
    /// the hull's diagonal, never too small. Zero where none reaches inside.
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
    /// Looks for a deeper point in a triangle.
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

    /// What no point of the triangle lies deeper than; `None` if that is of no interest.
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
