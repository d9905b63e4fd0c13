//! Carriers: the tetrahedron of the crack lattice from which a node of the cutting mesh takes its values.
//!
//! Nodes near the surface may lie outside the lattice, or inside a part of it that is separated from them by a narrow
//! gap. So the carrier is not found by position alone: it is walked to from the carriers of neighbors in the cutting
//! mesh, through faces of the lattice. A walk does not jump over a gap, but it may go around its end.
//!
//! Based on: O. Devillers, S. Pion, M. Teillaud, *Walking in a triangulation* (2002). The walk over two meshes is ours.

use crate::lattice::{Lattice, NO_TET};
use nalgebra::{Matrix3, Point3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Barycentric coordinate below which values are not extrapolated: about one height of the tetrahedron outside.
const EXTRAPOLATED_MIN: f64 = -1.0;

/// Gain in the least barycentric coordinate that is not due to rounding on another processor.
const MISPLACED_TOLERANCE: f64 = 1e-6;

/// Longest walk, in tetrahedra.
const WALK_MAX: usize = 256;

/// No node or tetrahedron yet.
const NONE: u32 = u32::MAX;

/// Source of the values at a node of the cutting mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carrier {
    /// Tetrahedron of the crack lattice.
    pub tet: u32,
    /// Weights of its corners; they sum to 1, and are negative where the values are extrapolated.
    pub weights: [f64; 4],
    /// True if the node is too far from the lattice: its values are those of the nearest corner, edge or face.
    pub is_anchored: bool,
}

/// Barycentric coordinates in the tetrahedra of a lattice.
struct Frames(Vec<(Point3<f64>, Matrix3<f64>)>);

impl Frames {
    fn new(lattice: &Lattice) -> Self {
        let frame = |tet: usize| {
            let inverse = lattice.edge_matrix(tet).try_inverse().unwrap_or_else(Matrix3::zeros);
            (lattice.corners(tet)[0], inverse)
        };
        Self((0..lattice.tets.len()).into_par_iter().map(frame).collect())
    }

    fn at(&self, tet: u32, point: &Point3<f64>) -> [f64; 4] {
        let (origin, inverse) = &self.0[tet as usize];
        let weights = inverse * (point - origin);
        [1.0 - weights.sum(), weights.x, weights.y, weights.z]
    }
}

fn least(weights: &[f64; 4]) -> f64 {
    weights.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Carriers of all nodes in the given tetrahedra of the lattice.
pub(super) fn weights(mesh: &Lattice, crack: &Lattice, tets: &[u32]) -> Vec<Carrier> {
    let frames = Frames::new(crack);
    let carrier = |(node, &tet): (&Point3<f64>, &u32)| {
        let weights = frames.at(tet, node);
        if least(&weights) >= EXTRAPOLATED_MIN {
            return Carrier { tet, weights, is_anchored: false };
        }
        let clamped = weights.map(|weight| weight.max(0.0));
        let sum: f64 = clamped.iter().sum();
        Carrier { tet, weights: clamped.map(|weight| weight / sum), is_anchored: true }
    };
    mesh.nodes.par_iter().zip(tets).map(carrier).collect()
}

/// The first node with a carrier at which no walk ends: a neighbor of the carrier, through the face where a walk goes on, fits better.
pub(super) fn misplaced(mesh: &Lattice, crack: &Lattice, carriers: &[Carrier]) -> Option<usize> {
    let (frames, around) = (Frames::new(crack), crack.neighbors());
    let is_misplaced = |node: usize| {
        let weights = frames.at(carriers[node].tet, &mesh.nodes[node]);
        let faces = (0..4).zip(around[carriers[node].tet as usize]);
        let exits = faces.filter(|(face, other)| weights[*face] < 0.0 && *other != NO_TET);
        let next = exits.min_by(|(a, _), (b, _)| weights[*a].total_cmp(&weights[*b]));
        next.is_some_and(|(_, next)| least(&frames.at(next, &mesh.nodes[node])) > least(&weights) + MISPLACED_TOLERANCE)
    };
    (0..mesh.nodes.len()).into_par_iter().find_first(|node| is_misplaced(*node))
}

/// Finds the tetrahedron of the lattice that carries each node; `None` for a mesh without a node of the lattice.
///
/// `known`: the lattice's node at the same position, for interior nodes of the mesh. `neighbors(node)`: nodes that share
/// an edge with `node`.
pub(super) fn find<'a>(
    mesh: &Lattice,
    crack: &Lattice,
    known: &[Option<u32>],
    neighbors: impl Fn(usize) -> &'a [u32] + Sync,
) -> Option<Vec<u32>> {
    let (frames, around, stars) = (Frames::new(crack), crack.neighbors(), crack.stars());
    let start = |node: &Option<u32>| node.map_or(NONE, |node| stars.of(node).first().copied().unwrap_or(NONE));
    let mut tets: Vec<u32> = known.iter().map(start).collect();
    let mut front: Vec<u32> = (0..mesh.nodes.len() as u32).filter(|&node| tets[node as usize] != NONE).collect();
    let mut found = front.len();
    while !front.is_empty() {
        let open = |node: &u32| tets[*node as usize] == NONE;
        let mut next: Vec<u32> =
            front.iter().flat_map(|&node| neighbors(node as usize)).copied().filter(open).collect();
        next.sort_unstable();
        next.dedup();
        let best = |&node: &u32| {
            let place = &mesh.nodes[node as usize];
            let starts = neighbors(node as usize).iter().map(|&other| tets[other as usize]).filter(|&tet| tet != NONE);
            let mut starts: Vec<u32> = starts.collect();
            starts.sort_unstable();
            starts.dedup();
            let ends = starts.into_iter().map(|tet| walk(&frames, &around, tet, place));
            ends.reduce(|best, other| if other.1 > best.1 { other } else { best }).map_or(NONE, |(tet, _)| tet)
        };
        let ends: Vec<u32> = next.par_iter().map(best).collect();
        next.iter().zip(ends).for_each(|(&node, tet)| tets[node as usize] = tet);
        found += next.len();
        front = next;
    }
    (found == mesh.nodes.len()).then_some(tets)
}

/// Walks from `tet` towards `place`; returns the tetrahedron that fits best and its least barycentric coordinate.
fn walk(frames: &Frames, around: &[[u32; 4]], mut tet: u32, place: &Point3<f64>) -> (u32, f64) {
    let mut best = (tet, f64::NEG_INFINITY);
    let mut before = NONE;
    for _ in 0..WALK_MAX {
        let weights = frames.at(tet, place);
        if least(&weights) > best.1 {
            best = (tet, least(&weights));
        }
        let exits = (0..4).filter(|&face| weights[face] < 0.0);
        let exits = exits.map(|face| (around[tet as usize][face], weights[face]));
        let exits = exits.filter(|(other, _)| *other != NO_TET && *other != before);
        let Some((next, _)) = exits.reduce(|a, b| if b.1 < a.1 { b } else { a }) else { break };
        (before, tet) = (tet, next);
    }
    best
}

/// Node of the mesh that represents each node of the lattice: the one that the lattice's node carries most, or that of a
/// neighbor.
pub(super) fn representatives(crack: &Lattice, carriers: &[Carrier]) -> Vec<u32> {
    let mut best: HashMap<u32, (f64, u32)> = HashMap::new();
    for (node, carrier) in carriers.iter().enumerate() {
        for (&corner, weight) in crack.tets[carrier.tet as usize].iter().zip(carrier.weights) {
            // Extrapolated nodes have weights above 1, and are not nearer.
            let nearness = -(weight - 1.0).abs();
            let own = best.entry(corner).or_insert((f64::NEG_INFINITY, node as u32));
            if nearness > own.0 {
                *own = (nearness, node as u32);
            }
        }
    }
    let mut found: Vec<u32> =
        (0..crack.nodes.len() as u32).map(|node| best.get(&node).map_or(NONE, |own| own.1)).collect();
    let edges = crack.edges();
    while found.contains(&NONE) && found.iter().any(|&node| node != NONE) {
        let before = found.clone();
        for &[a, b] in &edges {
            for (from, to) in [(a, b), (b, a)] {
                let (own, other) = (before[to as usize], before[from as usize]);
                if own == NONE && other != NONE && found[to as usize] == NONE {
                    found[to as usize] = other;
                }
            }
        }
    }
    found
}
