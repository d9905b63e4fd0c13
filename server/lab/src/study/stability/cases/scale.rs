//! Cases: size and position; the same object in micrometers, in megameters, and far from the origin.

use super::super::trial::{TrialFault, TrialResult, baked, coarse, difference, sites, sound, struck};
use nalgebra::{Isometry3, Point3, Vector3};
use shatter_fracture::pipeline::FractureRequest;
use shatter_fracture::surface::{RawMesh, shapes};

/// Arch, scaled and moved; rotated so that no face lies in a plane of the lattice, where rounding would decide.
fn arch(scale: f64, shift_m: f64) -> RawMesh {
    let mesh = shapes::arch();
    let askew = Isometry3::rotation(Vector3::new(0.31, 0.17, -0.23));
    let place = |point: &Point3<f64>| (askew * point) * scale + Vector3::repeat(shift_m);
    RawMesh::new(mesh.positions_m.iter().map(place).collect(), mesh.triangles)
}

/// Result with 16 sites, and γ scaled with the fifth power of length so that W/γ is constant.
fn struck_at_scale(scale: f64, shift_m: f64) -> Result<TrialResult, TrialFault> {
    let prepared = baked(arch(scale, shift_m), &coarse()?)?;
    // A point of the input, so that it is the same for all scales.
    let point_m = arch(scale, shift_m).positions_m[0];
    let inward = prepared.frame.center_m - point_m;
    let strike = sites(FractureRequest::at(point_m, inward * scale).seeded(1), 16);
    let result = struck(&prepared, &strike)?;
    sound(&prepared, &result)?;
    Ok(result)
}

/// Largest relative difference of a fragment's volume from the object of unit size at the origin.
fn like_the_original(scale: f64, shift_m: f64) -> Result<f64, TrialFault> {
    Ok(difference(&struck_at_scale(1.0, 0.0)?, &struck_at_scale(scale, shift_m)?, scale.powi(3)))
}

pub fn micrometers() -> Result<f64, TrialFault> {
    like_the_original(1e-6, 0.0)
}

pub fn megameters() -> Result<f64, TrialFault> {
    like_the_original(1e6, 0.0)
}

pub fn far_from_the_origin() -> Result<f64, TrialFault> {
    like_the_original(1.0, 1e6)
}

/// Largest distance of a vertex from its fragment's center over the object's diagonal, for the distant object: f32 keeps its digits
/// only because vertices are relative to their fragment.
pub fn positions_are_relative() -> Result<f64, TrialFault> {
    let result = struck_at_scale(1.0, 1e6)?;
    let farthest = result.positions.iter().flatten().map(|x| f64::from(x.abs())).fold(0.0, f64::max);
    Ok(farthest / arch_diagonal())
}

fn arch_diagonal() -> f64 {
    let points = arch(1.0, 0.0).positions_m;
    let low = points.iter().fold(Vector3::repeat(f64::INFINITY), |low, point| low.inf(&point.coords));
    let high = points.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |high, point| high.sup(&point.coords));
    (high - low).norm()
}
