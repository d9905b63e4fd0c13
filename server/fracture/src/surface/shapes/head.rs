//! Generated head of a person.

use super::RawMesh;
use super::implicit::implicit;
use super::objects::{blend, capsule};
use nalgebra::{Point3, Vector3};

/// Head of a person on a socle, 0.29 m high, with the face towards +z; about 100,000 triangles.
pub fn head() -> RawMesh {
    implicit(Point3::new(-0.1013, -0.0027, -0.1303), Point3::new(0.1013, 0.2953, 0.1183), 0.00387, height)
}

/// Height of the socle's lower side in the coordinates of the parts, m.
const BASE: f64 = 0.12;

/// Implicit function of the head, negative inside, m. Left and right are alike but for the hair.
fn height(place: &Point3<f64>) -> f64 {
    let place = place + Vector3::y() * BASE;
    let side = Point3::new(place.x.abs(), place.y, place.z);
    let head = blend(skull(&side), hair(&place), 0.006);
    let neck = capsule(&side, [0.0, 0.140, -0.022], [0.0, 0.225, -0.020], 0.055, 0.050);
    let socle = carve(side.x.hypot(side.z + 0.022) - 0.064, 0.138 - side.y, 0.014);
    carve(blend(blend(head, neck, 0.028), socle, 0.016), side.y - BASE, 0.014)
}

/// Head without hair.
fn skull(p: &Point3<f64>) -> f64 {
    let parts = [
        (ellipsoid(p, [0.0, 0.248, 0.030], [0.056, 0.078, 0.058]), 0.030),
        (ellipsoid(p, [0.0, 0.192, 0.058], [0.024, 0.018, 0.024]), 0.026),
        (capsule(p, [0.050, 0.225, 0.0], [0.012, 0.190, 0.052], 0.020, 0.014), 0.024),
        (ellipsoid(p, [0.036, 0.246, 0.058], [0.020, 0.018, 0.020]), 0.022),
        (capsule(p, [0.008, 0.2885, 0.0835], [0.046, 0.2905, 0.060], 0.0062, 0.0045), 0.020),
    ];
    let head = ellipsoid(p, [0.0, 0.305, -0.012], [0.074, 0.088, 0.094]);
    let head = parts.into_iter().fold(head, |all, (part, width)| blend(all, part, width));
    let socket = ellipsoid(p, [0.029, 0.271, 0.098], [0.0185, 0.0135, 0.022]);
    let parts = [
        (ellipsoid(p, EYE, [0.0135, 0.0125, 0.0135]), 0.003),
        (lid(p), 0.0025),
        (nose(p), 0.012),
        (ellipsoid(p, [0.0, 0.218, 0.0725], [0.033, 0.020, 0.0165]), 0.016),
        (lips(p), 0.0035),
        (ear(p), 0.006),
    ];
    parts.into_iter().fold(carve(head, socket, 0.012), |all, (part, width)| blend(all, part, width))
}

/// Center of an eyeball.
const EYE: [f64; 3] = [0.0285, 0.2715, 0.0715];

/// Upper half of a ball around the eye, bounded by an arch.
fn lid(p: &Point3<f64>) -> f64 {
    let arch = p.y - 0.2755 + 10.0 * (p.x - EYE[0]).powi(2);
    ellipsoid(p, EYE, [0.0155, 0.0142, 0.0158]).max(-arch)
}

fn nose(p: &Point3<f64>) -> f64 {
    let bridge = capsule(p, [0.0, 0.288, 0.081], [0.0, 0.2475, 0.1005], 0.0060, 0.0088);
    blend(bridge, ellipsoid(p, [0.0100, 0.2440, 0.0915], [0.0070, 0.0062, 0.0090]), 0.006)
}

fn lips(p: &Point3<f64>) -> f64 {
    let upper = capsule(p, [0.0, 0.2205, 0.0905], [0.0215, 0.2165, 0.0848], 0.0042, 0.0022);
    upper.min(capsule(p, [0.0, 0.2112, 0.0897], [0.0195, 0.2150, 0.0848], 0.0050, 0.0022))
}

fn ear(p: &Point3<f64>) -> f64 {
    let shell = ellipsoid(p, [0.076, 0.262, -0.006], [0.0095, 0.030, 0.019]);
    carve(shell, ellipsoid(p, [0.085, 0.264, 0.001], [0.0075, 0.020, 0.0115]), 0.005)
}

/// Hair: an ellipsoid with spiral grooves, which ends above the ears and the forehead.
fn hair(p: &Point3<f64>) -> f64 {
    let (angle, up) = ((p.z + 0.012).atan2(p.x), p.y - 0.3);
    let lock = (9.0 * angle + 45.0 * up + 2.2 * (70.0 * up + 3.0 * angle).sin()).sin();
    let from_crown = (p.x.hypot(p.z + 0.012) / 0.05).min(1.0);
    let cap = ellipsoid(p, [0.0, 0.3185, -0.026], [0.0835, 0.088, 0.092]) - 0.0024 * lock * from_crown;
    let forehead = p.z - 0.052 - 0.9 * (p.y - 0.345);
    carve(carve(cap, -forehead, 0.010), p.y - 0.232, 0.012)
}

/// Height of an ellipsoid, about the distance near its surface (I. Quilez).
fn ellipsoid(p: &Point3<f64>, center: [f64; 3], radii: [f64; 3]) -> f64 {
    let (offset, radii) = (p - Point3::from(center), Vector3::from(radii));
    let scaled = offset.component_div(&radii);
    let steepness = scaled.component_div(&radii).norm();
    if steepness == 0.0 { -radii.min() } else { scaled.norm() * (scaled.norm() - 1.0) / steepness }
}

/// Removes the region where `other` is negative, with an edge rounded by `width`.
fn carve(height: f64, other: f64, width: f64) -> f64 {
    -blend(-height, other, width)
}
