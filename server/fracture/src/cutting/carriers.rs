//! Carriers: the tetrahedron of the crack lattice from which a node of the cutting mesh takes its values.
//!
//! Nodes near the surface may lie outside the lattice, or inside a part of it that is separated from them by a narrow
//! gap. So the carrier is not the nearest of all tetrahedra: it is reached from the carriers of neighbors in the
//! cutting mesh, through tetrahedra that share a corner, as long as these are nearer. The descent does not jump over a
//! gap, but it may go around its end. It ends at a nearest point of the lattice, which depends on the cutting mesh only
//! where there are several.
//!
//! Based on: O. Devillers, S. Pion, M. Teillaud, *Walking in a triangulation* (2002). The descent by distance over two
//! meshes is ours.

use crate::lattice::{FACES, Lattice, NO_TET, NodeStars};
use crate::triangle::ClosestFeature;
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Barycentric coordinate below which values are not extrapolated: about one height of the tetrahedron outside.
const EXTRAPOLATED_MIN: f64 = -1.0;

/// Relative difference of distances below which they are equal but for rounding.
const EQUAL: f64 = 1e-9;

/// Distance from the nearest point, in longest edges of the carrier, beyond which no descent of a bake ended.
const MISPLACED_EDGES: f64 = 2.0;

/// Gain in the least barycentric coordinate that is not due to rounding on another processor.
const WALK_TOLERANCE: f64 = 1e-6;

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

/// Nearest point of a tetrahedron to a given one.
#[derive(Clone, Copy, Debug)]
struct NearestOfTet {
    tet: u32,
    distance: f64,
    /// Barycentric coordinates of the nearest point. Zero at the corners that are not of its vertex, edge or face.
    nearest: [f64; 4],
    /// Least barycentric coordinate of the given point.
    least: f64,
}

impl NearestOfTet {
    /// True if it is nearer, or as near and the given point fits the tetrahedron better.
    fn is_better(&self, other: &Self) -> bool {
        let slack = 1.0 + EQUAL;
        self.distance * slack < other.distance || (self.distance <= other.distance * slack && self.least > other.least)
    }
}

/// Crack lattice with what the descent needs.
struct Descent<'a> {
    lattice: &'a Lattice,
    frames: Frames,
    stars: NodeStars,
}

impl Descent<'_> {
    /// Nearest point of tetrahedron `tet` to `place`.
    fn nearest(&self, tet: u32, place: &Point3<f64>) -> NearestOfTet {
        nearest(self.lattice, &self.frames, tet, place)
    }

    /// Descends from `tet` to the tetrahedron with a nearest point of the lattice to `place`.
    fn run(&self, tet: u32, place: &Point3<f64>) -> NearestOfTet {
        let mut best = self.nearest(tet, place);
        while best.distance > 0.0 {
            // All tetrahedra around a point of the boundary share its vertex, edge or face.
            let corners = self.lattice.tets[best.tet as usize];
            let shared = corners.into_iter().zip(best.nearest).filter(|(_, weight)| *weight > 0.0).map(|own| own.0);
            let Some(first) = shared.clone().next() else { break };
            let around = self.stars.of(first).iter().copied().filter(|&tet| tet != best.tet);
            let around =
                around.filter(|&tet| shared.clone().all(|node| self.lattice.tets[tet as usize].contains(&node)));
            let around = around.map(|tet| self.nearest(tet, place));
            match around.reduce(|best, next| if next.is_better(&best) { next } else { best }) {
                Some(next) if next.distance < best.distance => best = next,
                Some(next) if next.is_better(&best) => return next,
                _ => break,
            }
        }
        best
    }
}

fn nearest(lattice: &Lattice, frames: &Frames, tet: u32, place: &Point3<f64>) -> NearestOfTet {
    let weights = frames.at(tet, place);
    let mut own = NearestOfTet { tet, distance: f64::INFINITY, nearest: weights, least: least(&weights) };
    if own.least >= 0.0 {
        return NearestOfTet { distance: 0.0, ..own };
    }
    let corners = lattice.corners(tet as usize);
    for (face, _) in FACES.iter().zip(weights).filter(|(_, weight)| *weight < 0.0) {
        let triangle = face.map(|corner| corners[corner]);
        let shares = ClosestFeature::of(&triangle, place).barycentric();
        let foot: Vector3<f64> = triangle.iter().zip(shares).map(|(corner, share)| corner.coords * share).sum();
        let distance = (foot - place.coords).norm();
        if distance < own.distance {
            (own.distance, own.nearest) = (distance, [0.0; 4]);
            face.iter().zip(shares).for_each(|(&corner, share)| own.nearest[corner] = share);
        }
    }
    own
}

/// Carriers of all nodes in the given tetrahedra of the lattice.
pub(super) fn weights(mesh: &Lattice, crack: &Lattice, tets: &[u32]) -> Vec<Carrier> {
    let frames = Frames::new(crack);
    let carrier = |(node, &tet): (&Point3<f64>, &u32)| {
        let weights = frames.at(tet, node);
        let is_anchored = least(&weights) < EXTRAPOLATED_MIN;
        let weights = if is_anchored { nearest(crack, &frames, tet, node).nearest } else { weights };
        Carrier { tet, weights, is_anchored }
    };
    mesh.nodes.par_iter().zip(tets).map(carrier).collect()
}

/// The first node whose carrier is much farther from it than the point of the lattice to which a descent leads from there.
///
/// Carriers of earlier bakes ended a walk through faces, maybe far from the nearest point. They are right, too.
pub(super) fn misplaced(mesh: &Lattice, crack: &Lattice, carriers: &[Carrier]) -> Option<usize> {
    let descent = Descent { lattice: crack, frames: Frames::new(crack), stars: crack.stars() };
    let around = crack.neighbors();
    let is_misplaced = |node: usize| {
        let (tet, place) = (carriers[node].tet, &mesh.nodes[node]);
        let corners = crack.corners(tet as usize);
        let edges = corners.iter().enumerate().flat_map(|(k, a)| corners[..k].iter().map(move |b| (a - b).norm()));
        let slack = MISPLACED_EDGES * edges.fold(0.0, f64::max);
        let own = descent.nearest(tet, place).distance;
        own > slack
            && own > slack + descent.run(tet, place).distance
            && !ends_walk(&descent.frames, &around[tet as usize], tet, place)
    };
    (0..mesh.nodes.len()).into_par_iter().find_first(|node| is_misplaced(*node))
}

/// True if no neighbor of `tet` through the face where a walk to `place` goes on fits better.
fn ends_walk(frames: &Frames, around: &[u32; 4], tet: u32, place: &Point3<f64>) -> bool {
    let weights = frames.at(tet, place);
    let exits = (0..4).filter(|face| weights[*face] < 0.0 && around[*face] != NO_TET);
    let next = exits.min_by(|a, b| weights[*a].total_cmp(&weights[*b])).map(|face| around[face]);
    next.is_none_or(|next| least(&frames.at(next, place)) <= least(&weights) + WALK_TOLERANCE)
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
    let descent = Descent { lattice: crack, frames: Frames::new(crack), stars: crack.stars() };
    let start = |node: &Option<u32>| node.map_or(NONE, |node| descent.stars.of(node).first().copied().unwrap_or(NONE));
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
            let ends = starts.into_iter().map(|tet| descent.run(tet, place));
            ends.reduce(|best, other| if other.is_better(&best) { other } else { best }).map_or(NONE, |own| own.tet)
        };
        let ends: Vec<u32> = next.par_iter().map(best).collect();
        next.iter().zip(ends).for_each(|(&node, tet)| tets[node as usize] = tet);
        found += next.len();
        front = next;
    }
    (found == mesh.nodes.len()).then_some(tets)
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
