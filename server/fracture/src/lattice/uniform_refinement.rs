//! Uniform refinement: every tetrahedron is divided into eight, and the body keeps its shape.
//!
//! Based on: J. Bey, *Tetrahedral grid refinement* (Computing 55, 1995), algorithm "RedRefinement3D". With the nodes
//! 0 to 3 and the midpoints 01 to 23 of its edges, a tetrahedron becomes four at its corners and four around the
//! diagonal 02–13. In this order of nodes the descendants of a tetrahedron have at most three shapes. Exchanging the
//! nodes 0 and 2 keeps all diagonals, so that every child can be given a positive volume.

use super::{EDGES, Lattice};
use nalgebra::{Point3, Vector3};

/// Children of a tetrahedron: indices into its nodes (0 to 3), then the midpoints of [`EDGES`] (4 to 9).
const CHILDREN: [[usize; 4]; CHILD_COUNT] =
    [[0, 4, 5, 6], [4, 1, 7, 8], [5, 7, 2, 9], [6, 8, 9, 3], [4, 5, 6, 8], [7, 5, 4, 8], [5, 6, 8, 9], [8, 7, 5, 9]];

/// Number of children of a tetrahedron.
pub const CHILD_COUNT: usize = 8;

/// Even permutations of the nodes, each with another pair of opposite edges at 02 and 13.
const ORDERS: [[usize; 4]; 3] = [[0, 1, 2, 3], [0, 3, 1, 2], [0, 2, 3, 1]];

/// A lattice that was made by refining another one.
#[derive(Clone, Debug)]
pub struct RefinedLattice {
    /// The nodes of the coarser lattice, then the midpoints of its edges. The children of tetrahedron t of the coarser
    /// lattice are those from [`CHILD_COUNT`] · t on.
    pub lattice: Lattice,
    /// Ends of the edge of each midpoint, in the order of the midpoints.
    pub parents: Vec<[u32; 2]>,
}

/// Refines `lattice` `count` times; the first result is the coarsest.
///
/// The first refinement takes the shortest diagonal of every tetrahedron, the first one of equal ones.
pub fn refinements(lattice: &Lattice, count: usize) -> Vec<RefinedLattice> {
    let mut all: Vec<RefinedLattice> = Vec::with_capacity(count);
    for _ in 0..count {
        let next = match all.last() {
            Some(last) => refined(&last.lattice.nodes, &last.lattice.tets, last.lattice.edges()),
            None => refined(&lattice.nodes, &ordered(lattice), lattice.edges()),
        };
        all.push(next);
    }
    all
}

/// Number of nodes of `lattice` after `count` refinements.
pub fn refined_node_count(lattice: &Lattice, count: usize) -> usize {
    let (mut nodes, mut edges, mut tets) = (lattice.nodes.len(), lattice.edges().len(), lattice.tets.len());
    let mut faces = (4 * tets + lattice.boundary().len()) / 2;
    for _ in 0..count {
        // An edge becomes two, a face has three new edges and four parts, a tetrahedron one new edge and eight new faces.
        (nodes, edges, faces, tets) =
            (nodes + edges, 2 * edges + 3 * faces + tets, 4 * faces + 8 * tets, CHILD_COUNT * tets);
    }
    nodes
}

/// The tetrahedra with their nodes in an order in which the diagonal 02–13 is the shortest.
fn ordered(lattice: &Lattice) -> Vec<[u32; 4]> {
    let order = |nodes: &[u32; 4]| {
        let places = nodes.map(|node| lattice.nodes[node as usize]);
        let length = |[a, b, c, d]: [usize; 4]| diagonal(places[a], places[c], places[b], places[d]).norm_squared();
        let mut best = ORDERS[0];
        for order in ORDERS {
            if length(order) < length(best) {
                best = order;
            }
        }
        best.map(|corner| nodes[corner])
    };
    lattice.tets.iter().map(order).collect()
}

/// Twice the vector between the midpoints of the edges a–b and c–d.
fn diagonal(a: Point3<f64>, b: Point3<f64>, c: Point3<f64>, d: Point3<f64>) -> Vector3<f64> {
    (a - c) + (b - d)
}

fn refined(nodes: &[Point3<f64>], tets: &[[u32; 4]], edges: Vec<[u32; 2]>) -> RefinedLattice {
    let starts: Vec<usize> =
        (0..=nodes.len() as u32).map(|node| edges.partition_point(|edge| edge[0] < node)).collect();
    let midpoint = |a: u32, b: u32| {
        let (low, high) = (a.min(b), a.max(b));
        let own = &edges[starts[low as usize]..starts[low as usize + 1]];
        (nodes.len() + starts[low as usize] + own.partition_point(|edge| edge[1] < high)) as u32
    };
    let mut children = Vec::with_capacity(tets.len() * CHILD_COUNT);
    for tet in tets {
        let mut all = [0; 10];
        all[..4].copy_from_slice(tet);
        for (own, [i, j]) in all[4..].iter_mut().zip(EDGES) {
            *own = midpoint(tet[i], tet[j]);
        }
        children.extend(CHILDREN.map(|child| child.map(|place| all[place])));
    }
    let middle = |[a, b]: &[u32; 2]| nalgebra::center(&nodes[*a as usize], &nodes[*b as usize]);
    let nodes = nodes.iter().copied().chain(edges.iter().map(middle)).collect();
    RefinedLattice { lattice: Lattice { nodes, tets: children }, parents: edges }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::{kuhn, perturbed};

    /// Shape of a tetrahedron that is the same for all similar ones: sorted squares of its edges over their sum, rounded.
    fn shape(lattice: &Lattice, tet: usize) -> [i64; 6] {
        let corners = lattice.corners(tet);
        let mut squares = EDGES.map(|[i, j]| (corners[i] - corners[j]).norm_squared());
        squares.sort_by(f64::total_cmp);
        let sum: f64 = squares.iter().sum();
        squares.map(|square| (1e7 * square / sum).round() as i64)
    }

    #[test]
    fn children_fill_their_parent_and_keep_its_boundary() {
        let coarse = perturbed([2, 3, 2], 0.2, 0.15, 4);
        let mut before = coarse.clone();
        for (level, count) in refinements(&coarse, 2).into_iter().zip(1..) {
            let fine = &level.lattice;
            assert_eq!(refined_node_count(&coarse, count), fine.nodes.len());
            assert_eq!(fine.tets.len(), 8 * before.tets.len());
            for tet in 0..before.tets.len() {
                let whole = before.tet_volume(tet);
                let children = (8 * tet..8 * tet + 8).map(|child| fine.tet_volume(child));
                assert!(children.into_iter().all(|own| (own - whole / 8.0).abs() < 1e-12 * whole), "tetrahedron {tet}");
            }
            assert_eq!(fine.boundary().len(), 4 * before.boundary().len());
            assert_eq!(fine.nodes.len(), before.nodes.len() + before.edges().len());
            for (place, [a, b]) in fine.nodes[before.nodes.len()..].iter().zip(&level.parents) {
                let middle = nalgebra::center(&before.nodes[*a as usize], &before.nodes[*b as usize]);
                assert_eq!(*place, middle);
            }
            before = fine.clone();
        }
    }

    #[test]
    fn descendants_have_few_shapes() {
        let coarse = perturbed([1, 1, 1], 1.0, 0.3, 2);
        let levels = refinements(&coarse, 3);
        let fine = &levels[2].lattice;
        for tet in 0..coarse.tets.len() {
            let mut shapes: Vec<_> = (512 * tet..512 * (tet + 1)).map(|child| shape(fine, child)).collect();
            shapes.sort_unstable();
            shapes.dedup();
            assert!(shapes.len() <= 3, "{} shapes of tetrahedron {tet}: {shapes:?}", shapes.len());
        }
    }

    #[test]
    fn the_shortest_diagonal_is_taken() {
        // All tetrahedra of a cube cut along one diagonal are similar, and so are their children.
        let coarse = kuhn([1, 1, 1], 1.0);
        let fine = &refinements(&coarse, 1)[0].lattice;
        let mut shapes: Vec<_> = (0..fine.tets.len()).map(|tet| shape(fine, tet)).collect();
        shapes.sort_unstable();
        shapes.dedup();
        assert_eq!(shapes, [shape(&coarse, 0)]);
    }
}
