//! First hit of a ray on a boundary, and closest approach of a ray that misses.
//!
//! Based on: T. Möller & B. Trumbore, *Fast, minimum storage ray/triangle intersection* (1997); A. Majercik et al., *A
//! ray-box intersection algorithm* (JCGT 7, 2018), for the slab test; C. Ericson, *Real-Time Collision Detection*
//! (2005), section 5.1.9, for the closest points of two lines.

use super::FaceSearch;
use nalgebra::{Point3, Vector3};

/// Tolerance outside a triangle, in barycentric coordinates, so that no ray passes between two neighbors.
const EDGE: f64 = 1e-9;

/// Rounding error of a box's sides, relative to the size of the box.
const SLACK: f64 = 1e-9;

/// First hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Face that the ray hits.
    pub face: usize,
    /// Position of the hit, local.
    pub place: Point3<f64>,
    /// Distance from the ray's origin, in lengths of its direction.
    pub distance: f64,
}

/// Closest approach of a ray to the boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestApproach {
    /// Point of the ray, local.
    pub on_ray: Point3<f64>,
    /// Point of the boundary, local.
    pub on_boundary: Point3<f64>,
    /// Distance between the two points, local.
    pub distance: f64,
}

impl FaceSearch<'_> {
    /// First hit of the ray from `origin` along `direction` on a face, from either side. The lowest face wins ties.
    pub fn first_hit(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<RayHit> {
        let mut best: Option<RayHit> = None;
        for (first, bounds) in self.groups() {
            if !meets_box(origin, direction, bounds, best.map_or(f64::INFINITY, |best| best.distance)) {
                continue;
            }
            for face in first {
                let Some(distance) = meets(origin, direction, self.faces.corners(face)) else { continue };
                if best.is_none_or(|best| (distance, face) < (best.distance, best.face)) {
                    best = Some(RayHit { face, place: origin + direction * distance, distance });
                }
            }
        }
        best
    }

    /// Closest approach to the boundary of the ray from `origin` along `direction`, a unit vector.
    ///
    /// Exact for a ray that misses. `None` if there are no faces.
    pub fn closest_approach(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<ClosestApproach> {
        let nearest = self.nearest(origin)?;
        let mut best = ClosestApproach { on_ray: *origin, on_boundary: nearest.place, distance: nearest.distance };
        for (faces, bounds) in self.groups() {
            if distance_min(origin, direction, bounds) > best.distance {
                continue;
            }
            for face in faces {
                let [a, b, c] = self.faces.corners(face);
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    let found = between(origin, direction, &from, &to);
                    if found.distance < best.distance {
                        best = found;
                    }
                }
            }
        }
        Some(best)
    }

    /// Outward unit normal of face `face`.
    pub fn normal(&self, face: usize) -> Vector3<f64> {
        let [a, b, c] = self.faces.corners(face);
        (b - a).cross(&(c - a)).normalize()
    }
}

/// Lower bound of the distance between a ray, whose direction has length one, and a box: that of the box's center, less
/// half the diagonal.
fn distance_min(origin: &Point3<f64>, direction: &Vector3<f64>, [low, high]: &[Point3<f64>; 2]) -> f64 {
    let offset = nalgebra::center(low, high) - origin;
    let nearest = direction * direction.dot(&offset).max(0.0);
    let reach = (offset - nearest).norm() * (1.0 - SLACK) - SLACK * offset.norm();
    reach - 0.5 * (high - low).norm() * (1.0 + SLACK)
}

/// Returns true if the ray meets a box before `limit`.
fn meets_box(origin: &Point3<f64>, direction: &Vector3<f64>, [low, high]: &[Point3<f64>; 2], limit: f64) -> bool {
    let slack = SLACK * (high - low).amax().max(low.coords.amax()).max(high.coords.amax());
    let (mut enter, mut leave) = (0.0_f64, limit);
    for axis in 0..3 {
        let inverse = 1.0 / direction[axis];
        let a = (low[axis] - slack - origin[axis]) * inverse;
        let b = (high[axis] + slack - origin[axis]) * inverse;
        // A ray in the plane of a side yields 0 · ∞ = NaN, which `max` and `min` ignore.
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter <= leave * (1.0 + SLACK)
}

/// Intersection of a ray and a triangle, in lengths of the ray's direction.
fn meets(origin: &Point3<f64>, direction: &Vector3<f64>, [a, b, c]: [Point3<f64>; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(&ac);
    let determinant = ab.dot(&across);
    if determinant == 0.0 {
        return None;
    }
    let offset = origin - a;
    let u = offset.dot(&across) / determinant;
    let turned = offset.cross(&ab);
    let v = direction.dot(&turned) / determinant;
    let distance = ac.dot(&turned) / determinant;
    let inside = u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE;
    (inside && distance >= 0.0 && distance.is_finite()).then_some(distance)
}

/// Closest points of a ray, whose direction has length one, and the segment from `from` to `to`.
fn between(origin: &Point3<f64>, direction: &Vector3<f64>, from: &Point3<f64>, to: &Point3<f64>) -> ClosestApproach {
    let (along, offset) = (to - from, origin - from);
    let (length, slope) = (along.norm_squared(), direction.dot(&along));
    let (ahead, beside) = (direction.dot(&offset), along.dot(&offset));
    let denominator = length - slope * slope;
    let ray = if denominator > 0.0 { ((slope * beside - ahead * length) / denominator).max(0.0) } else { 0.0 };
    let segment = if length > 0.0 { ((slope * ray + beside) / length).clamp(0.0, 1.0) } else { 0.0 };
    // The clamp moved the point on the segment, so the point on the ray follows.
    let ray = (slope * segment - ahead).max(0.0);
    let (on_ray, on_boundary) = (origin + direction * ray, from + along * segment);
    ClosestApproach { on_ray, on_boundary, distance: (on_ray - on_boundary).norm() }
}

#[cfg(test)]
mod tests {
    use super::super::{BoundaryNodes, SurfaceFaces};
    use super::*;
    use crate::random::RandomStream;

    fn block() -> BoundaryNodes {
        BoundaryNodes::new(&crate::lattice::block([5, 4, 6], 0.1))
    }

    fn random(stream: &mut RandomStream, scale: f64) -> Vector3<f64> {
        Vector3::from([(); 3].map(|()| scale * (stream.uniform() - 0.5)))
    }

    #[test]
    fn rays_hit_the_same_face_as_brute_force() {
        let (boundary, mut stream) = (block(), RandomStream::new(8, 0));
        let mut hits = 0;
        for _ in 0..500 {
            let (origin, direction) = (Point3::from(random(&mut stream, 2.0)), random(&mut stream, 1.0));
            let all = (0..boundary.faces.len()).filter_map(|face| meets(&origin, &direction, boundary.corners(face)));
            let plain = all.min_by(f64::total_cmp);
            let found = boundary.search().first_hit(&origin, &direction);
            assert_eq!(found.map(|hit| hit.distance), plain, "{origin} {direction}");
            hits += usize::from(found.is_some());
        }
        assert!((20..480).contains(&hits), "both hits and misses occur: {hits}");
    }

    #[test]
    fn rays_along_axes_and_through_corners_hit() {
        let boundary = block();
        let middle = |axis: usize| {
            let all = boundary.positions.iter().map(|corner| corner[axis]);
            0.5 * (all.clone().fold(f64::INFINITY, f64::min) + all.fold(f64::NEG_INFINITY, f64::max))
        };
        let center = Point3::new(middle(0), middle(1), middle(2));
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let direction = Vector3::ith(axis, sign);
                let hit = boundary.search().first_hit(&(center - direction * 3.0), &direction).unwrap();
                assert!(boundary.search().normal(hit.face).dot(&direction) < 0.0, "{axis} {sign}");
            }
        }
        for corner in &boundary.positions {
            let from = corner + (corner - center) * 2.0;
            let hit = boundary.search().first_hit(&from, &(center - from));
            assert!(hit.is_some_and(|hit| (hit.place - corner).norm() < 1e-6), "{corner}");
        }
    }

    #[test]
    fn the_closest_approach_is_that_of_points_along_the_ray() {
        let (boundary, mut stream, mut misses) = (block(), RandomStream::new(9, 0), 0);
        while misses < 20 {
            let (origin, direction) = (Point3::from(random(&mut stream, 3.0)), random(&mut stream, 1.0).normalize());
            if boundary.search().first_hit(&origin, &direction).is_some() {
                continue;
            }
            misses += 1;
            let found = boundary.search().closest_approach(&origin, &direction).unwrap();
            let along = (0..4000).map(|k| origin + direction * (f64::from(k) * 1e-3));
            let sampled = along.map(|point| boundary.nearest(&point).unwrap().distance).fold(f64::INFINITY, f64::min);
            assert!(found.distance <= sampled + 1e-12 && sampled <= found.distance + 1e-3, "{found:?} {sampled}");
        }
    }
}
