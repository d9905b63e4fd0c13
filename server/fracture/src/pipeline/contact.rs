//! A contact of an impact.

use nalgebra::{Point3, Vector3};
/// One contact, in the coordinates of the mesh file (meters, y up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactContact {
    /// Contact point, m.
    pub point_m: Point3<f64>,
    /// Impulse on the object, N·s.
    pub impulse_ns: Vector3<f64>,
    /// Contact duration, s; `None`: the scene's default.
    pub duration_s: Option<f64>,
    /// Contact radius, m; `None`: the scene's default.
    pub radius_m: Option<f64>,
}
