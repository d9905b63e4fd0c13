//! Simplification of base meshes that are open or not manifolds.
//!
//! Based on: J. Rossignac, P. Borrel, *Multi-resolution 3D approximations for rendering complex scenes* (1993): the vertices of
//! each cell of a grid become their mean. The result has no guarantees: walls thinner than a cell fuse, which is acceptable for a mesh
//! that is damaged afterwards.

use nalgebra::Point3;
use shatter_fracture::surface::RawMesh;
use std::collections::HashMap;

/// Number of cells along the longest side of the box at the first try, and the factor by which it decreases.
const CELLS_FIRST: f64 = 128.0;
const FEWER: f64 = 0.85;

/// Mesh on the finest of several grids that leaves at most `triangles_max` triangles; unchanged if it has no more.
pub(super) fn clustered(mesh: &RawMesh, triangles_max: usize) -> RawMesh {
    let (mut coarse, mut cells) = (mesh.clone(), CELLS_FIRST);
    while coarse.triangles.len() > triangles_max && cells > 1.0 {
        coarse = on_grid(mesh, cells);
        cells *= FEWER;
    }
    coarse.faces.clear();
    coarse
}

fn on_grid(mesh: &RawMesh, cells: f64) -> RawMesh {
    let low = mesh.positions_m.iter().fold(Point3::from([f64::INFINITY; 3]), |low, p| low.inf(p));
    let high = mesh.positions_m.iter().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, p| high.sup(p));
    let side = (high - low).amax() / cells;
    let (mut places, mut sums) = (HashMap::new(), Vec::new());
    let mut cluster_of = Vec::with_capacity(mesh.positions_m.len());
    for point in &mesh.positions_m {
        let cell: [i64; 3] = ((point - low) / side).map(|x| x.floor() as i64).into();
        let cluster = *places.entry(cell).or_insert(sums.len());
        if cluster == sums.len() {
            sums.push((nalgebra::Vector3::zeros(), 0.0));
        }
        sums[cluster].0 += point.coords;
        sums[cluster].1 += 1.0;
        cluster_of.push(cluster as u32);
    }
    let positions = sums.iter().map(|(sum, count)| Point3::from(sum / *count)).collect();
    let moved = mesh.triangles.iter().map(|corners| corners.map(|vertex| cluster_of[vertex as usize]));
    let triangles = moved.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
    RawMesh { rounding: mesh.rounding, ..RawMesh::new(positions, triangles) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_fracture::surface::shapes;

    #[test]
    fn clustering_keeps_the_shape_with_fewer_triangles() {
        let fine = shapes::sphere(1.0, 5);
        let coarse = clustered(&fine, 3000);
        assert!((1500..=3000).contains(&coarse.triangles.len()));
        assert!(coarse.check().is_ok());
        assert!(coarse.positions_m.iter().all(|p| (p.coords.norm() - 1.0).abs() < 0.02));
        assert_eq!(clustered(&coarse, 3000), coarse);
    }
}
