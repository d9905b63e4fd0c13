//! Moves parts of a surface apart that touch in a vertex.
//!
//! There the triangles around the vertex form several fans. Each gets its own vertex, moved into its fan by less than
//! single precision shows.

use super::meshed_surface::MeshedSurface;
use super::short_edges::LENGTH_MIN;
use crate::surface::DisjointSets;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Distance by which a vertex moves, local.
const SHIFT: f64 = 0.5 * LENGTH_MIN;

/// The surface with one vertex per fan, and the places of the vertices that were divided. `copies`: a division of the corners
/// where parts also touch along edges, or `None` for that by fans.
pub(super) fn separated(mut surface: MeshedSurface, copies: Option<&[u32]>) -> (MeshedSurface, Vec<Point3<f64>>) {
    let fans = copies.map_or_else(|| fans(&surface.triangles), <[u32]>::to_vec);
    // Vertices by old vertex and fan; the first fan keeps the old name.
    let mut first: Vec<Option<u32>> = vec![None; surface.positions.len()];
    let mut names: HashMap<(u32, u32), u32> = HashMap::new();
    let mut divided: Vec<u32> = Vec::new();
    let old = surface.positions.clone();
    let mut corners = surface.triangles.clone();
    for (corner, vertex) in corners.iter_mut().flatten().enumerate() {
        let fan = fans[corner];
        let own = *first[*vertex as usize].get_or_insert(fan);
        if own != fan {
            let positions = &mut surface.positions;
            *vertex = *names.entry((*vertex, fan)).or_insert_with(|| {
                divided.push(*vertex);
                positions.push(old[*vertex as usize]);
                positions.len() as u32 - 1
            });
        }
    }
    let copied = divided.len();
    divided.sort_unstable();
    divided.dedup();
    let moved = divided.iter().copied().chain((old.len() as u32)..(old.len() + copied) as u32);
    let mut rings: HashMap<u32, Vector3<f64>> = moved.map(|vertex| (vertex, Vector3::zeros())).collect();
    for triangle in &corners {
        for k in 0..3 {
            if let Some(sum) = rings.get_mut(&triangle[k]) {
                let at = |k: usize| surface.positions[triangle[k % 3] as usize];
                *sum += (at(k + 1) - at(k)) + (at(k + 2) - at(k));
            }
        }
    }
    for (vertex, sum) in rings {
        let step = sum.try_normalize(0.0).unwrap_or_default() * SHIFT;
        let place: &mut Point3<f64> = &mut surface.positions[vertex as usize];
        *place += step;
    }
    surface.triangles = corners;
    let places = divided.iter().map(|&vertex| old[vertex as usize]).collect();
    (surface, places)
}

/// Fan of each corner: corners of one vertex are in one fan if triangles join them across edges of two triangles.
fn fans(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut sides: Vec<([u32; 2], [u32; 2])> = Vec::with_capacity(3 * triangles.len());
    for (own, triangle) in (0_u32..).zip(triangles) {
        for k in 0..3 {
            let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
            let corners = [3 * own + k as u32, 3 * own + (k as u32 + 1) % 3];
            sides.push(if from < to { ([from, to], corners) } else { ([to, from], [corners[1], corners[0]]) });
        }
    }
    sides.sort_unstable();
    let mut sets = DisjointSets::new(3 * triangles.len());
    for pair in sides.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 2) {
        (0..2).for_each(|end| sets.join(pair[0].1[end], pair[1].1[end]));
    }
    (0..3 * triangles.len() as u32).map(|corner| sets.root(corner)).collect()
}
