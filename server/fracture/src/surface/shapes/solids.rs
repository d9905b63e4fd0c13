//! Solids of known volume.

use super::RawMesh;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Box of 12 triangles, centered on the origin. `size_m` holds its side lengths, m.
pub fn cuboid(size_m: [f64; 3]) -> RawMesh {
    let half = Vector3::from(size_m) * 0.5;
    let sign = |corner: usize, axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
    let corner = |k| Point3::from(half.component_mul(&Vector3::from_fn(|axis, _| sign(k, axis))));
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    RawMesh::new((0..8).map(corner).collect(), triangles)
}

/// Sphere centered on the origin: an icosahedron whose triangles are quartered `subdivisions` times.
pub fn sphere(radius_m: f64, subdivisions: u32) -> RawMesh {
    ellipsoid([radius_m; 3], subdivisions)
}

/// Ellipsoid centered on the origin: [`sphere`], stretched to three semi-axes, m.
pub fn ellipsoid(semi_axes_m: [f64; 3], subdivisions: u32) -> RawMesh {
    let (mut positions, mut triangles) = icosahedron();
    for _ in 0..subdivisions {
        triangles = quartered(&mut positions, &triangles);
    }
    let axes = Vector3::from(semi_axes_m);
    RawMesh::new(positions.iter().map(|p| Point3::from(p.component_mul(&axes))).collect(), triangles)
}

/// Torus about the y axis, with `segments` around the axis and around the tube, at least 3 each. Radii in m.
pub fn torus(major_m: f64, minor_m: f64, segments: [u32; 2]) -> RawMesh {
    let [around, across] = segments;
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    let angle = |k: u32, count: u32| TAU * f64::from(k) / f64::from(count);
    for i in 0..around {
        for j in 0..across {
            let (along, tube) = (angle(i, around), angle(j, across));
            let radius = major_m + minor_m * tube.cos();
            mesh.positions_m.push(Point3::new(radius * along.cos(), minor_m * tube.sin(), -radius * along.sin()));
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn icosahedron() -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut positions = Vec::new();
    for axis in 0..3 {
        for (one, two) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
            let mut position = Vector3::zeros();
            position[axis] = one;
            position[(axis + 1) % 3] = two;
            positions.push(position.normalize());
        }
    }
    let side = (positions[0] - positions[1]).norm();
    let near = |a: usize, b: usize| (positions[a] - positions[b]).norm() < 1.1 * side;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in (a + 1..12).filter(|&b| near(a, b)) {
            for c in (b + 1..12).filter(|&c| near(a, c) && near(b, c)) {
                let outward = positions[a].dot(&positions[b].cross(&positions[c])) > 0.0;
                triangles.push(if outward { [a, b, c] } else { [a, c, b] }.map(|k| k as u32));
            }
        }
    }
    (positions, triangles)
}

/// Cuts each triangle into four, with the new corners on the unit sphere.
fn quartered(positions: &mut Vec<Vector3<f64>>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let sum = positions[a.min(b) as usize] + positions[a.max(b) as usize];
            positions.push(sum.normalize());
            positions.len() as u32 - 1
        })
    };
    let mut finer = Vec::with_capacity(triangles.len() * 4);
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    finer
}
