//! Invariances of lifts, and dependences that must hold.

use super::shapes::{ball, fork, nearest};
use crate::cancel_token::CancelToken;
use crate::lattice::{Lattice, block};
use crate::lift::metric::metric;
use crate::lift::{LiftError, LiftKind, LiftedLattice, Spectrum, interior, stretch};
use crate::random::RandomStream;
use nalgebra::{Rotation3, Vector3};

fn lift(lattice: &Lattice, modes: usize, alpha: f64) -> LiftedLattice {
    interior(lattice, modes, alpha, &CancelToken::default()).unwrap()
}

fn distance(lift: &LiftedLattice, a: usize, b: usize) -> f64 {
    lift.at(a).iter().zip(lift.at(b)).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

/// Checks that distances between random nodes are the same on `lattice` and on its rotated, renumbered copy.
#[track_caller]
fn check_rotation(lattice: &Lattice, modes: usize) {
    let rotation = Rotation3::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7));
    let mut turned = lattice.clone();
    turned.nodes.iter_mut().for_each(|node| *node = rotation * *node);
    // Another numbering starts the iteration from another block.
    turned.nodes.reverse();
    let last = lattice.nodes.len() - 1;
    turned.tets.iter_mut().flatten().for_each(|node| *node = last as u32 - *node);
    let (one, other) = (lift(lattice, modes, 1.0), lift(&turned, modes, 1.0));
    assert_eq!(one.dimension, other.dimension);
    let mut random = RandomStream::new(7, 0);
    for _ in 0..500 {
        let [a, b] = [0, 1].map(|_| (random.uniform() * lattice.nodes.len() as f64) as usize);
        let (here, there) = (distance(&one, a, b), distance(&other, last - a, last - b));
        assert!((here - there).abs() <= 1e-8 * here.max(1e-3), "{here} and {there}");
    }
}

#[test]
fn distances_do_not_depend_on_the_orientation_even_with_multiplets() {
    check_rotation(&block([2; 3], 0.2), 16);
    check_rotation(&block([6; 3], 0.1), 16);
    check_rotation(&block([6; 3], 0.1), 4);
    check_rotation(&ball(6), 12);
    check_rotation(&fork(), 16);
}

#[test]
fn the_scale_makes_a_uniform_field_s_degree_the_same_for_every_lift() {
    let lattice = fork();
    let spectrum = Spectrum::compute(&lattice, 24, &CancelToken::default()).unwrap();
    let volumes = lattice.node_volumes();
    for alpha in [0.0, 0.5, 1.0, 2.0, 8.0] {
        let lift = spectrum.lift(&lattice, 16, alpha).unwrap();
        // n₀ of the uniform field W = 1, up to the constant (c/γ)^(3/5).
        let degree: f64 = volumes.iter().zip(&lift.density).map(|(volume, density)| volume * density).sum();
        assert!((degree / lattice.volume() - 1.0).abs() < 1e-12, "alpha {alpha}: {degree}");
        assert!(lift.second_moment.iter().all(|moment| *moment > 0.0));
    }
}

#[test]
fn the_embedding_alone_has_unit_mean_stretch() {
    let lattice = fork();
    let spectrum = Spectrum::compute(&lattice, 24, &CancelToken::default()).unwrap();
    let alpha = 3.0;
    let lift = spectrum.lift(&lattice, 16, alpha).unwrap();
    let positions = lift.at(0)[0] / lattice.nodes[0].x;
    let mut sum = 0.0;
    for tet in 0..lattice.tets.len() {
        // tr(JᵀJ) of s·[x; α·ψ] is s²·(3 + α²·tr of ψ).
        sum += lattice.tet_volume(tet) * (metric(&lift, &lattice, tet).trace() / (positions * positions) - 3.0);
    }
    let mean = sum / lattice.volume() / 3.0 / (alpha * alpha);
    assert!((mean - 1.0).abs() < 1e-9, "mean stretch {mean}");
}

#[test]
fn no_weight_is_euclidean() {
    let lattice = fork();
    let euclidean = LiftedLattice::euclidean(&lattice);
    for plain in [lift(&lattice, 16, 0.0), lift(&lattice, 0, 1.0)] {
        assert_eq!((plain.kind, plain.dimension), (LiftKind::Interior, 3));
        assert_eq!(plain.coordinates, euclidean.coordinates);
    }
    assert!((stretch(&euclidean, &lattice).max - 1.0).abs() < 1e-6);
}

#[test]
fn the_prongs_of_a_fork_are_far_apart_inside() {
    let lattice = fork();
    // Across the slot at the tips, and across solid material of the same width within the left prong.
    let tips = [nearest(&lattice, -0.05, 0.6, 0.0), nearest(&lattice, 0.05, 0.6, 0.0)];
    let solid = [nearest(&lattice, -0.25, 0.6, 0.0), nearest(&lattice, -0.15, 0.6, 0.0)];
    let ratio = |alpha: f64| {
        let lift = lift(&lattice, 16, alpha);
        distance(&lift, tips[0], tips[1]) / distance(&lift, solid[0], solid[1])
    };
    assert!((ratio(0.0) - 1.0).abs() < 1e-9);
    let (one, two) = (ratio(1.0), ratio(2.0));
    assert!(one > 5.0 && two > one, "across the slot {one} and {two} times as far as through material");
}

#[test]
fn stretch_orders_its_percentiles_and_grows_with_alpha() {
    let lattice = fork();
    let (one, two) = (stretch(&lift(&lattice, 16, 1.0), &lattice), stretch(&lift(&lattice, 16, 2.0), &lattice));
    assert!(1.0 <= one.median && one.median <= one.p99 && one.p99 <= one.max && one.max.is_finite(), "{one:?}");
    assert!(one.p99 < two.p99, "{one:?} {two:?}");
}

#[test]
fn tiny_lattices_use_the_modes_they_have() {
    let tet = Lattice { nodes: block([1; 3], 1.0).nodes[..4].to_vec(), tets: vec![[0, 1, 2, 3]] };
    let tet = if tet.tet_volume(0) > 0.0 { tet } else { Lattice { tets: vec![[0, 1, 3, 2]], ..tet } };
    let small = lift(&tet, 16, 1.0);
    assert_eq!(small.dimension, 3 + 3);
    assert!(small.coordinates.iter().chain(&small.second_moment).all(|value| value.is_finite()));
    assert_eq!(lift(&block([1; 3], 1.0), 16, 1.0).dimension, 3 + 14);
}

#[test]
fn what_has_no_lift_is_refused_by_name() {
    let lattice = block([1; 3], 1.0);
    let token = CancelToken::default();
    for alpha in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(interior(&lattice, 4, alpha, &token), Err(LiftError::InvalidAlpha { .. })));
    }
    assert_eq!(interior(&lattice, 65, 1.0, &token), Err(LiftError::TooManyModes { modes: 65, max: 64 }));
    assert!(matches!(interior(&Lattice::default(), 4, 1.0, &token), Err(LiftError::TooFewNodes { .. })));
}
