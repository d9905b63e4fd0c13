//! Local frame of an object: bounding-box center at the origin, bounding-box diagonal 1.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Accepted bounding-box diagonals, m.
///
/// Fragments are sent in single precision, which keeps all its digits from 1e-38 to 3e38. A vertex may lie a millionth
/// of the diagonal from its fragment's center.
pub(crate) const DIAGONAL_RANGE_M: std::ops::RangeInclusive<f64> = 1e-30..=1e36;

/// Transform between the coordinates of a mesh file (meters, y up) and local coordinates.
///
/// The mesh file's coordinates are those after `--unit` and `--up`. Scaling the input by a power of two changes only
/// `diagonal_m`, exactly. Translating it changes only `center_m`, to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalFrame {
    /// Center of the bounding box, meters.
    pub center_m: Point3<f64>,
    /// Diagonal of the bounding box, meters; finite and positive.
    pub diagonal_m: f64,
}

impl LocalFrame {
    /// Converts a position from meters to local.
    pub fn to_local(&self, point_m: &Point3<f64>) -> Point3<f64> {
        Point3::from((point_m - self.center_m) / self.diagonal_m)
    }

    /// Converts a position from local to meters.
    pub fn to_meters(&self, local: &Point3<f64>) -> Point3<f64> {
        self.center_m + local.coords * self.diagonal_m
    }

    /// Converts a direction or offset from local to meters.
    pub fn offset_m(&self, local: &Vector3<f64>) -> Vector3<f64> {
        local * self.diagonal_m
    }
}
