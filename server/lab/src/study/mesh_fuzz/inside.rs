//! Independent test whether a mesh clearly has an inside, without the engine's code, to judge its errors by.
//!
//! Based on: A. Jacobson, L. Kavan, O. Sorkine-Hornung, *Robust inside-outside segmentation using generalized winding
//! numbers* (2013), every triangle summed.

use nalgebra::{Point3, Vector3};
use shatter_fracture::surface::RawMesh;
use std::f64::consts::TAU;

/// Number of grid steps along the diagonal.
const STEPS: f64 = 16.0;

/// Maximum number of grid points along each side.
const SIDE_MAX: usize = 24;

/// Range of steps, m, in which single precision (the format of fragments) keeps all its digits.
const FRAGMENT_RANGE_M: std::ops::Range<f64> = 1e-30..1e34;

/// Minimum absolute winding number of a point inside.
const SURE: f64 = 0.75;

/// Whether some point and its six neighbors at 1/16 of the diagonal are surely inside, so that a lattice of that spacing fits, whichever
/// way the triangles face.
pub(super) fn clearly_has_inside(mesh: &RawMesh) -> bool {
    if mesh.check().is_err() {
        return false;
    }
    let used = || mesh.triangles.iter().flatten().map(|&vertex| mesh.positions_m[vertex as usize]);
    let low = used().fold(Point3::from([f64::INFINITY; 3]), |low, p| low.inf(&p));
    let high = used().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, p| high.sup(&p));
    let extent = high - low;
    let step = extent.norm() / STEPS;
    if !FRAGMENT_RANGE_M.contains(&step) {
        return false;
    }
    let count = extent.map(|side| ((side / step) as usize + 1).min(SIDE_MAX));
    let is_inside = |[x, y, z]: [usize; 3]| {
        let point = low + Vector3::new(x as f64, y as f64, z as f64) * step;
        let sure = |point: &Point3<f64>| winding(mesh, point).abs() > SURE;
        let around = |axis: usize, sign: f64| point + Vector3::ith(axis, sign * step);
        sure(&point) && (0..3).all(|axis| sure(&around(axis, 1.0)) && sure(&around(axis, -1.0)))
    };
    (0..count.x).any(|x| (0..count.y).any(|y| (0..count.z).any(|z| is_inside([x, y, z]))))
}

/// Winding number of the triangles around `point`.
pub(super) fn winding(mesh: &RawMesh, point: &Point3<f64>) -> f64 {
    let angle = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|vertex| mesh.positions_m[vertex as usize] - point);
        let [la, lb, lc] = [a, b, c].map(|side| side.norm());
        let cosine = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        a.dot(&b.cross(&c)).atan2(cosine)
    };
    mesh.triangles.iter().map(angle).sum::<f64>() / TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_fracture::surface::shapes;

    #[test]
    fn solids_have_an_inside_whichever_way_they_face_and_sheets_have_none() {
        let mut ball = shapes::sphere(1.0, 2);
        assert!(clearly_has_inside(&ball));
        ball.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
        assert!(clearly_has_inside(&ball));
        ball.positions_m.iter_mut().for_each(|p| p.y = 0.0);
        assert!(!clearly_has_inside(&ball));
        assert!(!clearly_has_inside(&shapes::cuboid([1.0, 1.0, 0.02])));
    }
}
