//! Defects of the list of triangles.

use super::super::draw::ChoiceStream;
use nalgebra::Point3;
use shatter_fracture::surface::RawMesh;

/// Maximum area of a small hole as a share of the whole area, unless a single triangle is larger.
const HOLE_SHARE_MAX: f64 = 0.02;

pub(super) fn dropped(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let share = draw.between(0.0, 0.5);
    let first = draw.below(mesh.triangles.len());
    mesh.triangles.swap_remove(first);
    mesh.triangles.retain(|_| !draw.chance(share));
}

pub(super) fn duplicated(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let own_vertices = draw.chance(0.5);
    for _ in 0..draw.few(mesh.triangles.len(), 0.5) {
        let mut copy = mesh.triangles[draw.below(mesh.triangles.len())];
        copy.rotate_left(draw.below(3));
        if own_vertices {
            copy = copy.map(|vertex| {
                mesh.positions_m.push(mesh.positions_m[vertex as usize]);
                mesh.positions_m.len() as u32 - 1
            });
        }
        let place = draw.below(mesh.triangles.len());
        mesh.triangles.insert(place, copy);
    }
}

pub(super) fn flipped(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    for _ in 0..draw.few(mesh.triangles.len(), 0.45) {
        let triangle = draw.below(mesh.triangles.len());
        mesh.triangles[triangle].swap(0, 1);
    }
}

pub(super) fn inside_out(mesh: &mut RawMesh) {
    mesh.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
}

/// Reverses a part that grows from one triangle across shared vertices.
pub(super) fn mixed_winding(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let around = around(mesh);
    let wanted = draw.few(mesh.triangles.len(), 0.6);
    let start = draw.below(mesh.triangles.len()) as u32;
    let (mut part, mut taken, mut next) = (vec![start], vec![false; mesh.triangles.len()], 0);
    taken[start as usize] = true;
    while next < part.len() && part.len() < wanted {
        let corners = mesh.triangles[part[next] as usize];
        next += 1;
        for &other in corners.iter().flat_map(|&vertex| &around[vertex as usize]) {
            if !std::mem::replace(&mut taken[other as usize], true) {
                part.push(other);
            }
        }
    }
    part.iter().for_each(|&triangle| mesh.triangles[triangle as usize].swap(0, 1));
}

/// Removes the triangles around a vertex, or a single triangle if that hole would be too large.
pub(super) fn small_holes(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    let around = around(mesh);
    let areas: Vec<f64> = mesh.triangles.iter().map(|corners| area(mesh, corners)).collect();
    let whole: f64 = areas.iter().sum();
    let mut keep = vec![true; mesh.triangles.len()];
    for _ in 0..1 + draw.below(4) {
        let triangle = draw.below(mesh.triangles.len());
        let vertex = mesh.triangles[triangle][draw.below(3)];
        let fan = &around[vertex as usize];
        keep[triangle] = false;
        if fan.iter().map(|&t| areas[t as usize]).sum::<f64>() <= HOLE_SHARE_MAX * whole {
            fan.iter().for_each(|&t| keep[t as usize] = false);
        }
    }
    let mut keep = keep.iter();
    mesh.triangles.retain(|_| keep.next() == Some(&true));
}

/// Splits triangles at a vertex exactly on or close to one of their edges, and leaves the neighbor across unsplit.
pub(super) fn t_junction(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    for _ in 0..draw.few(mesh.triangles.len(), 0.3) {
        let triangle = draw.below(mesh.triangles.len());
        mesh.triangles[triangle].rotate_left(draw.below(3));
        let [a, b, c] = mesh.triangles[triangle];
        let [from, to] = [a, b].map(|vertex| mesh.positions_m[vertex as usize].coords);
        let share = draw.between(0.2, 0.8);
        let beside = draw.direction() * ((to - from).norm() * if draw.chance(0.5) { 0.0 } else { 1e-3 });
        let middle = mesh.positions_m.len() as u32;
        mesh.positions_m.push(Point3::from(from + (to - from) * share + beside));
        mesh.triangles[triangle] = [a, middle, c];
        mesh.triangles.push([middle, b, c]);
    }
}

pub(super) fn single(mesh: &mut RawMesh, draw: &mut ChoiceStream) {
    mesh.triangles = vec![mesh.triangles[draw.below(mesh.triangles.len())]];
}

/// Triangles around each vertex.
fn around(mesh: &RawMesh) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); mesh.positions_m.len()];
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        corners.iter().for_each(|&vertex| around[vertex as usize].push(triangle as u32));
    }
    around
}

fn area(mesh: &RawMesh, corners: &[u32; 3]) -> f64 {
    let [a, b, c] = corners.map(|vertex| mesh.positions_m[vertex as usize]);
    0.5 * (b - a).cross(&(c - a)).norm()
}
