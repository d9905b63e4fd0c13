//! Block of body-centered cubic cells: the simplest lattice, for tests, references and the smallest objects.

use super::Lattice;
use nalgebra::{Point3, Vector3};

/// Block of `cells` cubes of side `spacing` (local), centered at the origin.
///
/// Each cube is cut into 24 tetrahedra by its center and its face centers, which neighboring cubes share.
pub fn block(cells: [usize; 3], spacing: f64) -> Lattice {
    let half = Vector3::from(cells.map(|count| count as f64)) * (0.5 * spacing);
    let mut builder = Builder { cells, spacing, half, lattice: Lattice::default(), index: Default::default() };
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                builder.cube([x, y, z]);
            }
        }
    }
    builder.lattice
}

struct Builder {
    cells: [usize; 3],
    spacing: f64,
    half: Vector3<f64>,
    lattice: Lattice,
    index: std::collections::HashMap<[usize; 3], u32>,
}

impl Builder {
    /// Node at twice its cell coordinates: even for a corner, odd for a center.
    fn node(&mut self, twice: [usize; 3]) -> u32 {
        debug_assert!((0..3).all(|k| twice[k] <= 2 * self.cells[k]));
        *self.index.entry(twice).or_insert_with(|| {
            let place = Vector3::from(twice.map(|t| t as f64)) * (0.5 * self.spacing) - self.half;
            self.lattice.nodes.push(Point3::from(place));
            (self.lattice.nodes.len() - 1) as u32
        })
    }

    fn cube(&mut self, cell: [usize; 3]) {
        let base = cell.map(|c| 2 * c);
        let center = self.node(base.map(|b| b + 1));
        for axis in 0..3 {
            for side in [0, 2] {
                self.pyramid(base, center, axis, side);
            }
        }
    }

    fn pyramid(&mut self, base: [usize; 3], center: u32, axis: usize, side: usize) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |du: usize, dv: usize| {
            let mut twice = base;
            twice[axis] += side;
            twice[u] += du;
            twice[v] += dv;
            twice
        };
        let face = self.node(corner(1, 1));
        let ring = [corner(0, 0), corner(2, 0), corner(2, 2), corner(0, 2)].map(|twice| self.node(twice));
        for k in 0..4 {
            let (a, b) = (ring[k], ring[(k + 1) % 4]);
            let tet = if side == 2 { [center, face, a, b] } else { [center, face, b, a] };
            self.lattice.tets.push(tet);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_fills_its_box_with_positive_tetrahedra() {
        let lattice = block([3, 2, 1], 0.5);
        assert!((0..lattice.tets.len()).all(|tet| lattice.tet_volume(tet) > 0.0));
        assert!((lattice.volume() - 0.75).abs() < 1e-14);
        assert_eq!(lattice.boundary().len(), (3 * 2 + 2 + 3) * 2 * 4);
        assert!((lattice.node_volumes().iter().sum::<f64>() - 0.75).abs() < 1e-14);
    }
}
