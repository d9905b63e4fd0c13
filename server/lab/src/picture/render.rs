//! Rendering of meshes to a picture.

use super::camera::Camera;
use super::color::{Color, encode};
use super::image::Image;
use super::light::{Finish, Lights, RenderStyle};
use super::mesh::DrawnMesh;
use super::occlusion::Occlusion;
use super::raster::{NOTHING, RasterVertex, SampleGrid, Visible, visible, weights};
use super::shadow::Shadow;
use super::{Backdrop, PictureSize};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Samples per side of a pixel.
const FINE: usize = 3;

/// Sky directions per sample; a pixel has `FINE`² times as many.
const SKY_PER_SAMPLE: usize = 8;

/// Key light directions per sample; a pixel has `FINE`² times as many.
const KEY_PER_SAMPLE: usize = 3;

/// Tangent of half the key light's angular size, which determines the softness of shadows.
const KEY_SPREAD: f32 = 0.11;

/// Appearance of a triangle of the mesh, by its number, at a point given by its weights of the corners.
pub type Texture<'a> = &'a (dyn Fn(usize, [f32; 3]) -> Finish + Sync);

/// Draws `mesh` in its own colors and checkerboards as seen by `camera`. `ground` is the height of the plane that receives the shadow, if any.
pub fn draw(
    mesh: &DrawnMesh,
    camera: &Camera,
    size: PictureSize,
    style: RenderStyle,
    ground: Option<f32>,
    backdrop: Backdrop,
) -> Image {
    let own = |triangle: usize, share: [f32; 3]| {
        let corners = &mesh.corners[triangle];
        let color = match mesh.checkers.get(triangle).copied().flatten() {
            Some(checkers) => checker([0, 1].map(|axis| (0..3).map(|c| checkers[c][axis] * share[c]).sum())),
            None => Color([0, 1, 2].map(|k| (0..3).map(|c| corners[c].color.0[k] * share[c]).sum())),
        };
        Finish { color, reflectance: 0.0 }
    };
    draw_textured(mesh, &own, camera, size, style, ground, backdrop)
}

/// Color of a checkerboard of unit fields.
fn checker([x, y]: [f32; 2]) -> Color {
    match (x.floor() + y.floor()).rem_euclid(2.0) > 0.5 {
        true => Color::oklch(0.45, 0.09, 250.0),
        false => Color::oklch(0.93, 0.02, 90.0),
    }
}

/// Draws `mesh` like [`draw`], with `texture` instead of its colors.
pub fn draw_textured(
    mesh: &DrawnMesh,
    texture: Texture<'_>,
    camera: &Camera,
    size: PictureSize,
    style: RenderStyle,
    ground: Option<f32>,
    backdrop: Backdrop,
) -> Image {
    let grid = SampleGrid { width: size.width * FINE, height: size.height * FINE };
    let spots: Vec<RasterVertex> = mesh.positions.iter().map(|position| grid.spot(camera, position)).collect();
    let seen = visible(&spots, &mesh.triangles, grid.width, grid.height);
    let lights = Lights::new(style, camera);
    let occlusion = Occlusion::new(mesh, FINE * FINE, SKY_PER_SAMPLE, KEY_PER_SAMPLE, lights.key, KEY_SPREAD);
    let shadow = ground.map(|height| Shadow::new(grid, camera, &lights, &occlusion, height));
    let scene = Scene { mesh, texture, camera, spots, seen, lights, occlusion, shadow, grid };
    let mut pixels = vec![[0; 4]; size.width * size.height];
    pixels.par_chunks_mut(size.width).enumerate().for_each(|(row, line)| {
        let behind = background(backdrop, row, size.height);
        for (column, pixel) in line.iter_mut().enumerate() {
            *pixel = scene.pixel(column, row, behind);
        }
    });
    Image { size, pixels }
}

/// Background color of row `row`, if there is one.
fn background(backdrop: Backdrop, row: usize, height: usize) -> Option<Color> {
    match backdrop {
        Backdrop::Clear => None,
        Backdrop::Gradient(top, bottom) => Some(top.mix(bottom, (row as f32 + 0.5) / height as f32)),
    }
}

struct Scene<'a> {
    mesh: &'a DrawnMesh,
    texture: Texture<'a>,
    camera: &'a Camera,
    spots: Vec<RasterVertex>,
    seen: Visible,
    lights: Lights,
    occlusion: Occlusion,
    shadow: Option<Shadow>,
    grid: SampleGrid,
}

impl Scene<'_> {
    /// Mean of the pixel's samples: light and coverage; coverage is the alpha of opaque parts.
    fn pixel(&self, column: usize, row: usize, behind: Option<Color>) -> [u8; 4] {
        let mut light = [0.0_f32; 3];
        let mut cover = 0.0;
        for stratum in 0..FINE * FINE {
            let (x, y) = (column * FINE + stratum % FINE, row * FINE + stratum / FINE);
            let (sample, alpha) = self.sample(x, y, stratum);
            light = [0, 1, 2].map(|k| light[k] + sample[k]);
            cover += alpha;
        }
        let count = (FINE * FINE) as f32;
        (light, cover) = (light.map(|x| x / count), cover / count);
        match behind {
            Some(color) => {
                let [r, g, b] = [0, 1, 2].map(|k| encode(light[k] + color.0[k] * (1.0 - cover)));
                [r, g, b, 255]
            }
            None if cover > 0.0 => {
                let [r, g, b] = light.map(|x| encode(x / cover));
                [r, g, b, (cover * 255.0).round() as u8]
            }
            None => [0; 4],
        }
    }

    /// Light of one sample, premultiplied by its alpha, and the alpha.
    fn sample(&self, x: usize, y: usize, stratum: usize) -> ([f32; 3], f32) {
        match self.seen.triangles[y * self.seen.width + x] {
            NOTHING => ([0.0; 3], self.shadow.as_ref().map_or(0.0, |shadow| shadow.at(x, y))),
            triangle => (self.surface(triangle as usize, x, y, stratum), 1.0),
        }
    }

    fn surface(&self, triangle: usize, x: usize, y: usize, stratum: usize) -> [f32; 3] {
        let vertices = self.mesh.triangles[triangle].map(|vertex| vertex as usize);
        let spots = vertices.map(|vertex| self.spots[vertex]);
        let mut share = weights(&spots, x as f32 + 0.5, y as f32 + 0.5);
        if self.camera.is_perspective() {
            share = [0, 1, 2].map(|k| share[k] * spots[k].near);
            let sum: f32 = share.iter().sum();
            share = share.map(|weight| weight / sum);
        }
        let corners = &self.mesh.corners[triangle];
        let places = vertices.map(|vertex| self.mesh.positions[vertex].coords);
        let place = Point3::from(places[0] * share[0] + places[1] * share[1] + places[2] * share[2]);
        let finish = (self.texture)(triangle, share);
        let (_, forward) = self.ray(x, y);
        let flat = (places[1] - places[0]).cross(&(places[2] - places[0]));
        let side = if flat.dot(&forward) > 0.0 { -1.0 } else { 1.0 };
        let mixed: Vector3<f32> = (0..3).map(|c| corners[c].normal * share[c]).sum();
        let normal = mixed.try_normalize(0.0).unwrap_or_else(Vector3::y) * side;
        let (sky, key) = self.occlusion.stratified(&place, &normal, stratum);
        self.lights.shade(finish, &normal, &-forward, sky, key)
    }

    fn ray(&self, x: usize, y: usize) -> (Point3<f32>, Vector3<f32>) {
        self.grid.ray(self.camera, x as f32 + 0.5, y as f32 + 0.5)
    }
}
