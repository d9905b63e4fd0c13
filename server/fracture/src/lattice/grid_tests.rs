use super::*;
use crate::lattice::shapes::ball;
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

/// Ball of radius 0.4 that counts its samples.
struct CountedBall {
    sampled: AtomicUsize,
    is_exact: bool,
}

impl SignedDistance for CountedBall {
    fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        self.sampled.fetch_add(1, Ordering::Relaxed);
        point.coords.norm() - 0.4
    }

    fn has_exact_sign(&self) -> bool {
        self.is_exact
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        (Point3::from([-0.4; 3]), Point3::from([0.4; 3]))
    }
}

#[test]
fn skipped_nodes_keep_their_sign() {
    let [by_block, by_node] = [false, true].map(|is_exact| {
        let shape = CountedBall { sampled: AtomicUsize::new(0), is_exact };
        let grid = Grid::over(&shape, 0.01).unwrap();
        let values = grid.sample(&shape, &CancelToken::default()).unwrap();
        let sampled = shape.sampled.load(Ordering::Relaxed);
        assert!(sampled < grid.node_count() / 2, "too few nodes were skipped");
        for (node, value) in values.iter().enumerate() {
            let exact = shape.signed_distance(&grid.position(node as u32));
            assert!(value.signum() == exact.signum() && value.abs() <= exact.abs() + 1e-12);
            assert!((value - exact).abs() < 1e-12 || value.abs() > 1.5 * grid.spacing);
        }
        sampled
    });
    println!("{by_block} samples by block, {by_node} by node");
    assert!(by_node < by_block * 2 / 3);
}
