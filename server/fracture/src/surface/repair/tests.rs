use super::*;
use crate::surface::{InsideTest, shapes};
use nalgebra::Vector3;

/// Repairs a mesh and checks its defects as (kind, count, first index).
fn check(mesh: RawMesh, expected: &[(DefectKind, u64, u64)]) -> Surface {
    let surface = Surface::repair(mesh).unwrap();
    let found: Vec<_> = surface.defects.iter().map(|d| (d.kind, d.count, d.first_index)).collect();
    assert_eq!(found, expected);
    surface
}

fn cube() -> RawMesh {
    shapes::cuboid([2.0; 3])
}

fn scaled(mut mesh: RawMesh, factor: f64) -> RawMesh {
    mesh.positions_m.iter_mut().for_each(|point| *point *= factor);
    mesh
}

fn inverted(mut mesh: RawMesh) -> RawMesh {
    mesh.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    mesh
}

fn both(mut one: RawMesh, two: &RawMesh, offset: [f64; 3]) -> RawMesh {
    let first = one.positions_m.len() as u32;
    one.positions_m.extend(two.positions_m.iter().map(|point| point + Vector3::from(offset)));
    one.triangles.extend(two.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
    one
}

fn volume_m3(surface: &Surface) -> f64 {
    surface.signed_volume() * surface.frame.diagonal_m.powi(3)
}

fn assert_close(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-12 * expected.abs(), "{value} instead of {expected}");
}

#[test]
fn a_good_mesh_has_no_defects_and_keeps_its_triangles() {
    for mesh in [cube(), shapes::sphere(1.0, 3), shapes::torus(2.0, 0.5, [32, 16])] {
        let count = mesh.triangles.len();
        let surface = check(mesh, &[]);
        assert!(surface.simple && surface.closed);
        assert_eq!(surface.triangles.len(), count);
        assert!(surface.faces.iter().enumerate().all(|(place, &face)| face == place as u64));
    }
}

#[test]
fn the_frame_is_that_of_the_box() {
    let mut mesh = both(shapes::cuboid([1.0, 2.0, 2.0]), &RawMesh::new(Vec::new(), Vec::new()), [0.0; 3]);
    mesh.positions_m.iter_mut().for_each(|point| *point += Vector3::new(5.0, 6.0, 7.0));
    mesh.positions_m.push(Point3::new(100.0, 0.0, 0.0));
    let surface = check(mesh, &[(DefectKind::UnreferencedVertices, 1, 8)]);
    assert_eq!(surface.frame, LocalFrame { center_m: Point3::new(5.0, 6.0, 7.0), diagonal_m: 3.0 });
    assert_eq!(surface.positions.len(), 8);
}

#[test]
fn inverted_shells_are_turned() {
    let surface = check(inverted(cube()), &[(DefectKind::FlippedShell, 1, 0)]);
    assert_close(volume_m3(&surface), 8.0);
}

#[test]
fn mixed_winding_is_made_one() {
    let mut mesh = shapes::sphere(1.0, 3);
    let expected = volume_m3(&check(mesh.clone(), &[]));
    mesh.triangles.iter_mut().skip(1).step_by(3).for_each(|corners| corners.swap(0, 1));
    let turned = (mesh.triangles.len() as u64 - 1).div_ceil(3);
    let surface = check(mesh.clone(), &[(DefectKind::MixedWinding, turned, 1)]);
    assert_close(volume_m3(&surface), expected);
    let kinds: Vec<_> = Surface::repair(inverted(mesh)).unwrap().defects.iter().map(|d| d.kind).collect();
    assert_eq!(kinds, [DefectKind::FlippedShell, DefectKind::MixedWinding]);
}

#[test]
fn unwelded_triangles_are_welded() {
    let mesh = cube();
    let corners = mesh.triangles.iter().flatten().map(|&vertex| mesh.positions_m[vertex as usize]).collect();
    let soup = RawMesh::new(corners, (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect());
    let surface = check(soup, &[(DefectKind::DuplicateVertices, 28, 3)]);
    assert!(surface.simple);
}

#[test]
fn minus_zero_is_zero() {
    let mut mesh = both(cube(), &cube(), [0.0, 0.0, 0.0]);
    mesh.positions_m.iter_mut().for_each(|point| *point += Vector3::repeat(1.0));
    mesh.positions_m
        .iter_mut()
        .skip(8)
        .flat_map(|p| p.coords.iter_mut())
        .for_each(|c| *c = if *c == 0.0 { -0.0 } else { *c });
    check(mesh, &[(DefectKind::DuplicateTriangles, 12, 12), (DefectKind::DuplicateVertices, 8, 8)]);
}

#[test]
fn a_cavity_stays_and_an_inverted_hollow_box_is_turned_as_a_whole() {
    let hollow = both(cube(), &inverted(scaled(cube(), 0.5)), [0.0; 3]);
    let shells = [(DefectKind::SeveralShells, 2, 12), (DefectKind::NestedShells, 1, 12)];
    let surface = check(hollow.clone(), &shells);
    assert!(surface.simple);
    assert_close(volume_m3(&surface), 7.0);
    let surface = check(
        inverted(hollow),
        &[(DefectKind::FlippedShell, 2, 0), (DefectKind::SeveralShells, 2, 12), (DefectKind::NestedShells, 1, 12)],
    );
    assert_close(volume_m3(&surface), 7.0);
}

#[test]
fn a_ball_in_a_cavity_is_solid() {
    let hollow = both(cube(), &inverted(scaled(cube(), 0.5)), [0.0; 3]);
    let mesh = both(hollow, &inverted(scaled(cube(), 0.25)), [0.0; 3]);
    let flipped = (DefectKind::FlippedShell, 1, 24);
    let surface = check(mesh, &[flipped, (DefectKind::SeveralShells, 3, 12), (DefectKind::NestedShells, 2, 12)]);
    assert!(surface.simple);
    assert_close(volume_m3(&surface), 7.125);
}

#[test]
fn nested_solids_are_reported_and_not_simple() {
    let mesh = both(cube(), &scaled(cube(), 0.5), [0.0; 3]);
    let surface = check(mesh, &[(DefectKind::SeveralShells, 2, 12), (DefectKind::NestedShells, 1, 12)]);
    assert!(surface.closed && !surface.simple);
}

#[test]
fn each_of_several_shells_is_turned_outward() {
    let mesh = both(cube(), &inverted(cube()), [5.0, 0.0, 0.0]);
    let surface = check(mesh, &[(DefectKind::FlippedShell, 1, 12), (DefectKind::SeveralShells, 2, 12)]);
    assert_close(volume_m3(&surface), 16.0);
}

#[test]
fn crossing_shells_intersect() {
    let mesh = both(cube(), &cube(), [0.7, 0.8, 0.9]);
    let surface = Surface::repair(mesh).unwrap();
    let crossing = surface.defects.iter().find(|d| d.kind == DefectKind::SelfIntersection).unwrap();
    assert!(crossing.count >= 6 && surface.closed && !surface.simple);
}

#[test]
fn shells_are_classified_independently() {
    let mut mesh = cube();
    for k in 1..300 {
        let shell = if k % 3 == 0 { inverted(cube()) } else { cube() };
        mesh = both(mesh, &shell, [3.0 * f64::from(k % 20), 3.0 * f64::from(k / 20), 0.0]);
    }
    let surface = check(mesh, &[(DefectKind::FlippedShell, 99, 36), (DefectKind::SeveralShells, 300, 12)]);
    assert!(surface.simple);
    assert_close(volume_m3(&surface), 2400.0);
}

#[test]
fn holes_are_counted_as_loops() {
    let mut mesh = shapes::sphere(1.0, 2);
    mesh.triangles.remove(200);
    mesh.triangles.remove(40);
    let surface = Surface::repair(mesh).unwrap();
    let [defect] = &surface.defects[..] else { panic!("{:?}", surface.defects) };
    assert_eq!((defect.kind, defect.count), (DefectKind::Holes, 2));
    assert!(!surface.closed);
}

#[test]
fn an_open_inverted_bowl_is_turned() {
    let mut mesh = inverted(shapes::sphere(1.0, 3));
    let heights: Vec<f64> = mesh.positions_m.iter().map(|point| point.y).collect();
    mesh.triangles.retain(|corners| corners.iter().all(|&vertex| heights[vertex as usize] < 0.5));
    let kinds: Vec<_> = Surface::repair(mesh).unwrap().defects.iter().map(|d| d.kind).collect();
    assert_eq!(kinds, [DefectKind::Holes, DefectKind::FlippedShell, DefectKind::UnreferencedVertices]);
}

#[test]
fn loose_inverted_panels_are_turned_together() {
    // Six faces of a cube, pulled apart, all facing inward.
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    let source = inverted(cube());
    for pair in source.triangles.chunks(2) {
        let part = RawMesh::new(source.positions_m.clone(), pair.to_vec());
        let center: Vector3<f64> = pair.iter().flatten().map(|&v| source.positions_m[v as usize].coords).sum();
        mesh = both(mesh, &part, (center * 0.01).into());
    }
    let surface = Surface::repair(mesh).unwrap();
    let flipped = surface.defects.iter().find(|d| d.kind == DefectKind::FlippedShell).unwrap();
    assert_eq!(flipped.count, 6);
    assert!(surface.signed_volume() > 0.0);
}

/// A box of unit cells, whose triangles two boxes on one grid share where they overlap.
fn cells(from: [u32; 3], to: [u32; 3]) -> RawMesh {
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    let mut quad = |corners: [[u32; 3]; 4]| {
        let first = mesh.positions_m.len() as u32;
        mesh.positions_m.extend(corners.map(|corner| Point3::from(corner.map(f64::from))));
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (i, j) in (from[u]..to[u]).flat_map(|i| (from[v]..to[v]).map(move |j| (i, j))) {
            let corner = |side: u32, di: u32, dj: u32| {
                let mut corner = [0; 3];
                (corner[axis], corner[u], corner[v]) = (side, i + di, j + dj);
                corner
            };
            quad([[0, 0], [1, 0], [1, 1], [0, 1]].map(|[di, dj]| corner(to[axis], di, dj)));
            // The same diagonal as on the opposite side.
            quad([[0, 0], [0, 1], [1, 1], [1, 0]].map(|[di, dj]| corner(from[axis], di, dj)));
        }
    }
    mesh
}

#[test]
fn overlapping_solids_on_one_grid_keep_the_triangles_that_they_share() {
    let overlapping = both(cells([0; 3], [2; 3]), &cells([1, 0, 0], [3, 2, 2]), [0.0; 3]);
    let surface = Surface::repair(overlapping).unwrap();
    assert!(surface.closed);
    assert_close(volume_m3(&surface), 16.0);
    let duplicates = surface.defects.iter().find(|own| own.kind == DefectKind::DuplicateTriangles).unwrap();
    assert_eq!((duplicates.count, duplicates.action.as_str()), (16, "kept: solids that overlap share them"));
    let beside = both(cells([0; 3], [2; 3]), &cells([2, 0, 0], [4, 2, 2]), [0.0; 3]);
    let surface = Surface::repair(beside).unwrap();
    assert_close(volume_m3(&surface), 16.0);
    let duplicates = surface.defects.iter().find(|own| own.kind == DefectKind::DuplicateTriangles).unwrap();
    assert_eq!(duplicates.action, "no copy kept: the surface is closed there without them");
}

/// The action for the duplicate triangles of a mesh, whose repaired surface has the volume of a cube of 8 m³.
fn action_for_duplicates(mesh: RawMesh) -> String {
    let surface = Surface::repair(mesh).unwrap();
    assert_close(volume_m3(&surface), 8.0);
    let mut duplicates = surface.defects.into_iter().filter(|own| own.kind == DefectKind::DuplicateTriangles);
    duplicates.next().unwrap().action
}

/// `mesh` with a two-sided sheet of two triangles through these points.
fn with_sheet(mut mesh: RawMesh, points: [[f64; 3]; 4]) -> RawMesh {
    let first = mesh.positions_m.len() as u32;
    mesh.positions_m.extend(points.map(Point3::from));
    let sheet = [[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]];
    mesh.triangles.extend(sheet.map(|own: [u32; 3]| own.map(|vertex| first + vertex)));
    mesh
}

#[test]
fn two_sided_sheets_are_no_walls() {
    let sheet = |y: f64| [[-0.5, y, -0.5], [0.5, y, -0.5], [0.5, y + 0.5, 0.5], [-0.5, y + 0.5, 0.5]];
    let pairs = "2 pairs that face opposite ways dropped: they enclose nothing";
    assert_eq!(action_for_duplicates(with_sheet(cube(), sheet(1.0))), pairs);
    assert_eq!(action_for_duplicates(with_sheet(cube(), sheet(-0.25))), pairs);
    // Along an edge of the cube.
    let fin = with_sheet(cube(), [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 2.0, 1.0], [2.0, 2.0, -1.0]]);
    let unneeded = "no copy kept: the surface is closed there without them";
    assert_eq!(action_for_duplicates(fin.clone()), unneeded);
    let mut copied = fin;
    let is_opposite = |own: &&[u32; 3]| own.iter().all(|&vertex| copied.positions_m[vertex as usize].x == -1.0);
    let again = *copied.triangles.iter().find(is_opposite).unwrap();
    copied.triangles.push(again);
    let mixed = "one copy kept, but no copy of 2: the surface is closed there without them";
    assert_eq!(action_for_duplicates(copied), mixed);
    let overlapping = both(cells([0; 3], [2; 3]), &cells([1, 0, 0], [3, 2, 2]), [0.0; 3]);
    let apart = [[8.0, 0.0, 0.0], [9.0, 0.0, 0.0], [9.0, 1.0, 0.0], [8.0, 1.0, 0.0]];
    let surface = Surface::repair(with_sheet(overlapping, apart)).unwrap();
    let duplicates = surface.defects.iter().find(|own| own.kind == DefectKind::DuplicateTriangles).unwrap();
    assert_eq!(duplicates.action, format!("kept: solids that overlap share them; {pairs}"));
}

/// A cavity and the solid that fills it, in either order, and a cavity that is there twice.
#[test]
fn a_filled_cavity_is_solid() {
    let (solid, cavity) = (scaled(cube(), 0.5), inverted(scaled(cube(), 0.5)));
    for [first, second] in [[&solid, &cavity], [&cavity, &solid]] {
        let surface = Surface::repair(both(both(cube(), first, [0.0; 3]), second, [0.0; 3])).unwrap();
        assert!(InsideTest::new(&surface).signed_distance(&Point3::origin()) < 0.0);
    }
    let twice = both(both(cube(), &cavity, [0.0; 3]), &cavity, [0.0; 3]);
    assert_close(volume_m3(&Surface::repair(twice).unwrap()), 7.0);
}

#[test]
fn duplicates_are_dropped_but_for_one() {
    let mut mesh = cube();
    let again: Vec<_> = mesh.triangles.iter().map(|&[a, b, c]| [b, c, a]).collect();
    mesh.triangles.extend(&again[3..5]);
    mesh.triangles.push([mesh.triangles[0][1], mesh.triangles[0][0], mesh.triangles[0][2]]);
    let surface = check(mesh, &[(DefectKind::DuplicateTriangles, 3, 12)]);
    assert!(surface.simple);
}

#[test]
fn a_wall_between_two_bodies_is_dropped() {
    let mesh = both(cube(), &cube(), [2.0, 0.0, 0.0]);
    let surface = Surface::repair(mesh).unwrap();
    let kinds: Vec<_> = surface.defects.iter().map(|d| (d.kind, d.count)).collect();
    assert_eq!(kinds, [(DefectKind::DuplicateTriangles, 2), (DefectKind::DuplicateVertices, 4)]);
    assert!(surface.simple);
    assert_eq!(surface.triangles.len(), 20);
    assert_close(volume_m3(&surface), 16.0);
}

#[test]
fn degenerate_triangles_are_dropped_unless_they_close_the_surface() {
    let mut mesh = cube();
    mesh.triangles.insert(4, [0, 0, 1]);
    mesh.triangles.push([2, 2, 2]);
    check(mesh, &[(DefectKind::DegenerateTriangles, 2, 4)]);
    // A T-junction: one side of an edge has a vertex in the middle, bridged by a triangle without area.
    let mut mesh = cube();
    mesh.positions_m.push(nalgebra::center(&mesh.positions_m[0], &mesh.positions_m[6]));
    mesh.triangles.splice(0..1, [[0, 4, 8], [8, 4, 6], [0, 8, 6]]);
    let surface = check(mesh, &[(DefectKind::DegenerateTriangles, 1, 2)]);
    assert!(surface.closed);
    assert_eq!(surface.defects[0].action, "kept: they close the surface");
}

#[test]
fn edges_of_four_triangles_and_bow_ties_are_named() {
    let mesh = both(cube(), &cube(), [2.0, 2.0, 0.0]);
    let surface = Surface::repair(mesh).unwrap();
    let kinds: Vec<_> = surface.defects.iter().map(|d| (d.kind, d.count)).collect();
    let two = (DefectKind::SeveralShells, 2);
    assert_eq!(kinds, [two, (DefectKind::DuplicateVertices, 2), (DefectKind::NonManifoldEdge, 1)]);
    assert!(surface.closed);
    let mesh = both(cube(), &cube(), [2.0, 2.0, 2.0]);
    let surface = Surface::repair(mesh).unwrap();
    let kinds: Vec<_> = surface.defects.iter().map(|d| (d.kind, d.count)).collect();
    let expected = [DefectKind::SeveralShells, DefectKind::DuplicateVertices, DefectKind::NonManifoldVertex];
    assert_eq!(kinds, [(expected[0], 2), (expected[1], 1), (expected[2], 1)]);
}

#[test]
fn a_moebius_strip_is_one_sided() {
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    for k in 0..12 {
        let (along, twist) = (std::f64::consts::TAU * f64::from(k) / 12.0, std::f64::consts::PI * f64::from(k) / 12.0);
        for side in [-0.3, 0.3] {
            let radius = 1.0 + side * twist.cos();
            mesh.positions_m.push(Point3::new(radius * along.cos(), side * twist.sin(), radius * along.sin()));
        }
        let [a, b] = [2 * k as u32, 2 * k as u32 + 1];
        let [c, d] = if k == 11 { [1, 0] } else { [a + 2, b + 2] };
        mesh.triangles.extend([[a, b, c], [b, d, c]]);
    }
    let kinds: Vec<_> = Surface::repair(mesh).unwrap().defects.iter().map(|d| d.kind).collect();
    assert!(kinds.contains(&DefectKind::NonOrientable), "{kinds:?}");
}

#[test]
fn far_away_single_precision_is_named() {
    let mut mesh = cube();
    mesh.positions_m.iter_mut().for_each(|point| point.x += 1000.0);
    check(mesh.clone(), &[]);
    mesh.rounding = crate::surface::SINGLE;
    check(mesh, &[(DefectKind::LostPrecision, 8, 0)]);
}

#[test]
fn useless_meshes_are_refused() {
    let refused = |mesh| Surface::repair(mesh).unwrap_err();
    assert!(matches!(refused(RawMesh::new(Vec::new(), Vec::new())), SurfaceError::Empty { .. }));
    assert!(matches!(refused(RawMesh::new(cube().positions_m, Vec::new())), SurfaceError::Empty { .. }));
    let mut mesh = cube();
    mesh.positions_m[5].y = f64::NAN;
    assert!(matches!(refused(mesh), SurfaceError::NonFiniteVertex { vertex: 5, line: None }));
    let mut mesh = cube();
    mesh.triangles[7][1] = 8;
    assert!(matches!(refused(mesh), SurfaceError::VertexOutOfBounds { face: 7, index: 8, vertices: 8 }));
    let line = (0..3).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
    assert!(matches!(refused(RawMesh::new(line, vec![[0, 1, 2], [0, 0, 1]])), SurfaceError::AllDegenerate));
    assert!(matches!(refused(RawMesh::new(vec![Point3::origin(); 3], vec![[0, 1, 2]])), SurfaceError::ZeroExtent));
    // Sizes outside the range of single precision are rejected.
    assert!(matches!(refused(scaled(cube(), 1e40)), SurfaceError::VertexOutOfRange { vertex: 0, .. }));
    assert!(matches!(refused(scaled(cube(), 1e-40)), SurfaceError::ExtentOutOfRange { .. }));
}

#[test]
fn sizes_and_places_do_not_matter() {
    let reference = check(shapes::sphere(1.0, 3), &[]);
    for exponent in [-20, 20] {
        let surface = check(scaled(shapes::sphere(1.0, 3), 2.0_f64.powi(exponent)), &[]);
        assert_eq!(surface.positions, reference.positions);
    }
    let mut mesh = shapes::sphere(1.0, 3);
    mesh.positions_m.iter_mut().for_each(|point| *point += Vector3::repeat(1e6));
    let surface = check(mesh, &[]);
    assert!((surface.signed_volume() - reference.signed_volume()).abs() < 1e-9);
}
