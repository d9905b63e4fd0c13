//! Normals of a surface whose file has none.
//!
//! Based on: H. Gouraud, *Continuous shading of curved surfaces* (IEEE Transactions on Computers C-20, 1971), weighted
//! by area, and only over neighbors without a crease between them.

use crate::lattice::area_vector;
use crate::surface::Surface;
use nalgebra::Vector3;

/// Cosine of the smallest angle between two triangles that form a crease: 40°.
const CREASE: f64 = 0.766;

/// Largest number of triangles around a vertex for which creases are searched, at quadratic cost.
const AROUND_MAX: usize = 256;

/// Normals of all corners: the mean over the triangles around the point without a crease to the corner's own.
pub(super) fn creased(surface: &Surface) -> Vec<[[f32; 3]; 3]> {
    let count = surface.triangles.len();
    let areas: Vec<Vector3<f64>> = (0..count).map(|triangle| area_vector(&surface.corners(triangle))).collect();
    let units: Vec<Vector3<f64>> = areas.iter().map(|area| area.try_normalize(0.0).unwrap_or_default()).collect();
    let around = around(surface);
    let corner = |triangle: usize, vertex: u32| {
        let others = around.of(vertex);
        let all = others.len() > AROUND_MAX;
        let alike = |other: &&u32| all || units[**other as usize].dot(&units[triangle]) >= CREASE;
        let sum: Vector3<f64> = others.iter().filter(alike).map(|&other| areas[other as usize]).sum();
        let normal = sum.try_normalize(0.0).unwrap_or(Vector3::z());
        [normal.x as f32, normal.y as f32, normal.z as f32]
    };
    (0..count).map(|triangle| surface.triangles[triangle].map(|vertex| corner(triangle, vertex))).collect()
}

/// Triangles around each vertex, ascending.
struct Around {
    offsets: Vec<u32>,
    triangles: Vec<u32>,
}

impl Around {
    fn of(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.triangles[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}

fn around(surface: &Surface) -> Around {
    let mut offsets = vec![0u32; surface.positions.len() + 1];
    surface.triangles.iter().flatten().for_each(|&vertex| offsets[vertex as usize + 1] += 1);
    (1..offsets.len()).for_each(|vertex| offsets[vertex] += offsets[vertex - 1]);
    let mut next = offsets.clone();
    let mut triangles = vec![0; 3 * surface.triangles.len()];
    for (triangle, corners) in surface.triangles.iter().enumerate() {
        for &vertex in corners {
            triangles[next[vertex as usize] as usize] = triangle as u32;
            next[vertex as usize] += 1;
        }
    }
    Around { offsets, triangles }
}
