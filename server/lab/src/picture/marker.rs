//! Markers in a scene.

use super::color::Color;
use super::mesh::DrawnMesh;
use nalgebra::{Point3, Vector3};
use std::f32::consts::TAU;

/// Number of corners around the arrow.
const SIDES: u32 = 40;

/// Arrow of length `length` along `direction` that ends at `tip`. Empty if the direction is zero.
pub fn arrow(tip: Point3<f32>, direction: Vector3<f32>, length: f32, color: Color) -> DrawnMesh {
    let Some(axis) = direction.try_normalize(1e-12) else {
        return DrawnMesh::default();
    };
    let aside = if axis.y.abs() > 0.9 { Vector3::x() } else { Vector3::y() };
    let across = aside.cross(&axis).normalize();
    let along = axis.cross(&across);
    // Profile from the tip backwards: distance from the tip and radius, both over the length.
    let profile = [(0.0, 0.0), (0.34, 0.115), (0.34, 0.042), (1.0, 0.042), (1.0, 0.0)];
    let mut positions = Vec::new();
    for (distance, radius) in profile {
        for side in 0..SIDES {
            let (sin, cos) = (TAU * side as f32 / SIDES as f32).sin_cos();
            positions.push(tip - axis * (distance * length) + (across * cos + along * sin) * (radius * length));
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..profile.len() as u32 - 1 {
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            let [a, b] = [ring * SIDES + side, ring * SIDES + next];
            let [c, d] = [a + SIDES, b + SIDES];
            triangles.extend([[a, b, d], [a, d, c]].map(|[p, q, r]| [p, r, q]));
        }
    }
    DrawnMesh::paint(positions, triangles, 30.0, |_, _| color)
}
