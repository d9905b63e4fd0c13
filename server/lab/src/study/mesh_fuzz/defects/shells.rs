//! Defects of the whole shape.

use super::super::draw::ChoiceStream;
use super::super::inside::winding;
use super::numbers::{bounds, diagonal};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use shatter_fracture::surface::{RawMesh, shapes};

/// Number of points tried for the center of a nested ball.
const TRIES: usize = 24;

/// Maximum radius of a nested ball over the free distance around its center.
const ROOM: f64 = 0.7;

pub(super) fn self_intersection(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    match draw.below(3) {
        0 => push_through(mesh, draw),
        1 => swap_vertices(mesh, draw),
        _ => {
            let turn = Rotation3::from_axis_angle(&Unit::new_normalize(draw.direction()), draw.between(0.1, 1.5));
            let shift = draw.direction() * (diagonal(mesh) * draw.between(0.0, 0.2));
            let copy = mesh.clone();
            append(mesh, &copy, |point| turn * point + shift);
        }
    }
}

/// Moves the vertices near one of them by up to half a diagonal.
fn push_through(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let middle = mesh.positions_m[draw.below(mesh.positions_m.len())];
    let radius = diagonal(mesh) * draw.between(0.05, 0.3);
    let shift = draw.direction() * (diagonal(mesh) * draw.between(0.1, 0.5));
    for point in mesh.positions_m.iter_mut().filter(|point| (**point - middle).norm() <= radius) {
        *point += shift;
    }
}

fn swap_vertices(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    for _ in 0..draw.few(mesh.positions_m.len(), 0.05) {
        let (one, two) = (draw.below(mesh.positions_m.len()), draw.below(mesh.positions_m.len()));
        mesh.positions_m.swap(one, two);
    }
}

pub(super) fn two_shells(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let [low, high] = bounds(mesh);
    let (axis, scale) = (draw.below(3), draw.between(0.5, 1.0));
    // From overlapping by much to a gap of a fifth of the width.
    let shift = Vector3::ith(axis, (high - low)[axis] * draw.between(0.3, 1.2));
    let middle = (low + high) * 0.5;
    let copy = mesh.clone();
    append(mesh, &copy, |point| Point3::from(middle + (point.coords - middle) * scale + shift));
}

pub(super) fn nested_shell(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let [low, high] = bounds(mesh);
    let (mut middle, mut room) = (Point3::from((low + high) * 0.5), 0.0);
    for _ in 0..TRIES {
        let point = Point3::from((high - low).map(|side| draw.between(0.0, side)) + low);
        let distance = mesh.positions_m.iter().map(|p| (p - point).norm()).fold(f64::INFINITY, f64::min);
        if distance > room && winding(mesh, &point).abs() > 0.75 {
            (middle, room) = (point, distance);
        }
    }
    // Without a point inside, a small ball at the center of the box.
    let radius = if room > 0.0 { room * draw.between(0.2, ROOM) } else { 0.05 * (high - low).norm() };
    let mut ball = shapes::sphere(radius, 1);
    if draw.chance(0.5) {
        ball.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    }
    append(mesh, &ball, |point| point + middle.coords);
}

pub(super) fn zero_thickness(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let axis = draw.below(3);
    let left = if draw.chance(0.4) { 0.0 } else { draw.decade(-15.0, -2.0) };
    mesh.positions_m.iter_mut().for_each(|point| point[axis] *= left);
}

pub(super) fn coplanar(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let normal = if draw.chance(0.5) { Vector3::ith(draw.below(3), 1.0) } else { draw.direction() };
    let height = mesh.positions_m[draw.below(mesh.positions_m.len())].coords.dot(&normal);
    for point in &mut mesh.positions_m {
        *point += normal * (height - point.coords.dot(&normal));
    }
}

/// Appends the triangles of `other`, with its vertices moved.
fn append(mesh: &mut RawMesh, other: &RawMesh, place: impl Fn(&Point3<f64>) -> Point3<f64>) {
    let first = mesh.positions_m.len() as u32;
    mesh.positions_m.extend(other.positions_m.iter().map(place));
    mesh.triangles.extend(other.triangles.iter().map(|corners| corners.map(|vertex| first + vertex)));
}
