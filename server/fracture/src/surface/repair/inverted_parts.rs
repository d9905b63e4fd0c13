//! Parts that are inside out beside others: they touch along edges or faces, however the faces are divided.
//!
//! Winding numbers are -1 in such a part, 1 in the others, and 0 in cavities and outside. They tell which patches to turn, except
//! for walls between an inverted part and another one: two layers cover them, and one of the two belongs to each part. One layer is
//! turned, so that each edge is passed equally often in both directions afterward.

use super::disjoint_sets::DisjointSets;
use super::edges::{Edges, HalfEdge};
use super::given_windings::{GivenWindings, Sides, given_windings};
use super::orient::area_vector;
use super::radial::join_patches;
use nalgebra::Point3;
use rayon::prelude::*;

/// Largest number of triangles of a patch whose sides are examined, the largest first.
const TRIED_MAX: usize = 16;

/// Parts of a surface that were turned.
#[derive(Default)]
pub(super) struct TurnedParts {
    /// Whether each triangle was turned. Empty if none was.
    pub is_turned: Vec<bool>,
    /// A triangle of each turned part.
    pub parts: Vec<u32>,
}

/// Turns inverted parts of a closed surface outward, if all winding numbers are 0 or 1 afterward, and changes nothing otherwise.
///
/// Surfaces whose parts are all inverted, or none of them, stay as they are.
pub(super) fn turn_inverted_parts(positions: &[Point3<f64>], triangles: &mut [[u32; 3]]) -> TurnedParts {
    let edges = Edges::new(triangles);
    let (patches, patch_of) = patches(&edges, triangles.len());
    if patches.len() < 2 || !edges.balanced() {
        return TurnedParts::default();
    }
    let Some(turn) = patches_to_turn(positions, triangles, &patches, &edges, &patch_of) else {
        return TurnedParts::default();
    };
    let mut outward = triangles.to_vec();
    let is_turned: Vec<bool> = patch_of.iter().map(|&patch| turn[patch as usize]).collect();
    outward.iter_mut().zip(&is_turned).filter(|(_, turn)| **turn).for_each(|(corners, _)| corners.swap(1, 2));
    let edges = Edges::new(&outward);
    if !edges.balanced() || given_windings(positions, &outward, &patches) != Some(GivenWindings::Outward) {
        return TurnedParts::default();
    }
    triangles.copy_from_slice(&outward);
    let shells = join_patches(positions, triangles, &edges, patches);
    let first = |shell: &Vec<u32>| shell.iter().copied().find(|&triangle| is_turned[triangle as usize]);
    TurnedParts { parts: shells.iter().filter_map(first).collect(), is_turned }
}

/// Triangles connected through edges that exactly two of them share, and the patch of each triangle.
fn patches(edges: &Edges, triangle_count: usize) -> (Vec<Vec<u32>>, Vec<u32>) {
    let mut sets = DisjointSets::new(triangle_count);
    for group in edges.groups() {
        if let [a, b] = group {
            sets.join(a.triangle, b.triangle);
        }
    }
    let mut patches: Vec<Vec<u32>> = Vec::new();
    let mut patch_of = vec![0; triangle_count];
    for triangle in 0..triangle_count as u32 {
        let root = sets.root(triangle);
        if root == triangle {
            patch_of[triangle as usize] = patches.len() as u32;
            patches.push(Vec::new());
        }
        let patch = patch_of[root as usize];
        patch_of[triangle as usize] = patch;
        patches[patch as usize].push(triangle);
    }
    (patches, patch_of)
}

/// Whether to turn each patch; `None` unless some are to be turned and others not.
fn patches_to_turn(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    patches: &[Vec<u32>],
    edges: &Edges,
    patch_of: &[u32],
) -> Option<Vec<bool>> {
    let sides = Sides::new(positions, triangles);
    let area = |triangle: &u32| area_vector(positions, &triangles[*triangle as usize]).norm();
    let found = |members: &Vec<u32>| {
        let mut tried = members.clone();
        tried.sort_by(|a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
        tried.truncate(TRIED_MAX);
        let mut best = Found { sample: tried[0], kind: PatchKind::Layers };
        for sample in tried {
            match PatchKind::of(sides.whole_windings(sample)?)? {
                PatchKind::Layers => {}
                PatchKind::Wall if best.kind == PatchKind::Wall => {}
                PatchKind::Wall => best = Found { sample, kind: PatchKind::Wall },
                kind => return Some(Found { sample, kind }),
            }
        }
        Some(best)
    };
    let found: Vec<Found> = patches.par_iter().map(found).collect::<Option<_>>()?;
    let has = |kind| found.iter().any(|own| own.kind == kind);
    let is_mixed = has(PatchKind::Wall) || has(PatchKind::Inverted) && has(PatchKind::Outward);
    is_mixed.then(|| with_walls(&found, &sides, edges, patch_of))
}

/// Kind of a patch, and the triangle that shows it.
struct Found {
    sample: u32,
    kind: PatchKind,
}

/// Place of a patch between parts.
#[derive(Clone, Copy, PartialEq)]
enum PatchKind {
    Outward,
    Inverted,
    /// A layer between an inverted part and another one.
    Wall,
    /// One of several layers that enclose nothing.
    Layers,
}

impl PatchKind {
    /// Kind by the winding numbers in front and behind; `None` for those of other surfaces.
    fn of(windings: [i32; 2]) -> Option<Self> {
        match windings {
            [-1, 1] => Some(Self::Wall),
            [0, 0] => Some(Self::Layers),
            [-1, -1 | 0] => Some(Self::Inverted),
            [0 | 1, 1] => Some(Self::Outward),
            _ => None,
        }
    }
}

/// Whether to turn each patch: walls so that each edge is passed equally often in both directions, and one of two layers.
fn with_walls(found: &[Found], sides: &Sides, edges: &Edges, patch_of: &[u32]) -> Vec<bool> {
    let mut known: Vec<Option<bool>> = Vec::with_capacity(found.len());
    known.extend(found.iter().map(|own| match own.kind {
        PatchKind::Outward => Some(false),
        PatchKind::Inverted => Some(true),
        PatchKind::Wall | PatchKind::Layers => None,
    }));
    let patch = |triangle: u32| patch_of[triangle as usize] as usize;
    let groups: Vec<&[HalfEdge]> = edges.groups().filter(|group| group.len() > 2).collect();
    let mut groups_of: Vec<Vec<usize>> = vec![Vec::new(); known.len()];
    for (place, group) in groups.iter().enumerate() {
        let walls = group.iter().map(|half| patch(half.triangle)).filter(|&own| known[own].is_none());
        walls.for_each(|own| groups_of[own].push(place));
    }
    let mut waiting: Vec<usize> = (0..groups.len()).rev().collect();
    for next in 0..known.len() {
        while let Some(place) = waiting.pop() {
            if let Some((own, turn)) = balanced_by(groups[place], &known, patch) {
                known[own] = Some(turn);
                waiting.extend(&groups_of[own]);
            }
        }
        if known[next].is_some() {
            continue;
        }
        let others: Vec<usize> = sides.layers(found[next].sample).into_iter().map(patch).collect();
        let turn = others.iter().any(|&own| known[own] == Some(false));
        known[next] = Some(turn);
        waiting.extend(&groups_of[next]);
        for own in others {
            if known[own].is_none() {
                known[own] = Some(!turn);
                waiting.extend(&groups_of[own]);
            }
        }
    }
    known.into_iter().map(|turn| turn == Some(true)).collect()
}

/// The only patch around an edge that is not decided, and whether turning it balances the edge.
fn balanced_by(group: &[HalfEdge], known: &[Option<bool>], patch: impl Fn(u32) -> usize) -> Option<(usize, bool)> {
    let mut open = group.iter().map(|half| patch(half.triangle)).filter(|&own| known[own].is_none());
    let last = open.next().filter(|last| open.all(|other| other == *last))?;
    let (mut own, mut others) = (0, 0);
    for half in group {
        let sign = if half.forward { 1 } else { -1 };
        match known[patch(half.triangle)] {
            None => own += sign,
            Some(turn) => others += if turn { -sign } else { sign },
        }
    }
    Some((last, own != 0 && own == others))
}

#[cfg(test)]
#[path = "inverted_parts_tests.rs"]
mod tests;
