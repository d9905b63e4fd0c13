//! Ground shadow of a scene.

use super::camera::Camera;
use super::light::Lights;
use super::occlusion::Occlusion;
use super::raster::SampleGrid;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Distance of shadow samples in samples of the picture; the shadow is soft, so the rest is interpolated.
const STEP: usize = 8;

/// Number of smoothing passes over the sky's part of the shadow, which hide its single directions.
const BLURS: usize = 14;

/// Darkness of the deepest shadow.
const DEEPEST: f32 = 0.62;

/// Width of the border zone over which the shadow fades out, over the picture's height.
const INSET: f32 = 0.14;

/// Shadow over the background, on a coarse grid.
pub(super) struct Shadow {
    columns: usize,
    opacity: Vec<f32>,
}

impl Shadow {
    /// Computes the shadow on the horizontal plane at `height`.
    pub fn new(grid: SampleGrid, camera: &Camera, lights: &Lights, occlusion: &Occlusion, height: f32) -> Self {
        let (columns, rows) = (grid.width.div_ceil(STEP) + 1, grid.height.div_ceil(STEP) + 1);
        let up = Vector3::y();
        let spot = |at: usize| ((at % columns * STEP) as f32, (at / columns * STEP) as f32);
        let light = |at: usize| {
            let (x, y) = spot(at);
            let (origin, forward) = grid.ray(camera, x, y);
            if forward.y >= -1e-3 || origin.y <= height {
                return (1.0, 1.0);
            }
            occlusion.all(&(origin + forward * ((height - origin.y) / forward.y)), &up)
        };
        let (mut sky, key): (Vec<f32>, Vec<f32>) = (0..columns * rows).into_par_iter().map(light).unzip();
        for _ in 0..BLURS {
            sky = blurred(&sky, columns);
        }
        let opacity = |at: usize| {
            let (x, y) = spot(at);
            DEEPEST * lights.ground_shadow(sky[at], key[at]) * inset(grid, x, y)
        };
        Self { columns, opacity: (0..columns * rows).map(opacity).collect() }
    }

    /// Share of the background that the shadow removes at a sample.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        let first = y / STEP * self.columns + x / STEP;
        let (right, down) = ((x % STEP) as f32 / STEP as f32, (y % STEP) as f32 / STEP as f32);
        let mix = |left: usize| self.opacity[left] * (1.0 - right) + self.opacity[left + 1] * right;
        mix(first) * (1.0 - down) + mix(first + self.columns) * down
    }
}

/// Means over neighbors with weights ¼, ½, ¼, along rows and then along columns; border values repeat.
fn blurred(values: &[f32], columns: usize) -> Vec<f32> {
    let rows = values.len() / columns;
    let pass = |values: &[f32], across: usize, down: usize| -> Vec<f32> {
        let at = |x: usize, y: usize| values[y.min(rows - 1) * columns + x.min(columns - 1)];
        let mean = |k: usize| {
            let (x, y) = (k % columns, k / columns);
            let before = at(x.saturating_sub(across), y.saturating_sub(down));
            0.25 * before + 0.5 * at(x, y) + 0.25 * at(x + across, y + down)
        };
        (0..values.len()).map(mean).collect()
    };
    pass(&pass(values, 1, 0), 0, 1)
}

/// Fade: 0 at the border of the picture, 1 from a small distance inside.
fn inset(grid: SampleGrid, x: f32, y: f32) -> f32 {
    let (width, height) = (grid.width as f32, grid.height as f32);
    let border = x.min(width - x).min(y).min(height - y) / height;
    let share = (border / INSET).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
