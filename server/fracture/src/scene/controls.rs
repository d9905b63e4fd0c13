//! An artist's controls of an object's cracks.

use super::Region;
use nalgebra::{Point3, Vector3};

/// Elongation of fragments along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Direction, of any length above zero.
    pub axis: Vector3<f64>,
    /// Ratio of the length along the direction to that across it; below 1: shorter. With interior distances somewhat
    /// more.
    pub ratio: f64,
}

/// Undulation of cracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// Wavelength, m.
    pub length_m: f64,
    /// Root mean square slope of a formerly plane crack. 0.3 is strong; above about 0.4 the space folds.
    pub slope: f64,
}

/// Local density of fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paint {
    /// Painted points, coordinates of the mesh file, m.
    pub points_m: Vec<Point3<f64>>,
    /// Fragments per volume at each point, relative to those without paint; above zero.
    pub factors: Vec<f64>,
}

/// All controls of an artist. They do not affect whether the object breaks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WarpControls {
    /// Elongation of fragments along a direction.
    pub grain: Option<Grain>,
    /// Undulation of cracks.
    pub waves: Option<Waves>,
    /// Local density of fragments.
    pub paint: Option<Paint>,
    /// Regions that cracks do not cross. Where no natural crack is farther away, cracks lie on the boundary of the region: of
    /// a ball of r crack spacings, about 0.3/r spacings outside; of a box, up to 0.8.
    pub protected: Vec<Region>,
    /// Fixed sites, each the center of a fragment, coordinates of the mesh file, m.
    pub sites_m: Vec<Point3<f64>>,
}

impl WarpControls {
    /// True if there are no controls.
    pub fn is_silent(&self) -> bool {
        *self == Self::default()
    }
}
