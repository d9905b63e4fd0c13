//! Tests of the repairs that make a surface conform.

use super::FilledSurface;
use super::meshed_surface::MeshedSurface;
use super::united::{UnitedSurface, united};
use super::{RepairKind, SurfaceRepair};
use crate::cancel_token::CancelToken;
use crate::conforming::{ConformingOptions, conforming_mesh};
use crate::database::BakeRequest;
use crate::fragment::closed;
use crate::pipeline::{DegreeRequest, FractureOutcome, FractureRequest, PreparedObject, SurfaceKind};
use crate::scene::Material;
use crate::surface::{DefectKind, RawMesh, Surface, shapes};
use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;

/// `mesh` rotated about its center by `angles` and moved by `offset_m`.
fn moved(mut mesh: RawMesh, angles: [f64; 3], offset_m: [f64; 3]) -> RawMesh {
    let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
    mesh.positions_m.iter_mut().for_each(|point| *point = rotation * *point + Vector3::from(offset_m));
    mesh
}

/// Both meshes in one.
fn joined(mut one: RawMesh, other: &RawMesh) -> RawMesh {
    let first = one.positions_m.len() as u32;
    one.positions_m.extend(&other.positions_m);
    one.triangles.extend(other.triangles.iter().map(|own| own.map(|vertex| vertex + first)));
    one
}

fn cube(offset_m: [f64; 3]) -> RawMesh {
    moved(shapes::cuboid([1.0; 3]), [0.0; 3], offset_m)
}

fn baked(mesh: RawMesh) -> PreparedObject {
    let request = BakeRequest {
        kappa: Some(1.0),
        elastic_spacing: Some(0.12),
        crack_spacing: Some(0.08),
        ..BakeRequest::new("repaired", "ceramic", Material::named("ceramic").unwrap())
    };
    request.bake(mesh).unwrap()
}

/// Bakes, checks surface and volume, and breaks the object into closed pieces.
#[track_caller]
fn check(mesh: RawMesh, volume_m3: f64, kinds: &[RepairKind]) -> PreparedObject {
    let prepared = baked(mesh);
    let report = &prepared.report.surface;
    assert_eq!((report.kind, &report.reason), (SurfaceKind::Exact, &None));
    assert_eq!(report.repairs.iter().map(|own| own.kind).collect::<Vec<_>>(), kinds);
    let found = prepared.report.input_volume_m3;
    assert!((found / volume_m3 - 1.0).abs() < 1e-6, "{found} m³ instead of {volume_m3} m³");
    let boundary = &prepared.bodies[0].cutting.as_ref().unwrap().topology.boundary;
    for number in 0..3 {
        let face = boundary[7919 * (number + 1) % boundary.len()];
        let node = prepared.bodies[0].cutting.as_ref().unwrap().mesh.nodes[face.nodes[0] as usize];
        let point_m = prepared.frame.to_meters(&node);
        let request = FractureRequest::at(point_m, prepared.frame.center_m - point_m).seeded(number as u64);
        let request = FractureRequest { degree: DegreeRequest::Sites(12), ..request };
        let FractureOutcome::Fractured(fracture) = prepared.strike(&request).unwrap() else { panic!("intact") };
        let emitted = fracture.meshes.emitted().unwrap();
        emitted.fragments().for_each(|fragment| closed(fragment.positions, fragment.indices).unwrap());
        let sum: f64 = fracture.meshes.fragments.iter().map(|row| row.volume_m3).sum();
        assert!((sum / found - 1.0).abs() < 1e-9, "{sum} of {found}");
    }
    prepared
}

#[test]
fn holes_are_closed_by_films() {
    let mut open = cube([0.0; 3]);
    open.triangles.truncate(open.triangles.len() - 1);
    let prepared = check(open, 1.0, &[RepairKind::FilledHoles]);
    let SurfaceRepair { count, area_m2, area_share, places_m, .. } = &prepared.report.surface.repairs[0];
    assert_eq!((*count, places_m.len()), (1, 1));
    assert!((area_m2 - 0.5).abs() < 1e-12 && (area_share - 0.5 / 6.0).abs() < 1e-12, "{area_m2}, {area_share}");
    // Of a rim of four vertices, the film of least area is the flat one.
    check(without_top(), 1.0, &[RepairKind::FilledHoles]);
}

#[test]
fn the_area_of_a_wall_between_parts_is_reported() {
    let prepared = check(joined(cube([0.0; 3]), &cube([1.0, 0.0, 0.0])), 2.0, &[RepairKind::DuplicateTriangles]);
    let SurfaceRepair { count, area_m2, area_share, places_m, .. } = &prepared.report.surface.repairs[0];
    assert_eq!(*count, 4);
    assert!((area_m2 - 2.0).abs() < 1e-12 && (area_share - 2.0 / 12.0).abs() < 1e-12, "{area_m2}, {area_share}");
    assert!(places_m.iter().all(|place| place.x == 0.5), "{places_m:?}");
}

/// The cube without its upper side.
fn without_top() -> RawMesh {
    let mut cube = cube([0.0; 3]);
    let positions_m = &cube.positions_m;
    cube.triangles.retain(|own| own.iter().any(|&vertex| positions_m[vertex as usize].y < 0.0));
    assert_eq!(cube.triangles.len(), 10);
    cube
}

#[test]
fn the_area_of_films_is_that_outside_other_parts() {
    let offset_m = [0.5, 0.25, 0.125];
    let kinds = [RepairKind::FilledHoles, RepairKind::UnitedParts];
    let prepared = check(joined(without_top(), &cube(offset_m)), 2.0 - 0.5 * 0.75 * 0.875, &kinds);
    let [films, united] = [0, 1].map(|own| &prepared.report.surface.repairs[own]);
    let inside_m2 = 0.5 * 0.875;
    let common_m2 = 2.0 * (0.5 * 0.75 + inside_m2 + 0.75 * 0.875);
    for (repair, area_m2, whole_m2) in
        [(films, 1.0 - inside_m2, 12.0 - inside_m2), (united, common_m2 - inside_m2, 11.0)]
    {
        assert!((repair.area_m2 - area_m2).abs() < 1e-6, "{repair:?}, not {area_m2} m²");
        assert!((repair.area_share - area_m2 / whole_m2).abs() < 1e-6, "{repair:?}");
    }
}

/// `mesh` with one of its edges divided in one of its triangles, at a point `beside_m` off the edge.
fn with_t_junctions(mut mesh: RawMesh, every: usize, beside_m: f64) -> RawMesh {
    for own in (0..mesh.triangles.len()).step_by(every) {
        let [a, b, c] = mesh.triangles[own];
        let [from, to, apex] = [a, b, c].map(|vertex| mesh.positions_m[vertex as usize]);
        let middle = mesh.positions_m.len() as u32;
        mesh.positions_m.push(from + (to - from) * 0.375 + (apex - from).normalize() * beside_m);
        mesh.triangles[own] = [a, middle, c];
        mesh.triangles.push([middle, b, c]);
    }
    mesh
}

#[test]
fn t_junctions_are_closed() {
    for beside_m in [0.0, 1e-3] {
        for (mesh, every) in [(cube([0.0; 3]), 5), (shapes::sphere(0.5, 2), 9)] {
            let volume_m3 = Surface::repair(mesh.clone()).unwrap();
            let volume_m3 = volume_m3.signed_volume() * volume_m3.frame.diagonal_m.powi(3);
            let prepared = baked(with_t_junctions(mesh, every, beside_m));
            let report = &prepared.report.surface;
            assert_eq!((report.kind, &report.reason), (SurfaceKind::Exact, &None), "{beside_m}");
            let found = prepared.report.input_volume_m3;
            assert!((found / volume_m3 - 1.0).abs() < 1e-3, "{beside_m}: {found} m³ instead of {volume_m3} m³");
            let kinds: Vec<RepairKind> = report.repairs.iter().map(|own| own.kind).collect();
            let wanted = if beside_m == 0.0 { RepairKind::DividedEdges } else { RepairKind::FilledHoles };
            assert!(
                kinds.contains(&wanted) && (beside_m > 0.0 || !kinds.contains(&RepairKind::FilledHoles)),
                "{kinds:?}"
            );
        }
    }
}

#[test]
fn many_holes_are_closed() {
    let mut mesh = shapes::sphere(0.5, 3);
    let kept = mesh.triangles.iter().enumerate().filter(|(own, _)| own * 7919 % 10 > 1);
    mesh.triangles = kept.map(|(_, own)| *own).collect();
    let report = baked(mesh).report.surface;
    assert_eq!((report.kind, &report.reason), (SurfaceKind::Exact, &None), "{report:?}");
}

/// Elasticity is solved on the solid that the fragments come from.
#[test]
fn the_lattice_has_the_volume_of_the_closed_surface() {
    let mut tube = cube([0.0; 3]);
    let is_end = |own: &[u32; 3]| {
        let [a, b, c] = own.map(|vertex| tube.positions_m[vertex as usize].y);
        a == b && b == c
    };
    tube.triangles = tube.triangles.iter().filter(|own| !is_end(own)).copied().collect();
    let report = baked(tube).report;
    assert_eq!(report.surface.kind, SurfaceKind::Exact);
    assert!(report.volume_error().abs() < 0.01, "{}", report.volume_error());
    let holes = report.defects.iter().find(|own| own.kind == DefectKind::Holes).unwrap();
    assert_eq!(holes.action, "closed by films of least area");
}

#[test]
fn large_holes_stay_open() {
    let mut sheet = cube([0.0; 3]);
    let bottom = |own: &[u32; 3]| own.iter().all(|&vertex| sheet.positions_m[vertex as usize].y < 0.0);
    sheet.triangles = sheet.triangles.iter().filter(|own| bottom(own)).copied().collect();
    for mesh in [sheet, cube([0.0; 3])] {
        assert_eq!(FilledSurface::new(Surface::repair(mesh).unwrap()).repairs, []);
    }
}

#[test]
fn films_have_the_attributes_of_their_rim() {
    let mut open = cube([0.0; 3]);
    open.triangles.truncate(open.triangles.len() - 2);
    open.attributes.uvs = (0..open.triangles.len()).map(|own| [[own as f32, 0.5]; 3]).collect();
    open.attributes.uvs2 = vec![[[0.25, 0.75]; 3]; open.triangles.len()];
    open.attributes.colors = vec![[[0.5; 4]; 3]; open.triangles.len()];
    open.attributes.materials = vec![1; open.triangles.len()];
    open.attributes.names = vec!["a".to_owned(), "b".to_owned()];
    let surface = Surface::repair(open).unwrap();
    let filled = FilledSurface::new(surface).surface;
    let count = filled.triangles.len();
    assert_eq!(count, 12);
    assert_eq!(
        (filled.attributes.uvs.len(), filled.attributes.materials.len(), filled.faces.len()),
        (count, count, count)
    );
    assert_eq!(filled.attributes.materials[count - 1], 1);
    assert_eq!(filled.attributes.uvs[count - 1][0][1], 0.5);
    assert_eq!((filled.attributes.uvs2.len(), filled.attributes.colors.len()), (count, count));
    assert_eq!(
        (filled.attributes.uvs2[count - 1][0], filled.attributes.colors[count - 1][0]),
        ([0.25, 0.75], [0.5; 4])
    );
}

#[test]
fn divided_triangles_keep_their_attributes() {
    let mut mesh = with_t_junctions(cube([0.0; 3]), 5, 0.0);
    let map = |at: &Point3<f64>| [at.x + 0.5 * at.y - at.z, at.z - 0.25 * at.x].map(|x| x as f32);
    let second = |[u, v]: [f32; 2]| [v, -u];
    let color = |[u, v]: [f32; 2]| [u, v, u + v, 1.0].map(|x| 0.25 + 0.125 * x);
    let uvs: Vec<[[f32; 2]; 3]> =
        mesh.triangles.iter().map(|own| own.map(|vertex| map(&mesh.positions_m[vertex as usize]))).collect();
    mesh.attributes.uvs2 = uvs.iter().map(|own| own.map(second)).collect();
    mesh.attributes.colors = uvs.iter().map(|own| own.map(color)).collect();
    mesh.attributes.uvs = uvs;
    let count = mesh.triangles.len();
    let filled = FilledSurface::new(Surface::repair(mesh).unwrap()).surface;
    assert!(filled.triangles.len() > count);
    let attributes = &filled.attributes;
    for (own, triangle) in filled.triangles.iter().enumerate() {
        for (corner, &vertex) in triangle.iter().enumerate() {
            let wanted = map(&filled.frame.to_meters(&filled.positions[vertex as usize]));
            let found = [attributes.uvs[own][corner], attributes.uvs2[own][corner]];
            for (found, wanted) in found.as_flattened().iter().zip([wanted, second(wanted)].as_flattened()) {
                assert!((found - wanted).abs() < 1e-6, "{own}, {corner}: {found} instead of {wanted}");
            }
            let colors = attributes.colors[own][corner].into_iter().zip(color(wanted));
            colors.for_each(|(found, wanted)| assert!((found - wanted).abs() < 1e-6, "{own}, {corner}"));
        }
    }
}

#[test]
fn parts_that_cross_are_united() {
    let tilted = moved(shapes::cuboid([1.0; 3]), [0.0; 3], [0.5, 0.25, 0.125]);
    let volume_m3 = 2.0 - 0.5 * 0.75 * 0.875;
    let prepared = check(joined(cube([0.0; 3]), &tilted), volume_m3, &[RepairKind::UnitedParts]);
    let repair = &prepared.report.surface.repairs[0];
    assert!(repair.count > repair.places_m.len() as u64 && repair.places_m.len() > 1, "{repair:?}");
    // The surface of the common part, of that of both cubes.
    let common_m2 = 2.0 * (0.5 * 0.75 + 0.5 * 0.875 + 0.75 * 0.875);
    assert!((repair.area_m2 - common_m2).abs() < 1e-6, "{repair:?}");
    assert!((repair.area_share - common_m2 / 12.0).abs() < 1e-6, "{repair:?}");
    // The places lie on both boundaries.
    for place in &repair.places_m {
        for center in [[0.0; 3], [0.5, 0.25, 0.125]] {
            let offset = (place - Point3::from(center)).amax();
            assert!((offset - 0.5).abs() < 1e-9, "{place} is not on the cube at {center:?}");
        }
    }
}

/// A plate, and a pyramid that stands on its tip at (0.13, 0.125, 0.07), far from all corners of the plate.
#[test]
fn the_reason_names_the_point_in_which_parts_touch() {
    let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    let corners =
        [at(0.13, 0.125, 0.07), at(-0.1, 0.5, -0.2), at(0.4, 0.5, -0.2), at(0.4, 0.5, 0.3), at(-0.1, 0.5, 0.3)];
    let mut triangles: Vec<[u32; 3]> = (0..4).map(|k| [0, 1 + k, 1 + (k + 1) % 4]).collect();
    triangles.extend([[1, 3, 2], [1, 4, 3]]);
    let plate = shapes::cuboid([1.0, 0.25, 1.0]);
    let report = baked(joined(plate, &RawMesh::new(corners.to_vec(), triangles))).report.surface;
    let wanted =
        "triangles of the mesh intersect or touch near (0.1300, 0.1250, 0.0700) m; mend the mesh there and bake again";
    assert_eq!(report.reason.as_deref(), Some(wanted));
}

#[test]
fn holes_of_a_sheet_on_a_solid_are_named_so() {
    let at = |x: f64, z: f64| Point3::new(x, 0.2, z);
    let fin = RawMesh::new(vec![at(0.2, 0.5), at(0.3, 0.5), at(0.25, 0.9)], vec![[0, 1, 2]]);
    let prepared = check(joined(cube([0.0; 3]), &fin), 1.0, &[RepairKind::UnitedParts, RepairKind::HiddenTriangles]);
    let holes = prepared.report.defects.iter().find(|defect| defect.kind == DefectKind::Holes).unwrap();
    assert!(holes.action.contains("sheets without volume"), "{holes:?}");
}

#[test]
fn a_part_inside_another_dissolves_and_a_cavity_stays() {
    let inner = shapes::cuboid([0.25; 3]);
    let solid = joined(cube([0.0; 3]), &inner);
    check(solid, 1.0, &[RepairKind::HiddenTriangles]);
    let mut reversed = inner;
    reversed.triangles.iter_mut().for_each(|own| own.swap(1, 2));
    check(joined(cube([0.0; 3]), &reversed), 1.0 - 0.25_f64.powi(3), &[]);
}

#[test]
fn parts_that_touch_in_a_vertex_are_moved_apart() {
    // A cube with a dent whose tip reaches the middle of the opposite face's vertex: two pyramids that meet in one point.
    let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    let mut hourglass = RawMesh::new(vec![at(0.0, 0.0, 0.0)], Vec::new());
    for y in [-1.0, 1.0] {
        let first = hourglass.positions_m.len() as u32;
        hourglass.positions_m.extend([at(-1.0, y, -1.0), at(1.0, y, -1.0), at(1.0, y, 1.0), at(-1.0, y, 1.0)]);
        let mut own: Vec<[u32; 3]> = (0..4).map(|k| [0, first + k, first + (k + 1) % 4]).collect();
        own.extend([[first, first + 2, first + 1], [first, first + 3, first + 2]]);
        if y > 0.0 {
            own.iter_mut().for_each(|own| own.swap(1, 2));
        }
        hourglass.triangles.extend(own);
    }
    let surface = Surface::repair(hourglass).unwrap();
    let meshed = MeshedSurface::new(&surface, true);
    let united = united(&meshed, &CancelToken::default()).unwrap();
    assert_eq!((united.crossings.len(), united.hidden.len(), united.divided.len()), (0, 0, 1));
    assert_eq!(united.meshed.positions.len(), meshed.positions.len() + 1);
    let options = ConformingOptions { spacing: 0.1, ..ConformingOptions::default() };
    let UnitedSurface { meshed, .. } = united;
    let mesh =
        conforming_mesh(&meshed.positions, &meshed.triangles, &[], &options, &CancelToken::default(), &mut |_| ());
    assert!(mesh.is_ok(), "{mesh:?}");
    assert_eq!(meshed.corners.len(), meshed.triangles.len());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// The union of two boxes has a volume between the larger one's and the sum, and its surface can be meshed.
    #[test]
    fn any_two_boxes_are_united(
        size in prop::array::uniform3(0.3_f64..1.5),
        angles in prop::array::uniform3(0.0_f64..3.0),
        offset_m in prop::array::uniform3(-0.9_f64..0.9),
    ) {
        let other = moved(shapes::cuboid(size), angles, offset_m);
        let surface = Surface::repair(joined(cube([0.0; 3]), &other)).unwrap();
        let united = united(&MeshedSurface::new(&surface, false), &CancelToken::default()).unwrap();
        let MeshedSurface { positions, triangles, .. } = &united.meshed;
        let options = ConformingOptions { spacing: 0.2, ..ConformingOptions::default() };
        let mesh = conforming_mesh(positions, triangles, &[], &options, &CancelToken::default(), &mut |_| ());
        prop_assert!(mesh.is_ok(), "{mesh:?}");
        let cone = |own: &[u32; 3]| {
            let [a, b, c] = own.map(|vertex| positions[vertex as usize].coords);
            a.dot(&b.cross(&c)) / 6.0
        };
        let volume_m3 = triangles.iter().map(cone).sum::<f64>() * surface.frame.diagonal_m.powi(3);
        let own = size.iter().product::<f64>();
        prop_assert!(volume_m3 > own.max(1.0) - 1e-9 && volume_m3 < own + 1.0 + 1e-9, "{volume_m3}");
    }
}
