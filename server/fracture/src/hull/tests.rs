//! Bodies with known hulls, random points, and points without a hull.

use super::*;
use crate::random::RandomStream;
use proptest::prelude::*;

/// A cube from `low`, of this edge, every face a grid of `parts` by `parts` squares.
fn cube(low: [f64; 3], edge: f64, parts: usize) -> ClosedTriangles {
    let mut shell = ClosedTriangles::default();
    let low = Vector3::from(low);
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0.0), (axis, 1.0)]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (u, v) = if side > 0.0 { (u, v) } else { (v, u) };
        let point = |i: usize, j: usize| {
            let mut at = Vector3::zeros();
            (at[axis], at[u], at[v]) = (side, i as f64 / parts as f64, j as f64 / parts as f64);
            Point3::from(low + at * edge)
        };
        for (i, j) in (0..parts).flat_map(|i| (0..parts).map(move |j| (i, j))) {
            let first = shell.points.len() as u32;
            shell.points.extend([point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
            shell.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    shell
}

/// Volume computed from the triangles only.
fn volume(points: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    let cone = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|point| points[point as usize] - points[0]);
        a.dot(&b.cross(&c))
    };
    triangles.iter().map(cone).sum::<f64>() / 6.0
}

/// Expects a closed, convex hull within the limits, with vertices from the points; unless a limit was met, it contains
/// all points to a ten-thousandth.
#[track_caller]
fn check(points: &[Point3<f64>]) -> ConvexHull {
    let hull = ConvexHull::of(points).unwrap();
    let (vertices, faces) = (hull.vertices.len(), hull.triangles.len());
    assert!(faces <= FACES_MAX && 2 * vertices == faces + 4, "{vertices} vertices, {faces} faces");
    let edges: Vec<[u32; 2]> = hull.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    for edge in &edges {
        let both = edges.iter().filter(|other| *other == edge || **other == [edge[1], edge[0]]);
        assert_eq!(both.count(), 2, "edge {edge:?}");
    }
    assert!(hull.vertices.iter().all(|vertex| points.contains(vertex)));
    let size = hull.size();
    let beyond = |point: &Point3<f64>| {
        let planes = hull.triangles.iter().map(|t| Plane::through(t.map(|corner| hull.vertices[corner as usize])));
        planes.map(|plane| plane.unwrap().beyond(point)).fold(f64::NEG_INFINITY, f64::max) / size
    };
    let most = |points: &[Point3<f64>]| points.iter().map(beyond).fold(f64::NEG_INFINITY, f64::max);
    assert!(most(&hull.vertices) < 1e-9, "not convex: {:e}", most(&hull.vertices));
    assert!(faces + 2 > FACES_MAX || most(points) < 1.01e-4, "left out: {:e}", most(points));
    assert!(volume(&hull.vertices, &hull.triangles) > 0.0);
    hull
}

#[test]
fn a_cube_is_its_own_hull_however_finely_it_is_divided() {
    for parts in [1, 2, 7] {
        let cube = cube([0.25, -3.0, 1.0], 2.0, parts);
        let hull = check(&cube.points);
        assert_eq!((hull.vertices.len(), hull.triangles.len()), (8, 12));
        assert!((volume(&hull.vertices, &hull.triangles) - 8.0).abs() < 1e-12);
        assert_eq!(hull.coverage(&cube), 1.0);
    }
}

#[test]
fn coverage_is_the_share_of_the_body_inside() {
    let body = cube([0.0; 3], 1.0, 3);
    let whole = ConvexHull::of(&body.points).unwrap();
    for (share, low, edge) in
        [(0.125, [0.5; 3], 3.0), (1.0, [-1.0; 3], 3.0), (0.0, [2.0; 3], 1.0), (0.027, [0.4; 3], 0.3)]
    {
        let other = ConvexHull::of(&cube(low, edge, 1).points).unwrap();
        assert!((other.coverage(&body) - share).abs() < 1e-12, "{} {share}", other.coverage(&body));
    }
    // A corner cut off by an oblique plane.
    let plane = Plane::at(&Point3::new(0.5, 1.0, 1.0), Vector3::repeat(1.0)).unwrap();
    let rest = check(&clipped(&body, &[plane]));
    assert!((volume(&rest.vertices, &rest.triangles) - (1.0 - 0.125 / 6.0)).abs() < 1e-12);
    assert!((rest.coverage(&body) - (1.0 - 0.125 / 6.0)).abs() < 1e-12);
    // Two cubes that touch form one body with a hollow between them.
    let mut pair = body.clone();
    let second = cube([1.0; 3], 1.0, 2);
    pair.triangles.extend(second.triangles.iter().map(|t| t.map(|point| point + body.points.len() as u32)));
    pair.points.extend(second.points);
    assert!((whole.coverage(&pair) - 0.5).abs() < 1e-12);
    assert!((check(&pair.points).coverage(&pair) - 1.0).abs() < 1e-12);
}

#[test]
fn depth_is_that_of_the_deepest_point_of_a_surface() {
    let own = ConvexHull::of(&cube([0.0; 3], 1.0, 1).points).unwrap();
    let slack = 1e-3 * own.size();
    for (depth, low, edge, parts) in [
        (0.1, [0.9, 0.2, 0.2], 0.5, 1),
        (0.0, [1.0, 0.0, 0.0], 1.0, 4),
        (0.0, [1.5, 0.0, 0.0], 1.0, 4),
        // Faces pass through the middle; corners are far outside.
        (0.5, [0.5, -4.0, -4.0], 9.0, 1),
        (0.25, [0.25, -4.0, -4.0], 9.0, 1),
    ] {
        let found = own.depth([cube(low, edge, parts)].iter());
        assert!(found >= depth && found <= depth + slack, "{found} {depth}");
    }
}

#[test]
fn flat_and_broken_points_have_no_hull() {
    let line = |k: i32| Point3::new(f64::from(k), 0.5, 0.0);
    let flat = |k: i32| Point3::new(f64::from(k), f64::from(k * k), 1e-9 * f64::from(k % 2));
    for points in [
        vec![],
        vec![Point3::origin(); 9],
        (0..9).map(line).collect(),
        (0..9).map(flat).collect(),
        vec![Point3::new(f64::NAN, 0.0, 0.0), Point3::origin()],
        cube([0.0; 3], f64::INFINITY, 1).points,
    ] {
        assert_eq!(ConvexHull::of(&points), None);
    }
    assert!(clipped(&cube([0.0; 3], 1.0, 2), &[Plane { normal: Vector3::x(), offset: -1.0 }]).is_empty());
}

#[test]
fn expanded_hulls_extend_by_their_outset() {
    let body = cube([0.0; 3], 1.0, 1);
    let [own, moved] = [&body, &body.outset(4, 0.25)].map(|shell| bounds(&shell.points));
    assert_eq!((own[0], own[1]), (Point3::origin(), Point3::new(1.0, 1.0, 1.0)));
    assert_eq!((moved[0], moved[1]), (Point3::new(-0.25, 0.0, 0.0), own[1]));
}

/// Random points of seven different distributions.
fn points(kind: u32, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut random = RandomStream::new(seed, 7);
    let mut draw = || Vector3::from_fn(|_, _| 2.0 * random.uniform() - 1.0);
    let place = |k: usize, at: Vector3<f64>| match kind {
        0 => at,
        1 => at.normalize(),
        2 => at.map(|x| (3.0 * x).round()),
        3 => Vector3::new(at.x, at.y, 1e-4 * at.z),
        4 => Vector3::new(1e-3 * at.x, 1e-3 * at.y, at.z),
        5 => Vector3::new(at.x, at.y, at.x * at.x + at.y * at.y),
        _ => Vector3::new(f64::from(k as u32 % 2), at.y, at.z).map(|x| 1e-4 * x) + Vector3::repeat(0.3),
    };
    (0..count).map(|k| Point3::from(place(k, draw()))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn hulls_of_random_points_are_convex_and_hold_what_they_keep(
        kind in 0u32..7, count in 6usize..400, seed in any::<u64>(),
    ) {
        let points = points(kind, count, seed);
        if ConvexHull::of(&points).is_some() {
            let hull = check(&points);
            prop_assert_eq!(&hull, &ConvexHull::of(&points).unwrap());
            let known = ClosedTriangles { points: hull.vertices.clone(), triangles: hull.triangles.clone() };
            prop_assert!((hull.coverage(&known) - 1.0).abs() < 1e-9);
            prop_assert!(hull.depth([known].iter()) <= 1.01e-3 * hull.size());
        } else {
            prop_assert!(kind == 2 || count < 9);
        }
    }
}
