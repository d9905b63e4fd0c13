//! Anchors: fixed regions of an object, and gravity on it.

use super::Region;
use nalgebra::{Point3, Vector3};

/// Default gravity of an object with weight, m/s²; y is up.
pub const DEFAULT_GRAVITY_M_S2: [f64; 3] = [0.0, -9.81, 0.0];

/// Fixed regions and gravity. Without regions, the object is free.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Anchors {
    /// Regions whose nodes do not move.
    pub regions: Vec<Region>,
    /// Gravitational acceleration of an anchored object, m/s²; `None`: no weight.
    pub gravity_m_s2: Option<Vector3<f64>>,
}

impl Anchors {
    /// True if `point_m` (mesh file, m) is in a fixed region.
    pub fn contains(&self, point_m: &Point3<f64>) -> bool {
        self.regions.iter().any(|region| region.holds(point_m))
    }
}
