//! Vases as OBJ: profiles rotated about +y, 0.3 m high.

use std::f64::consts::{PI, TAU};

/// Height of all vases, m.
pub const HEIGHT_M: f64 = 0.3;

/// Wall of the painted vase, m.
pub const WALL_M: f64 = 0.009;

/// Earthenware vase. Its walls of 16 mm suit coarse lattices.
pub fn vase() -> String {
    let (steps, wall_m, floor) = (40, 0.016, 0.02 / HEIGHT_M);
    let radius = |t: f64| 0.062 + 0.026 * (TAU * (0.85 * t + 0.1)).sin();
    let share = |k: u32| f64::from(k) / f64::from(steps);
    let outside = (0..=steps).map(|k| [radius(share(k)), HEIGHT_M * share(k)]);
    let inside = (0..=steps).map(|k| 1.0 - (1.0 - floor) * share(k)).map(|t| [radius(t) - wall_m, HEIGHT_M * t]);
    lathe(&outside.chain(inside).collect::<Vec<_>>(), 64)
}

/// Outer radius of the painted vase at a height over the whole one, m: foot, belly, neck, flared lip.
pub fn radius_m(t: f64) -> f64 {
    let bell = |middle: f64, width: f64| (-((t - middle) / width).powi(2)).exp();
    0.036 + 0.010 * bell(0.0, 0.12) + 0.058 * bell(0.53, 0.22) + 0.016 * bell(1.0, 0.09)
}

/// Painted vase with a wall of [`WALL_M`] and a round lip.
pub fn painted_vase() -> String {
    let (steps, lip_m, floor) = (90, 0.5 * WALL_M, 0.014 / HEIGHT_M);
    let top = 1.0 - lip_m / HEIGHT_M;
    let share = |k: u32| f64::from(k) / f64::from(steps);
    let slope = |t: f64| (radius_m(t + 1e-4) - radius_m(t - 1e-4)) / (2e-4 * HEIGHT_M);
    let outside = (0..=steps).map(|k| top * share(k)).map(|t| [radius_m(t), HEIGHT_M * t]);
    let inner = |t: f64| radius_m(t) - WALL_M * (1.0 + slope(t).powi(2)).sqrt();
    let angle = |k: u32| PI * f64::from(k) / 8.0;
    let lip = (1..8).map(angle).map(|a| [radius_m(top) - lip_m * (1.0 - a.cos()), HEIGHT_M - lip_m * (1.0 - a.sin())]);
    let inside = (0..=steps).map(|k| top - (top - floor) * share(k)).map(|t| [inner(t), HEIGHT_M * t]);
    lathe(&outside.chain(lip).chain(inside).collect::<Vec<_>>(), 128)
}

/// Rotates a profile of radii and heights, m, that begins outside at the bottom and ends inside above it.
fn lathe(profile: &[[f64; 2]], around: u32) -> String {
    let last = profile.len() as u32 - 1;
    let mut text = format!("v 0 {} 0\nv 0 {} 0\n", profile[0][1], profile[last as usize][1]);
    for [r, y] in profile {
        for angle in (0..around).map(|k| TAU * f64::from(k) / f64::from(around)) {
            text += &format!("v {} {y} {}\n", r * angle.cos(), -r * angle.sin());
        }
    }
    // OBJ numbers start at 1: the two points on the axis, then ring by ring.
    let at = |ring: u32, k: u32| 3 + ring * around + k % around;
    for k in 0..around {
        text += &format!("f 1 {} {}\nf 2 {} {}\n", at(0, k + 1), at(0, k), at(last, k), at(last, k + 1));
        for ring in 0..last {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    text
}
