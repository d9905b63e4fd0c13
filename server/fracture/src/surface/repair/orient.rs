//! Consistent orientation of each patch: triangles connected through edges that exactly two of them share.

use super::super::defect::DefectTally;
use super::edges::Edges;
use nalgebra::{Point3, Vector3};

/// Patches of a consistently wound mesh.
pub(super) struct Patches {
    /// Triangles of each patch, ascending.
    pub members: Vec<Vec<u32>>,
    /// Triangles whose winding was reversed.
    pub turned: DefectTally,
    /// Edges across which the orientation cannot be consistent.
    pub twisted: DefectTally,
}

/// Winds each patch consistently and keeps the orientation that covers more area.
///
/// `face` maps a triangle to its face in the report.
pub(super) fn orient(
    positions: &[Point3<f64>],
    triangles: &mut [[u32; 3]],
    edges: &Edges,
    face: impl Fn(u32) -> u64,
) -> Patches {
    let neighbors = neighbors(edges, triangles.len());
    let mut patches = Patches { members: Vec::new(), turned: DefectTally::default(), twisted: DefectTally::default() };
    let mut against: Vec<Option<bool>> = vec![None; triangles.len()];
    for seed in 0..triangles.len() as u32 {
        if against[seed as usize].is_some() {
            continue;
        }
        let mut members = spread(seed, &neighbors, &mut against, |triangle| patches.twisted.note(face(triangle)));
        members.sort_unstable();
        let area_of = |side: bool| {
            let same = members.iter().filter(|&&t| against[t as usize] == Some(side));
            same.map(|&t| area_vector(positions, &triangles[t as usize]).norm()).sum::<f64>()
        };
        let minority = area_of(true) <= area_of(false);
        for &triangle in members.iter().filter(|&&t| against[t as usize] == Some(minority)) {
            triangles[triangle as usize].swap(1, 2);
            patches.turned.note(face(triangle));
        }
        patches.members.push(members);
    }
    patches
}

/// Area times unit normal of a triangle.
pub(super) fn area_vector(positions: &[Point3<f64>], corners: &[u32; 3]) -> Vector3<f64> {
    let [a, b, c] = corners.map(|vertex| positions[vertex as usize]);
    (b - a).cross(&(c - a)) * 0.5
}

/// Neighbors of each triangle, by side.
///
/// An entry holds the triangle across, if exactly one, and whether both run along the edge in the same direction, that
/// is, are wound against each other.
fn neighbors(edges: &Edges, triangles: usize) -> Vec<[Option<(u32, bool)>; 3]> {
    let mut neighbors = vec![[None; 3]; triangles];
    for group in edges.groups() {
        if let [a, b] = group {
            let against = a.forward == b.forward;
            neighbors[a.triangle as usize][a.side as usize] = Some((b.triangle, against));
            neighbors[b.triangle as usize][b.side as usize] = Some((a.triangle, against));
        }
    }
    neighbors
}

/// Collects and marks the patch of `seed`: false for triangles wound like the seed, true for the others.
///
/// Calls `twisted` for each edge that contradicts.
fn spread(
    seed: u32,
    neighbors: &[[Option<(u32, bool)>; 3]],
    against: &mut [Option<bool>],
    mut twisted: impl FnMut(u32),
) -> Vec<u32> {
    against[seed as usize] = Some(false);
    let mut members = vec![seed];
    let mut next = 0;
    while next < members.len() {
        let triangle = members[next];
        next += 1;
        let own = against[triangle as usize] == Some(true);
        for &(other, differs) in neighbors[triangle as usize].iter().flatten() {
            match against[other as usize] {
                None => {
                    against[other as usize] = Some(own != differs);
                    members.push(other);
                }
                // Each contradicting edge is met from both sides; the lower triangle reports it.
                Some(known) if known != (own != differs) && triangle < other => twisted(triangle),
                Some(_) => {}
            }
        }
    }
    members
}
