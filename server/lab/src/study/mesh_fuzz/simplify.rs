//! Simplification of base meshes.
//!
//! A closed manifold stays one: edges collapse within a tolerance that grows until few enough triangles are left. Vertices of other
//! meshes are clustered.

use super::cluster::clustered;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::MeshGL64;
use nalgebra::Point3;
use shatter_fracture::surface::RawMesh;

/// Tolerance of the first try, over the diagonal; the factor by which it grows; and the largest one.
const TOLERANCE_FIRST: f64 = 5e-4;
const COARSER: f64 = 1.2;
const TOLERANCE_MAX: f64 = 0.02;

/// Mesh with at most `triangles_max` triangles; unchanged if it has no more.
pub(super) fn simplified(mesh: &RawMesh, triangles_max: usize) -> RawMesh {
    match mesh.triangles.len() > triangles_max {
        true => collapsed(mesh, triangles_max).unwrap_or_else(|| clustered(mesh, triangles_max)),
        false => clustered(mesh, triangles_max),
    }
}

/// Mesh with edges collapsed; `None` if it is no closed manifold or keeps too many triangles.
fn collapsed(mesh: &RawMesh, triangles_max: usize) -> Option<RawMesh> {
    let mut body = Manifold::from_mesh_gl64(&welded(mesh));
    let low = mesh.positions_m.iter().fold(Point3::from([f64::INFINITY; 3]), |low, point| low.inf(point));
    let high = mesh.positions_m.iter().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, point| high.sup(point));
    let diagonal_m = (high - low).norm();
    let mut tolerance = TOLERANCE_FIRST;
    while tolerance < TOLERANCE_MAX {
        body = body.simplify(tolerance * diagonal_m);
        if body.is_empty() {
            return None;
        }
        if body.num_tri() <= triangles_max {
            return Some(RawMesh { rounding: mesh.rounding, ..raw(&body.get_mesh_gl64(0)) });
        }
        tolerance *= COARSER;
    }
    None
}

/// The mesh with vertices of equal positions as one.
fn welded(mesh: &RawMesh) -> MeshGL64 {
    let mut welded = MeshGL64 { num_prop: 3, ..MeshGL64::default() };
    let mut places = std::collections::HashMap::new();
    let mut place_of = Vec::with_capacity(mesh.positions_m.len());
    for point in &mesh.positions_m {
        // Adding zero joins the two zeros.
        let position: [f64; 3] = point.coords.map(|x| x + 0.0).into();
        let next = places.len() as u64;
        let place = *places.entry(position.map(f64::to_bits)).or_insert(next);
        if place == next {
            welded.vert_properties.extend(position);
        }
        place_of.push(place);
    }
    welded.tri_verts = mesh.triangles.iter().flatten().map(|&vertex| place_of[vertex as usize]).collect();
    welded
}

fn raw(mesh: &MeshGL64) -> RawMesh {
    let positions =
        mesh.vert_properties.chunks(mesh.num_prop as usize).map(|p| Point3::new(p[0], p[1], p[2])).collect();
    let (triangles, _) = mesh.tri_verts.as_chunks::<3>();
    RawMesh::new(positions, triangles.iter().map(|corners| corners.map(|vertex| vertex as u32)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_fracture::surface::{Surface, shapes};

    #[test]
    fn a_closed_mesh_stays_closed_and_keeps_its_shape() {
        for fine in [shapes::sphere(1.0, 5), shapes::torus(0.4, 0.15, [100, 50])] {
            let coarse = simplified(&fine, 3000);
            assert!((1000..=3000).contains(&coarse.triangles.len()), "{}", coarse.triangles.len());
            let volume_m3 = |mesh: &RawMesh| {
                let surface = Surface::repair(mesh.clone()).unwrap();
                assert!(surface.simple, "{:?}", surface.defects);
                surface.signed_volume() * surface.frame.diagonal_m.powi(3)
            };
            let ratio = volume_m3(&coarse) / volume_m3(&fine);
            assert!((0.97..1.03).contains(&ratio), "{ratio}");
            assert_eq!(simplified(&coarse, 3000), coarse);
        }
    }

    #[test]
    fn an_open_mesh_is_clustered() {
        let mut open = shapes::sphere(1.0, 5);
        open.triangles.pop();
        assert_eq!(simplified(&open, 3000), clustered(&open, 3000));
    }
}
