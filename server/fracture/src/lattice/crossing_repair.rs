//! Undoing of node moves that make boundaries cross.

use super::Lattice;
use crate::surface::crossings;
use nalgebra::Point3;

/// Restores nodes of `lattice` to `before` until no moved face of the boundary meets another face.
///
/// With a node, all moved nodes are restored that share a tetrahedron with it, directly or through other moved nodes.
/// So every tetrahedron keeps its shape or returns to its former one. Returns the moved nodes of faces that met.
pub(super) fn put_back(lattice: &mut Lattice, before: &[Point3<f64>]) -> Vec<u32> {
    let faces: Vec<[u32; 3]> = lattice.boundary().iter().map(|face| face.nodes).collect();
    let (stars, mut all) = (lattice.stars(), Vec::new());
    loop {
        let moved = |node: u32| lattice.nodes[node as usize] != before[node as usize];
        let chosen: Vec<u32> =
            (0..faces.len() as u32).filter(|&face| faces[face as usize].iter().any(|&node| moved(node))).collect();
        let met = crossings(&lattice.nodes, &faces, &chosen);
        let mut back: Vec<u32> =
            met.into_iter().flatten().flat_map(|face| faces[face as usize]).filter(|&node| moved(node)).collect();
        if back.is_empty() {
            return all;
        }
        all.extend(&back);
        while let Some(node) = back.pop() {
            let place = before[node as usize];
            if std::mem::replace(&mut lattice.nodes[node as usize], place) == place {
                continue;
            }
            let around = stars.of(node).iter().flat_map(|&tet| lattice.tets[tet as usize]);
            back.extend(around.filter(|&other| lattice.nodes[other as usize] != before[other as usize]));
        }
    }
}
