//! The local frame: bounding-box center at the origin, bounding-box diagonal 1.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Diagonals that are accepted, m: fragments go out in single precision, which keeps all its digits from 1e-38 to 3e38, and
/// a vertex may lie a millionth of the diagonal from its fragment's center.
pub(crate) const DIAGONAL_RANGE_M: std::ops::RangeInclusive<f64> = 1e-30..=1e36;

/// Maps the mesh file's coordinates (meters, after `--unit`; y up, after `--up`) to local ones and back.
///
/// Scaling the input by a power of two changes `diagonal_m` alone, exactly; translating it changes `center_m` alone,
/// to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalFrame {
    /// Center of the bounding box, meters.
    pub center_m: Point3<f64>,
    /// Diagonal of the bounding box, meters; finite and positive.
    pub diagonal_m: f64,
}

impl LocalFrame {
    /// Meters to local.
    pub fn to_local(&self, point_m: &Point3<f64>) -> Point3<f64> {
        Point3::from((point_m - self.center_m) / self.diagonal_m)
    }

    /// Local to meters.
    pub fn to_meters(&self, local: &Point3<f64>) -> Point3<f64> {
        self.center_m + local.coords * self.diagonal_m
    }

    /// A local direction or offset in meters.
    pub fn offset_m(&self, local: &Vector3<f64>) -> Vector3<f64> {
        local * self.diagonal_m
    }
}
