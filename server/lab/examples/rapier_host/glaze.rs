//! Texture of the painted vase, by the place in its mesh file: cobalt under a clear glaze outside, clay in the cracks.

use super::vessel::{HEIGHT_M, WALL_M, radius_m};
use nalgebra::Vector3;
use shatter_lab::picture::{Color, Finish};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Thickness of the glaze, m.
const GLAZE_M: f32 = 0.0007;

/// Number of periods of the vine around the vase, and its height and half its width, m.
const PERIODS: f32 = 4.0;
const VINE_M: f32 = 0.146;
const SWING_M: f32 = 0.031;

/// Appearance of an outer face or of a crack face at a place of the mesh file, m.
pub fn finish(place: Vector3<f32>, is_crack: bool) -> Finish {
    let depth_m = radius_m(f64::from(place.y) / HEIGHT_M) as f32 - place.x.hypot(place.z);
    let is_foot = place.y < 0.001;
    if is_foot || (is_crack && depth_m > GLAZE_M) {
        let grain = 0.5 + 0.2 * waves(place, 70.0) + 0.1 * waves(place, 610.0) + 0.2 * waves(place, 2700.0);
        return Finish {
            color: Color::oklch(0.58, 0.085, 45.0).mix(Color::oklch(0.74, 0.075, 62.0), grain),
            reflectance: 0.0,
        };
    }
    let is_outside = !is_crack && depth_m < 0.5 * WALL_M as f32;
    let ink = if is_outside { ink(place.z.atan2(place.x), place.y) } else { 0.0 };
    let cobalt = Color::oklch(0.31, 0.16, 263.0).mix(Color::oklch(0.42, 0.16, 259.0), 0.5 + 0.5 * waves(place, 260.0));
    let wash = Color::oklch(0.945, 0.008, 220.0).mix(Color::oklch(0.58, 0.125, 254.0), (1.6 * ink).min(1.0));
    Finish { color: wash.mix(cobalt, ((ink - 0.6) * 2.5).clamp(0.0, 1.0)), reflectance: 0.04 }
}

/// Irregular value between -1 and 1 that changes over about one radian of `frequency`, 1/m.
fn waves(place: Vector3<f32>, frequency: f32) -> f32 {
    let [x, y, z]: [f32; 3] = (place * frequency).into();
    let folded = [x + 1.7 * (0.9 * y).sin(), y + 1.7 * (1.1 * z).sin(), z + 1.7 * (0.8 * x).sin()];
    folded.iter().map(|at| at.sin()).product::<f32>() * 0.5 + 0.5 * (folded[0] + folded[1] * 0.7 - folded[2]).sin()
}

/// Density of the paint, 0 to 1, at an angle around the vase and a height, m.
fn ink(angle: f32, y: f32) -> f32 {
    let is_line =
        [(0.0045, 0.0012), (0.0630, 0.0006), (0.0665, 0.0014), (0.2320, 0.0014), (0.2355, 0.0006), (0.2915, 0.003)]
            .iter()
            .any(|(middle, half)| (y - middle).abs() < *half);
    if is_line {
        return 1.0;
    }
    match y {
        0.0..0.062 => 1.0 - petals(angle, (y - 0.009) / 0.050, 12.0),
        0.062..0.200 => scroll(angle, y),
        0.200..0.231 => petals(angle, (0.231 - y) / 0.031, 18.0),
        _ => petals(angle, (y - 0.239) / 0.046, 10.0),
    }
}

/// Row of `count` pointed petals, outlined and filled; `rise` is 0 at their base and 1 at their tips.
fn petals(angle: f32, rise: f32, count: f32) -> f32 {
    let aside = 2.0 * ((angle / TAU * count).rem_euclid(1.0) - 0.5).abs();
    let half = |rise: f32| if (0.0..1.0).contains(&rise) { 0.92 * (1.0 - rise.powi(3)) } else { 0.0 };
    if aside > half(rise) {
        0.0
    } else if aside > half(rise) - 0.13 || rise > 0.93 {
        1.0
    } else if aside > half(1.25 * rise + 0.02) - 0.22 {
        0.04
    } else {
        0.55 + 0.40 * rise
    }
}

/// Vine with a flower in each bend, and leaves.
fn scroll(angle: f32, y: f32) -> f32 {
    let (phase, radius) = (angle * PERIODS, 0.092);
    let per_m = PERIODS / radius;
    let vine = |phase: f32| [SWING_M * phase.sin(), (SWING_M * per_m * phase.cos()).atan()];
    let bend = ((phase - FRAC_PI_2) / PI).round();
    let middle = FRAC_PI_2 + bend * PI;
    let flower = flower((phase - middle) / per_m, y - VINE_M + 0.22 * SWING_M * middle.sin());
    let [height, slope] = vine(phase);
    let is_stem = (y - VINE_M - height).abs() * slope.cos() < 0.0009;
    let nearest = (phase / (PI / 5.0)).round();
    let is_leaf = [-2.0, -1.0, 0.0, 1.0, 2.0].iter().any(|beside| {
        let own = (nearest + beside) * PI / 5.0;
        let [height, slope] = vine(own);
        let side = if (nearest + beside).rem_euclid(2.0) < 0.5 { 1.0 } else { -1.0 };
        let (sine, cosine) = (slope + 0.85 * side).sin_cos();
        let (dx, dy) = ((phase - own) / per_m, y - VINE_M - height);
        let (along, across) = (dx * cosine + dy * sine - 0.0085, dy * cosine - dx * sine);
        across.abs() < 0.0034 * (1.0 - (along / 0.0085).powi(2)) && across.abs() > 0.0003
    });
    if flower > 0.0 {
        flower
    } else if is_leaf || is_stem {
        0.95
    } else {
        0.0
    }
}

/// Flower of eight petals about (0, 0), m.
fn flower(x: f32, y: f32) -> f32 {
    let (radius, angle) = (x.hypot(y), y.atan2(x));
    let edge = 0.021 + 0.007 * (4.0 * angle).cos().abs();
    let vein = radius * (4.0 * angle).sin().abs() / 4.0;
    let seam = radius * (4.0 * angle).cos().abs() / 4.0;
    match radius {
        _ if radius > edge => 0.0,
        _ if radius > edge - 0.0019 => 1.0,
        0.0..0.0055 => 1.0,
        0.0055..0.0073 => 0.03,
        0.0073..0.0089 => 1.0,
        _ if seam < 0.0006 => 1.0,
        _ if vein < 0.0005 => 0.9,
        _ => 0.60 - 24.0 * (radius - 0.0089),
    }
}
