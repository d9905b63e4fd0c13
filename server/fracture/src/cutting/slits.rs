//! Closes films that are too narrow for single precision: the triangle beyond the film gets its vertex.

use super::short_edges::LENGTH_MIN;
use crate::lattice::area_vector;
use crate::surface::Surface;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// True if the height of a triangle is below [`LENGTH_MIN`].
pub(super) fn is_slit(corners: &[Point3<f64>; 3]) -> bool {
    let longest = (0..3).map(|k| (corners[(k + 1) % 3] - corners[k]).norm()).fold(0.0, f64::max);
    2.0 * area_vector(corners).norm() < LENGTH_MIN * longest
}

/// Replaces triangles from number `first` on whose height is below [`LENGTH_MIN`]: their longest side is divided at the
/// opposite vertex in the triangle beyond it. Returns the number of replaced triangles.
pub(super) fn close_slits(surface: &mut Surface, first: usize) -> usize {
    let sides = |(own, &[a, b, c]): (u32, &[u32; 3])| [[a, b], [b, c], [c, a]].map(|edge| (edge, own));
    let mut owners: HashMap<[u32; 2], u32> = (0..).zip(&surface.triangles).flat_map(sides).collect();
    let mut is_closed = vec![false; surface.triangles.len()];
    for own in first..surface.triangles.len() {
        let Some(([a, b, m], height)) = longest_side(surface, own) else { continue };
        let Some(&beyond) = owners.get(&[b, a]).filter(|_| height < LENGTH_MIN) else { continue };
        let corners = surface.triangles[beyond as usize];
        let Some(turn) = corners.iter().position(|&corner| corner == b) else { continue };
        let apex = corners[(turn + 2) % 3];
        if beyond as usize == own || apex == m || is_closed[beyond as usize] {
            continue;
        }
        let added = surface.triangles.len() as u32;
        divide(surface, beyond as usize, turn, m);
        is_closed.push(false);
        is_closed[own] = true;
        owners.remove(&[b, a]);
        owners.remove(&[a, b]);
        let pieces = [beyond, added].map(|piece| (piece, surface.triangles[piece as usize]));
        for (piece, [x, y, z]) in pieces {
            owners.extend([[x, y], [y, z], [z, x]].map(|edge| (edge, piece)));
        }
    }
    let count = is_closed.iter().filter(|is_closed| **is_closed).count();
    if count > 0 {
        keep(surface, &is_closed);
    }
    count
}

/// Corners of a triangle, its longest side first, and its height on that side; `None` if two corners coincide.
fn longest_side(surface: &Surface, own: usize) -> Option<([u32; 3], f64)> {
    let ([a, b, c], at) = (surface.triangles[own], surface.corners(own));
    let lengths = [(at[1] - at[0]).norm(), (at[2] - at[1]).norm(), (at[0] - at[2]).norm()];
    let longest = (0..3).max_by(|i, j| lengths[*i].total_cmp(&lengths[*j]))?;
    let mut corners = [a, b, c];
    corners.rotate_left(longest);
    let height = 2.0 * area_vector(&at).norm() / lengths[longest];
    Some((corners, height)).filter(|_| height.is_finite())
}

/// Corners of a triangle from corner `turn` on.
fn turned<T: Copy>(corners: [T; 3], turn: usize) -> [T; 3] {
    [0, 1, 2].map(|k| corners[(turn + k) % 3])
}

/// Divides the values of a triangle as [`divide`] does the triangle. `t`: place of the new vertex on the side, from 0 to 1.
fn divide_values<const N: usize>(values: &mut Vec<[[f32; N]; 3]>, own: usize, turn: usize, t: f64) {
    if !values.is_empty() {
        let [b, a, x] = turned(values[own], turn);
        let mixed = std::array::from_fn(|k| (f64::from(b[k]) * (1.0 - t) + f64::from(a[k]) * t) as f32);
        values[own] = [b, mixed, x];
        values.push([mixed, a, x]);
    }
}

/// Divides a triangle at vertex `m` of the side that begins at corner `turn`: it keeps the beginning, and the rest is added.
fn divide(surface: &mut Surface, own: usize, turn: usize, m: u32) {
    let [b, a, x] = turned(surface.triangles[own], turn);
    surface.triangles[own] = [b, m, x];
    surface.triangles.push([m, a, x]);
    surface.faces.push(surface.faces[own]);
    surface.solids.push(surface.solids[own]);
    let [from, to, middle] = [b, a, m].map(|vertex| -> Point3<f64> { surface.positions[vertex as usize] });
    let t = (middle - from).dot(&(to - from)) / (to - from).norm_squared();
    let attributes = &mut surface.attributes;
    if !attributes.normals.is_empty() {
        let [b, a, x] = turned(attributes.normals[own], turn);
        let mixed = Vector3::from(b).lerp(&Vector3::from(a), t as f32);
        let normal = mixed.try_normalize(0.0).map_or(b, Into::into);
        attributes.normals[own] = [b, normal, x];
        attributes.normals.push([normal, a, x]);
    }
    for set in [&mut attributes.uvs, &mut attributes.uvs2] {
        divide_values(set, own, turn, t);
    }
    divide_values(&mut attributes.colors, own, turn, t);
    if !attributes.materials.is_empty() {
        attributes.materials.push(attributes.materials[own]);
    }
}

/// Drops the closed triangles.
fn keep(surface: &mut Surface, is_closed: &[bool]) {
    fn drop_closed<T>(list: &mut Vec<T>, is_closed: &[bool]) {
        let mut own = is_closed.iter();
        list.retain(|_| !own.next().copied().unwrap_or(false));
    }
    drop_closed(&mut surface.triangles, is_closed);
    drop_closed(&mut surface.faces, is_closed);
    drop_closed(&mut surface.solids, is_closed);
    drop_closed(&mut surface.attributes.normals, is_closed);
    drop_closed(&mut surface.attributes.uvs, is_closed);
    drop_closed(&mut surface.attributes.uvs2, is_closed);
    drop_closed(&mut surface.attributes.colors, is_closed);
    drop_closed(&mut surface.attributes.materials, is_closed);
}
