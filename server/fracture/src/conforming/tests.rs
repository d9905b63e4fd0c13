//! Properties of the meshes of generated surfaces.

use super::predicates::orientation;
use super::test_shapes::*;
use super::*;
use crate::tessellation::relative_height;
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

fn mesh(shape: &Shape, interior: &[Point3<f64>], spacing: f64) -> Result<ConformingMesh, ConformingError> {
    let options = ConformingOptions { spacing, ..ConformingOptions::default() };
    conforming_mesh(&shape.positions, &shape.triangles, interior, &options, &CancelToken::default(), &mut |_| ())
}

fn ascending<const N: usize>(mut vertices: [u32; N]) -> [u32; N] {
    vertices.sort_unstable();
    vertices
}

/// Meshes a surface and checks the mesh. `euler` is the Euler characteristic of the inside.
fn check(shape: &Shape, interior: &[Point3<f64>], spacing: f64, euler: i64) -> ConformingMesh {
    let mesh = mesh(shape, interior, spacing).unwrap();
    let at = |vertex: u32| &mesh.nodes[vertex as usize];
    let mut faces: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    let mut edges: BTreeSet<[u32; 2]> = BTreeSet::new();
    let mut used = vec![false; mesh.nodes.len()];
    for &[a, b, c, d] in &mesh.tets {
        assert!(orientation(at(a), at(b), at(c), at(d)) > 0.0);
        for face in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            *faces.entry(ascending(face)).or_default() += 1;
        }
        edges.extend([[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]].map(ascending));
        [a, b, c, d].iter().for_each(|&vertex| used[vertex as usize] = true);
    }
    assert!(used.iter().all(|used| *used));
    let boundary: BTreeSet<[u32; 3]> = mesh.boundary.iter().copied().map(ascending).collect();
    assert_eq!(boundary.len(), mesh.boundary.len());
    assert!(faces.iter().all(|(face, &count)| count == if boundary.contains(face) { 1 } else { 2 }));
    assert!(boundary.iter().all(|face| faces.contains_key(face)));
    let counted = [mesh.nodes.len(), edges.len(), faces.len(), mesh.tets.len()].map(|count| count as i64);
    assert_eq!(counted[0] - counted[1] + counted[2] - counted[3], euler);
    input::check(&Input { positions: &mesh.nodes, triangles: &mesh.boundary, interior: &[] }).unwrap();
    check_volume(shape, &mesh);
    check_boundary(shape, &mesh, spacing);
    let inside: Vec<Point3<f64>> = mesh.interior_sources.iter().map(|&source| interior[source as usize]).collect();
    assert_eq!(mesh.nodes[mesh.places.len()..], inside);
    mesh
}

fn check_volume(shape: &Shape, mesh: &ConformingMesh) {
    let at = |vertex: u32| mesh.nodes[vertex as usize];
    let volume = |&[a, b, c, d]: &[u32; 4]| (at(b) - at(a)).cross(&(at(c) - at(a))).dot(&(at(d) - at(a))) / 6.0;
    let sum: f64 = mesh.tets.iter().map(volume).sum();
    let split = Shape { positions: mesh.nodes.clone(), triangles: mesh.boundary.clone() };
    assert!((sum / split.volume() - 1.0).abs() < 1e-9, "{sum} is not {}", split.volume());
    // Rounded vertices move the surface by the deviation.
    let area = |&[a, b, c]: &[u32; 3]| (at(b) - at(a)).cross(&(at(c) - at(a))).norm() / 2.0;
    let tolerance = 1e-9 * shape.volume() + 10.0 * mesh.deviation * mesh.boundary.iter().map(area).sum::<f64>();
    assert!((sum - shape.volume()).abs() < tolerance);
}

/// Checks that boundary nodes and triangles lie where the mesh says.
fn check_boundary(shape: &Shape, mesh: &ConformingMesh, spacing: f64) {
    let scale = shape.positions.iter().map(|point| point.coords.amax()).fold(0.0, f64::max);
    assert!(mesh.deviation <= 4.0 * f64::EPSILON * scale, "{}", mesh.deviation);
    assert_eq!(mesh.nodes[..shape.positions.len()], shape.positions);
    for (place, node) in mesh.places.iter().zip(&mesh.nodes) {
        let weighted = place.vertices.iter().zip(place.weights);
        let sum: Vector3<f64> =
            weighted.map(|(&vertex, weight)| shape.positions[vertex as usize].coords * weight).sum();
        assert!((sum - node.coords).amax() <= 8.0 * f64::EPSILON * scale);
    }
    for (triangle, &source) in mesh.boundary.iter().zip(&mesh.boundary_sources) {
        let corners = shape.triangles[source as usize];
        for &vertex in triangle {
            let place = mesh.places[vertex as usize];
            for (vertex, weight) in place.vertices.iter().zip(place.weights) {
                assert!(weight == 0.0 || corners.contains(vertex));
            }
        }
        for [a, b] in [[0, 1], [1, 2], [2, 0]] {
            let length = (mesh.nodes[triangle[a] as usize] - mesh.nodes[triangle[b] as usize]).norm();
            assert!(length <= 0.7 * spacing * (1.0 + 1e-12) + 4.0 * f64::EPSILON * scale);
        }
    }
}

#[test]
fn spheres() {
    for levels in 0..5 {
        let shape = sphere(levels);
        check(&shape, &[], f64::INFINITY, 1);
        let interior = shape.lattice(0.25, |point| point.coords.norm() < 0.5);
        check(&shape, &interior, 0.3, 1);
    }
}

#[test]
fn tori() {
    for (around, across, tube) in [(3, 3, 0.3), (24, 12, 0.4), (60, 8, 0.05)] {
        let shape = torus(around, across, tube);
        check(&shape, &[], f64::INFINITY, 0);
        check(&shape, &[], 0.2, 0);
    }
}

#[test]
fn grids_of_cubes() {
    for counts in [[1, 1, 1], [4, 4, 4], [12, 5, 1]] {
        for offset in [0.0, 0.1, 1e6] {
            let shape = cubes(&block(counts), |k| k % 3 == 0).moved(offset);
            let high = shape.positions.iter().fold(shape.positions[0], |high, point| high.sup(point));
            let interior = shape.lattice(0.5, |point| {
                point.iter().zip(&high.coords).all(|(x, top)| *x > offset + 0.2 && *x < top - 0.2)
            });
            check(&shape, &interior, f64::INFINITY, 1);
            check(&shape, &interior, 0.5, 1);
        }
    }
}

#[test]
fn plates_with_holes_and_l_shapes() {
    let mut plate = block([9, 9, 2]);
    plate.retain(|[x, y, _]| !(matches!(x, 2 | 6) && matches!(y, 2..=6)));
    check(&cubes(&plate, |_| true), &[], f64::INFINITY, -1);
    check(&cubes(&plate, |k| k % 2 == 0), &[], 0.6, -1);
    let mut corner = block([6, 6, 6]);
    corner.retain(|cell| cell.contains(&0));
    check(&cubes(&corner, |k| k % 5 < 2), &[], f64::INFINITY, 1);
    check(&cubes(&corner, |k| k % 5 < 2), &[], 0.8, 1);
}

#[test]
fn flat_faces_of_needles() {
    for (outer, inner, hole) in [(64, 64, 0.5), (200, 7, 0.1), (90, 91, 0.99)] {
        let shape = washer(outer, inner, hole, 0.2);
        for spacing in [f64::INFINITY, 0.2] {
            check(&shape, &[], spacing, 0);
            check(&shape.clone().moved(1e6), &[], spacing, 0);
        }
    }
    for count in [3, 17, 300] {
        check(&cone(count, 0.3), &[], f64::INFINITY, 1);
        check(&cone(count, 0.3), &[], 0.1, 1);
    }
}

#[test]
fn dihedral_angles_of_one_degree() {
    let degree = std::f64::consts::PI / 180.0;
    for spacing in [f64::INFINITY, 0.3, 0.05] {
        check(&wedge(degree), &[], spacing, 1);
        check(&wedge(degree).moved(1e6), &[], spacing, 1);
    }
    check(&cuboid([1.0, 1.0, 1e-3]), &[], 0.05, 1);
}

#[test]
fn a_twisted_prism_takes_a_steiner_point() {
    let mesh = check(&schonhardt(), &[], f64::INFINITY, 1);
    assert!(mesh.steiner_count > 0);
}

#[test]
fn edges_of_4e_6_of_the_diagonal() {
    for offset in [0.0, 1e6] {
        let mut shape = cuboid([1.0, 2.0, 0.5]);
        let length = 4e-6 * shape.diagonal();
        let [a, b, c] = shape.triangles.swap_remove(0);
        let [at_a, at_b, at_c] = [a, b, c].map(|vertex| shape.positions[vertex as usize]);
        let center = nalgebra::center(&nalgebra::center(&at_a, &at_b), &at_c);
        let normal = (at_b - at_a).cross(&(at_c - at_a)).normalize() * length;
        let start = shape.positions.len() as u32;
        let inner = [at_a, at_b, at_c].map(|corner| center + (corner - center).normalize() * length);
        shape.positions.extend(inner);
        shape.positions.push(center + normal);
        let [p, q, r, tip] = [start, start + 1, start + 2, start + 3];
        for ([u, v], [inner_u, inner_v]) in [([a, b], [p, q]), ([b, c], [q, r]), ([c, a], [r, p])] {
            shape.triangles.extend([[u, v, inner_u], [v, inner_v, inner_u], [inner_u, inner_v, tip]]);
        }
        let shape = shape.moved(offset);
        for spacing in [f64::INFINITY, 0.2] {
            check(&shape, &[], spacing, 1);
        }
    }
}

#[test]
fn cavities_and_several_shells() {
    let small = |radius: f64| sphere(2).map(|point| point * radius);
    let hollow = sphere(3).and(&small(0.9).reversed()).and(&small(0.3));
    check(&hollow, &[], f64::INFINITY, 3);
    let interior = hollow.lattice(0.15, |point| point.coords.norm() < 0.25);
    check(&hollow, &interior, 0.3, 3);
    let close = sphere(3).and(&small(0.9985).map(|point| point + Vector3::new(1.9, 0.0, 0.0) * 1.06));
    check(&close, &[], f64::INFINITY, 2);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn perturbed_spheres(
        levels in 1..4_u32,
        noise in prop::collection::vec(-1.0..1.0_f64, 8..40),
        amount in prop_oneof![Just(0.02), Just(0.2), Just(0.4)],
        offset in prop_oneof![Just(0.0), Just(1e6)],
        scale in prop_oneof![Just(1.0), Just(1e-3)],
        spacing in prop_oneof![Just(f64::INFINITY), Just(0.3)],
    ) {
        let mut shape = sphere(levels);
        for (k, point) in shape.positions.iter_mut().enumerate() {
            *point *= scale * (1.0 + amount * noise[k * 7 % noise.len()]);
        }
        let interior = shape.lattice(0.3 * scale, |point| point.coords.norm() < 0.3 * scale);
        let interior: Vec<_> = interior.into_iter().map(|point| point + Vector3::repeat(offset)).collect();
        check(&shape.moved(offset), &interior, spacing * scale, 1);
    }

    #[test]
    fn random_cubes(cells in prop::collection::btree_set(prop::array::uniform3(0..4_i32), 1..30), turns in any::<u64>()) {
        let shape = cubes(&cells, |k| turns >> (k % 64) & 1 == 1);
        let result = mesh(&shape, &[], f64::INFINITY);
        // Cubes that meet at an edge or a corner are not manifold; the mesher says so.
        let is_refused =
            matches!(result, Err(ConformingError::OpenEdge { .. } | ConformingError::NonManifoldVertex { .. }));
        prop_assert!(is_refused || result.is_ok(), "{result:?}");
    }
}

#[test]
fn turned_shapes_are_flat_up_to_rounding() {
    let shapes = [
        (cubes(&block([5, 4, 3]), |k| k % 3 == 0), 1),
        (cubes(&block([9, 6, 1]), |k| k % 2 == 0), 1),
        (washer(120, 31, 0.3, 0.1), 0),
        (cone(150, 0.2), 1),
        (wedge(std::f64::consts::PI / 180.0), 1),
        (cuboid([1.0, 0.3, 1e-4]), 1),
    ];
    for (shape, euler) in shapes {
        for (k, spacing) in [(1.0, f64::INFINITY), (2.0, 0.3), (3.0, 0.1)] {
            let turn = Rotation3::from_euler_angles(0.3 * k, 1.1 * k, -0.7 * k);
            let turned = shape.clone().map(|point| turn * point);
            let spacing = spacing * turned.diagonal();
            check(&turned, &[], spacing, euler);
            check(&turned.moved(1e6), &[], spacing, euler);
        }
    }
}

#[test]
fn equal_input_gives_an_equal_mesh() {
    let shape = torus(30, 12, 0.4);
    let interior = shape.lattice(0.2, |point| {
        let radius = point.x.hypot(point.y) - 1.0;
        radius.hypot(point.z) < 0.3
    });
    assert_eq!(mesh(&shape, &interior, 0.2), mesh(&shape, &interior, 0.2));
}

#[test]
fn surfaces_that_intersect_or_fold_are_refused() {
    let two = sphere(2).and(&sphere(2).map(|point| point + Vector3::new(1.0, 0.1, 0.2)));
    let count = sphere(2).triangles.len() as u32;
    let Err(ConformingError::SelfIntersection { first, second }) = mesh(&two, &[], 1.0) else { panic!() };
    assert!(first < count && second >= count);
    let touching = cuboid([1.0; 3]).and(&cuboid([1.0; 3]).map(|point| point + Vector3::new(1.0, 0.25, 0.25)));
    let location = |shape: &Shape| match mesh(shape, &[], 1.0) {
        Err(error @ ConformingError::SelfIntersection { .. }) => error.location(&shape.positions, &shape.triangles),
        other => panic!("{other:?}"),
    };
    let contact = location(&touching).unwrap();
    assert!(contact.x == 1.0 && contact.y >= 0.25 && contact.z >= 0.25, "{contact}");
    let crossing = location(&two).unwrap();
    let of_other = crossing - Vector3::new(1.0, 0.1, 0.2);
    assert!((crossing.coords.norm() - of_other.coords.norm()).abs() < 0.1, "{crossing}");
    let fold = |x: f64| {
        let at = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [x, x, 0.0]].map(Point3::from).to_vec();
        mesh(&Shape { positions: at, triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]] }, &[], 1.0)
    };
    assert!(matches!(fold(0.3), Err(ConformingError::SelfIntersection { .. })));
}

#[test]
fn invalid_input_is_refused() {
    let cube = cuboid([1.0; 3]);
    let mut open = cube.clone();
    open.triangles.pop();
    assert!(matches!(mesh(&open, &[], 1.0), Err(ConformingError::OpenEdge { .. })));
    let mut not_finite = cube.clone();
    not_finite.positions[3].y = f64::NAN;
    assert_eq!(mesh(&not_finite, &[], 1.0), Err(ConformingError::InvalidPoint { point: 3 }));
    for x in [1e-60, 1e60, f64::INFINITY] {
        let mut inexact = cube.clone();
        inexact.positions[2].x = x;
        assert_eq!(mesh(&inexact, &[], 1.0), Err(ConformingError::InvalidPoint { point: 2 }));
    }
    let mut beyond = cube.clone();
    beyond.triangles[2][1] = 99;
    assert_eq!(mesh(&beyond, &[], 1.0), Err(ConformingError::InvalidPoint { point: 99 }));
    let mut flat = cube.clone();
    flat.triangles[4] = [0, 1, 1];
    assert_eq!(mesh(&flat, &[], 1.0), Err(ConformingError::DegenerateTriangle { triangle: 4 }));
    assert!(matches!(mesh(&cube, &[], 0.0), Err(ConformingError::InvalidSpacing { .. })));
    let inside = Point3::new(0.5, 0.5, 0.5);
    assert_eq!(mesh(&cube, &[inside; 2], 9.0), Err(ConformingError::DuplicatePoint { at: inside }));
    assert!(matches!(
        mesh(&cube.clone().reversed(), &[], 1.0),
        Err(ConformingError::WrongOrientation { winding: -1, .. })
    ));
    for x in [0.5, 0.25] {
        let at = Point3::new(x, 0.5, 1.0);
        assert_eq!(mesh(&cube, &[at], 9.0), Err(ConformingError::PointOnSurface { at }));
    }
    let nested = sphere(1).and(&sphere(1).map(|point| point * 0.5));
    assert!(matches!(mesh(&nested, &[], 9.0), Err(ConformingError::WrongOrientation { winding: 2, .. })));
    let pinched = cubes(&BTreeSet::from([[0, 0, 0], [1, 1, 1]]), |_| true);
    assert!(matches!(mesh(&pinched, &[], 9.0), Err(ConformingError::NonManifoldVertex { .. })));
}

#[test]
fn limits_and_cancellation_stop_the_work() {
    let (shape, token) = (sphere(3), CancelToken::default());
    let run = |options: ConformingOptions, token: &CancelToken, progress: &mut dyn FnMut(ConformingStep)| {
        conforming_mesh(&shape.positions, &shape.triangles, &[], &options, token, progress)
    };
    let options = ConformingOptions { spacing: 0.05, points_max: 2000, ..ConformingOptions::default() };
    assert!(matches!(run(options, &token, &mut |_| ()), Err(ConformingError::TooManyPoints { points_max: 2000, .. })));
    let options = ConformingOptions { spacing: 0.1, ..ConformingOptions::default() };
    let mut steps = Vec::new();
    run(options, &token, &mut |step| steps.push(step)).unwrap();
    use ConformingStep::{Check, Extract, Facets, Insert, Segments, Split};
    assert!(matches!(steps[..3], [Check, Split, Insert { round: 0, done: 0, .. }]), "{steps:?}");
    assert!(matches!(steps[steps.len() - 3..], [Segments { .. }, Facets { .. }, Extract]), "{steps:?}");
    let is_insert = |step: &&ConformingStep| matches!(step, Insert { done, total, .. } if done < total);
    assert_eq!(steps.iter().filter(is_insert).count(), steps.len() - 5);
    for (stop, step) in steps.iter().enumerate() {
        let (token, mut seen) = (CancelToken::default(), 0);
        let result = run(options, &token, &mut |_| {
            if seen == stop {
                token.cancel();
            }
            seen += 1;
        });
        assert!(matches!(result, Err(ConformingError::Canceled(_))), "step {step:?}");
    }
    let options = ConformingOptions { steps_max: 1000, ..ConformingOptions::default() };
    assert_eq!(run(options, &token, &mut |_| ()), Err(ConformingError::TooManySteps { steps_max: 1000 }));
    let twisted = schonhardt();
    let options = ConformingOptions { rounds_max: 0, ..ConformingOptions::default() };
    let result = conforming_mesh(&twisted.positions, &twisted.triangles, &[], &options, &token, &mut |_| ());
    assert!(matches!(result, Err(ConformingError::Unrecovered { rounds: 0, .. })), "{result:?}");
}

#[test]
fn the_limit_of_the_steps_ends_a_search_among_needles() {
    let (shape, token) = (washer(200, 7, 0.1, 0.2), CancelToken::default());
    let mut last = ConformingStep::Check;
    let mut run = |steps_max: u64| {
        let options = ConformingOptions { steps_max, ..ConformingOptions::default() };
        conforming_mesh(&shape.positions, &shape.triangles, &[], &options, &token, &mut |step| last = step)
    };
    let steps = run(u64::MAX).unwrap().steps;
    assert_eq!(run(steps).unwrap().steps, steps);
    for steps_max in [steps - 1, steps / 2] {
        assert_eq!(run(steps_max), Err(ConformingError::TooManySteps { steps_max }));
    }
    assert!(matches!(last, ConformingStep::Segments { .. } | ConformingStep::Facets { .. }), "{last:?}");
}

/// Of the tetrahedra between vertices in one plane or on one line, up to rounding, hardly any stay.
#[test]
fn flat_tetrahedra_are_removed() {
    let turn = Rotation3::from_euler_angles(0.3, 0.5, 0.7);
    let ring = torus(48, 24, 0.4);
    let inside = ring.lattice(0.1, |point| (point.x.hypot(point.y) - 1.0).hypot(point.z) < 0.33);
    let sheet = cubes(&block([9, 6, 1]), |k| k % 2 == 0);
    for (shape, interior, spacing, euler) in [
        (ring.clone(), &inside[..], 0.1, 0),
        (ring, &inside, 0.3, 0),
        (sheet.clone(), &[], 0.6, 1),
        (sheet, &[], 9.0, 1),
    ] {
        let rounded = |point: &Point3<f64>| (turn * point).map(|x| f64::from(x as f32));
        let interior: Vec<Point3<f64>> = interior.iter().map(rounded).collect();
        let mesh = check(&shape.map(|point| rounded(&point)), &interior, spacing, euler);
        let height = |tet: &[u32; 4]| relative_height(&tet.map(|corner| mesh.nodes[corner as usize]));
        let flat = mesh.tets.iter().filter(|tet| height(tet) < 1e-3).count();
        println!("{flat} of {}", mesh.tets.len());
        assert!(100 * flat < mesh.tets.len(), "{flat} of {}", mesh.tets.len());
    }
}
