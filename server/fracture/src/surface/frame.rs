//! The local frame: bounding-box centre at the origin, bounding-box diagonal 1.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Diagonals that are accepted, m: fragments go out in single precision, which keeps all its digits from 1e-38 to 3e38, and
/// a vertex may lie a millionth of the diagonal from its fragment's center.
pub(crate) const DIAGONAL_RANGE_M: std::ops::RangeInclusive<f64> = 1e-30..=1e36;

/// Maps the mesh file's coordinates (metres, after `--unit`; y up, after `--up`) to local ones and back.
///
/// Scaling the input by a power of two changes `diagonal_m` alone, exactly; translating it changes `centre_m` alone,
/// to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalFrame {
    /// Centre of the bounding box, metres.
    pub centre_m: Point3<f64>,
    /// Diagonal of the bounding box, metres; finite and positive.
    pub diagonal_m: f64,
}

impl LocalFrame {
    /// Metres to local.
    pub fn to_local(&self, point_m: &Point3<f64>) -> Point3<f64> {
        Point3::from((point_m - self.centre_m) / self.diagonal_m)
    }

    /// Local to metres.
    pub fn to_metres(&self, local: &Point3<f64>) -> Point3<f64> {
        self.centre_m + local.coords * self.diagonal_m
    }

    /// A local direction or offset in metres.
    pub fn offset_m(&self, local: &Vector3<f64>) -> Vector3<f64> {
        local * self.diagonal_m
    }
}
