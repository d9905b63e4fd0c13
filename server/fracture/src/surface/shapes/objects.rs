//! Generated objects for fracture.

use super::RawMesh;
use super::implicit::implicit;
use super::sweep::{lathe, tube};
use nalgebra::{Point3, Vector2, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Mug with a handle along +x, 0.1 m high and 0.08 m wide, with a wall of 9 mm.
///
/// It has about 70,000 triangles and genus 1. Its rims are rounded, because lattices follow smooth
/// surfaces better than sharp edges.
pub fn mug() -> RawMesh {
    implicit(Point3::new(-0.0443, -0.0042, -0.0443), Point3::new(0.0793, 0.1043, 0.0443), 0.0019, mug_height)
}

/// Implicit function of the mug, negative inside: wall and bottom thickened about their
/// profiles, ring-shaped handle, hollow.
fn mug_height(p: &Point3<f64>) -> f64 {
    let profile = Point3::new(p.x.hypot(p.z), p.y, 0.0);
    let wall = capsule(&profile, [0.0355, 0.0055, 0.0], [0.0355, 0.0955, 0.0], 0.0045, 0.0045);
    let bottom = capsule(&profile, [0.0, 0.0055, 0.0], [0.0345, 0.0055, 0.0], 0.0055, 0.0055);
    let ring = Vector2::new(p.x - 0.040, p.y - 0.051).norm() - 0.0265;
    let handle = Vector2::new(ring, 0.9 * p.z).norm() - 0.0062;
    let hollow = -blend(0.031 - profile.x, profile.y - 0.011, 0.008);
    blend(blend(wall, bottom, 0.006), handle, 0.007).max(-hollow)
}

/// Vase, 0.3 m high, with a wall of 6 mm.
pub fn vase() -> RawMesh {
    let radius = |t: f64| 0.060 + 0.028 * (TAU * (0.85 * t + 0.1)).sin();
    let (height, wall, base, steps) = (0.3, 0.006, 0.012, 60);
    let mut profile = vec![[0.0, 0.0], [0.5 * radius(0.0), 0.0]];
    let rise = |k: u32| f64::from(k) / f64::from(steps);
    profile.extend((0..=steps).map(|k| [radius(rise(k)), height * rise(k)]));
    let lowest = base / height;
    let fall = |k: u32| 1.0 - (1.0 - lowest) * rise(k);
    profile.extend((0..=steps).map(|k| [radius(fall(k)) - wall, height * fall(k)]));
    profile.extend([[0.5 * (radius(lowest) - wall), base], [0.0, base]]);
    lathe(&profile, 96)
}

/// Stone arch: a rectangular section of 0.2 × 0.3 m along two legs and a half circle of radius 0.5 m between them.
pub fn arch() -> RawMesh {
    let mut path = Vec::new();
    let (radius, leg, steps) = (0.5, 0.4, 8);
    path.extend((0..steps).map(|k| ([radius, leg * f64::from(k) / f64::from(steps)], 0.0)));
    path.extend(
        (0..=32)
            .map(|k| PI * f64::from(k) / 32.0)
            .map(|angle| ([radius * angle.cos(), leg + radius * angle.sin()], angle)),
    );
    path.extend((1..=steps).map(|k| ([-radius, leg * (1.0 - f64::from(k) / f64::from(steps))], PI)));
    let mut section = Vec::new();
    let sides =
        [([1.0, -1.0], [0.0, 1.0]), ([1.0, 1.0], [-1.0, 0.0]), ([-1.0, 1.0], [0.0, -1.0]), ([-1.0, -1.0], [1.0, 0.0])];
    for (start, step) in sides {
        let along = (0..6).map(|k| f64::from(k) / 3.0);
        section.extend(along.map(|s| [0.1 * (start[0] + s * step[0]), 0.15 * (start[1] + s * step[1])]));
    }
    swept(&path, &section)
}

/// Horseshoe of round bar, 20 mm thick, open at the bottom. Its two tips face each other across a gap.
pub fn horseshoe() -> RawMesh {
    let steps = 96;
    let angle = |k: u32| -FRAC_PI_2 + 0.4 + (TAU - 0.8) * f64::from(k) / f64::from(steps);
    let path: Vec<_> =
        (0..=steps).map(angle).map(|a| ([0.06 * a.cos(), 0.07 * a.sin()], heading(a, 0.06, 0.07))).collect();
    let section: Vec<_> =
        (0..24).map(|k| TAU * f64::from(k) / 24.0).map(|a| [0.01 * a.cos(), 0.01 * a.sin()]).collect();
    swept(&path, &section)
}

/// Direction of an ellipse's tangent at parameter `angle`, less a quarter turn.
fn heading(angle: f64, a: f64, b: f64) -> f64 {
    (b * angle.cos()).atan2(-a * angle.sin()) - FRAC_PI_2
}

/// Dumbbell: two balls of radius 0.1 m, 0.3 m apart, joined by a neck of radius 15 mm, where it must break.
pub fn dumbbell() -> RawMesh {
    let (ball, half, neck) = (0.1, 0.15, 0.015_f64);
    let meet = (neck / ball).asin();
    let arc = |k: u32, count: u32| (PI - meet) * f64::from(k) / f64::from(count);
    let mut profile: Vec<[f64; 2]> =
        (0..=40).map(|k| arc(k, 40)).map(|a| [ball * a.sin(), -half - ball * a.cos()]).collect();
    let end = half - ball * meet.cos();
    profile.extend((1..12).map(|k| [neck, -end + 2.0 * end * f64::from(k) / 12.0]));
    profile.extend((0..=40).map(|k| arc(40 - k, 40)).map(|a| [ball * a.sin(), half + ball * a.cos()]));
    lathe(&profile, 64)
}

/// Four-legged animal, 0.5 m long, of blended capsules, with legs well apart; about 54,000 triangles.
pub fn statue() -> RawMesh {
    statue_on(0.0075)
}

/// The animal of [`statue`] with about 100,000 triangles, as from a scan.
pub fn scanned_statue() -> RawMesh {
    statue_on(0.00552)
}

/// The animal of [`statue`], meshed on cubes of side `spacing_m`, m. Smaller cubes yield more triangles.
pub fn statue_on(spacing_m: f64) -> RawMesh {
    // Start, end (m, x forward), and radii at both ends.
    let bones: [([f64; 3], [f64; 3], f64, f64); 9] = [
        ([-0.14, 0.30, 0.0], [0.12, 0.31, 0.0], 0.062, 0.068),
        ([0.13, 0.32, 0.0], [0.22, 0.43, 0.0], 0.045, 0.034),
        ([0.21, 0.44, 0.0], [0.30, 0.40, 0.0], 0.036, 0.022),
        ([0.12, 0.28, 0.042], [0.13, 0.025, 0.046], 0.030, 0.019),
        ([0.12, 0.28, -0.042], [0.11, 0.025, -0.046], 0.030, 0.019),
        ([-0.14, 0.28, 0.042], [-0.15, 0.025, 0.046], 0.034, 0.019),
        ([-0.14, 0.28, -0.042], [-0.13, 0.025, -0.046], 0.034, 0.019),
        ([-0.18, 0.33, 0.0], [-0.24, 0.20, 0.0], 0.018, 0.012),
        ([0.205, 0.455, 0.0], [0.200, 0.490, 0.0], 0.020, 0.010),
    ];
    let height = |p: &Point3<f64>| {
        let distance = |&(from, to, start, end): &(_, _, f64, f64)| capsule(p, from, to, start, end);
        bones.iter().map(distance).fold(1.0, |all, bone| blend(all, bone, 0.016)).max(0.008 - p.y)
    };
    implicit(Point3::new(-0.2703, -0.0042, -0.0843), Point3::new(0.3393, 0.5203, 0.0843), spacing_m, height)
}

/// Distance from a capsule whose radius changes linearly along its axis; negative inside.
pub(super) fn capsule(p: &Point3<f64>, from: [f64; 3], to: [f64; 3], start: f64, end: f64) -> f64 {
    let (from, to) = (Point3::from(from), Point3::from(to));
    let axis: Vector3<f64> = to - from;
    let share = ((p - from).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
    (p - (from + axis * share)).norm() - (start + (end - start) * share)
}

/// Smaller of two heights, rounded where they differ by less than `width` (I. Quilez's polynomial minimum).
pub(super) fn blend(a: f64, b: f64, width: f64) -> f64 {
    let overlap = (width - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * width)
}

/// Sweeps a section (outward, along z) along a path in the plane z = 0.
///
/// The path is given by points and by the angle of the outward direction; it runs to the left of that direction.
fn swept(path: &[([f64; 2], f64)], section: &[[f64; 2]]) -> RawMesh {
    let ring = |&([x, y], angle): &([f64; 2], f64)| {
        let (sine, cosine) = angle.sin_cos();
        section.iter().rev().map(|&[out, side]| Point3::new(x + out * cosine, y + out * sine, side)).collect()
    };
    tube(&path.iter().map(ring).collect::<Vec<Vec<_>>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mug_has_a_cavity_and_a_handle_hole() {
        let solid = |x: f64, y: f64| mug_height(&Point3::new(x, y, 0.0)) < 0.0;
        assert!(!solid(0.0, 0.05) && !solid(0.028, 0.09), "hollow inside");
        assert!(solid(0.0, 0.005) && solid(-0.0355, 0.05), "bottom and wall");
        assert!(solid(0.0665, 0.051) && !solid(0.05, 0.051), "a handle with a hole");
        let mesh = mug();
        assert_eq!(mesh.positions_m.len() * 2, mesh.triangles.len(), "closed and of genus 1");
    }
}
