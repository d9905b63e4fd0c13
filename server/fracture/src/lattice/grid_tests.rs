use super::*;
use crate::lattice::shapes::{ImplicitShape, ball};
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn node_numbers_and_coordinates_are_inverse_and_neighbors_mutual() {
    let grid = Grid::over(&ball(0.2), 0.11).unwrap();
    for node in 0..grid.node_count() as u32 {
        assert_eq!(grid.node(grid.twice(node)), Some(node));
        for (other, long) in grid.neighbors(node) {
            assert!(grid.neighbors(other).any(|back| back == (node, long)));
            let length = (grid.position(other) - grid.position(node)).norm();
            assert!((length - grid.spacing * if long { 1.0 } else { 0.75f64.sqrt() }).abs() < 1e-12);
        }
    }
    assert_eq!(grid.node([-1, 1, 1]), None);
}

#[test]
fn tetrahedra_are_positive_and_of_one_size() {
    let grid = Grid::over(&ball(0.2), 0.11).unwrap();
    let mut count = 0;
    grid.for_each_tet(|tet| {
        let [a, b, c, d] = tet.map(|node| grid.position(node));
        let volume = (b - a).dot(&(c - a).cross(&(d - a))) / 6.0;
        assert!((volume - 0.11f64.powi(3) / 12.0).abs() < 1e-14);
        count += 1;
    });
    let [x, y, z] = grid.cells;
    assert_eq!(count, 4 * ((x - 1) * y * z + x * (y - 1) * z + x * y * (z - 1)));
}

#[test]
fn skipped_blocks_keep_the_sign_of_every_node() {
    let asked = AtomicUsize::new(0);
    let distance = |p: &Point3<f64>| {
        asked.fetch_add(1, Ordering::Relaxed);
        p.coords.norm() - 0.4
    };
    let shape = ImplicitShape { distance, half: Vector3::repeat(0.4) };
    let grid = Grid::over(&shape, 0.01).unwrap();
    let values = grid.sample(&shape, &CancelToken::default()).unwrap();
    assert!(asked.load(Ordering::Relaxed) < grid.node_count() / 2, "too few nodes were skipped");
    for (node, value) in values.iter().enumerate() {
        let exact = shape.signed_distance(&grid.position(node as u32));
        assert!(value.signum() == exact.signum() && value.abs() <= exact.abs() + 1e-12);
        assert!((value - exact).abs() < 1e-12 || value.abs() > 1.5 * grid.spacing);
    }
}
