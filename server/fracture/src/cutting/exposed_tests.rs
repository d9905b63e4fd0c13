//! Cracks that lie in the outer surface, where two triangles of it lie in one plane.

use super::tests::{baked, fragments, outer, strike};
use crate::pipeline::{FractureMeshes, PreparedObject};
use crate::surface::{InsideTest, RawMesh, Surface, shapes};
use nalgebra::Vector3;

/// A mesh in a direction of its own.
fn turned(mut mesh: RawMesh) -> RawMesh {
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, 0.5, 0.7);
    mesh.positions_m.iter_mut().for_each(|place| *place = turn * *place);
    mesh
}

/// Vertices rounded to single precision, as files hold them: quadrilaterals are then flat only nearly.
pub(super) fn rounded(mut mesh: RawMesh) -> RawMesh {
    mesh.positions_m.iter_mut().for_each(|place| *place = place.map(|x| f64::from(x as f32)));
    mesh
}

/// Area of the triangles of cracks that lie on the input surface, m².
fn exposed_cracks(meshes: &FractureMeshes, prepared: &PreparedObject, inside: &InsideTest) -> f64 {
    let emitted = meshes.emitted().unwrap();
    let mut sum = 0.0;
    for fragment in emitted.fragments() {
        let center = Vector3::from(fragment.row.center_m);
        let place = |vertex: u32| Vector3::from(fragment.positions[vertex as usize]).cast::<f64>() + center;
        let runs = &meshes.runs[fragment.row.run_first as usize..][..fragment.row.run_count as usize];
        for run in runs.iter().filter(|run| run.crack) {
            let first = (run.index_first - fragment.row.index_first) as usize;
            for triangle in fragment.indices[first..][..run.index_count as usize].chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|corner| place(triangle[corner]));
                let on_surface = |p: &Vector3<f64>| inside.distance(&prepared.frame.to_local(&(*p).into())) < 2e-7;
                if [a, b, c, (a + b + c) / 3.0].iter().all(on_surface) {
                    sum += (b - a).cross(&(c - a)).norm() / 2.0;
                }
            }
        }
    }
    sum
}

#[test]
fn cracks_do_not_lie_in_the_outer_surface() {
    for (mesh, spacing) in
        [(shapes::torus(0.1, 0.04, [48, 24]), 0.05), (turned(shapes::arch()), 0.05), (turned(shapes::mug()), 0.04)]
    {
        let mesh = rounded(mesh);
        let inside = InsideTest::new(&Surface::repair(mesh.clone()).unwrap());
        let prepared = baked(mesh, spacing);
        for number in 0..2 {
            let fracture = fragments(&prepared, &strike(&prepared, number));
            let (_, outer_m2) = outer(&fracture.meshes, &prepared, &inside);
            let exposed_m2 = exposed_cracks(&fracture.meshes, &prepared, &inside);
            // 1.3e-4 to 5e-3 on the torus and the arch before points of cracks were moved.
            assert!(exposed_m2 < 5e-5 * outer_m2, "{number}: {exposed_m2:e} of {outer_m2}");
        }
    }
}
