//! Ambient occlusion and shadows: depth maps from many directions, looked up per sample.
//!
//! Based on: L. Williams, *Casting curved shadows on curved surfaces* (depth maps), 1978; W. Reeves, D. Salesin, R. Cook,
//! *Rendering antialiased shadows with depth maps* (filtered comparison), 1987. The samples of a pixel use different directions, so that
//! the pixel's mean covers all of them.

use super::mesh::DrawnMesh;
use super::raster::{RasterVertex, nearest};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Samples per side of a depth map of the sky, whose light is soft.
const SKY_SIDE: usize = 192;

/// Samples per side of a depth map of the key light.
const KEY_SIDE: usize = 384;

/// Offset of a point from its surface before the look-up, in samples of the map.
const LIFT: f32 = 1.5;

/// Depth map: the scene as seen from far away in one direction.
pub(super) struct DepthMap {
    /// Unit vector towards the light.
    pub towards: Vector3<f32>,
    across: Vector3<f32>,
    along: Vector3<f32>,
    center: Point3<f32>,
    /// Samples per unit of length.
    scale: f32,
    side: usize,
    nearest: Vec<f32>,
}

impl DepthMap {
    fn new(mesh: &DrawnMesh, (center, radius): (Point3<f32>, f32), side: usize, towards: Vector3<f32>) -> Self {
        let aside = if towards.y.abs() > 0.9 { Vector3::x() } else { Vector3::y() };
        let across = aside.cross(&towards).normalize();
        let along = towards.cross(&across);
        let scale = (side as f32 - 4.0) / (2.0 * radius);
        let mut map = Self { towards, across, along, center, scale, side, nearest: Vec::new() };
        let spots: Vec<RasterVertex> = mesh.positions.iter().map(|position| map.spot(position)).collect();
        map.nearest = nearest(&spots, &mesh.triangles, side);
        map
    }

    fn spot(&self, point: &Point3<f32>) -> RasterVertex {
        let offset = point - self.center;
        let middle = self.side as f32 / 2.0;
        RasterVertex {
            x: middle + offset.dot(&self.across) * self.scale,
            y: middle + offset.dot(&self.along) * self.scale,
            near: offset.dot(&self.towards),
        }
    }

    /// Share of the light that reaches a surface at `point`, with the comparison filtered over four samples. The point is moved off its
    /// surface, and an occluder must be nearer by at least the width of a sample.
    fn lit(&self, point: &Point3<f32>, normal: &Vector3<f32>) -> f32 {
        let slack = 1.0 / self.scale;
        let spot = self.spot(&(point + normal * (LIFT * slack)));
        let (x, y) = (spot.x - 0.5, spot.y - 0.5);
        let last = self.side as f32 - 1.0;
        if !(x >= 0.0 && y >= 0.0 && x < last && y < last) {
            return 1.0;
        }
        let (column, row) = (x as usize, y as usize);
        let (right, down) = (x - column as f32, y - row as f32);
        let free = |dx: usize, dy: usize| {
            let between = self.nearest[(row + dy) * self.side + column + dx] > spot.near + slack;
            if between { 0.0 } else { 1.0 }
        };
        let upper = free(0, 0) * (1.0 - right) + free(1, 0) * right;
        let lower = free(0, 1) * (1.0 - right) + free(1, 1) * right;
        upper * (1.0 - down) + lower * down
    }
}

/// Depth maps over the whole sphere and around one light, distributed over `strata_count` groups of samples.
pub(super) struct Occlusion {
    sky: Vec<DepthMap>,
    key: Vec<DepthMap>,
    strata_count: usize,
}

impl Occlusion {
    /// Creates, per group of samples, `sky` directions over the sphere and `key` directions within `spread` (tangent) of `towards`.
    pub fn new(
        mesh: &DrawnMesh,
        strata_count: usize,
        sky: usize,
        key: usize,
        towards: Vector3<f32>,
        spread: f32,
    ) -> Self {
        let (low, high) = mesh.bounds();
        let center = nalgebra::center(&low, &high);
        let radius = mesh.positions.iter().map(|p| (p - center).norm()).fold(f32::MIN_POSITIVE, f32::max);
        let map = |side| move |towards| DepthMap::new(mesh, (center, radius), side, towards);
        let sky = sphere(strata_count * sky).into_par_iter().map(map(SKY_SIDE)).collect();
        let key = cone(towards, spread, strata_count * key).into_par_iter().map(map(KEY_SIDE)).collect();
        Self { sky, key, strata_count }
    }

    /// Shares of sky light and key light that reach a surface at `point`, by the directions of group `stratum`.
    pub fn stratified(&self, point: &Point3<f32>, normal: &Vector3<f32>, stratum: usize) -> (f32, f32) {
        let stratified = |maps| <[DepthMap]>::iter(maps).skip(stratum).step_by(self.strata_count);
        (sky(stratified(&self.sky), point, normal), key(stratified(&self.key), point, normal))
    }

    /// The same shares by all directions.
    pub fn all(&self, point: &Point3<f32>, normal: &Vector3<f32>) -> (f32, f32) {
        (sky(self.sky.iter(), point, normal), key(self.key.iter(), point, normal))
    }
}

/// Sky light weighted by the cosine to `normal`.
fn sky<'a>(maps: impl Iterator<Item = &'a DepthMap>, point: &Point3<f32>, normal: &Vector3<f32>) -> f32 {
    let (mut seen, mut whole) = (0.0, 0.0);
    for map in maps {
        let cosine = map.towards.dot(normal);
        if cosine > 0.0 {
            whole += cosine;
            seen += cosine * map.lit(point, normal);
        }
    }
    if whole > 0.0 { seen / whole } else { 1.0 }
}

fn key<'a>(maps: impl Iterator<Item = &'a DepthMap>, point: &Point3<f32>, normal: &Vector3<f32>) -> f32 {
    let (sum, count) = maps.fold((0.0, 0.0), |(sum, count), map| (sum + map.lit(point, normal), count + 1.0));
    sum / count
}

/// Nearly even directions over the sphere: a spiral with the golden angle (Vogel 1979, on the sphere).
fn sphere(count: usize) -> Vec<Vector3<f32>> {
    let turn = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    (0..count)
        .map(|k| {
            let y = 1.0 - (2 * k + 1) as f32 / count as f32;
            let (sin, cos) = (turn * k as f32).sin_cos();
            let ring = (1.0 - y * y).sqrt();
            Vector3::new(ring * cos, y, ring * sin)
        })
        .collect()
}

/// `count` directions distributed evenly over the cone around `axis` whose half-angle has the tangent `spread`.
fn cone(axis: Vector3<f32>, spread: f32, count: usize) -> Vec<Vector3<f32>> {
    let aside = if axis.y.abs() > 0.9 { Vector3::x() } else { Vector3::y() };
    let (across, turn) = (aside.cross(&axis).normalize(), std::f32::consts::PI * (3.0 - 5.0_f32.sqrt()));
    let along = axis.cross(&across);
    (0..count)
        .map(|k| {
            let radius = spread * ((k as f32 + 0.5) / count as f32).sqrt();
            let (sin, cos) = (turn * k as f32).sin_cos();
            (axis + (across * cos + along * sin) * radius).normalize()
        })
        .collect()
}
