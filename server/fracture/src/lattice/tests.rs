//! Stuffing from analytic distances: angles, manifolds, volumes, orders of convergence, refusals.

use super::shapes::{Shape, ball, balls, cuboid, torus};
use super::*;
use crate::random::Stream;
use crate::token::Token;
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

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
