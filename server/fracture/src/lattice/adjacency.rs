//! Adjacency of lattices: tetrahedra across faces and around nodes, and face-connected components.

use super::{FACES, Lattice};
use crate::memory::held;

/// Neighbor across a boundary face: no tetrahedron.
pub const NO_TET: u32 = u32::MAX;

/// Tetrahedra around every node, in increasing order.
#[derive(Clone, Debug)]
pub struct NodeStars {
    offsets: Vec<u32>,
    tets: Vec<u32>,
}

/// Face of one tetrahedron, without its lowest node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Face {
    others: [u32; 2],
    tet: u32,
    face: u8,
}

impl NodeStars {
    /// Tetrahedra that have `node` as a corner, in increasing order.
    pub fn of(&self, node: u32) -> &[u32] {
        &self.tets[self.offsets[node as usize] as usize..self.offsets[node as usize + 1] as usize]
    }

    /// Bytes of memory that they hold.
    pub fn bytes(&self) -> usize {
        held(&self.offsets) + held(&self.tets)
    }
}

impl Lattice {
    /// Neighbors of each tetrahedron across its four faces; face k is opposite node k ([`FACES`]).
    ///
    /// [`NO_TET`] marks the boundary. It also marks a face that more than two tetrahedra share,
    /// which no constructor produces.
    pub fn neighbors(&self) -> Vec<[u32; 4]> {
        let (offsets, faces) = self.faces_by_lowest_node();
        let mut neighbors = vec![[NO_TET; 4]; self.tets.len()];
        for bucket in offsets.windows(2) {
            let bucket = &faces[bucket[0] as usize..bucket[1] as usize];
            for same in bucket.chunk_by(|a, b| a.others == b.others) {
                if let [a, b] = same {
                    neighbors[a.tet as usize][usize::from(a.face)] = b.tet;
                    neighbors[b.tet as usize][usize::from(b.face)] = a.tet;
                }
            }
        }
        neighbors
    }

    /// All faces in buckets by lowest node, sorted by the other two nodes within each; and the start of each bucket.
    fn faces_by_lowest_node(&self) -> (Vec<u32>, Vec<Face>) {
        let faces = || {
            self.tets.iter().enumerate().flat_map(|(tet, nodes)| {
                FACES.iter().enumerate().map(move |(face, corner)| {
                    let mut key = corner.map(|c| nodes[c]);
                    key.sort_unstable();
                    (key[0], Face { others: [key[1], key[2]], tet: tet as u32, face: face as u8 })
                })
            })
        };
        let mut offsets = vec![0u32; self.nodes.len() + 1];
        faces().for_each(|(lowest, _)| offsets[lowest as usize + 1] += 1);
        for node in 0..self.nodes.len() {
            offsets[node + 1] += offsets[node];
        }
        let (mut next, mut sorted) = (offsets.clone(), vec![Face::default(); self.tets.len() * 4]);
        for (lowest, face) in faces() {
            sorted[next[lowest as usize] as usize] = face;
            next[lowest as usize] += 1;
        }
        for bucket in offsets.windows(2) {
            sorted[bucket[0] as usize..bucket[1] as usize].sort_unstable();
        }
        (offsets, sorted)
    }

    /// Collects the tetrahedra around every node.
    pub fn stars(&self) -> NodeStars {
        let mut offsets = vec![0u32; self.nodes.len() + 1];
        for &node in self.tets.iter().flatten() {
            offsets[node as usize + 1] += 1;
        }
        for node in 0..self.nodes.len() {
            offsets[node + 1] += offsets[node];
        }
        let (mut next, mut tets) = (offsets.clone(), vec![0; self.tets.len() * 4]);
        for (tet, nodes) in self.tets.iter().enumerate() {
            for &node in nodes {
                let slot = &mut next[node as usize];
                tets[*slot as usize] = tet as u32;
                *slot += 1;
            }
        }
        NodeStars { offsets, tets }
    }

    /// Face-connected components: tetrahedra in increasing order, components by their lowest tetrahedron.
    pub fn components(&self) -> Vec<Vec<u32>> {
        let neighbors = self.neighbors();
        let (mut seen, mut components) = (vec![false; self.tets.len()], Vec::new());
        for start in 0..self.tets.len() {
            if std::mem::replace(&mut seen[start], true) {
                continue;
            }
            let mut component = vec![start as u32];
            let mut next = 0;
            while next < component.len() {
                for &other in &neighbors[component[next] as usize] {
                    if other != NO_TET && !std::mem::replace(&mut seen[other as usize], true) {
                        component.push(other);
                    }
                }
                next += 1;
            }
            component.sort_unstable();
            components.push(component);
        }
        components
    }

    /// Lattice of `tets` only, in that order. The nodes they use keep their relative order.
    pub fn part(&self, tets: &[u32]) -> Self {
        let mut renamed = vec![u32::MAX; self.nodes.len()];
        for &tet in tets {
            self.tets[tet as usize].iter().for_each(|&node| renamed[node as usize] = 0);
        }
        let mut nodes = Vec::new();
        for (node, name) in renamed.iter_mut().enumerate().filter(|(_, name)| **name == 0) {
            *name = nodes.len() as u32;
            nodes.push(self.nodes[node]);
        }
        let tets = tets.iter().map(|&tet| self.tets[tet as usize].map(|node| renamed[node as usize])).collect();
        Self { nodes, tets }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    #[test]
    fn neighbors_are_mutual_and_missing_exactly_on_the_boundary() {
        let lattice = block([2, 3, 1], 0.25);
        let neighbors = lattice.neighbors();
        let open = neighbors.iter().flatten().filter(|&&other| other == NO_TET).count();
        assert_eq!(open, lattice.boundary().len());
        for (tet, around) in neighbors.iter().enumerate() {
            let mutual = |other: &u32| *other == NO_TET || neighbors[*other as usize].contains(&(tet as u32));
            assert!(around.iter().all(mutual));
        }
    }

    #[test]
    fn components_and_parts_split_what_only_an_edge_joins() {
        let lattice = block([2, 2, 1], 0.5);
        let kept: Vec<u32> = (0..lattice.tets.len() as u32).filter(|tet| matches!(tet / 24, 0 | 3)).collect();
        let crossed = lattice.part(&kept);
        let components = crossed.components();
        assert_eq!(components.iter().map(Vec::len).collect::<Vec<_>>(), [24, 24]);
        assert!(components.iter().all(|component| (crossed.part(component).volume() - 0.125).abs() < 1e-15));
        let stars = crossed.stars();
        assert_eq!((0..crossed.nodes.len() as u32).map(|node| stars.of(node).len()).sum::<usize>(), 48 * 4);
    }
}
