//! Defects of coordinates and indices.

use super::super::draw::ChoiceStream;
use nalgebra::Vector3;
use shatter_fracture::surface::RawMesh;

/// Maximum share of damaged vertices.
const SHARE_MAX: f64 = 0.1;

pub(super) fn nan(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    coordinates(mesh, draw, |_| f64::NAN);
}

pub(super) fn infinity(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    coordinates(mesh, draw, |draw| f64::INFINITY.copysign(draw.between(-1.0, 1.0)));
}

pub(super) fn huge(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    if draw.chance(0.5) {
        coordinates(mesh, draw, |draw| 1e30_f64.copysign(draw.between(-1.0, 1.0)));
    } else {
        scale(mesh, 1e30);
    }
}

pub(super) fn denormal(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    if draw.chance(0.7) {
        coordinates(mesh, draw, |draw| f64::from_bits(1 + draw.below(1 << 20) as u64));
    } else {
        scale(mesh, 1e-310);
    }
}

pub(super) fn index_out_of_range(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let vertices = mesh.positions_m.len() as u32;
    for _ in 0..draw.few(mesh.triangles.len(), SHARE_MAX) {
        let (triangle, corner) = (draw.below(mesh.triangles.len()), draw.below(3));
        let past = [vertices, vertices + draw.below(1 << 20) as u32, u32::MAX];
        mesh.triangles[triangle][corner] = past[draw.below(3)];
    }
}

pub(super) fn huge_offset(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let offset = draw.direction() * (diagonal(mesh) * draw.decade(3.0, 18.0));
    mesh.positions_m.iter_mut().for_each(|point| *point += offset);
}

pub(super) fn tiny_scale(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    // Half of them at sizes that occur in practice.
    let lowest = if draw.chance(0.5) { -9.0 } else { -80.0 };
    scale(mesh, draw.decade(lowest, -3.0));
}

/// Diagonal of the bounding box.
pub(super) fn diagonal(mesh: &RawMesh) -> f64 {
    let [low, high] = bounds(mesh);
    (high - low).norm()
}

/// Lowest and highest corner of the bounding box.
pub(super) fn bounds(mesh: &RawMesh) -> [Vector3<f64>; 2] {
    let coords = || mesh.positions_m.iter().map(|point| point.coords);
    [
        coords().fold(Vector3::repeat(f64::INFINITY), |low, p| low.inf(&p)),
        coords().fold(Vector3::repeat(f64::NEG_INFINITY), |high, p| high.sup(&p)),
    ]
}

fn scale(mesh: &mut RawMesh, factor: f64) {
    mesh.positions_m.iter_mut().for_each(|point| *point *= factor);
}

/// Sets single coordinates of a few vertices.
fn coordinates(mesh: &mut RawMesh, draw: &mut ChoiceStream, value: impl Fn(&mut ChoiceStream) -> f64) {
    for _ in 0..draw.few(mesh.positions_m.len(), SHARE_MAX) {
        let (vertex, axis) = (draw.below(mesh.positions_m.len()), draw.below(3));
        mesh.positions_m[vertex][axis] = value(draw);
    }
}
