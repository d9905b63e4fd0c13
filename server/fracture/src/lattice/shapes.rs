//! Analytic signed distances for tests.

use super::SignedDistance;
use nalgebra::{Isometry3, Point3, Vector3};

/// Shape given by a closure and half the sides of its box.
pub(super) struct ImplicitShape<F: Fn(&Point3<f64>) -> f64 + Sync> {
    /// Signed distance.
    pub(super) distance: F,
    /// Half sides of the box, centered at the origin.
    pub(super) half: Vector3<f64>,
}

impl<F: Fn(&Point3<f64>) -> f64 + Sync> SignedDistance for ImplicitShape<F> {
    fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        (self.distance)(point)
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        (Point3::from(-self.half), Point3::from(self.half))
    }
}

/// Ball at the origin.
pub(super) fn ball(radius: f64) -> impl SignedDistance {
    ImplicitShape { distance: move |p: &Point3<f64>| p.coords.norm() - radius, half: Vector3::repeat(radius) }
}

/// Union of balls, each given by center and radius.
pub(super) fn balls(balls: Vec<(Point3<f64>, f64)>) -> impl SignedDistance {
    let reach = balls.iter().map(|(center, radius)| center.coords.abs().add_scalar(*radius));
    let half = reach.fold(Vector3::zeros(), |a: Vector3<f64>, b| a.sup(&b));
    let distance = move |p: &Point3<f64>| {
        balls.iter().map(|(center, radius)| (p - center).norm() - radius).fold(f64::INFINITY, f64::min)
    };
    ImplicitShape { distance, half }
}

/// Torus around the z axis.
pub(super) fn torus(ring: f64, tube: f64) -> impl SignedDistance {
    let distance = move |p: &Point3<f64>| (p.x.hypot(p.y) - ring).hypot(p.z) - tube;
    ImplicitShape { distance, half: Vector3::new(ring + tube, ring + tube, tube) }
}

/// Box of half sides `half`, transformed by `isometry`.
pub(super) fn cuboid(half: Vector3<f64>, isometry: Isometry3<f64>) -> impl SignedDistance {
    let distance = move |p: &Point3<f64>| {
        let q = isometry.inverse_transform_point(p).coords.abs() - half;
        q.sup(&Vector3::zeros()).norm() + q.max().min(0.0)
    };
    let reach = isometry.rotation.to_rotation_matrix().matrix().abs() * half + isometry.translation.vector.abs();
    ImplicitShape { distance, half: reach }
}
