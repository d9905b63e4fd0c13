use super::*;
use crate::lattice::block;
use nalgebra::Isometry3;

/// Shares of a block against its own faces, rotated by `degrees`.
fn turned(degrees: f64, carried: Option<Vector3<f64>>) -> NormalShares {
    let lattice = block([3, 3, 3], 0.1);
    let turn = Isometry3::rotation(Vector3::new(0.6, 0.64, 0.48).normalize() * degrees.to_radians());
    // The planes are large enough that the nearest triangle is the rotated one of the same side, except near a rim.
    let lit = |face: &crate::lattice::BoundaryFace| {
        let corners = face.nodes.map(|node| turn * lattice.nodes[node as usize]);
        (corners, [area_vector(&corners).normalize(); 3])
    };
    let input: Vec<ShadedTriangle> = lattice.boundary().iter().map(lit).collect();
    let normals = carried.map(|normal| vec![normal; lattice.nodes.len()]);
    NormalShares::new(&[(&lattice, normals)], &input, NORMAL_DEG)
}

#[test]
fn normal_error_is_zero_for_equal_faces_and_large_for_rotated_ones() {
    let same = turned(0.0, None);
    assert!((same.faces - 1.0).abs() < 1e-12 && same.carried.is_none(), "{same:?}");
    assert!(turned(5.0, None).faces > 0.9);
    assert!(turned(30.0, None).faces < 0.05);
}

#[test]
fn smooth_normals_miss_a_cube_near_its_edges_and_carried_ones_are_taken_as_they_are() {
    let shares = turned(0.0, Some(Vector3::x()));
    // One side of six. Nodes inside a side have its normal; the others do not.
    assert!((shares.carried.unwrap() - 1.0 / 6.0).abs() < 1e-12, "{shares:?}");
    assert!((0.3..0.7).contains(&shares.smooth), "{shares:?}");
}

#[test]
fn normals_of_nodes_are_held_against_what_the_input_is_shaded_with() {
    let lattice = block([2, 2, 2], 0.1);
    let outward = |place: &Point3<f64>| place.coords.normalize();
    // A cube that is shaded like a ball: its faces stay flat, but its nodes may still be right.
    let lit = |face: &crate::lattice::BoundaryFace| {
        let corners = face.nodes.map(|node| lattice.nodes[node as usize]);
        (corners, corners.map(|corner| outward(&corner)))
    };
    let input: Vec<ShadedTriangle> = lattice.boundary().iter().map(lit).collect();
    let normals = lattice.nodes.iter().map(|node| node.coords.try_normalize(0.0).unwrap_or_default()).collect();
    let shares = NormalShares::new(&[(&lattice, Some(normals))], &input, NORMAL_DEG);
    assert!((shares.faces - 1.0).abs() < 1e-12 && (shares.carried.unwrap() - 1.0).abs() < 1e-12, "{shares:?}");
}

#[test]
fn normal_error_is_zero_without_a_boundary() {
    let shares = NormalShares::new(&[], &[], NORMAL_DEG);
    assert_eq!(shares, NormalShares { faces: 1.0, smooth: 1.0, carried: Some(1.0) });
}
