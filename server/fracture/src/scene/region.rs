//! Parts of space that a scene speaks of.

use nalgebra::Point3;
use serde::Deserialize;

/// A part of space, in the coordinates of the mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Region {
    /// A ball.
    Ball {
        /// Its centre, m.
        center: [f64; 3],
        /// Its radius, m.
        radius_m: f64,
    },
    /// A box along the axes.
    Box {
        /// Its lowest corner, m.
        min: [f64; 3],
        /// Its highest corner, m.
        max: [f64; 3],
    },
}

impl Region {
    /// Whether its numbers are finite and it has an inside.
    pub fn is_solid(&self) -> bool {
        match self {
            Self::Ball { center, radius_m } => {
                center.iter().all(|x| x.is_finite()) && radius_m.is_finite() && *radius_m > 0.0
            }
            Self::Box { min, max } => min.iter().zip(max).all(|(low, high)| low < high && (high - low).is_finite()),
        }
    }

    /// Distance of `point_m` from it, m; 0 inside.
    pub fn distance_m(&self, point_m: &Point3<f64>) -> f64 {
        match self {
            Self::Ball { center, radius_m } => ((point_m - Point3::from(*center)).norm() - radius_m).max(0.0),
            Self::Box { min, max } => {
                let outside = |axis: usize| (min[axis] - point_m[axis]).max(point_m[axis] - max[axis]).max(0.0);
                (0..3).map(|axis| outside(axis).powi(2)).sum::<f64>().sqrt()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_geometry() {
        let ball = Region::Ball { center: [1.0, 0.0, 0.0], radius_m: 0.5 };
        let cube = Region::Box { min: [-1.0; 3], max: [1.0; 3] };
        let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        assert_eq!([at(1.2, 0.0, 0.0), at(3.0, 0.0, 0.0)].map(|point| ball.distance_m(&point)), [0.0, 1.5]);
        assert_eq!(cube.distance_m(&at(0.9, -0.9, 0.0)), 0.0);
        assert_eq!(cube.distance_m(&at(4.0, 5.0, 0.5)), 5.0);
        let flat = Region::Box { min: [0.0; 3], max: [1.0, 1.0, 0.0] };
        let hollow = Region::Ball { center: [0.0; 3], radius_m: f64::NAN };
        assert!(ball.is_solid() && cube.is_solid() && !flat.is_solid() && !hollow.is_solid());
    }
}
