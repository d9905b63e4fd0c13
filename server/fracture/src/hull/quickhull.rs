//! Convex hull of points, refined from coarse to fine.
//!
//! Based on: Barber, Dobkin & Huhdanpaa, *The quickhull algorithm for convex hulls* (ACM Transactions on Mathematical
//! Software 22(4), 1996): faces seen from a point beyond them are replaced by the cone from that point to their
//! horizon. There are no lists of points per face. Instead, every new face searches all points for its farthest, and
//! the face with the farthest point of all is next. Stopped at any time, the result is the hull of the most prominent
//! points.

use super::{ConvexHull, FACES_MAX, Plane, bounds};
use nalgebra::Point3;

/// Thickness over the diagonal below which a body has no hull.
const FLAT: f64 = 1e-6;

/// Distance from the hull below which points are ignored, over its diagonal.
const DETAIL: f64 = 1e-4;
/// The same over the hull's thickness; the smaller distance applies.
const DETAIL_OF_THICKNESS: f64 = 1e-2;

/// Distance beyond a face from which it counts as seen, over the diagonal.
const SEEN: f64 = 1e-12;

/// Weight of the squared distance from the center among equally far points. It prefers corners over points within an
/// edge.
const TIE: f64 = 1e-6;

/// A triangle of the growing hull.
struct Face {
    corners: [usize; 3],
    /// Neighbor across the edge from each corner to the next.
    across: [usize; 3],
    plane: Plane,
    /// Distance and index of the farthest point beyond the face.
    far: Option<(f64, usize)>,
    alive: bool,
}

/// An edge of the horizon: corners in the order of the seen face, and the unseen face.
#[derive(Clone, Copy)]
struct Edge {
    from: usize,
    to: usize,
    outer: usize,
}

/// Numbers of triangles at which points inside the hull are discarded.
const SIEVES: [usize; 3] = [8, 16, 32];

struct Builder {
    /// Points relative to the center of their bounding box.
    points: Vec<Point3<f64>>,
    /// Points that may still be farthest, ascending.
    open: Vec<usize>,
    /// Tie-break of each point.
    bias: Vec<f64>,
    size: f64,
    detail: f64,
    faces: Vec<Face>,
    alive: usize,
}

impl ConvexHull {
    /// The convex hull of `points` with at most [`FACES_MAX`] triangles, of the most prominent points if all would need
    /// more.
    ///
    /// `None` if there are no points, a coordinate is not finite, or all are coplanar.
    pub fn of(points: &[Point3<f64>]) -> Option<Self> {
        let [low, high] = bounds(points);
        let size = (high - low).norm();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let middle = nalgebra::center(&low, &high);
        let mut builder = Builder::new(points, &middle, size);
        builder.begin()?;
        while builder.alive + 2 <= FACES_MAX {
            let Some((face, point)) = builder.next() else { break };
            let before = builder.alive;
            if !builder.add(face, point) {
                builder.faces[face].far = None;
            } else if SIEVES.iter().any(|sieve| before < *sieve && *sieve <= builder.alive) {
                builder.classify_points();
            }
        }
        Some(builder.finish(points, &middle))
    }
}

impl Builder {
    fn new(points: &[Point3<f64>], middle: &Point3<f64>, size: f64) -> Self {
        let points: Vec<Point3<f64>> = points.iter().map(|point| Point3::from(point - middle)).collect();
        let bias = points.iter().map(|point| TIE / size * point.coords.norm_squared()).collect();
        let open = (0..points.len()).collect();
        Self { points, open, bias, size, detail: DETAIL * size, faces: Vec::new(), alive: 0 }
    }

    /// The first open point with the largest score.
    fn most(&self, score: impl Fn(&Point3<f64>) -> f64) -> usize {
        let mut best = (f64::NEG_INFINITY, 0);
        for &place in &self.open {
            let own = score(&self.points[place]) + self.bias[place];
            if own > best.0 {
                best = (own, place);
            }
        }
        best.1
    }

    /// Starts with a tetrahedron of far points; `None` if all are coplanar.
    fn begin(&mut self) -> Option<()> {
        let a = self.most(|point| point.coords.norm());
        let first = self.points[a];
        let b = self.most(|point| (point - first).norm());
        let along = (self.points[b] - first).try_normalize(0.0)?;
        let c = self.most(|point| (point - first).cross(&along).norm());
        let base = Plane::through([a, b, c].map(|place| self.points[place]))?;
        let d = self.most(|point| base.beyond(point).abs());
        let height = base.beyond(&self.points[d]);
        let width = (self.points[c] - first).cross(&along).norm();
        if width.min(height.abs()) <= FLAT * self.size {
            return None;
        }
        self.detail = self.detail.min(DETAIL_OF_THICKNESS * height.abs());
        // Seen from outside, the base is counter-clockwise and the last corner is behind it.
        let (b, c) = if height > 0.0 { (c, b) } else { (b, c) };
        let sides = [([a, b, c], [1, 2, 3]), ([b, a, d], [0, 3, 2]), ([c, b, d], [0, 1, 3]), ([a, c, d], [0, 2, 1])];
        for (corners, across) in sides {
            let plane = Plane::through(corners.map(|place| self.points[place]))?;
            self.push(corners, across, plane);
        }
        Some(())
    }

    fn push(&mut self, corners: [usize; 3], across: [usize; 3], plane: Plane) {
        let far = self.most(|point| plane.normal.dot(&point.coords));
        let distance = plane.beyond(&self.points[far]);
        let far = (distance > self.detail).then_some((distance, far));
        self.faces.push(Face { corners, across, plane, far, alive: true });
        self.alive += 1;
    }

    /// Discards points inside the hull, which cannot be farthest later.
    fn classify_points(&mut self) {
        let Self { points, open, faces, .. } = self;
        let outside = |point: &Point3<f64>| faces.iter().any(|face| face.alive && face.plane.beyond(point) > 0.0);
        open.retain(|&place| outside(&points[place]));
    }

    /// The face with the farthest point, and that point.
    fn next(&self) -> Option<(usize, usize)> {
        let mut best: Option<(f64, usize, usize)> = None;
        for (place, face) in self.faces.iter().enumerate().filter(|(_, face)| face.alive) {
            if let Some((distance, point)) = face.far.filter(|far| best.is_none_or(|best| far.0 > best.0)) {
                best = Some((distance, place, point));
            }
        }
        best.map(|(_, face, point)| (face, point))
    }

    /// Replaces the faces seen from a point beyond `face` by the cone to their horizon.
    ///
    /// Returns `false` without a change if rounding yields no simple horizon or a cone without volume.
    fn add(&mut self, face: usize, point: usize) -> bool {
        let seen = self.seen(face, &self.points[point]);
        let Some(rim) = self.rim(&seen) else { return false };
        let plane = |edge: &Edge| Plane::through([edge.from, edge.to, point].map(|place| self.points[place]));
        let Some(planes) = rim.iter().map(plane).collect::<Option<Vec<Plane>>>() else { return false };
        let (first, count) = (self.faces.len(), rim.len());
        for (k, (edge, plane)) in rim.iter().zip(planes).enumerate() {
            let across = [edge.outer, first + (k + 1) % count, first + (k + count - 1) % count];
            let outer = &mut self.faces[edge.outer];
            if let Some(side) = outer.corners.iter().position(|corner| *corner == edge.to) {
                outer.across[side] = first + k;
            }
            self.push([edge.from, edge.to, point], across, plane);
        }
        seen.iter().for_each(|&face| self.faces[face].alive = false);
        self.alive -= seen.len();
        true
    }

    /// Faces seen from `point` and connected with `face`, which is the first.
    fn seen(&self, face: usize, point: &Point3<f64>) -> Vec<usize> {
        let mut seen = vec![face];
        let mut at = 0;
        while at < seen.len() {
            for other in self.faces[seen[at]].across {
                if !seen.contains(&other) && self.faces[other].plane.beyond(point) > SEEN * self.size {
                    seen.push(other);
                }
            }
            at += 1;
        }
        seen
    }

    /// The horizon as a closed loop of edges; `None` if it is not a single loop.
    fn rim(&self, seen: &[usize]) -> Option<Vec<Edge>> {
        let edges = seen.iter().flat_map(|&face| {
            let Face { corners, across, .. } = &self.faces[face];
            (0..3).map(|k| Edge { from: corners[k], to: corners[(k + 1) % 3], outer: across[k] })
        });
        let edges: Vec<Edge> = edges.filter(|edge| !seen.contains(&edge.outer)).collect();
        let mut rim = vec![*edges.first()?];
        while rim.len() < edges.len() {
            let end = rim[rim.len() - 1].to;
            let mut follow = edges.iter().filter(|edge| edge.from == end);
            let next = follow.next().filter(|next| next.from != rim[0].from)?;
            if follow.next().is_some() {
                return None;
            }
            rim.push(*next);
        }
        (rim[rim.len() - 1].to == rim[0].from).then_some(rim)
    }

    fn finish(self, points: &[Point3<f64>], middle: &Point3<f64>) -> ConvexHull {
        let alive: Vec<&Face> = self.faces.iter().filter(|face| face.alive).collect();
        let mut used: Vec<usize> = alive.iter().flat_map(|face| face.corners).collect();
        used.sort_unstable();
        used.dedup();
        let number = |corner: usize| used.partition_point(|own| *own < corner) as u32;
        let moved = |plane: &Plane| Plane { offset: plane.offset + plane.normal.dot(&middle.coords), ..*plane };
        let left_out = alive.iter().filter_map(|face| face.far).fold(0.0, |most, far| far.0.max(most));
        ConvexHull {
            left_out,
            vertices: used.iter().map(|&place| points[place]).collect(),
            triangles: alive.iter().map(|face| face.corners.map(number)).collect(),
            planes: alive.iter().map(|face| moved(&face.plane)).collect(),
        }
    }
}
