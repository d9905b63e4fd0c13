//! Tests of the boundary fit: gains, invariants and undone moves.

use super::*;
use crate::lattice::shapes::{ImplicitShape, ball, balls, cuboid, torus};
use crate::lattice::{block, check_manifold};
use nalgebra::Isometry3;
use std::f64::consts::PI;

/// Stuffs and fits a shape to its volume and checks both lattices. Returns both deviations over the spacing.
fn check(name: &str, shape: &dyn SignedDistance, volume: f64, spacing: f64) -> [f64; 2] {
    let token = CancelToken::default();
    let stuffed = stuff(shape, spacing, Some(volume), &token).unwrap();
    let fitted = stuff_fitted(shape, spacing, volume, &token).unwrap();
    assert_eq!(fitted.node_count(), fitted.bodies.iter().map(|body| body.nodes.len()).sum::<usize>());
    for body in &fitted.bodies {
        check_manifold(body).unwrap();
        assert!((0..body.tets.len()).all(|tet| body.tet_volume(tet) > 0.0));
        let angles = body.dihedral();
        assert!(angles.min_deg > 10.7 && angles.max_deg < 164.8, "{name}: {angles:?}");
        let faces: Vec<[u32; 3]> = body.boundary().iter().map(|face| face.nodes).collect();
        let all: Vec<u32> = (0..faces.len() as u32).collect();
        assert_eq!(crate::surface::crossings(&body.nodes, &faces, &all), Vec::<[u32; 2]>::new(), "{name}");
    }
    assert!((fitted.volume() / volume - 1.0).abs() < 1.001 * crate::lattice::VOLUME_TOLERANCE, "{name}: volume");
    let deviations = [&stuffed, &fitted].map(|level| {
        let own = level.bodies.iter().map(|body| body.deviation(&|place| shape.signed_distance(place)));
        own.fold(0.0, f64::max) / spacing
    });
    println!("{name}: deviation {:.3} spacings stuffed, {:.3} fitted", deviations[0], deviations[1]);
    deviations
}

fn turned() -> Isometry3<f64> {
    Isometry3::rotation(Vector3::new(0.3, -0.7, 0.5))
}

#[test]
fn edges_and_corners_of_a_turned_box_come_much_nearer() {
    let half = Vector3::new(0.3, 0.15, 0.2);
    for spacing in [0.04, 0.05] {
        let [stuffed, fitted] = check("turned box", &cuboid(half, turned()), 8.0 * half.product(), spacing);
        assert!(fitted < 0.6 * stuffed && stuffed > 0.2, "{stuffed} {fitted}");
    }
}

#[test]
fn a_crease_comes_much_nearer() {
    // The union of two balls has a concave crease; their intersection has a sharp ridge.
    let both = balls(vec![(Point3::new(-0.1, 0.0, 0.0), 0.2), (Point3::new(0.1, 0.01, 0.0), 0.2)]);
    let lens = |p: &Point3<f64>| {
        let inward = |x: f64| (p - Point3::new(x, 0.0, 0.0)).norm() - 0.3;
        inward(-0.2).max(inward(0.2))
    };
    // Volume of the intersection of two balls of radius r at a distance d.
    let common = |r: f64, d: f64| PI * (2.0 * r - d).powi(2) * (d * d + 4.0 * d * r) / (12.0 * d);
    let apart = 0.2f64.hypot(0.01);
    let joined = 2.0 * 4.0 / 3.0 * PI * 0.2f64.powi(3) - common(0.2, apart);
    let cases: [(&str, &dyn SignedDistance, f64); 2] = [
        ("crease", &both, joined),
        ("lens", &ImplicitShape { distance: lens, half: Vector3::repeat(0.3) }, common(0.3, 0.4)),
    ];
    for (name, shape, volume) in cases {
        let [stuffed, fitted] = check(name, shape, volume, 0.04);
        assert!(fitted < 0.65 * stuffed && fitted < 1.2 * FAR, "{name}: {stuffed} {fitted}");
    }
}

#[test]
fn fitting_keeps_smooth_surfaces_accurate() {
    for (name, shape, volume) in [
        ("ball", Box::new(ball(0.3)) as Box<dyn SignedDistance>, 4.0 / 3.0 * PI * 0.3f64.powi(3)),
        ("torus", Box::new(torus(0.3, 0.1)), 2.0 * PI * PI * 0.3 * 0.01),
    ] {
        let [stuffed, fitted] = check(name, &*shape, volume, 0.04);
        assert!(fitted <= stuffed, "{name}");
    }
    let shape = ball(0.3);
    let (fine, token) = (0.02, CancelToken::default());
    let mut level = stuff(&shape, fine, None, &token).unwrap();
    let before = level.bodies.clone();
    fit(&mut level, &shape, &token).unwrap();
    assert_eq!(level.bodies, before);
}

#[test]
fn fitting_does_not_depend_on_the_number_of_threads() {
    let half = Vector3::new(0.3, 0.15, 0.2);
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            stuff_fitted(&cuboid(half, turned()), 0.05, 8.0 * half.product(), &CancelToken::default()).unwrap().bodies
        })
    };
    assert!(made(1) == made(5));
}

#[test]
fn an_inconsistent_distance_function_gives_a_valid_lattice() {
    let mut stream = crate::random::RandomStream::new(5, 0);
    for _ in 0..3 {
        let mut uniform = || 2.0 * stream.uniform() - 1.0;
        let (k, phase) = (Vector3::new(uniform(), uniform(), uniform()) * 80.0, 3.0 * uniform());
        let distance =
            move |p: &Point3<f64>| ((k.dot(&p.coords) + phase).sin() * 0.02).max(p.coords.abs().max() - 0.15);
        let shape = ImplicitShape { distance, half: Vector3::repeat(0.15) };
        let mut level = stuff(&shape, 0.05, None, &CancelToken::default()).unwrap();
        fit(&mut level, &shape, &CancelToken::default()).unwrap();
        for body in &level.bodies {
            check_manifold(body).unwrap();
            let angles = body.dihedral();
            assert!(angles.min_deg > 10.7 && angles.max_deg < 164.8, "{angles:?}");
        }
    }
}

#[test]
fn the_largest_error_of_a_linear_model_is_made_least() {
    // 1 + x, −1 + x / 2 − y, −1 + y: x = −1/2, y = 1/2 minimizes the largest magnitude.
    let rows = [(Vector3::x(), 1.0), (Vector3::new(0.5, -1.0, 0.0), -1.0), (Vector3::y(), -1.0)];
    let step = minimax(&rows);
    let most = |step: &Vector3<f64>| rows.iter().map(|(g, v)| (v + g.dot(step)).abs()).fold(0.0, f64::max);
    let mut least = f64::INFINITY;
    for i in -40..=40 {
        for k in -40..=40 {
            least = least.min(most(&Vector3::new(f64::from(i) / 20.0, f64::from(k) / 20.0, 0.0)));
        }
    }
    assert!(most(&step) < 1.05 * least + 0.02 && step.z.abs() < 1e-12, "{step:?} {} {least}", most(&step));
}

#[test]
fn moves_that_make_boundaries_intersect_are_reverted() {
    let (one, other) = (block([2, 2, 2], 0.1), block([2, 2, 2], 0.1));
    let count = one.nodes.len() as u32;
    let mut both = one.clone();
    both.nodes.extend(other.nodes.iter().map(|node| node + Vector3::new(0.21, 0.0, 0.0)));
    both.tets.extend(other.tets.iter().map(|tet| tet.map(|node| node + count)));
    let before = both.nodes.clone();
    let right = (0..count as usize).filter(|&node| before[node].x > 0.09).collect::<Vec<_>>();
    let left = (0..count as usize).find(|&node| before[node].x < -0.09 && before[node].y.abs() < 0.01).unwrap();
    // Two nodes across the gap of 0.01, in the middle of the face and beside it, and a third one far away.
    let middle = *right.iter().find(|&&node| before[node].y.abs() < 0.01 && before[node].z.abs() < 0.01).unwrap();
    let beside = *right.iter().find(|&&node| before[node].y > 0.09 && before[node].z.abs() < 0.01).unwrap();
    both.nodes[middle].x += 0.02;
    both.nodes[beside].x += 0.001;
    both.nodes[left].x -= 0.01;
    let met = put_back(&mut both, &before);
    assert!(met.contains(&(middle as u32)) && !met.contains(&(left as u32)));
    assert_eq!((both.nodes[middle], both.nodes[beside]), (before[middle], before[beside]));
    assert!(both.nodes[left] != before[left]);
    both.nodes[middle].x += 0.005;
    let kept = both.nodes.clone();
    assert_eq!(put_back(&mut both, &before), Vec::<u32>::new());
    assert_eq!(both.nodes, kept);
}
