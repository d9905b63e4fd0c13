//! Lattices of simple bodies for the reference problems.

use crate::lattice::{Lattice, block};
use crate::random::RandomStream;
use nalgebra::{Point3, Vector3};
use std::collections::HashSet;

/// Block of `cells` cubes with displaced interior nodes.
///
/// The cubes have side `spacing`. Every interior node is moved at random by up to `amount` · `spacing` along each axis.
pub fn perturbed(cells: [usize; 3], spacing: f64, amount: f64, seed: u64) -> Lattice {
    let mut lattice = block(cells, spacing);
    let outer: HashSet<u32> = lattice.boundary().iter().flat_map(|face| face.nodes).collect();
    let mut stream = RandomStream::new(seed, 0);
    for (node, place) in lattice.nodes.iter_mut().enumerate() {
        let shift = Vector3::from_fn(|_, _| (stream.uniform() - 0.5) * 2.0 * amount * spacing);
        if !outer.contains(&(node as u32)) {
            *place += shift;
        }
    }
    lattice
}

/// Block of cubes that are cut into six tetrahedra each, along one diagonal (Kuhn's subdivision).
///
/// All nodes are corners of cubes. Linear elements on this lattice lock as early as on any tetrahedral lattice.
pub fn kuhn(cells: [usize; 3], spacing: f64) -> Lattice {
    let counts = cells.map(|cell| cell + 1);
    let half = Vector3::from(cells.map(|count| count as f64)) * 0.5;
    let index = |[x, y, z]: [usize; 3]| (z * counts[1] + y) * counts[0] + x;
    let mut lattice = Lattice::default();
    for node in 0..counts.iter().product() {
        let corner = [node % counts[0], node / counts[0] % counts[1], node / counts[0] / counts[1]];
        lattice.nodes.push(Point3::from((Vector3::from(corner.map(|i| i as f64)) - half) * spacing));
        if (0..3).any(|axis| corner[axis] == cells[axis]) {
            continue;
        }
        for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [2, 1, 0], [0, 2, 1]] {
            let mut walk = corner;
            let steps = order.map(|axis| {
                walk[axis] += 1;
                index(walk) as u32
            });
            let odd = (order[0] + 1) % 3 != order[1];
            let [a, b, c] = if odd { [steps[1], steps[0], steps[2]] } else { steps };
            lattice.tets.push([node as u32, a, b, c]);
        }
    }
    lattice
}

/// Unit ball with `cells` cubes across.
///
/// The cube [−1, 1]³ is mapped by x√(1 − y²/2 − z²/2 + y²z²/3), and likewise in y and z, which
/// takes its surface onto the sphere.
pub fn ball(cells: usize) -> Lattice {
    let mut lattice = block([cells; 3], 2.0 / cells as f64);
    for node in &mut lattice.nodes {
        let [xx, yy, zz] = [node.x * node.x, node.y * node.y, node.z * node.z];
        let bend = |a: f64, b: f64| (1.0 - a / 2.0 - b / 2.0 + a * b / 3.0).sqrt();
        *node = Point3::new(node.x * bend(yy, zz), node.y * bend(zz, xx), node.z * bend(xx, yy));
    }
    lattice
}
