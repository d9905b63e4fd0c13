//! Lattices for the tests.

use crate::lattice::{Lattice, block};
pub use crate::reference::ball;
use nalgebra::Point3;

/// `lattice` without the tetrahedra whose centroid fails `keep`, and without unused nodes.
pub fn carved(lattice: Lattice, keep: impl Fn(&Point3<f64>) -> bool) -> Lattice {
    let mut renumbered = vec![u32::MAX; lattice.nodes.len()];
    let mut carved = Lattice::default();
    for tet in 0..lattice.tets.len() {
        let centroid =
            Point3::from(lattice.corners(tet).iter().map(|corner| corner.coords).sum::<nalgebra::Vector3<f64>>() / 4.0);
        if keep(&centroid) {
            carved.tets.push(lattice.tets[tet].map(|node| {
                let new = &mut renumbered[node as usize];
                if *new == u32::MAX {
                    *new = carved.nodes.len() as u32;
                    carved.nodes.push(lattice.nodes[node as usize]);
                }
                *new
            }));
        }
    }
    carved
}

/// Two prongs, 1.0 long and 0.3 wide, 0.1 apart, on a foot 0.2 high. y is up; the slot is at x = 0.
pub fn fork() -> Lattice {
    carved(block([7, 12, 3], 0.1), |at| at.x.abs() > 0.05 || at.y < -0.4)
}

/// Nearest node to a point.
pub fn nearest(lattice: &Lattice, x: f64, y: f64, z: f64) -> usize {
    let target = Point3::new(x, y, z);
    let distance = |node: &usize| (lattice.nodes[*node] - target).norm();
    (0..lattice.nodes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
}
