//! Shells: patches joined across edges that more than two triangles share.
//!
//! Around such an edge, each triangle is paired with the one on the other side of the solid between them (Hoffmann 1989, chapter 4).
//! Solids and cavities that touch along edges become shells of their own in this way, and none is left open.

use super::disjoint_sets::DisjointSets;
use super::edges::{Edges, HalfEdge};
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;

/// Angles around an edge that are distinguished: faces in one plane stay so when their coordinates are rounded to 32 bits.
const STEPS: i64 = 1 << 22;

/// Joins patches into shells: the triangles of each, ascending.
///
/// The windings must say where the solid is. Patches are joined only where all edges that connect them are passed equally often in
/// both directions. Other patches stay apart.
pub(super) fn join_patches(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    edges: &Edges,
    patches: Vec<Vec<u32>>,
) -> Vec<Vec<u32>> {
    let patch_of = super::shell_of(&patches, triangles.len());
    let patch = |half: &HalfEdge| patch_of[half.triangle as usize];
    let shared = || edges.groups().filter(|group| group.len() > 2);
    let mut connected = DisjointSets::new(patches.len());
    for group in shared() {
        group[1..].iter().for_each(|half| connected.join(patch(&group[0]), patch(half)));
    }
    let mut is_unclear = vec![false; patches.len()];
    for group in shared().filter(|group| !Edges::is_balanced(group)) {
        is_unclear[connected.root(patch(&group[0])) as usize] = true;
    }
    let mut shells = DisjointSets::new(patches.len());
    for group in shared() {
        if !is_unclear[connected.root(patch(&group[0])) as usize] {
            pair_around(positions, triangles, group, |a, b| shells.join(patch(a), patch(b)));
        }
    }
    collect(&mut shells, patches)
}

/// Merges the patches of each set, in the order of their first triangles.
fn collect(shells: &mut DisjointSets, patches: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let mut place_of = vec![None; patches.len()];
    let mut joined: Vec<Vec<u32>> = Vec::new();
    for (patch, members) in patches.into_iter().enumerate() {
        let place = *place_of[shells.root(patch as u32) as usize].get_or_insert(joined.len());
        match joined.get_mut(place) {
            Some(shell) => shell.extend(members),
            None => joined.push(members),
        }
    }
    joined.iter_mut().for_each(|shell| shell.sort_unstable());
    joined
}

/// Calls `pair` for the two triangles at the sides of each solid around an edge.
///
/// `group` is balanced. Seen along the edge, the solid lies after a triangle that runs backward and before one that runs forward.
/// Solids within solids are paired from the inside out, as brackets are.
fn pair_around(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    group: &[HalfEdge],
    mut pair: impl FnMut(&HalfEdge, &HalfEdge),
) {
    let steps = angles(positions, triangles, group).into_iter().map(step);
    let mut around: Vec<(i64, &HalfEdge)> = steps.zip(group).collect();
    // Where solids touch along a face, one ends before the next begins.
    around.sort_by_key(|(step, half)| (*step, !half.forward, *half));
    let mut open: Vec<&HalfEdge> = Vec::new();
    // The second round closes the solids that began in the first one.
    let mut paired = vec![false; around.len()];
    for (place, (_, half)) in (0..2).flat_map(|_| around.iter().enumerate()) {
        if paired[place] {
            continue;
        }
        if half.forward {
            if let Some(begin) = open.pop() {
                pair(begin, half);
                paired[place] = true;
            }
        } else {
            open.push(half);
            paired[place] = true;
        }
    }
}

/// An angle in steps from 0 to [`STEPS`] - 1, so that triangles in one plane have equal ones.
fn step(angle: f64) -> i64 {
    (angle / TAU * STEPS as f64).round().rem_euclid(STEPS as f64) as i64
}

/// Angle of each triangle around the edge of `group`, in the order of the group.
fn angles(positions: &[Point3<f64>], triangles: &[[u32; 3]], group: &[HalfEdge]) -> Vec<f64> {
    let [from, to] = group[0].ends.map(|vertex| positions[vertex as usize]);
    let axis = (to - from).normalize();
    let arm = |half: &HalfEdge| {
        let apex = triangles[half.triangle as usize][(half.side as usize + 2) % 3];
        let arm = positions[apex as usize] - from;
        arm - axis * axis.dot(&arm)
    };
    let first: Vector3<f64> = arm(&group[0]).normalize();
    let second = axis.cross(&first);
    group.iter().map(arm).map(|arm| arm.dot(&second).atan2(arm.dot(&first))).collect()
}

#[cfg(test)]
#[path = "radial_tests.rs"]
mod tests;
