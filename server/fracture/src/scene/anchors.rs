//! Anchors: where the world holds an object, and how it pulls at what it holds.

use nalgebra::{Point3, Vector3};
use std::fmt::{Display, Formatter, Result};

/// Gravity where an object has weight and nobody says how much, m/s²; y is up.
pub const DEFAULT_GRAVITY_M_S2: [f64; 3] = [0.0, -9.81, 0.0];

/// A part of space, in the coordinates of the mesh file, m. What lies in it, or on its boundary, is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// A ball.
    Ball {
        /// Its centre.
        centre_m: Point3<f64>,
        /// Its radius, positive.
        radius_m: f64,
    },
    /// A box along the axes.
    Cuboid {
        /// The corner with the smallest coordinates.
        min_m: Point3<f64>,
        /// The corner with the largest.
        max_m: Point3<f64>,
    },
}

impl Region {
    /// Whether `point_m` (mesh file, m) is held.
    pub fn holds(&self, point_m: &Point3<f64>) -> bool {
        match self {
            Self::Ball { centre_m, radius_m } => (point_m - centre_m).norm() <= *radius_m,
            Self::Cuboid { min_m, max_m } => (0..3).all(|k| (min_m[k]..=max_m[k]).contains(&point_m[k])),
        }
    }
}

impl Display for Region {
    fn fmt(&self, out: &mut Formatter<'_>) -> Result {
        let point = |point: &Point3<f64>| format!("({}, {}, {})", point.x, point.y, point.z);
        match self {
            Self::Ball { centre_m, radius_m } => write!(out, "the ball of {radius_m} m around {}", point(centre_m)),
            Self::Cuboid { min_m, max_m } => write!(out, "the box from {} to {} m", point(min_m), point(max_m)),
        }
    }
}

/// What holds an object. Without regions nothing does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Anchors {
    /// Nodes in any of these do not move.
    pub regions: Vec<Region>,
    /// The acceleration that gives a held object its weight, m/s²; `None`: it has none.
    pub gravity_m_s2: Option<Vector3<f64>>,
}

impl Anchors {
    /// Whether `point_m` (mesh file, m) is held.
    pub fn hold(&self, point_m: &Point3<f64>) -> bool {
        self.regions.iter().any(|region| region.holds(point_m))
    }
}
