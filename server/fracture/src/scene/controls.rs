//! What an artist says about the cracks of an object.

use super::Region;
use nalgebra::{Point3, Vector3};

/// Fragments longer along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// The direction, any length above zero.
    pub axis: Vector3<f64>,
    /// How many times longer than across it; below 1: shorter. With interior distances somewhat more.
    pub ratio: f64,
}

/// Cracks that wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// Wavelength, m.
    pub length_m: f64,
    /// Root mean square slope of what was a plane: 0.3 is plenty, above about 0.4 space folds.
    pub slope: f64,
}

/// More cracks here than there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paint {
    /// Painted points, coordinates of the mesh file, m.
    pub points_m: Vec<Point3<f64>>,
    /// Pieces per volume at each point, over what there would be without; above zero.
    pub factors: Vec<f64>,
}

/// All that an artist says. Nothing of it changes whether an object breaks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WarpControls {
    /// Fragments longer along a direction.
    pub grain: Option<Grain>,
    /// Cracks that wind.
    pub waves: Option<Waves>,
    /// More cracks here than there.
    pub paint: Option<Paint>,
    /// Regions that no crack passes through.
    pub protected: Vec<Region>,
    /// Points around which there is a piece, coordinates of the mesh file, m.
    pub sites_m: Vec<Point3<f64>>,
}

impl WarpControls {
    /// True if nothing is said.
    pub fn is_silent(&self) -> bool {
        *self == Self::default()
    }
}
