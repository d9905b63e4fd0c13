use super::*;
use crate::surface::{LengthUnit, Surface, UpAxis};
use std::f64::consts::PI;

/// Checks that a shape is one closed surface without defects, and returns its volume, m³.
fn check(mesh: RawMesh) -> f64 {
    let surface = Surface::repair(mesh).unwrap();
    assert!(surface.simple, "{:?}", surface.defects);
    assert_eq!(surface.defects, []);
    surface.signed_volume() * surface.frame.diagonal_m.powi(3)
}

fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!((value / expected - 1.0).abs() < tolerance, "{value} instead of {expected}");
}

#[test]
fn solids_have_their_volumes() {
    assert_near(check(cuboid([1.0, 2.0, 3.0])), 6.0, 1e-14);
    assert_near(check(sphere(2.0, 5)), 32.0 * PI / 3.0, 1e-2);
    assert_near(check(ellipsoid([1.0, 2.0, 0.5], 5)), 4.0 * PI / 3.0, 1e-2);
    assert_near(check(torus(2.0, 0.5, [96, 48])), 2.0 * PI * PI * 2.0 * 0.25, 1e-2);
}

#[test]
fn spheres_converge_with_the_square_of_the_spacing() {
    let error = |subdivisions| 1.0 - check(sphere(1.0, subdivisions)) * 3.0 / (4.0 * PI);
    let order = (error(3) / error(4)).log2();
    assert!((order - 2.0).abs() < 0.1, "order {order}");
}

#[test]
fn objects_are_closed_and_of_the_expected_size() {
    assert_near(check(mug()), 2.49e-4, 0.01);
    assert_near(check(vase()), 7.5e-4, 0.3);
    assert_near(check(arch()), 0.2 * 0.3 * (0.8 + 0.5 * PI), 0.01);
    assert_near(check(horseshoe()), PI * 1e-4 * 0.355, 0.05);
    assert_near(check(dumbbell()), 2.0 * 4.0 * PI / 3.0 * 1e-3 + PI * 0.015 * 0.015 * 0.1, 0.02);
    assert_near(check(statue()), 8e-3, 0.4);
}

#[test]
fn the_scanned_statue_has_as_many_triangles_as_it_says() {
    let mesh = scanned_statue();
    assert_near(mesh.triangles.len() as f64, 100_000.0, 0.02);
    assert_near(check(mesh), check(statue()), 0.01);
}

#[test]
fn the_head_has_as_many_triangles_as_it_says_and_a_face() {
    let mesh = head();
    assert_near(mesh.triangles.len() as f64, 100_000.0, 0.02);
    // The tip of the nose is the foremost point.
    let nose = mesh.positions_m.iter().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
    assert!(nose.x.abs() < 0.003 && (0.12..0.14).contains(&nose.y), "{nose}");
    assert_near(check(mesh), 4.9e-3, 0.05);
}

#[test]
fn an_implicit_sphere_is_a_sphere() {
    let corner = nalgebra::Point3::new(1.21, 1.21, 1.21);
    let mesh = implicit(-corner, corner, 0.1, |point| point.coords.norm() - 1.0);
    assert_near(check(mesh), 4.0 * PI / 3.0, 0.02);
}

#[test]
fn shapes_are_clipped_at_the_box_and_closed() {
    let corner = nalgebra::Point3::new(1.0, 1.0, 1.0);
    let mesh = implicit(-corner, corner, 0.25, |point| point.x.hypot(point.y) - 0.5);
    assert!(check(mesh) > 0.5);
}

#[test]
fn a_written_mesh_is_read_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("horseshoe.obj");
    let mesh = horseshoe();
    write_obj(&mesh, &path).unwrap();
    let again = crate::surface::read(&path, LengthUnit::M, UpAxis::Y).unwrap();
    assert_eq!((again.positions_m, again.triangles), (mesh.positions_m, mesh.triangles));
}
