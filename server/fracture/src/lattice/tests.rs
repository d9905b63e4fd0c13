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

#[test]
fn calibrate() {
    let cases: Vec<(&str, Box<dyn SignedDistance>, f64, f64)> = vec![
        (
            "ball",
            Box::new(ball(0.28)),
            4.0 / 3.0 * std::f64::consts::PI * 0.28f64.powi(3),
            4.0 * std::f64::consts::PI * 0.28f64.powi(2),
        ),
        (
            "cube",
            Box::new(cuboid(Vector3::repeat(0.28), Isometry3::identity())),
            0.56f64.powi(3),
            6.0 * 0.56f64.powi(2),
        ),
        (
            "turned",
            Box::new(cuboid(Vector3::repeat(0.28), Isometry3::rotation(Vector3::new(0.3, 0.5, 0.2)))),
            0.56f64.powi(3),
            6.0 * 0.56f64.powi(2),
        ),
        (
            "slab",
            Box::new(cuboid(Vector3::new(0.35, 0.03, 0.35), Isometry3::rotation(Vector3::new(0.3, 0.5, 0.2)))),
            0.7 * 0.7 * 0.06,
            2.0 * 0.49 + 4.0 * 0.7 * 0.06,
        ),
        (
            "torus",
            Box::new(torus(0.3, 0.08)),
            2.0 * std::f64::consts::PI.powi(2) * 0.3 * 0.08 * 0.08,
            4.0 * std::f64::consts::PI.powi(2) * 0.3 * 0.08,
        ),
    ];
    for (name, shape, volume, area) in &cases {
        for nodes in [1000, 3000, 12000] {
            let h = (2.0 * volume / nodes as f64).cbrt();
            let start = std::time::Instant::now();
            let level = stuffed(&**shape, h, Some(*volume));
            let time = start.elapsed();
            check(&level);
            let layer = (level.node_count() as f64 * h.powi(3) / 2.0 - volume) / (area * h);
            let d = level.bodies[0].dihedral();
            println!(
                "{name} {nodes}: h {h:.4} nodes {} tets {} layer {layer:.3} v err {:+.5} offset/h {:+.4} dih {:.2} {:.2} pinch {} drop {} dev/h {:.4} {time:?} area/v23 {:.2}",
                level.node_count(),
                level.tet_count(),
                level.volume() / volume - 1.0,
                level.offset / h,
                d.min_deg,
                d.max_deg,
                level.pinches_mended,
                level.dropped.len(),
                level.bodies[0].deviation(&|p| shape.signed_distance(p)) / h,
                area / volume.powf(2.0 / 3.0)
            );
        }
    }
}

#[test]
fn measure_real() {
    use crate::surface::{Inside, RawMesh, Surface};
    for name in std::env::var("NAMES").unwrap_or("horse".into()).split(',') {
        let d = std::fs::read(format!("/tmp/{name}.bin")).unwrap();
        let (nv, nt) = (
            i64::from_le_bytes(d[0..8].try_into().unwrap()) as usize,
            i64::from_le_bytes(d[8..16].try_into().unwrap()) as usize,
        );
        let f = |i: usize| f64::from_le_bytes(d[16 + 8 * i..24 + 8 * i].try_into().unwrap());
        let v: Vec<_> = (0..nv).map(|k| Point3::new(f(3 * k), f(3 * k + 1), f(3 * k + 2))).collect();
        let o = 16 + 24 * nv;
        let u = |i: usize| u32::from_le_bytes(d[o + 4 * i..o + 4 * i + 4].try_into().unwrap());
        let t: Vec<_> = (0..nt).map(|k| [u(3 * k), u(3 * k + 1), u(3 * k + 2)]).collect();
        let surface = Surface::repair(RawMesh::new(v, t)).unwrap();
        let inside = Inside::new(&surface);
        let token = Token::default();
        let volume = inside.input_volume(&token).unwrap();
        let area: f64 = surface
            .triangles
            .iter()
            .map(|t| super::measure::area_vector(&t.map(|n| surface.positions[n as usize])).norm())
            .sum();
        println!("{name}: volume {volume:.5} area {area:.4} area/v23 {:.2}", area / volume.powf(2.0 / 3.0));
        for nodes in [3000, 12000] {
            let h = spacing_for(volume, area, nodes);
            for v in [None, Some(volume)] {
                let start = std::time::Instant::now();
                let level = stuff(&inside, h, v, &token).unwrap();
                let time = start.elapsed();
                let layer = (level.node_count() as f64 * h.powi(3) / 2.0 - volume) / (area * h);
                let d = level.bodies[0].dihedral();
                println!(
                    "{name} {nodes} {}: h {h:.5} default {:.5} nodes {} tets {} layer {layer:.3} bodies {} v err {:+.5} offset/h {:+.4} dih {:.2} {:.2} pinch {} vol {:.2e} drop {:?} dev/h {:.4} dev {:.5} {time:?}",
                    v.is_some(),
                    default_spacing(volume, nodes),
                    level.node_count(),
                    level.tet_count(),
                    level.bodies.len(),
                    level.volume() / volume - 1.0,
                    level.offset / h,
                    d.min_deg,
                    d.max_deg,
                    level.pinches_mended,
                    level.mended_volume / volume,
                    level.dropped.iter().map(|d| (d.volume / volume, d.tets)).collect::<Vec<_>>(),
                    level.bodies.iter().map(|b| b.deviation(&|p| inside.distance(p))).fold(0.0, f64::max) / h,
                    level.bodies.iter().map(|b| b.deviation(&|p| inside.distance(p))).fold(0.0, f64::max)
                );
                if std::env::var("CHECK").is_ok() {
                    check(&level);
                }
            }
        }
        let start = std::time::Instant::now();
        let both =
            levels(&inside, spacing_for(volume, area, 3000), spacing_for(volume, area, 12000), volume, &token).unwrap();
        println!(
            "{name} both {:?} replaced {:?} unmatched {:.2e} bodies {}",
            start.elapsed(),
            both.replaced,
            both.unmatched_volume,
            both.bodies.len()
        );
    }
}
