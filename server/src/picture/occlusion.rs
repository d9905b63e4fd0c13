//! How much of the sky and of a light a point sees: depth maps from many directions, looked up per sample.
//!
//! Based on: L. Williams, *Casting curved shadows on curved surfaces* (depth maps), 1978; W. Reeves, D. Salesin, R. Cook,
//! *Rendering antialiased shadows with depth maps* (filtered comparison), 1987. Samples of one pixel look along
//! different directions, so that a pixel's mean covers all of them.

use super::mesh::Mesh;
use super::raster::{Spot, nearest};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Samples per side of a depth map.
const SIDE: usize = 384;

/// A depth map: the scene seen from far away in one direction.
pub(super) struct DepthMap {
    /// Unit vector towards the light.
    pub towards: Vector3<f32>,
    across: Vector3<f32>,
    along: Vector3<f32>,
    centre: Point3<f32>,
    /// Samples per unit of length.
    scale: f32,
    nearest: Vec<f32>,
}

impl DepthMap {
    fn new(mesh: &Mesh, centre: Point3<f32>, radius: f32, towards: Vector3<f32>) -> Self {
        let aside = if towards.y.abs() > 0.9 { Vector3::x() } else { Vector3::y() };
        let across = aside.cross(&towards).normalize();
        let along = towards.cross(&across);
        let scale = (SIDE as f32 - 4.0) / (2.0 * radius);
        let mut map = Self { towards, across, along, centre, scale, nearest: Vec::new() };
        let spots: Vec<Spot> = mesh.positions.iter().map(|position| map.spot(position)).collect();
        map.nearest = nearest(&spots, &mesh.triangles, SIDE);
        map
    }

    fn spot(&self, point: &Point3<f32>) -> Spot {
        let offset = point - self.centre;
        let middle = SIDE as f32 / 2.0;
        Spot {
            x: middle + offset.dot(&self.across) * self.scale,
            y: middle + offset.dot(&self.along) * self.scale,
            near: offset.dot(&self.towards),
        }
    }

    /// The part of the light that reaches `point`, the comparison filtered over four samples; `slack` is how much
    /// nearer something must be to count as in between.
    fn lit(&self, point: &Point3<f32>, slack: f32) -> f32 {
        let spot = self.spot(point);
        let (x, y) = (spot.x - 0.5, spot.y - 0.5);
        if !(x >= 0.0 && y >= 0.0 && x < SIDE as f32 - 1.0 && y < SIDE as f32 - 1.0) {
            return 1.0;
        }
        let (column, row) = (x as usize, y as usize);
        let (right, down) = (x - column as f32, y - row as f32);
        let free = |dx: usize, dy: usize| {
            let between = self.nearest[(row + dy) * SIDE + column + dx] > spot.near + slack;
            if between { 0.0 } else { 1.0 }
        };
        let upper = free(0, 0) * (1.0 - right) + free(1, 0) * right;
        let lower = free(0, 1) * (1.0 - right) + free(1, 1) * right;
        upper * (1.0 - down) + lower * down
    }
}

/// Depth maps over the whole sphere and around one light, dealt out over `deals` kinds of samples.
pub(super) struct Occlusion {
    sky: Vec<DepthMap>,
    key: Vec<DepthMap>,
    deals: usize,
    /// Width of one sample of a map.
    texel: f32,
}

impl Occlusion {
    /// `deals` · `sky_per_deal` directions over the sphere and `deals` ones within `spread` (tangent) of `key`.
    pub fn new(mesh: &Mesh, deals: usize, sky_per_deal: usize, key: Vector3<f32>, spread: f32) -> Self {
        let (low, high) = mesh.bounds();
        let centre = nalgebra::center(&low, &high);
        let radius = mesh.positions.iter().map(|p| (p - centre).norm()).fold(f32::MIN_POSITIVE, f32::max);
        let map = |towards| DepthMap::new(mesh, centre, radius, towards);
        let sky = sphere(deals * sky_per_deal).into_par_iter().map(map).collect();
        let key = cone(key, spread, deals).into_par_iter().map(map).collect();
        Self { sky, key, deals, texel: 2.0 * radius / SIDE as f32 }
    }

    /// The part of the sky's light, weighted by the cosine to `normal`, that reaches `point`; sample kind `deal`.
    pub fn sky(&self, point: &Point3<f32>, normal: &Vector3<f32>, deal: usize) -> f32 {
        let lifted = point + normal * (1.5 * self.texel);
        let (mut seen, mut whole) = (0.0, 0.0);
        for map in self.sky.iter().skip(deal % self.deals).step_by(self.deals) {
            let cosine = map.towards.dot(normal);
            if cosine > 0.0 {
                whole += cosine;
                seen += cosine * map.lit(&lifted, self.texel);
            }
        }
        if whole > 0.0 { seen / whole } else { 1.0 }
    }

    /// The part of the key light that reaches `point`; sample kind `deal`.
    pub fn key(&self, point: &Point3<f32>, normal: &Vector3<f32>, deal: usize) -> f32 {
        let map = &self.key[deal % self.deals];
        map.lit(&(point + normal * (1.5 * self.texel)), self.texel)
    }
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

/// `count` directions evenly over the cone around `axis` whose half-angle has the tangent `spread`.
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
