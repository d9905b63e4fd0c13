//! Tests of stuffing on analytic distances: angles, manifolds, volumes, orders of convergence, errors.

use super::level::split;
use super::shapes::{ImplicitShape, ball, balls, cuboid, torus};
use super::*;
use crate::cancel_token::{CancelToken, Canceled};
use crate::random::RandomStream;
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use std::f64::consts::PI;

/// Bounds that Labelle & Shewchuk prove, degrees.
const DIHEDRAL_DEG: [f64; 2] = [10.7, 164.8];

fn stuffed(shape: &dyn SignedDistance, spacing: f64, volume: Option<f64>) -> LatticeLevel {
    stuff(shape, spacing, volume, &CancelToken::default()).unwrap()
}

/// Checks the invariants of a level.
fn check(level: &LatticeLevel) {
    assert!(!level.bodies.is_empty());
    for body in &level.bodies {
        check_manifold(body).unwrap();
        assert!((0..body.tets.len()).all(|tet| body.tet_volume(tet) > 0.0));
        let mut used = vec![false; body.nodes.len()];
        body.tets.iter().flatten().for_each(|&node| used[node as usize] = true);
        assert!(used.into_iter().all(|used| used));
    }
    assert!(level.bodies.windows(2).all(|pair| pair[0].volume() >= pair[1].volume()));
    assert!(level.bodies[1..].iter().all(|body| body.tets.len() >= BODY_TETS_MIN));
    assert!(level.dropped.iter().all(|dropped| dropped.volume > 0.0 && dropped.tets > 0));
}

/// As [`check`], with the bounds on angles.
fn check_stuffed(level: &LatticeLevel) {
    check(level);
    for body in &level.bodies {
        let angles = body.dihedral();
        assert!(angles.min_deg > DIHEDRAL_DEG[0] && angles.max_deg < DIHEDRAL_DEG[1], "{angles:?}");
    }
}

/// Waves of about two spacings in random directions: unlike a distance, so that cuts lie anywhere on the edges.
fn noise(seed: u64, waves: usize, spacing: f64) -> impl SignedDistance {
    let mut stream = RandomStream::new(seed, 0);
    let mut uniform = move || 2.0 * stream.uniform() - 1.0;
    let waves: Vec<(Vector3<f64>, f64)> = (0..waves)
        .map(|_| (Vector3::new(uniform(), uniform(), uniform()) * (4.0 / spacing), 3.0 * uniform()))
        .collect();
    let distance = move |p: &Point3<f64>| {
        let sum: f64 = waves.iter().map(|(k, phase)| (k.dot(&p.coords) + phase).sin()).sum();
        let rim = p.coords.abs().max() - 0.25;
        (sum * 0.05 * spacing).max(rim)
    };
    ImplicitShape { distance, half: Vector3::repeat(0.25) }
}

#[test]
fn angles_stay_within_the_proven_bounds_on_noise() {
    let (mut smallest, mut largest, mut pinches) = (180.0f64, 0.0f64, 0);
    for seed in 0..60 {
        let level = stuffed(&noise(seed, 6, 0.05), 0.05, None);
        check_stuffed(&level);
        pinches += level.pinches_mended;
        for body in &level.bodies {
            smallest = smallest.min(body.dihedral().min_deg);
            largest = largest.max(body.dihedral().max_deg);
        }
    }
    println!("noise: dihedral angles {smallest:.2} to {largest:.2} degrees, {pinches} pinches");
    assert!(smallest < 14.0 && largest > 158.0 && pinches > 100, "too tame: {smallest} {largest} {pinches}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn sums_of_balls_always_end_in_valid_bodies(
        list in prop::collection::vec((prop::array::uniform3(-0.3f64..0.3), 0.02f64..0.2), 1..7),
        spacing in 0.04f64..0.12,
        aimed in prop::option::of(0.5f64..1.5),
    ) {
        let list: Vec<_> = list.into_iter().map(|(center, radius)| (Point3::from(center), radius)).collect();
        let volume: f64 = list.iter().map(|(_, radius)| 4.0 / 3.0 * PI * radius.powi(3)).sum();
        match stuff(&balls(list), spacing, aimed.map(|share| share * volume), &CancelToken::default()) {
            Ok(level) => {
                check_stuffed(&level);
                prop_assert!(level.offset.abs() <= 0.5 * spacing);
            }
            Err(error) => prop_assert_eq!(error, LatticeError::NothingInside { spacing }),
        }
    }

    #[test]
    fn any_tetrahedra_of_a_block_end_in_valid_bodies(seed in any::<u64>(), share in 0.1f64..0.95) {
        let whole = block([3, 3, 3], 0.2);
        let mut stream = RandomStream::new(seed, 0);
        let kept: Vec<u32> = (0..whole.tets.len() as u32).filter(|_| stream.uniform() < share).collect();
        prop_assume!(!kept.is_empty());
        let ragged = whole.part(&kept);
        let level = split(&ragged, 0.0, 0.2);
        check(&level);
        let dropped: f64 = level.dropped.iter().map(|dropped| dropped.volume).sum();
        prop_assert!((level.volume() + dropped + level.mended_volume - ragged.volume()).abs() < 1e-12);
    }
}

#[test]
fn shapes_of_every_topology_become_bodies_of_the_volume_asked_for() {
    let turn = Isometry3::rotation(Vector3::new(0.3, -0.7, 0.5));
    let cases: [(&str, Box<dyn SignedDistance>, f64); 6] = [
        ("ball", Box::new(ball(0.3)), 4.0 / 3.0 * PI * 0.3f64.powi(3)),
        ("torus", Box::new(torus(0.3, 0.09)), 2.0 * PI * PI * 0.3 * 0.09 * 0.09),
        ("thin torus", Box::new(torus(0.4, 0.03)), 2.0 * PI * PI * 0.4 * 0.03 * 0.03),
        ("box", Box::new(cuboid(Vector3::repeat(0.25), Isometry3::identity())), 0.125),
        ("turned box", Box::new(cuboid(Vector3::new(0.4, 0.1, 0.2), turn)), 8.0 * 0.4 * 0.1 * 0.2),
        ("plate", Box::new(cuboid(Vector3::new(0.3, 0.025, 0.3), turn)), 8.0 * 0.3 * 0.025 * 0.3),
    ];
    for (name, shape, volume) in cases {
        let plain = stuffed(&*shape, 0.04, None);
        let met = stuffed(&*shape, 0.04, Some(volume));
        check_stuffed(&plain);
        check_stuffed(&met);
        let [before, after] = [&plain, &met].map(|level| level.volume() / volume - 1.0);
        println!("{name}: volume {before:+.4} as it is, {after:+.5} at offset {:+.4} spacings", met.offset / 0.04);
        assert!(after.abs() < 2e-3 && met.bodies.len() == 1 && met.offset.abs() <= 0.02);
        assert!(after.abs() <= before.abs() + 1e-12);
    }
}

#[test]
fn a_volume_out_of_reach_ends_at_half_a_spacing() {
    let level = stuffed(&ball(0.3), 0.1, Some(0.4));
    check_stuffed(&level);
    assert!((level.offset - 0.05).abs() < 1e-9);
    assert!(level.volume() > 4.0 / 3.0 * PI * 0.33f64.powi(3));
}

#[test]
fn balls_that_touch_in_a_point_are_two_bodies_or_one_without_a_pinch() {
    for spacing in [0.03, 0.05, 0.0731] {
        let centers = [-0.2, 0.2].map(|x| (Point3::new(x, 0.01, 0.02), 0.2));
        let level = stuffed(&balls(centers.to_vec()), spacing, None);
        check_stuffed(&level);
        assert!(level.bodies.len() <= 2);
    }
}

#[test]
fn small_components_are_dropped_and_reported() {
    let list = vec![(Point3::new(-0.1, 0.0, 0.0), 0.25), (Point3::new(0.3, 0.1, 0.0), 0.022)];
    let level = stuffed(&balls(list), 0.03, None);
    check_stuffed(&level);
    assert_eq!((level.bodies.len(), level.dropped.len()), (1, 1));
    let crumb = level.dropped[0];
    assert!((crumb.place - Point3::new(0.3, 0.1, 0.0)).norm() < 0.01 && crumb.volume < 5e-5);
}

#[test]
fn volume_and_deviation_of_a_ball_converge_with_the_square_of_the_spacing() {
    let shape = ball(0.3);
    let exact = 4.0 / 3.0 * PI * 0.3f64.powi(3);
    let errors = [0.1, 0.05, 0.025].map(|spacing| {
        let level = stuffed(&shape, spacing, None);
        let deviation = level.bodies[0].deviation(&|point| shape.signed_distance(point));
        [1.0 - level.volume() / exact, deviation]
    });
    for (measure, name) in ["volume", "deviation"].iter().enumerate() {
        // The largest deviation depends on the position of the grid, so the order is taken over the
        // whole range, a factor of four.
        let order = (errors[0][measure] / errors[2][measure]).log2() / 2.0;
        println!(
            "{name}: {:.2e} at 0.1, {:.2e} at 0.025, observed order {order:.2}",
            errors[0][measure], errors[2][measure]
        );
        assert!((1.7..2.4).contains(&order), "{name} {order}");
    }
}

#[test]
fn a_turned_shape_has_the_same_volume_and_a_moved_lattice_its_angles() {
    let half = Vector3::new(0.3, 0.2, 0.15);
    let turn = Isometry3::new(Vector3::new(0.01, -0.02, 0.03), Vector3::new(0.4, 0.2, -0.9));
    let straight = stuffed(&cuboid(half, Isometry3::identity()), 0.03, None);
    let turned = stuffed(&cuboid(half, turn), 0.03, None);
    assert!((turned.volume() / straight.volume() - 1.0).abs() < 0.02);
    let body = &straight.bodies[0];
    let moved = body.transformed(&turn);
    assert!((moved.volume() - body.volume()).abs() < 1e-14 && (moved.center() - turn * body.center()).norm() < 1e-14);
    assert!((moved.dihedral().min_deg - body.dihedral().min_deg).abs() < 1e-9);
    assert!((moved.boundary_area() - body.boundary_area()).abs() < 1e-12);
}

#[test]
fn the_lattice_does_not_depend_on_the_number_of_threads() {
    let lattice = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let shape = torus(0.3, 0.1);
        let both = pool.install(|| {
            levels(
                &shape,
                Spacings { elastic: 0.08, crack: 0.05, refine: false, fits_elastic: false },
                0.059,
                &CancelToken::default(),
            )
            .unwrap()
        });
        both.bodies.into_iter().map(|body| (body.elastic, body.crack, body.transfer)).collect::<Vec<_>>()
    };
    assert!(lattice(1) == lattice(5));
}

#[test]
fn shapes_without_a_lattice_are_rejected_with_a_reason() {
    let refused = |shape: &dyn SignedDistance, spacing, volume| {
        stuff(shape, spacing, volume, &CancelToken::default()).unwrap_err()
    };
    let shape = ball(0.3);
    for spacing in [0.0, -0.1, 0.0019, 0.26, f64::INFINITY, f64::NAN] {
        assert!(matches!(refused(&shape, spacing, None), LatticeError::SpacingOutOfRange { .. }));
    }
    assert!(matches!(refused(&shape, 0.003, None), LatticeError::GridTooLarge { .. }));
    for volume in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(&shape, 0.1, Some(volume)), LatticeError::VolumeNotPositive { .. }));
    }
    assert_eq!(refused(&ball(0.01), 0.2, None), LatticeError::NothingInside { spacing: 0.2 });
    let hole = ImplicitShape {
        distance: |p: &Point3<f64>| if p.x > 0.0 { f64::NAN } else { -0.1 },
        half: Vector3::repeat(0.1),
    };
    assert!(matches!(refused(&hole, 0.05, None), LatticeError::DistanceNotFinite { place } if place.x > 0.0));
    let endless = ImplicitShape { distance: |_: &Point3<f64>| 1.0, half: Vector3::repeat(f64::INFINITY) };
    assert_eq!(refused(&endless, 0.05, None), LatticeError::BoundsNotFinite);
    let token = CancelToken::default();
    token.cancel();
    assert_eq!(stuff(&shape, 0.05, None, &token).unwrap_err(), LatticeError::Canceled(Canceled));
}

#[test]
fn a_jump_of_the_sign_ends_in_valid_bodies() {
    // Outside a cone the sign jumps far from any surface, as in front of a hole in an open mesh.
    let distance = |p: &Point3<f64>| if p.z > 0.0 { 0.3 } else { p.coords.norm() - 0.3 };
    let level = stuffed(&ImplicitShape { distance, half: Vector3::repeat(0.3) }, 0.02, None);
    check_stuffed(&level);
    let half_ball = 2.0 / 3.0 * PI * 0.3f64.powi(3);
    assert!((level.volume() / half_ball - 1.0).abs() < 0.02, "{}", level.volume() / half_ball);
}

#[test]
fn the_spacing_that_a_refusal_names_is_accepted() {
    for step in 0..40 {
        let (volume, area) = (0.02 + 0.004 * f64::from(step), 0.6 + 0.05 * f64::from(step));
        let refused = spacings(volume, area, [3_000, 9_000], None, Some(0.002)).unwrap_err();
        let LatticeError::TooManyNodes { spacing_needed, .. } = refused else { panic!("{refused}") };
        let named: f64 = format!("{spacing_needed:.4}").parse().unwrap();
        assert!(refused.to_string().ends_with(&format!("use {spacing_needed:.4} or more")), "{refused}");
        assert_eq!(spacings(volume, area, [3_000, 9_000], None, Some(named)).map(|chosen| chosen[1]), Ok(named));
    }
}

#[test]
fn spacings_give_the_nodes_asked_for() {
    let turn = Isometry3::rotation(Vector3::new(0.3, 0.5, 0.2));
    let cases: [(Box<dyn SignedDistance>, f64, f64); 3] = [
        (Box::new(ball(0.3)), 4.0 / 3.0 * PI * 0.3f64.powi(3), 4.0 * PI * 0.09),
        (Box::new(cuboid(Vector3::new(0.35, 0.05, 0.35), turn)), 0.049, 0.98 + 0.28),
        (Box::new(torus(0.3, 0.08)), 2.0 * PI * PI * 0.3 * 0.08 * 0.08, 4.0 * PI * PI * 0.3 * 0.08),
    ];
    for (shape, volume, area) in cases {
        for nodes in [ELASTIC_NODES_DEFAULT, CRACK_NODES_DEFAULT] {
            let spacing = default_spacing(volume, area, nodes);
            let share = stuffed(&*shape, spacing, None).node_count() as f64 / nodes as f64;
            println!("spacing {spacing:.4}: {share:.3} of the {nodes} nodes asked for");
            assert!((share - 1.0).abs() < 0.12);
        }
    }
    assert!((default_spacing(1e-12, 1e-9, 12_000) - SPACING_RANGE[0]).abs() < 1e-9);
}
