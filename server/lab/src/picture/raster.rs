//! Rasterization: the visible triangle at each sample.
//!
//! Based on: J. Pineda, *A parallel algorithm for polygon rasterization* (edge functions), SIGGRAPH 1988.

use super::camera::Camera;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Vertex on the sample grid: x to the right, y down, and nearness (larger is nearer).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RasterVertex {
    pub x: f32,
    pub y: f32,
    pub near: f32,
}

/// Sample grid of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleGrid {
    pub width: usize,
    pub height: usize,
}

impl SampleGrid {
    /// Position of a scene point on the grid.
    pub fn spot(&self, camera: &Camera, point: &Point3<f32>) -> RasterVertex {
        let seen = camera.project(point);
        let half = self.height as f32 / 2.0;
        RasterVertex { x: self.width as f32 / 2.0 + seen.x * half, y: half - seen.y * half, near: seen.near }
    }

    /// Ray through a point of the grid: origin and unit direction.
    pub fn ray(&self, camera: &Camera, x: f32, y: f32) -> (Point3<f32>, Vector3<f32>) {
        let half = self.height as f32 / 2.0;
        camera.ray((x - self.width as f32 / 2.0) / half, (half - y) / half)
    }
}

/// Value for no triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// Number of rows per task.
const BAND_ROWS: usize = 48;

/// Nearest triangle per sample.
pub(super) struct Visible {
    pub width: usize,
    pub triangles: Vec<u32>,
}

/// Fills a `width` × `height` grid with the nearest triangle per sample; of equally near ones the first.
pub(super) fn visible(spots: &[RasterVertex], triangles: &[[u32; 3]], width: usize, height: usize) -> Visible {
    let bands = height.div_ceil(BAND_ROWS);
    let mut bins: Vec<Vec<u32>> = vec![Vec::new(); bands];
    for (t, triangle) in triangles.iter().enumerate() {
        let rows = triangle.map(|vertex| spots[vertex as usize].y);
        let low = rows.iter().copied().fold(f32::INFINITY, f32::min).max(0.0) as usize / BAND_ROWS;
        let high = rows.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        if high >= 0.0 {
            let last = (high as usize / BAND_ROWS).min(bands - 1);
            bins.iter_mut().take(last + 1).skip(low).for_each(|bin| bin.push(t as u32));
        }
    }
    let mut found = vec![NOTHING; width * height];
    found.par_chunks_mut(width * BAND_ROWS).zip(&bins).enumerate().for_each(|(band, (found, bin))| {
        let mut nearest = vec![f32::NEG_INFINITY; found.len()];
        let first_row = band * BAND_ROWS;
        let window = Window { first_row, rows: found.len() / width, width };
        for &t in bin {
            let corners = triangles[t as usize].map(|vertex| spots[vertex as usize]);
            cover(&corners, &window, |sample, near| {
                if near > nearest[sample] {
                    nearest[sample] = near;
                    found[sample] = t;
                }
            });
        }
    });
    Visible { width, triangles: found }
}

/// Nearness of the nearest triangle per sample of a `side` × `side` grid; −∞ without a triangle.
pub(super) fn nearest(spots: &[RasterVertex], triangles: &[[u32; 3]], side: usize) -> Vec<f32> {
    let mut nearest = vec![f32::NEG_INFINITY; side * side];
    let window = Window { first_row: 0, rows: side, width: side };
    for triangle in triangles {
        let corners = triangle.map(|vertex| spots[vertex as usize]);
        cover(&corners, &window, |sample, near| nearest[sample] = nearest[sample].max(near));
    }
    nearest
}

/// Rows of the grid that are being filled.
struct Window {
    first_row: usize,
    rows: usize,
    width: usize,
}

/// Calls `put(sample within the window, nearness)` for each sample whose center the triangle covers, including its border, in either
/// winding order.
fn cover([a, b, c]: &[RasterVertex; 3], window: &Window, mut put: impl FnMut(usize, f32)) {
    let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let span = |low: f32, high: f32, first: usize, count: usize| {
        let begin = (low - 0.5).ceil().max(first as f32) as usize;
        let end = ((high - 0.5).floor() + 1.0).clamp(0.0, (first + count) as f32) as usize;
        begin..end
    };
    let columns = span(a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x), 0, window.width);
    let rows = span(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), window.first_row, window.rows);
    if columns.is_empty() {
        return;
    }
    let inverse = 1.0 / area;
    for row in rows {
        let y = row as f32 + 0.5;
        let line = (row - window.first_row) * window.width;
        for column in columns.clone() {
            let x = column as f32 + 0.5;
            let u = ((c.x - b.x) * (y - b.y) - (c.y - b.y) * (x - b.x)) * inverse;
            let v = ((a.x - c.x) * (y - c.y) - (a.y - c.y) * (x - c.x)) * inverse;
            let w = 1.0 - u - v;
            if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                put(line + column, a.near * u + b.near * v + c.near * w);
            }
        }
    }
}

/// Barycentric weights of (x, y) in a triangle on the grid; not clamped.
pub(super) fn weights([a, b, c]: &[RasterVertex; 3], x: f32, y: f32) -> [f32; 3] {
    let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    let u = ((c.x - b.x) * (y - b.y) - (c.y - b.y) * (x - b.x)) / area;
    let v = ((a.x - c.x) * (y - c.y) - (a.y - c.y) * (x - c.x)) / area;
    [u, v, 1.0 - u - v]
}
