//! Stuffing from analytic distances: angles, manifolds, volumes, orders of convergence, refusals.

use super::shapes::{Shape, ball, balls, cuboid, torus};
use super::*;
use crate::random::Stream;
use crate::token::Token;
use nalgebra::{Isometry3, Vector3};

/// The bounds that Labelle & Shewchuk prove for the safe parameters, degrees, rounded outwards.
const DIHEDRAL_DEG: [f64; 2] = [10.7, 164.8];

fn stuffed(shape: &dyn SignedDistance, spacing: f64, volume: Option<f64>) -> Level {
    stuff(shape, spacing, volume, &Token::default()).unwrap()
}

/// Everything that every level promises.
fn check(level: &Level) {
    assert!(!level.bodies.is_empty());
    for body in &level.bodies {
        check_manifold(body).unwrap();
        assert!((0..body.tets.len()).all(|tet| body.tet_volume(tet) > 0.0));
        let angles = body.dihedral();
        assert!(angles.min_deg > DIHEDRAL_DEG[0] && angles.max_deg < DIHEDRAL_DEG[1], "{angles:?}");
        let mut used = vec![false; body.nodes.len()];
        body.tets.iter().flatten().for_each(|&node| used[node as usize] = true);
        assert!(used.into_iter().all(|used| used));
    }
    assert!(level.bodies.windows(2).all(|pair| pair[0].volume() >= pair[1].volume()));
}

/// Waves of about two spacings in random directions: nothing like a distance, cuts fall anywhere on the edges.
fn noise(seed: u64, waves: usize, spacing: f64) -> impl SignedDistance {
    let mut stream = Stream::new(seed, 0);
    let mut uniform = move || 2.0 * stream.uniform() - 1.0;
    let waves: Vec<(Vector3<f64>, f64)> = (0..waves)
        .map(|_| (Vector3::new(uniform(), uniform(), uniform()) * (4.0 / spacing), 3.0 * uniform()))
        .collect();
    let distance = move |p: &Point3<f64>| {
        let sum: f64 = waves.iter().map(|(k, phase)| (k.dot(&p.coords) + phase).sin()).sum();
        let rim = p.coords.abs().max() - 0.25;
        (sum * 0.05 * spacing).max(rim)
    };
    Shape { distance, half: Vector3::repeat(0.25) }
}

#[test]
fn angles_stay_within_the_proven_bounds_on_noise() {
    let (mut smallest, mut largest) = (180.0f64, 0.0f64);
    for seed in 0..60 {
        let level = stuffed(&noise(seed, 6, 0.05), 0.05, None);
        check(&level);
        for body in &level.bodies {
            smallest = smallest.min(body.dihedral().min_deg);
            largest = largest.max(body.dihedral().max_deg);
        }
    }
    println!("dihedral {smallest} {largest}");
    assert!(smallest < 14.0 && largest > 158.0, "the noise is too tame: {smallest} {largest}");
}

/// Volume and deviation of a ball at this spacing, relative to the ball and to its radius.
fn ball_errors(spacing: f64) -> [f64; 2] {
    let (radius, shape) = (0.3, ball(0.3));
    let level = stuffed(&shape, spacing, None);
    check(&level);
    let exact = 4.0 / 3.0 * std::f64::consts::PI * f64::powi(radius, 3);
    let deviation = level.bodies[0].deviation(&|point| shape.signed_distance(point).abs());
    [(level.volume() / exact - 1.0).abs(), deviation / radius]
}

#[test]
fn volume_and_deviation_of_a_ball_converge_with_the_square_of_the_spacing() {
    let (coarse, fine) = (ball_errors(0.08), ball_errors(0.04));
    let orders = [0, 1].map(|k| (coarse[k] / fine[k]).log2());
    println!("volume {coarse:?} {fine:?}, orders {orders:?}");
    assert!(orders[0] > 1.7 && orders[1] > 1.4, "{orders:?}");
}

#[test]
fn a_wanted_volume_is_met_on_thin_and_round_shapes() {
    let tilted = Isometry3::rotation(Vector3::new(0.3, 0.5, 0.1));
    let ring = 2.0 * std::f64::consts::PI.powi(2) * 0.3 * f64::powi(0.06, 2);
    let shapes: [(&dyn SignedDistance, f64); 2] =
        [(&torus(0.3, 0.06), ring), (&cuboid(Vector3::new(0.3, 0.2, 0.05), tilted), 8.0 * 0.3 * 0.2 * 0.05)];
    for (shape, volume) in shapes {
        let level = stuffed(shape, 0.05, Some(volume));
        check(&level);
        assert!((level.volume() / volume - 1.0).abs() < 2e-3, "{} of {volume}", level.volume());
        assert!(level.offset.abs() <= 0.025);
    }
}

#[test]
fn balls_that_touch_or_nearly_touch_give_bodies_without_pinches() {
    let mut stream = Stream::new(5, 0);
    for _ in 0..12 {
        let centre = |stream: &mut Stream| Point3::from([(); 3].map(|()| 0.5 * stream.uniform() - 0.25));
        let cloud = (0..6).map(|_| (centre(&mut stream), 0.06 + 0.08 * stream.uniform())).collect();
        check(&stuffed(&balls(cloud), 0.05, None));
    }
    let apart = vec![(Point3::new(-0.25, 0.0, 0.0), 0.15), (Point3::new(0.25, 0.0, 0.0), 0.15)];
    assert_eq!(stuffed(&balls(apart), 0.04, None).bodies.len(), 2);
}

#[test]
fn any_set_of_tetrahedra_can_be_mended() {
    let whole = block([4, 4, 4], 0.1);
    for seed in 0..20 {
        let mut stream = Stream::new(seed, 1);
        let kept: Vec<u32> = (0..whole.tets.len() as u32).filter(|_| stream.uniform() < 0.7).collect();
        let part = whole.part(&kept);
        for tets in part.components() {
            let (mended, _) = super::mend::mend(&part.part(&tets));
            for tets in mended.components() {
                check_manifold(&mended.part(&tets)).unwrap();
            }
        }
    }
}

#[test]
fn what_cannot_be_stuffed_is_refused_by_name() {
    let shape = ball(0.3);
    let refused = |spacing, volume| stuff(&shape, spacing, volume, &Token::default()).unwrap_err();
    for spacing in [0.0, -1.0, 1e-6, 0.9, f64::NAN] {
        assert!(matches!(refused(spacing, None), LatticeError::SpacingOutOfRange { .. }), "{spacing}");
    }
    assert!(matches!(refused(0.05, Some(f64::NAN)), LatticeError::VolumeNotPositive { .. }));
    let tiny = stuff(&ball(0.0), 0.1, None, &Token::default());
    assert!(matches!(tiny, Err(LatticeError::NothingInside { .. } | LatticeError::BoundsNotFinite)), "{tiny:?}");
    let token = Token::default();
    token.cancel();
    assert!(matches!(stuff(&shape, 0.05, None, &token), Err(LatticeError::Cancelled(_))));
}

/// Energy before and after the transfer agree; returns the nodes' share of the tetrahedra's volumes.
fn transferred(elastic: &Lattice, crack: &Lattice) -> Vec<f64> {
    let transfer = Transfer::between(elastic, crack);
    let energy: Vec<f64> = (0..elastic.tets.len()).map(|tet| 1.0 + (tet as f64 * 0.37).sin()).collect();
    let mut nodes = Vec::new();
    transfer.apply(&energy, &mut nodes);
    let (before, after): (f64, f64) = (energy.iter().sum(), nodes.iter().sum());
    assert!((before - after).abs() < 1e-12 * before, "{before} {after}");
    let volumes: Vec<f64> = (0..elastic.tets.len()).map(|tet| elastic.tet_volume(tet)).collect();
    transfer.apply(&volumes, &mut nodes);
    nodes
}

#[test]
fn energy_is_conserved_between_the_levels() {
    let shape = ball(0.3);
    let [coarse, fine] = [0.09, 0.05].map(|spacing| stuffed(&shape, spacing, None).bodies.remove(0));
    let nodes = transferred(&coarse, &fine);
    let mut errors: Vec<f64> =
        fine.node_volumes().iter().zip(&nodes).map(|(volume, energy)| (energy / volume - 1.0).abs()).collect();
    errors.sort_by(f64::total_cmp);
    let median = errors[errors.len() / 2];
    println!("uniform density after the transfer: median error {median:.3}");
    assert!(median < 0.1);
}

#[test]
fn energy_is_conserved_where_the_levels_do_not_cover_each_other() {
    transferred(&block([6, 4, 4], 0.1), &block([3, 3, 3], 0.05));
    transferred(&block([2, 2, 2], 0.1), &block([9, 9, 9], 0.05));
}
