//! Repair of the real meshes in the folder `SHATTER_MESHES`, and of damaged copies of them.

use super::*;
use crate::cancel_token::CancelToken;
use DefectKind::*;
use std::path::PathBuf;

/// Reads a mesh of the folder. Without the folder, prints that the test is skipped and returns `None`.
fn mesh(name: &str) -> Option<RawMesh> {
    let Some(folder) = std::env::var_os("SHATTER_MESHES").map(PathBuf::from) else {
        println!("skipped: SHATTER_MESHES is not set");
        return None;
    };
    Some(read(&folder.join(name), LengthUnit::M, UpAxis::Y).unwrap())
}

/// Repairs a mesh and checks its defects (kind, count) and its local volume, to 0.3 %.
fn check(name: &str, damage: impl Fn(&mut RawMesh), defects: &[(DefectKind, u64)], volume: f64) {
    let Some(mut raw) = mesh(name) else { return };
    damage(&mut raw);
    let surface = Surface::repair(raw).unwrap();
    let found: Vec<_> = surface.defects.iter().map(|defect| (defect.kind, defect.count)).collect();
    assert_eq!(found, defects, "{name}");
    check_volume(name, &surface, volume, 0.003);
}

fn check_volume(name: &str, surface: &Surface, volume: f64, tolerance: f64) {
    let found = InsideTest::new(surface).input_volume(&CancelToken::default()).unwrap();
    assert!((found / volume - 1.0).abs() < tolerance, "{name}: {found} instead of {volume}");
}

#[test]
fn good_meshes_have_no_defects() {
    check("spot.obj", |_| {}, &[], 0.0414327);
    check("fandisk.obj", |_| {}, &[], 0.0458324);
    check("cheburashka.obj", |_| {}, &[], 0.0263071);
}

#[test]
fn the_horse_is_inside_out_and_touches_itself() {
    check("horse.ply", |_| {}, &[(FlippedShell, 1), (SelfIntersection, 2)], 0.0162582);
}

#[test]
fn the_cow_mesh_has_a_bow_tie_vertex() {
    check("cow.obj", |_| {}, &[(SelfIntersection, 71), (NonManifoldVertex, 1)], 0.0260778);
}

/// Volumes of open meshes.
///
/// Those of bunny and spot come from a reference that fills holes by fans. The others are the values found; they agree
/// roughly with the same reference, which counts overlaps twice.
#[test]
fn open_meshes_have_an_inside() {
    check("stanford-bunny.obj", |_| {}, &[(Holes, 5), (UnreferencedVertices, 1113)], 0.0481899);
    let teapot =
        [(Holes, 6), (SelfIntersection, 161), (SeveralShells, 4), (DuplicateVertices, 403), (NonManifoldVertex, 1)];
    check("teapot.obj", |_| {}, &teapot, 0.0468);
    let suzanne = [
        (Holes, 4),
        (SelfIntersection, 86),
        (SeveralShells, 3),
        (DuplicateTriangles, 1),
        (DuplicateVertices, 2),
        (NonManifoldVertex, 2),
    ];
    check("suzanne.obj", |_| {}, &suzanne, 0.0403);
    let beetle = [(Holes, 23), (SelfIntersection, 32), (SeveralShells, 33), (NonManifoldEdge, 47)];
    check("beetle.obj", |_| {}, &beetle, 0.0373);
}

#[test]
fn a_horse_with_a_third_of_its_triangles_turned_is_mended() {
    let turn = |mesh: &mut RawMesh| mesh.triangles.iter_mut().step_by(3).for_each(|corners| corners.swap(0, 1));
    check("horse.ply", turn, &[(FlippedShell, 1), (MixedWinding, 32322), (SelfIntersection, 2)], 0.0162582);
}

#[test]
fn a_horse_of_loose_triangles_is_welded() {
    let loosen = |mesh: &mut RawMesh| {
        mesh.positions_m = mesh.triangles.iter().flatten().map(|&v| mesh.positions_m[v as usize]).collect();
        mesh.triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    };
    let duplicates = (DuplicateVertices, 3 * 96966 - 48485);
    check("horse.ply", loosen, &[(FlippedShell, 1), (SelfIntersection, 2), duplicates], 0.0162582);
}

#[test]
fn a_horse_without_every_twentieth_triangle_keeps_its_volume() {
    let Some(mut raw) = mesh("horse.ply") else { return };
    raw.triangles = raw.triangles.into_iter().enumerate().filter(|(t, _)| t % 20 != 7).map(|(_, t)| t).collect();
    let surface = Surface::repair(raw).unwrap();
    assert!(surface.defects.iter().any(|defect| defect.kind == Holes && defect.count > 1000));
    check_volume("a pierced horse", &surface, 0.0162582, 0.01);
}
