use super::super::winding::brute_force;
use super::super::{RawMesh, SurfaceError, shapes};
use super::*;
use crate::cancel_token::CancelToken;
use crate::random::RandomStream;
use nalgebra::Vector3;

fn surface(mesh: RawMesh) -> Surface {
    Surface::repair(mesh).unwrap()
}

/// `count` points, uniform in the surface's bounding box widened by a tenth.
fn points(inside: &InsideTest, count: usize) -> Vec<Point3<f64>> {
    let mut random = RandomStream::new(7, 0);
    let (low, size) = (inside.bounds.low, inside.bounds.diagonal());
    let mut uniform = || 1.2 * random.uniform() - 0.1;
    (0..count).map(|_| low + size.component_mul(&Vector3::from_fn(|_, _| uniform()))).collect()
}

/// Compares the hierarchy's winding numbers with the sum over all triangles, for single
/// points and for four close together.
///
/// Returns the number of points inside.
fn check_winding(surface: &Surface, count: usize) -> usize {
    let inside = InsideTest::new(surface);
    let triangles: Vec<_> = (0..surface.triangles.len()).map(|t| surface.corners(t)).collect();
    let compare = |point: &Point3<f64>| {
        let together = [[0.0; 3], [0.02, 0.0, 0.0], [0.0, -0.02, 0.0], [0.01, 0.01, 0.02]];
        let together = together.map(|offset| point + Vector3::from(offset));
        let exacts = together.map(|point| brute_force(&triangles, &point));
        let [alone] = inside.winding.at(&inside.tree, &[*point]);
        let exact = exacts[0];
        let errors = inside.winding.at(&inside.tree, &together).into_iter().zip(exacts);
        let error = errors.chain([(alone, exact)]).map(|(found, exact)| (found - exact).abs()).fold(0.0, f64::max);
        (error, exact, inside.signed_distance(point) < 0.0)
    };
    let compared: Vec<_> = points(&inside, count).par_iter().map(compare).collect();
    let worst = compared.iter().map(|(error, ..)| *error).fold(0.0, f64::max);
    assert!(worst < if surface.closed { 0.1 } else { 0.01 }, "off by {worst}");
    assert!(compared.iter().all(|(_, exact, within)| (exact - 0.5).abs() < 0.01 || *within == (*exact > 0.5)));
    compared.iter().filter(|(.., within)| *within).count()
}

/// Sphere without its cap above `height`.
fn open_sphere(height: f64) -> RawMesh {
    let mut mesh = shapes::sphere(1.0, 4);
    let RawMesh { positions_m, triangles, .. } = &mut mesh;
    triangles.retain(|corners| corners.iter().all(|&vertex| positions_m[vertex as usize].y <= height));
    mesh
}

fn both(mut one: RawMesh, two: RawMesh, offset: Vector3<f64>) -> RawMesh {
    let first = one.positions_m.len() as u32;
    one.positions_m.extend(two.positions_m.iter().map(|point| point + offset));
    one.triangles.extend(two.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
    one
}

#[test]
fn the_winding_number_matches_the_sum_over_all_triangles() {
    for mesh in [shapes::sphere(1.0, 4), shapes::torus(1.0, 0.3, [64, 32]), shapes::statue(), open_sphere(0.5)] {
        assert!(check_winding(&surface(mesh), 1000) > 50);
    }
}

#[test]
fn ten_thousand_points_are_on_the_right_side_of_a_torus() {
    let surface = surface(shapes::torus(1.0, 0.4, [48, 24]));
    let within = check_winding(&surface, 10_000) as f64 / 10_000.0;
    let size = InsideTest::new(&surface).bounds.diagonal() * 1.2;
    assert!((within - surface.signed_volume() / size.product()).abs() < 0.015);
}

#[test]
fn the_signed_distance_of_a_sphere_is_its_own() {
    let surface = surface(shapes::sphere(3.0, 6));
    let inside = InsideTest::new(&surface);
    let radius = 3.0 / surface.frame.diagonal_m;
    for point in points(&inside, 1000) {
        let expected = point.coords.norm() - radius;
        assert!((inside.signed_distance(&point) - expected).abs() < 2e-4, "at {point}");
    }
}

#[test]
fn a_hole_is_closed_by_a_film() {
    let mut mesh = shapes::cuboid([2.0; 3]);
    mesh.triangles.retain(|corners| corners.iter().any(|&vertex| mesh.positions_m[vertex as usize].y < 0.0));
    let surface = surface(mesh);
    let inside = InsideTest::new(&surface);
    assert!(!surface.closed);
    let center = Point3::new(0.0, 1.0 / surface.frame.diagonal_m, 0.0);
    assert!(inside.signed_distance(&center).abs() < 1e-12);
    for step in [-0.1, -0.01, 0.01, 0.1] {
        let height = inside.signed_distance(&(center + Vector3::y() * step));
        assert!((height / step - 0.9).abs() < 0.1, "{height} at {step}");
    }
    let sum: usize =
        points(&inside, 2000).iter().filter(|p| inside.signed_distance(p).abs() > inside.distance(p)).count();
    assert_eq!(sum, 0);
}

fn check_volume(mesh: RawMesh, expected_m3: f64, tolerance: f64) {
    let surface = surface(mesh);
    let volume = InsideTest::new(&surface).input_volume(&CancelToken::default()).unwrap();
    let relative = volume * surface.frame.diagonal_m.powi(3) / expected_m3 - 1.0;
    assert!(relative.abs() < tolerance, "the volume is off by {relative}");
}

#[test]
fn volumes_of_closed_surfaces_are_exact() {
    check_volume(shapes::cuboid([1.0, 2.0, 3.0]), 6.0, 1e-14);
    let mut cavity = shapes::cuboid([0.5, 0.5, 0.5]);
    cavity.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    check_volume(both(shapes::cuboid([1.0, 2.0, 3.0]), cavity, Vector3::zeros()), 6.0 - 0.125, 1e-14);
}

#[test]
fn overlapping_shells_count_once() {
    let cube = || shapes::cuboid([1.0; 3]);
    check_volume(both(cube(), cube(), Vector3::new(0.3, 0.4, 0.5)), 2.0 - 0.7 * 0.6 * 0.5, 1e-3);
    check_volume(both(cube(), shapes::cuboid([0.5; 3]), Vector3::zeros()), 1.0, 1e-3);
}

#[test]
fn an_open_surface_has_the_volume_behind_its_film() {
    let cap = |height: f64| std::f64::consts::PI * (2.0 / 3.0 + height - height.powi(3) / 3.0);
    check_volume(open_sphere(0.0), cap(0.0), 0.06);
    let sphere = shapes::sphere(1.0, 4);
    let mut pierced = sphere.clone();
    pierced.triangles.remove(17);
    let whole = surface(sphere);
    check_volume(pierced, whole.signed_volume() * whole.frame.diagonal_m.powi(3), 1e-3);
}

#[test]
fn a_flat_sheet_encloses_nothing() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    let surface = surface(RawMesh::new(points.to_vec(), vec![[0, 1, 2], [0, 2, 3]]));
    let volume = InsideTest::new(&surface).input_volume(&CancelToken::default());
    assert!(matches!(volume, Err(SurfaceError::NothingInside)));
}

#[test]
fn a_canceled_integral_stops() {
    let surface = surface(open_sphere(0.5));
    let token = CancelToken::default();
    token.cancel();
    assert!(matches!(InsideTest::new(&surface).input_volume(&token), Err(SurfaceError::Canceled(_))));
}

#[test]
fn points_in_a_hole_are_ambiguous() {
    let surface = surface(open_sphere(0.3));
    let inside = InsideTest::new(&surface);
    let rim = surface.positions.iter().map(|p| p.y).fold(f64::MIN, f64::max);
    let samples = [Point3::new(0.0, -0.2, 0.0), Point3::new(0.0, rim, 0.0), Point3::new(0.0, 2.0, 0.0)];
    let defect = inside.ambiguous(&samples).unwrap();
    assert_eq!((defect.kind, defect.count), (DefectKind::AmbiguousInside, 1));
    assert!(inside.ambiguous(&samples[2..]).is_none());
}

#[test]
fn bulk_queries_equal_single_ones() {
    let inside = InsideTest::new(&surface(shapes::horseshoe()));
    let points = points(&inside, 300);
    let one_by_one: Vec<f64> = points.iter().map(|point| inside.signed_distance(point)).collect();
    assert_eq!(inside.signed_distances(&points), one_by_one);
}
