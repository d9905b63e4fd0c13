//! Skins of spheres and blocks: intact, cut, and with computed normals.

use super::*;
use crate::random::RandomStream;
use crate::surface::{RawMesh, shapes};
use nalgebra::Vector3;

fn surface(mesh: RawMesh) -> Surface {
    Surface::repair(mesh).unwrap()
}

/// A skin without lattices.
fn skin(mesh: RawMesh, longest: f64) -> Skin {
    Skin::of(&surface(mesh), &[], longest)
}

fn area([a, b, c]: [Point3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

fn place(skin: &Skin, blend: &BlendedVertex) -> Point3<f64> {
    let own = blend.of.map(|vertex| skin.points[skin.vertices[vertex as usize] as usize].coords);
    Point3::from((0..3).map(|k| own[k] * blend.weights[k]).sum::<Vector3<f64>>())
}

/// Directed edges, as the bits of their ends.
fn half_edges(triangles: &[[Point3<f64>; 3]]) -> Vec<[[u64; 3]; 2]> {
    let key = |point: &Point3<f64>| [point.x.to_bits(), point.y.to_bits(), point.z.to_bits()];
    let sides = |corners: &[Point3<f64>; 3]| [0, 1, 2].map(|k| [key(&corners[k]), key(&corners[(k + 1) % 3])]);
    let mut edges: Vec<_> = triangles.iter().flat_map(sides).collect();
    edges.sort_unstable();
    edges
}

fn assert_closed(triangles: &[[Point3<f64>; 3]]) {
    let edges = half_edges(triangles);
    assert!(edges.windows(2).all(|pair| pair[0] != pair[1]), "an edge twice");
    assert!(edges.iter().all(|[a, b]| edges.binary_search(&[*b, *a]).is_ok()), "an edge without its other side");
}

#[test]
fn long_edges_are_halved_without_gaps_and_the_area_stays() {
    for (mesh, longest) in
        [(shapes::cuboid([1.0, 0.4, 0.1]), 0.06), (shapes::sphere(1.0, 1), 0.1), (shapes::mug(), 0.03)]
    {
        let surface = surface(mesh);
        let whole: f64 = (0..surface.triangles.len()).map(|triangle| area(surface.corners(triangle))).sum();
        let skin = Skin::of(&surface, &[], longest);
        let triangles: Vec<_> = (0..skin.triangles.len()).map(|triangle| skin.corners(triangle)).collect();
        let sum: f64 = triangles.iter().map(|corners| area(*corners)).sum();
        assert!((sum / whole - 1.0).abs() < 1e-12, "{sum} of {whole}");
        let edges = triangles.iter().flat_map(|t| [0, 1, 2].map(|k| (t[(k + 1) % 3] - t[k]).norm()));
        assert!(edges.fold(0.0, f64::max) <= longest);
        assert_closed(&triangles);
    }
}

#[test]
fn normals_are_smooth_on_a_sphere_and_sharp_on_a_block() {
    let ball = skin(shapes::sphere(1.0, 3), 1.0);
    for (&point, &normal) in ball.vertices.iter().zip(&ball.attributes.normals) {
        let outward = ball.points[point as usize].coords.normalize();
        assert!(Vector3::from(normal).cast::<f64>().dot(&outward) > 0.999);
    }
    let block = skin(shapes::cuboid([1.0, 0.5, 0.2]), 0.1);
    for triangle in 0..block.triangles.len() {
        let [a, b, c] = block.corners(triangle);
        let flat = (b - a).cross(&(c - a)).normalize();
        for vertex in block.triangles[triangle] {
            let normal = Vector3::from(block.attributes.normals[vertex as usize]).cast::<f64>();
            assert!((normal - flat).norm() < 1e-6, "{normal:?} instead of {flat:?}");
        }
    }
}

/// For any labels, every part's triangles belong to its fragment, all parts together tile the skin, and neighbors share
/// boundaries.
#[test]
fn parts_tile_the_skin_for_any_labels() {
    let skin = skin(shapes::sphere(1.0, 3), 1.0);
    let whole: f64 = (0..skin.triangles.len()).map(|triangle| area(skin.corners(triangle))).sum();
    for (fragments, seed) in [(1, 0), (2, 1), (3, 2), (20, 3), (300, 4)] {
        let mut random = RandomStream::new(seed, 0);
        let labels: Vec<u32> =
            skin.points.iter().map(|_| (random.uniform() * f64::from(fragments)) as u32 % fragments).collect();
        let heights: Vec<f64> = (0..fragments).map(|_| random.uniform()).collect();
        let parts = clip(&skin, &labels, fragments as usize, |point, a, b| {
            f64::from(point % 7) - 3.0 + heights[a as usize] - heights[b as usize]
        });
        let corners = |part: &ClippedSurface| -> Vec<[Point3<f64>; 3]> {
            part.triangles.iter().map(|own| own.map(|vertex| place(&skin, &part.vertices[vertex as usize]))).collect()
        };
        let triangles: Vec<_> = parts.iter().flat_map(corners).collect();
        let sum: f64 = triangles.iter().map(|own| area(*own)).sum();
        assert!((sum / whole - 1.0).abs() < 1e-12, "{sum} of {whole}");
        assert_closed(&triangles);
        for (label, part) in parts.iter().enumerate() {
            assert_eq!(part.triangles.len(), part.sources.len());
            let own = part.vertices.iter().filter(|blend| blend.weights[0] == 1.0);
            own.for_each(|blend| {
                assert_eq!(labels[skin.vertices[blend.of[0] as usize] as usize], label as u32);
            });
            let mut keys: Vec<_> =
                part.vertices.iter().map(|blend| (blend.of, blend.weights.map(f64::to_bits))).collect();
            keys.sort_unstable();
            assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "a vertex twice");
        }
    }
}

/// Three half-planes that meet on an axis: every boundary is at the zero of the difference.
#[test]
fn borders_lie_where_rivals_are_equal() {
    let skin = skin(shapes::sphere(1.0, 3), 1.0);
    let directions = [0.3f64, 2.4, 4.5].map(|angle| Vector3::new(angle.cos(), angle.sin(), 0.0));
    let value = |point: &Point3<f64>, label: u32| -directions[label as usize].dot(&point.coords);
    let rival = |point: u32, a: u32, b: u32| {
        let at = &skin.points[point as usize];
        value(at, a) - value(at, b)
    };
    let nearest = |point: u32| (1..3).fold(0, |best, other| if rival(point, other, best) < 0.0 { other } else { best });
    let labels: Vec<u32> = (0..skin.points.len() as u32).map(nearest).collect();
    let parts = clip(&skin, &labels, 3, rival);
    let mut exact = [0, 0];
    for (label, part) in parts.iter().enumerate() {
        for blend in part.vertices.iter().filter(|blend| blend.weights[0] != 1.0) {
            let at = place(&skin, blend);
            let gap = (0..3)
                .filter(|other| *other != label as u32)
                .map(|other| (value(&at, label as u32) - value(&at, other)).abs())
                .fold(f64::INFINITY, f64::min);
            // Points moved by the margin are off by it. Points outside of their triangle are moved to its center.
            let [on_edge, share] = [blend.weights[2] == 0.0, blend.weights[1] == 1.0 / 3.0].map(usize::from);
            let moved = if on_edge == 1 { !(0.021..0.979).contains(&blend.weights[1]) } else { share == 1 };
            let bound = match (moved, on_edge) {
                (false, _) => 1e-12,
                (true, 1) => 2e-3,
                (true, _) => 0.06,
            };
            assert!(gap < bound, "off by {gap}");
            exact[on_edge] += usize::from(!moved);
        }
    }
    assert!(exact[1] > 100, "{exact:?} points in triangles and on edges that nothing moved");
}

/// Sector meshes: each triangle reaches from the rim to the axis, or along the whole wall.
fn sectors(count: u32, lower: [f64; 2], upper: [f64; 2]) -> RawMesh {
    let ring = |[radius, height]: [f64; 2]| {
        (0..count).map(move |k| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count);
            Point3::new(radius * angle.cos(), radius * angle.sin(), height)
        })
    };
    let mut positions: Vec<Point3<f64>> = ring(lower).chain(ring(upper)).collect();
    positions.extend([Point3::new(0.0, 0.0, lower[1]), Point3::new(0.0, 0.0, upper[1])]);
    let parts = |k: u32| {
        let (a, b) = (k, (k + 1) % count);
        [[b, a, 2 * count], [a + count, b + count, 2 * count + 1], [a, b, b + count], [a, b + count, a + count]]
    };
    RawMesh::new(positions, (0..count).flat_map(parts).collect())
}

/// Halving alone gave a cone of 600 triangles 2 million of them.
#[test]
fn sectors_have_as_many_triangles_as_their_edges_have_parts() {
    for (count, lower, upper) in [
        (300, [1.0, 0.0], [0.01, 3.0]),
        (500, [1.0, 0.0], [1.0, 0.05]),
        (500, [1.0, 0.0], [1.0, 2.0]),
        (64, [0.02, 0.0], [0.02, 1.0]),
    ] {
        let surface = surface(sectors(count, lower, upper));
        for longest in [0.2, 0.05] {
            let skin = Skin::of(&surface, &[], longest / EDGE_SPACINGS);
            let triangles: Vec<_> = (0..skin.triangles.len()).map(|triangle| skin.corners(triangle)).collect();
            assert_closed(&triangles);
            let edges = triangles.iter().flat_map(|t| [0, 1, 2].map(|k| (t[(k + 1) % 3] - t[k]).norm()));
            assert!(edges.fold(0.0, f64::max) <= longest);
            let parts: f64 = surface
                .triangles
                .iter()
                .map(|triangle| {
                    let [a, b, c] = triangle.map(|vertex| surface.positions[vertex as usize]);
                    [b - a, c - b, a - c]
                        .iter()
                        .map(|edge| (edge.norm() / longest).log2().ceil().max(0.0).exp2())
                        .sum::<f64>()
                })
                .sum();
            assert!((triangles.len() as f64) < 2.0 * parts, "{} triangles of {parts} parts", triangles.len());
            let split =
                crate::conforming::boundary_count(&surface.positions, &surface.triangles, longest / EDGE_SPACINGS);
            let ratio = split as f64 / triangles.len() as f64;
            assert!((0.9..1.1).contains(&ratio), "the exact surface has {split} triangles, {}", triangles.len());
        }
    }
}
