//! Anchors: where the world holds an object, and how it pulls at what it holds.

use super::Region;
use nalgebra::{Point3, Vector3};

/// Gravity where an object has weight and nobody says how much, m/s²; y is up.
pub const DEFAULT_GRAVITY_M_S2: [f64; 3] = [0.0, -9.81, 0.0];

/// What holds an object. Without regions nothing does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Anchors {
    /// Nodes in any of these do not move.
    pub regions: Vec<Region>,
    /// The acceleration that gives a held object its weight, m/s²; `None`: it has none.
    pub gravity_m_s2: Option<Vector3<f64>>,
}

impl Anchors {
    /// True if `point_m` (mesh file, m) is held.
    pub fn contains(&self, point_m: &Point3<f64>) -> bool {
        self.regions.iter().any(|region| region.holds(point_m))
    }
}
