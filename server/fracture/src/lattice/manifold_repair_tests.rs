use super::*;
use crate::lattice::block;

/// Lattice of the tetrahedra of `lattice` that pass `keep`.
fn part(lattice: &Lattice, keep: impl Fn(usize) -> bool) -> Lattice {
    lattice.part(&(0..lattice.tets.len() as u32).filter(|&tet| keep(tet as usize)).collect::<Vec<_>>())
}

fn repaired(lattice: &Lattice) -> (Lattice, RepairReport) {
    let (left, took) = repair_manifold(lattice).unwrap();
    assert!((left.volume() + took.volume - lattice.volume()).abs() < 1e-14);
    assert!(left.components().iter().all(|tets| check_manifold(&left.part(tets)).is_ok()));
    (left, took)
}

#[test]
fn blocks_need_no_mending() {
    for cells in [[1, 1, 1], [2, 3, 2]] {
        let lattice = block(cells, 0.25);
        check_manifold(&lattice).unwrap();
        assert!(repair_manifold(&lattice).is_none());
    }
    assert_eq!(check_manifold(&Lattice::default()), Err(NonManifold::Empty));
}

#[test]
fn a_hinge_is_found_and_its_smaller_side_dropped() {
    // Cubes 0 and 3 of a 2 × 2 layer share an edge; a cube on either side would join them.
    let layer = block([2, 2, 1], 0.5);
    let hinge = part(&layer, |tet| matches!(tet / 24, 0 | 3) && tet != 80);
    assert!(matches!(check_manifold(&hinge), Err(NonManifold::Disconnected { parts: 2 })));
    let (left, took) = repaired(&hinge);
    assert!(took.pinches > 0 && left.volume() > 0.5 * hinge.volume());
}

#[test]
fn a_hinge_between_connected_cubes_is_found_as_an_edge() {
    // All four cubes in the lower layer; two in the upper layer that meet only in an edge.
    let both = block([2, 2, 2], 0.5);
    let hinge = part(&both, |tet| tet / 24 < 4 || matches!(tet / 24, 4 | 7));
    assert!(matches!(check_manifold(&hinge), Err(NonManifold::Edge { faces: 4, .. })));
    let (left, _) = repaired(&hinge);
    assert!(left.volume() > 0.6 * hinge.volume());
}

#[test]
fn two_holes_that_meet_at_a_node_become_one() {
    let whole = block([4, 4, 4], 0.25);
    let middle = whole.nodes.iter().position(|node| node.coords.norm() < 1e-12).unwrap() as u32;
    let star = whole.stars().of(middle).to_vec();
    let apart =
        |a: u32, b: u32| whole.tets[a as usize].iter().filter(|n| whole.tets[b as usize].contains(n)).count() == 1;
    let other = star[1..].iter().copied().find(|&tet| apart(star[0], tet)).unwrap();
    let holes = part(&whole, |tet| tet as u32 != star[0] && tet as u32 != other);
    assert!(matches!(check_manifold(&holes), Err(NonManifold::Node { fans: 2, .. })));
    let (left, took) = repaired(&holes);
    assert_eq!(left.components().len(), 1);
    assert!(took.volume < 0.02 * whole.volume(), "only a shortest chain between the holes is dropped");
}

#[test]
fn a_face_in_three_tetrahedra_and_a_turned_one_are_faults() {
    let mut lattice = block([1, 1, 1], 1.0);
    let [a, b, c, _] = lattice.tets[0];
    lattice.nodes.push(nalgebra::Point3::new(0.1, 0.2, 0.9));
    lattice.tets.push([a, b, c, lattice.nodes.len() as u32 - 1]);
    assert!(matches!(check_manifold(&lattice), Err(NonManifold::Face { tets: 3, .. })));
    let mut lattice = block([1, 1, 1], 1.0);
    lattice.tets[5].swap(0, 1);
    assert!(matches!(check_manifold(&lattice), Err(NonManifold::Edge { .. })));
}
