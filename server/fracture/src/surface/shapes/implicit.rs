//! Closed mesh of the region where a function is negative.
//!
//! Based on: A. Guéziec, R. Hummel, *Exploiting triangulated surface extraction using tetrahedral decomposition*
//! (1995): marching tetrahedra on cubes cut in six along a diagonal. Cut points keep a margin from the nodes, so no
//! triangle degenerates. The surface is a closed manifold by construction.

use super::RawMesh;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Distance of cut points from the nodes, as a share of the edge.
const MARGIN: f64 = 0.1;

/// Corners of the six tetrahedra of a cube, as bits x, y, z. Each runs along cube edges from corner 0 to corner 7.
const TETS: [[usize; 4]; 6] = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// Meshes the region {`height` < 0} inside a box, on cubes of side `spacing_m`. The box
/// closes the mesh where they meet.
pub fn implicit(
    low_m: Point3<f64>,
    high_m: Point3<f64>,
    spacing_m: f64,
    height: impl Fn(&Point3<f64>) -> f64,
) -> RawMesh {
    let cells = ((high_m - low_m) / spacing_m).map(|cells| cells.ceil().max(1.0) as usize);
    let nodes = cells.map(|cells| cells + 1);
    let place = |[x, y, z]: [usize; 3]| low_m + Vector3::new(x as f64, y as f64, z as f64) * spacing_m;
    let index = |[x, y, z]: [usize; 3]| (z * nodes.y + y) * nodes.x + x;
    let mut grid = Grid {
        positions: Vec::new(),
        heights: Vec::new(),
        cuts: HashMap::new(),
        mesh: RawMesh::new(Vec::new(), Vec::new()),
    };
    for z in 0..nodes.z {
        for y in 0..nodes.y {
            for x in 0..nodes.x {
                let position = place([x, y, z]);
                let rim = [x, y, z].iter().zip(cells.iter()).any(|(&k, &last)| k == 0 || k == last);
                let value = height(&position);
                grid.heights.push(if rim { value.max(f64::MIN_POSITIVE) } else { value });
                grid.positions.push(position);
            }
        }
    }
    for z in 0..cells.z {
        for y in 0..cells.y {
            for x in 0..cells.x {
                let corner = |k: usize| index([x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)]);
                TETS.iter().for_each(|tet| grid.cut(tet.map(corner)));
            }
        }
    }
    grid.mesh
}

struct Grid {
    positions: Vec<Point3<f64>>,
    heights: Vec<f64>,
    cuts: HashMap<[usize; 2], u32>,
    mesh: RawMesh,
}

impl Grid {
    fn cut(&mut self, tet: [usize; 4]) {
        let (inside, outside): (Vec<usize>, Vec<usize>) = tet.iter().partition(|&&node| self.heights[node] < 0.0);
        match (&inside[..], &outside[..]) {
            (&[a], &[b, c, d]) => self.face(&[[a, b], [a, c], [a, d]], a, b),
            (&[a, b, c], &[d]) => self.face(&[[a, d], [b, d], [c, d]], a, d),
            (&[a, b], &[c, d]) => {
                self.face(&[[a, c], [a, d], [b, d]], a, c);
                self.face(&[[a, c], [b, d], [b, c]], a, c);
            }
            _ => {}
        }
    }

    /// Adds a triangle between three cut edges (inside, outside each), facing from node `from` to node `to`.
    fn face(&mut self, edges: &[[usize; 2]; 3], from: usize, to: usize) {
        let [a, b, c] = edges.map(|edge| self.point(edge));
        let [pa, pb, pc] = [a, b, c].map(|vertex| self.mesh.positions_m[vertex as usize]);
        let outward = (pb - pa).cross(&(pc - pa)).dot(&(self.positions[to] - self.positions[from])) > 0.0;
        self.mesh.triangles.push(if outward { [a, b, c] } else { [a, c, b] });
    }

    fn point(&mut self, edge: [usize; 2]) -> u32 {
        let [inside, outside] = edge;
        let (positions, heights, mesh) = (&self.positions, &self.heights, &mut self.mesh);
        *self.cuts.entry(edge).or_insert_with(|| {
            let share = heights[inside] / (heights[inside] - heights[outside]);
            let step = positions[outside] - positions[inside];
            mesh.positions_m.push(positions[inside] + step * share.clamp(MARGIN, 1.0 - MARGIN));
            mesh.positions_m.len() as u32 - 1
        })
    }
}
