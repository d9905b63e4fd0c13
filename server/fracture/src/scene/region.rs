//! Regions of space in scenes.

use super::number;
use nalgebra::Point3;
use std::fmt::{Display, Formatter, Result};

/// A closed region of space, in the coordinates of the mesh file, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// A ball.
    Ball {
        /// Center, m.
        center_m: Point3<f64>,
        /// Radius, m, positive.
        radius_m: f64,
    },
    /// An axis-aligned box.
    Cuboid {
        /// Corner with the smallest coordinates, m.
        min_m: Point3<f64>,
        /// Corner with the largest coordinates, m.
        max_m: Point3<f64>,
    },
}

impl Region {
    /// True if `point_m` is in the region.
    pub fn holds(&self, point_m: &Point3<f64>) -> bool {
        self.distance_m(point_m) == 0.0
    }

    /// Distance of `point_m` from the region, m; 0 inside.
    pub fn distance_m(&self, point_m: &Point3<f64>) -> f64 {
        self.signed_distance_m(point_m).max(0.0)
    }

    /// Distance of `point_m` from the region's boundary, m; negative inside.
    pub fn signed_distance_m(&self, point_m: &Point3<f64>) -> f64 {
        match self {
            Self::Ball { center_m, radius_m } => (point_m - center_m).norm() - radius_m,
            Self::Cuboid { min_m, max_m } => {
                let outside = [0, 1, 2].map(|k| (min_m[k] - point_m[k]).max(point_m[k] - max_m[k]));
                let largest = outside.into_iter().fold(f64::NEG_INFINITY, f64::max);
                let distance = || outside.iter().map(|own| own.max(0.0).powi(2)).sum::<f64>().sqrt();
                if largest < 0.0 { largest } else { distance() }
            }
        }
    }
}

impl Display for Region {
    fn fmt(&self, out: &mut Formatter<'_>) -> Result {
        let point = |point: &Point3<f64>| format!("({}, {}, {})", number(point.x), number(point.y), number(point.z));
        match self {
            Self::Ball { center_m, radius_m } => {
                write!(out, "the ball of {} m around {}", number(*radius_m), point(center_m))
            }
            Self::Cuboid { min_m, max_m } => write!(out, "the box from {} to {} m", point(min_m), point(max_m)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huge_and_tiny_numbers_are_short() {
        let ball = Region::Ball { center_m: Point3::new(1e300, -0.5, 0.0), radius_m: 1e-300 };
        assert_eq!(ball.to_string(), "the ball of 1e-300 m around (1e300, -0.5, 0)");
    }

    #[test]
    fn distances_are_those_of_geometry() {
        let ball = Region::Ball { center_m: Point3::new(1.0, 0.0, 0.0), radius_m: 0.5 };
        let cube = Region::Cuboid { min_m: Point3::new(-1.0, -1.0, -1.0), max_m: Point3::new(1.0, 1.0, 1.0) };
        let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        assert_eq!([at(1.2, 0.0, 0.0), at(3.0, 0.0, 0.0)].map(|point| ball.distance_m(&point)), [0.0, 1.5]);
        assert_eq!(cube.distance_m(&at(0.9, -0.9, 0.0)), 0.0);
        assert_eq!(cube.distance_m(&at(4.0, 5.0, 0.5)), 5.0);
        assert!(cube.holds(&at(1.0, 1.0, -1.0)) && !cube.holds(&at(1.0, 1.0, -1.1)));
        assert_eq!([at(1.0, 0.0, 0.0), at(1.5, 0.0, 0.0)].map(|point| ball.signed_distance_m(&point)), [-0.5, 0.0]);
        assert_eq!([at(0.5, -0.75, 0.0), at(1.0, 2.0, 0.0)].map(|point| cube.signed_distance_m(&point)), [-0.25, 1.0]);
    }
}
