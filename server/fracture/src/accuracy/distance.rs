//! Distance between crack surfaces.

use crate::lattice::area_vector;
use crate::surface::NearestTriangles;
use nalgebra::Point3;
use rayon::prelude::*;

/// Distances between two crack surfaces, local: over the bounding-box diagonal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CrackDistance {
    /// Mean of both directions, each the area mean of the distance from one surface to the other.
    pub mean: f64,
    /// Largest distance in either direction: the Hausdorff distance of the sample points.
    pub max: f64,
}

/// Barycentric coordinates of sample points that stand for a third of a triangle's area
/// each: exact for linear functions.
const PLACES: [[f64; 3]; 3] =
    [[2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]];

/// Triangles per parallel task and partial sum.
const CHUNK: usize = 512;

/// Distances between two crack surfaces, given as triangle soups in local coordinates.
///
/// A crack that only one of them has counts with its distance to the nearest crack of the other. Zero if both are
/// empty, infinite if one is.
pub fn crack_distance(cracks: &[[Point3<f64>; 3]], reference: &[[Point3<f64>; 3]]) -> CrackDistance {
    match (cracks.is_empty(), reference.is_empty()) {
        (true, true) => CrackDistance::default(),
        (false, false) => {
            let (there, back) = (one_way(cracks, reference), one_way(reference, cracks));
            CrackDistance { mean: (there.mean + back.mean) / 2.0, max: there.max.max(back.max) }
        }
        _ => CrackDistance { mean: f64::INFINITY, max: f64::INFINITY },
    }
}

fn one_way(from: &[[Point3<f64>; 3]], to: &[[Point3<f64>; 3]]) -> CrackDistance {
    let nearest = NearestTriangles::new(to);
    let chunk = |triangles: &[[Point3<f64>; 3]]| {
        let (mut area, mut moment, mut max) = (0.0, 0.0, 0.0f64);
        for triangle in triangles {
            let size = area_vector(triangle).norm();
            let [a, b, c] = triangle.map(|corner| corner.coords);
            for [u, v, w] in PLACES {
                let distance = nearest.distance(&Point3::from(a * u + b * v + c * w));
                area += size / 3.0;
                moment += size / 3.0 * distance;
                max = max.max(distance);
            }
            max = triangle.iter().map(|corner| nearest.distance(corner)).fold(max, f64::max);
        }
        (area, moment, max)
    };
    let parts: Vec<(f64, f64, f64)> = from.par_chunks(CHUNK).map(chunk).collect();
    let area: f64 = parts.iter().map(|part| part.0).sum();
    let moment: f64 = parts.iter().map(|part| part.1).sum();
    let max = parts.iter().map(|part| part.2).fold(0.0, f64::max);
    CrackDistance { mean: if area > 0.0 { moment / area } else { max }, max }
}
