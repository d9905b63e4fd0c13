//! Repair of a body's boundary to a closed 2-manifold by dropping tetrahedra, and the check for it.
//!
//! The *star* of a node is the set of tetrahedra around it. Their faces opposite the node are its *link*. The boundary
//! is a 2-manifold at a node exactly if the link is a disc or, for interior nodes, a sphere. Otherwise the repair drops
//! the smallest of these sets of tetrahedra:
//!
//! - all but the largest face-connected part of the star;
//! - all but the largest fan around an edge;
//! - a shortest chain of tetrahedra between two holes of the link.
//!
//! Dropping tetrahedra can make other nodes non-manifold, so their nodes are checked again. The repair ends, because
//! the number of tetrahedra falls and a single one is a manifold. Positions never change, so the bounds on angles still
//! hold.

use super::adjacency::{NO_TET, NodeStars};
use super::{FACES, Lattice};
use std::collections::{BTreeMap, BTreeSet};

/// Fault of a lattice whose boundary is not the closed 2-manifold of one body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NonManifold {
    /// There are no tetrahedra.
    #[error("the lattice is empty")]
    Empty,
    /// The lattice is not connected through faces.
    #[error("the lattice has {parts} face-connected parts")]
    Disconnected {
        /// Number of parts.
        parts: usize,
    },
    /// More than two tetrahedra share a face.
    #[error("{tets} tetrahedra share the face of nodes {nodes:?}")]
    Face {
        /// Nodes of the face, increasing.
        nodes: [u32; 3],
        /// Number of tetrahedra that share it.
        tets: usize,
    },
    /// A boundary edge does not have two boundary faces, one in each direction.
    #[error("edge {nodes:?} has {faces} boundary faces")]
    Edge {
        /// Nodes of the edge, lower first.
        nodes: [u32; 2],
        /// Number of its boundary faces.
        faces: usize,
    },
    /// The boundary faces at a boundary node do not form one fan.
    #[error("node {node} has {fans} fans of boundary faces")]
    Node {
        /// The node.
        node: u32,
        /// Number of its fans.
        fans: usize,
    },
}

/// Checks that the lattice is one face-connected body whose boundary is a closed 2-manifold.
///
/// Returns the first fault found.
///
/// # Errors
/// [`NonManifold`]: the first defect.
pub fn check_manifold(lattice: &Lattice) -> Result<(), NonManifold> {
    check_faces(lattice)?;
    match lattice.components().len() {
        0 => return Err(NonManifold::Empty),
        1 => {}
        parts => return Err(NonManifold::Disconnected { parts }),
    }
    let boundary: Vec<[u32; 3]> = lattice.boundary().iter().map(|face| face.nodes).collect();
    check_edges(&boundary)?;
    // Around a node, every boundary face leads from one neighbor to the next.
    let mut around: BTreeMap<u32, BTreeMap<u32, u32>> = BTreeMap::new();
    for [a, b, c] in boundary {
        for [node, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
            around.entry(node).or_default().insert(from, to);
        }
    }
    for (node, mut next) in around {
        let mut fans = 0;
        while let Some((_, mut to)) = next.pop_first() {
            fans += 1;
            while let Some(after) = next.remove(&to) {
                to = after;
            }
        }
        if fans != 1 {
            return Err(NonManifold::Node { node, fans });
        }
    }
    Ok(())
}

fn check_faces(lattice: &Lattice) -> Result<(), NonManifold> {
    let sorted = |nodes: [u32; 3]| {
        let mut nodes = nodes;
        nodes.sort_unstable();
        nodes
    };
    let faces_of = |nodes: &[u32; 4]| FACES.map(|corner| sorted(corner.map(|c| nodes[c])));
    let mut faces: Vec<[u32; 3]> = lattice.tets.iter().flat_map(faces_of).collect();
    faces.sort_unstable();
    match faces.chunk_by(|a, b| a == b).find(|same| same.len() > 2) {
        Some(same) => Err(NonManifold::Face { nodes: same[0], tets: same.len() }),
        None => Ok(()),
    }
}

fn check_edges(boundary: &[[u32; 3]]) -> Result<(), NonManifold> {
    let directed = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let mut edges: Vec<([u32; 2], bool)> =
        boundary.iter().flat_map(directed).map(|[a, b]| ([a.min(b), a.max(b)], a < b)).collect();
    edges.sort_unstable();
    let whole = |same: &&[([u32; 2], bool)]| same.len() != 2 || same[0].1 == same[1].1;
    match edges.chunk_by(|a, b| a.0 == b.0).find(whole) {
        Some(same) => Err(NonManifold::Edge { nodes: same[0].0, faces: same.len() }),
        None => Ok(()),
    }
}

/// Statistics of the repair of one lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RepairReport {
    /// Number of pinches, each removed by dropping at least one tetrahedron.
    pub(super) pinches: usize,
    /// Volume of the dropped tetrahedra, local.
    pub(super) volume: f64,
}

/// Drops tetrahedra until every face-connected part passes [`check_manifold`].
///
/// Returns the remaining lattice and the statistics, or `None` if no repair was needed. The lattice may have several
/// parts, which share no node once split.
pub(super) fn repair_manifold(lattice: &Lattice) -> Option<(Lattice, RepairReport)> {
    let neighbors = lattice.neighbors();
    // The link of any other node is a sphere, because its star was joined face to face.
    let rim = lattice.tets.iter().zip(&neighbors).flat_map(|(nodes, around)| {
        let open = (0..4).filter(|&face| around[face] == NO_TET);
        open.flat_map(|face| FACES[face].map(|c| nodes[c])).collect::<Vec<u32>>()
    });
    let mut rim: Vec<u32> = rim.collect();
    rim.sort_unstable();
    rim.dedup();
    let suspects: BTreeSet<u32> = rim.into_iter().collect();
    let mut repairer = ManifoldRepairer {
        lattice,
        neighbors,
        stars: lattice.stars(),
        alive: vec![true; lattice.tets.len()],
        suspects: [suspects.clone(), suspects],
        repaired: RepairReport::default(),
    };
    repairer.run();
    let kept = || (0..lattice.tets.len() as u32).filter(|&tet| repairer.alive[tet as usize]).collect::<Vec<u32>>();
    (repairer.repaired.pinches > 0).then(|| (lattice.part(&kept()), repairer.repaired))
}

struct ManifoldRepairer<'a> {
    lattice: &'a Lattice,
    neighbors: Vec<[u32; 4]>,
    stars: NodeStars,
    alive: Vec<bool>,
    /// Nodes to check: for loose parts of their star first; once no node has any, for edges and holes.
    suspects: [BTreeSet<u32>; 2],
    repaired: RepairReport,
}

impl ManifoldRepairer<'_> {
    fn run(&mut self) {
        loop {
            let surplus = if let Some(node) = self.suspects[0].pop_first() {
                all_but_largest(self.lattice, self.groups(&self.star(node), &[node]))
            } else if let Some(node) = self.suspects[1].pop_first() {
                self.hinge_or_hole(node)
            } else {
                return;
            };
            if !surplus.is_empty() {
                self.repaired.pinches += 1;
                self.drop_all(&surplus);
            }
        }
    }

    fn drop_all(&mut self, tets: &[u32]) {
        for &tet in tets {
            self.alive[tet as usize] = false;
            self.repaired.volume += self.lattice.tet_volume(tet as usize);
            for node in self.lattice.tets[tet as usize] {
                self.suspects.iter_mut().for_each(|suspects| {
                    suspects.insert(node);
                });
            }
        }
    }

    fn star(&self, node: u32) -> Vec<u32> {
        self.stars.of(node).iter().copied().filter(|&tet| self.alive[tet as usize]).collect()
    }

    /// Remaining tetrahedron across face `face` of `tet`.
    fn across(&self, tet: u32, face: usize) -> Option<u32> {
        Some(self.neighbors[tet as usize][face]).filter(|&other| other != NO_TET && self.alive[other as usize])
    }

    /// Faces of `tet` that contain all of `nodes`.
    fn faces_at(&self, tet: u32, nodes: &[u32]) -> impl Iterator<Item = usize> {
        let corners = self.lattice.tets[tet as usize];
        let opposite: [bool; 4] = corners.map(|corner| nodes.contains(&corner));
        (0..4).filter(move |&face| !opposite[face])
    }

    /// Groups of `tets`, which all contain `nodes`, connected through faces that contain `nodes` too.
    fn groups(&self, tets: &[u32], nodes: &[u32]) -> Vec<Vec<u32>> {
        let (mut left, mut groups) = (tets.to_vec(), Vec::new());
        while !left.is_empty() {
            let (mut group, mut next) = (vec![left.remove(0)], 0);
            while next < group.len() {
                let tet = group[next];
                for other in self.faces_at(tet, nodes).filter_map(|face| self.across(tet, face)) {
                    // A star has a few dozen tetrahedra, so a scan is faster than a set.
                    if let Some(at) = left.iter().position(|&tet| tet == other) {
                        group.push(left.remove(at));
                    }
                }
                next += 1;
            }
            groups.push(group);
        }
        groups
    }

    /// Tetrahedra to drop at a node whose star is connected: surplus fans at an edge, or a chain between two holes.
    fn hinge_or_hole(&self, node: u32) -> Vec<u32> {
        let star = self.star(node);
        // Rim of the link: for each neighbor on it, the neighbors that boundary faces lead to, with their tetrahedra.
        let mut rim: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
        for &tet in &star {
            for face in self.faces_at(tet, &[node]).filter(|&face| self.across(tet, face).is_none()) {
                let corners = self.lattice.tets[tet as usize];
                let mut ends = (0..4).filter(|&c| c != face && corners[c] != node).map(|c| corners[c]);
                if let (Some(a), Some(b)) = (ends.next(), ends.next()) {
                    rim.entry(a).or_default().push((b, tet));
                    rim.entry(b).or_default().push((a, tet));
                }
            }
        }
        if let Some((&other, _)) = rim.iter().find(|(_, faces)| faces.len() > 2) {
            let around: Vec<u32> =
                star.into_iter().filter(|&tet| self.lattice.tets[tet as usize].contains(&other)).collect();
            return all_but_largest(self.lattice, self.groups(&around, &[node, other]));
        }
        self.chain_between_holes(node, rim)
    }

    /// Shortest chain of the star's tetrahedra from the first hole of the link to another.
    /// Empty if there is only one hole.
    fn chain_between_holes(&self, node: u32, rim: BTreeMap<u32, Vec<(u32, u32)>>) -> Vec<u32> {
        let Some((&first, _)) = rim.first_key_value() else { return Vec::new() };
        let (mut hole, mut next) = (BTreeSet::from([first]), vec![first]);
        while let Some(at) = next.pop() {
            next.extend(rim[&at].iter().map(|(to, _)| *to).filter(|to| hole.insert(*to)));
        }
        if hole.len() == rim.len() {
            return Vec::new();
        }
        let touching = |inside: bool| -> BTreeSet<u32> {
            let side = rim.iter().filter(|(at, _)| hole.contains(at) == inside);
            side.flat_map(|(_, faces)| faces).map(|(_, tet)| *tet).collect()
        };
        let (starts, goals) = (touching(true), touching(false));
        let mut came_from: BTreeMap<u32, u32> = starts.iter().map(|&tet| (tet, tet)).collect();
        let mut queue: Vec<u32> = starts.into_iter().collect();
        let mut next = 0;
        while next < queue.len() {
            let tet = queue[next];
            if goals.contains(&tet) {
                return trace(&came_from, tet);
            }
            for other in self.faces_at(tet, &[node]).filter_map(|face| self.across(tet, face)) {
                came_from.entry(other).or_insert_with(|| {
                    queue.push(other);
                    tet
                });
            }
            next += 1;
        }
        Vec::new()
    }
}

/// Chain from `end` back to its start, which is its own predecessor.
fn trace(came_from: &BTreeMap<u32, u32>, end: u32) -> Vec<u32> {
    let mut chain = vec![end];
    while let Some(&before) = chain.last().and_then(|tet| came_from.get(tet)) {
        if chain.last() == Some(&before) {
            break;
        }
        chain.push(before);
    }
    chain
}

/// Members of all groups but the one of largest volume (the first of them at a tie).
fn all_but_largest(lattice: &Lattice, mut groups: Vec<Vec<u32>>) -> Vec<u32> {
    let volume = |group: &Vec<u32>| group.iter().map(|&tet| lattice.tet_volume(tet as usize)).sum::<f64>();
    let volumes: Vec<f64> = groups.iter().map(volume).collect();
    let largest = (0..groups.len()).rev().max_by(|&a, &b| volumes[a].total_cmp(&volumes[b]));
    if let Some(largest) = largest {
        groups.remove(largest);
    }
    groups.concat()
}

#[cfg(test)]
#[path = "manifold_repair_tests.rs"]
mod tests;
