//! Edges too short for single precision: crack points on them, or even their ends, would have one position in a result.

use super::meshed_surface::MeshedSurface;
use nalgebra::Point3;
use std::collections::BTreeSet;

/// Length below which an edge is collapsed, local: two units in the last place of the largest coordinate.
pub(super) const LENGTH_MIN: f64 = 1.0 / (1 << 23) as f64;

/// Length below which an edge is not cut, local: crack points keep half of it from its ends.
const CUT_LENGTH_MIN: f64 = 4e-6;

/// Collapses each edge of less than [`LENGTH_MIN`] into its lower vertex, where the surface stays a manifold. Returns these
/// vertices of the edges, too. What is left keeps its order and its positions.
///
/// Based on: T. K. Dey, H. Edelsbrunner, S. Guha, D. V. Nekhayev, *Topology preserving edge contraction* (1999), the
/// link condition.
pub(super) fn collapse(mut surface: MeshedSurface) -> (MeshedSurface, Vec<Point3<f64>>) {
    let MeshedSurface { positions, triangles, .. } = &mut surface;
    let is_short = |[a, b]: [u32; 2]| (positions[a as usize] - positions[b as usize]).norm() < LENGTH_MIN;
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    let mut short: Vec<[u32; 2]> = triangles.iter().flat_map(|own| sides(*own)).filter(|[a, b]| a < b).collect();
    short.retain(|edge| is_short(*edge));
    if short.is_empty() {
        return (surface, Vec::new());
    }
    let mut around = vec![Vec::new(); positions.len()];
    for (index, triangle) in triangles.iter().enumerate() {
        triangle.iter().for_each(|&vertex| around[vertex as usize].push(index as u32));
    }
    let mut merged: Vec<u32> = (0..positions.len() as u32).collect();
    let mut places = Vec::new();
    for edge in short {
        let [a, b] = edge.map(|vertex| root(&merged, vertex));
        if a != b && is_short([a, b]) && contract(triangles, &mut around, a.min(b), a.max(b)) {
            merged[a.max(b) as usize] = a.min(b);
            places.push(positions[a.min(b) as usize]);
        }
    }
    (surface.compact(), places)
}

/// Nodes that edges too short to be cut join, each with the lowest node of its group; ascending, without that node itself.
pub(super) fn groups(nodes: &[Point3<f64>], edges: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let is_short = |[a, b]: &&[u32; 2]| (nodes[*a as usize] - nodes[*b as usize]).norm() < CUT_LENGTH_MIN;
    let short: Vec<[u32; 2]> = edges.iter().filter(is_short).copied().collect();
    if short.is_empty() {
        return Vec::new();
    }
    let mut merged: Vec<u32> = (0..nodes.len() as u32).collect();
    for [a, b] in short {
        let (a, b) = (root(&merged, a), root(&merged, b));
        merged[a.max(b) as usize] = a.min(b);
    }
    let lowest = |node: u32| [node, root(&merged, node)];
    (0..nodes.len() as u32).map(lowest).filter(|[node, lowest]| node != lowest).collect()
}

fn root(merged: &[u32], mut vertex: u32) -> u32 {
    while merged[vertex as usize] != vertex {
        vertex = merged[vertex as usize];
    }
    vertex
}

/// Moves vertex `b` to `a`; returns false, and changes nothing, if the surface would no longer be a manifold.
fn contract(triangles: &mut [[u32; 3]], around: &mut [Vec<u32>], a: u32, b: u32) -> bool {
    let is_whole = |[x, y, z]: [u32; 3]| x != y && y != z && z != x;
    let ring = |center: u32| -> BTreeSet<u32> {
        let own = around[center as usize].iter().map(|&triangle| triangles[triangle as usize]);
        own.filter(|own| is_whole(*own)).flatten().filter(|&vertex| vertex != center).collect()
    };
    if ring(a).intersection(&ring(b)).count() != 2 {
        return false;
    }
    let moved = std::mem::take(&mut around[b as usize]);
    for &triangle in &moved {
        let corners = &mut triangles[triangle as usize];
        corners.iter_mut().filter(|corner| **corner == b).for_each(|corner| *corner = a);
    }
    around[a as usize].extend(moved);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::shapes;

    #[test]
    fn short_edges_go_and_the_rest_stays() {
        let mesh = shapes::sphere(0.3, 2);
        let meshed = |positions: &[Point3<f64>], triangles: &[[u32; 3]]| MeshedSurface {
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            corners: Vec::new(),
            sources: (0..triangles.len() as u32).collect(),
        };
        let (mut positions, mut triangles) = (mesh.positions_m, mesh.triangles);
        let whole = meshed(&positions, &triangles);
        assert_eq!(collapse(whole.clone()), (whole.clone(), Vec::new()));
        // The first triangle gets a vertex very near its first corner.
        let [a, b, c] = triangles[0];
        let near = positions[a as usize]
            + (positions[b as usize] - positions[a as usize]) * 1e-8
            + (positions[c as usize] - positions[a as usize]) * 1e-8;
        let added = positions.len() as u32;
        positions.push(near);
        triangles[0] = [a, b, added];
        triangles.extend([[b, c, added], [c, a, added]]);
        let (collapsed, places) = collapse(meshed(&positions, &triangles));
        assert_eq!(places, [positions[a as usize]]);
        assert_eq!(collapsed.positions, positions[..added as usize]);
        assert_eq!(collapsed.triangles.len(), whole.triangles.len());
        let mut sides: Vec<[u32; 2]> =
            collapsed.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
        sides.sort_unstable();
        assert!(sides.iter().all(|[a, b]| sides.binary_search(&[*b, *a]).is_ok()));
    }
}
