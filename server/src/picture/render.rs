//! From meshes to a picture.

use super::camera::Camera;
use super::colour::{Colour, encode};
use super::image::Image;
use super::light::{Lights, Style};
use super::mesh::Mesh;
use super::occlusion::Occlusion;
use super::raster::{NOTHING, Spot, Visible, visible, weights};
use super::{Backdrop, Size};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Samples per side of a pixel.
const FINE: usize = 3;

/// Directions into the sky per sample; a pixel has `FINE`² times as many.
const SKY_PER_SAMPLE: usize = 7;

/// Tangent of half the key light's angle: how soft shadows are.
const KEY_SPREAD: f32 = 0.11;

/// How dark the deepest shadow on the ground is.
const GROUND_SHADOW: f32 = 0.62;

/// The part of the picture's height, from the border, over which shadows on the ground fade.
const SHADOW_INSET: f32 = 0.14;

/// Draws `mesh` as `camera` sees it. `ground` is the height of the plane that takes the shadow, if any.
pub fn draw(mesh: &Mesh, camera: &Camera, size: Size, style: Style, ground: Option<f32>, backdrop: Backdrop) -> Image {
    let (width, height) = (size.width * FINE, size.height * FINE);
    let half = height as f32 / 2.0;
    let spots: Vec<Spot> = mesh
        .positions
        .iter()
        .map(|position| {
            let seen = camera.project(position);
            Spot { x: width as f32 / 2.0 + seen.x * half, y: half - seen.y * half, near: seen.near }
        })
        .collect();
    let seen = visible(&spots, &mesh.triangles, width, height);
    let lights = Lights::new(style, camera);
    let occlusion = Occlusion::new(mesh, FINE * FINE, SKY_PER_SAMPLE, lights.key, KEY_SPREAD);
    let scene = Scene { mesh, camera, spots, seen, lights, occlusion, ground, half };
    let mut pixels = vec![[0; 4]; size.width * size.height];
    pixels.par_chunks_mut(size.width).enumerate().for_each(|(row, line)| {
        let behind = background(backdrop, row, size.height);
        for (column, pixel) in line.iter_mut().enumerate() {
            *pixel = scene.pixel(column, row, behind);
        }
    });
    Image { size, pixels }
}

/// The colour behind row `row`, if there is one.
fn background(backdrop: Backdrop, row: usize, height: usize) -> Option<Colour> {
    match backdrop {
        Backdrop::Clear => None,
        Backdrop::Gradient(top, bottom) => Some(top.mix(bottom, (row as f32 + 0.5) / height as f32)),
    }
}

struct Scene<'a> {
    mesh: &'a Mesh,
    camera: &'a Camera,
    spots: Vec<Spot>,
    seen: Visible,
    lights: Lights,
    occlusion: Occlusion,
    ground: Option<f32>,
    /// Half the height of the sample grid.
    half: f32,
}

impl Scene<'_> {
    /// Mean of the pixel's samples: light and cover, the latter the alpha of what is not seen through.
    fn pixel(&self, column: usize, row: usize, behind: Option<Colour>) -> [u8; 4] {
        let mut light = [0.0_f32; 3];
        let mut cover = 0.0;
        for deal in 0..FINE * FINE {
            let (x, y) = (column * FINE + deal % FINE, row * FINE + deal / FINE);
            let (sample, alpha) = self.sample(x, y, deal);
            light = [0, 1, 2].map(|k| light[k] + sample[k]);
            cover += alpha;
        }
        let count = (FINE * FINE) as f32;
        (light, cover) = (light.map(|x| x / count), cover / count);
        match behind {
            Some(colour) => {
                let [r, g, b] = [0, 1, 2].map(|k| encode(light[k] + colour.0[k] * (1.0 - cover)));
                [r, g, b, 255]
            }
            None if cover > 0.0 => {
                let [r, g, b] = light.map(|x| encode(x / cover));
                [r, g, b, (cover * 255.0).round() as u8]
            }
            None => [0; 4],
        }
    }

    /// Light of one sample, already multiplied by its alpha, and the alpha.
    fn sample(&self, x: usize, y: usize, deal: usize) -> ([f32; 3], f32) {
        match self.seen.triangles[y * self.seen.width + x] {
            NOTHING => ([0.0; 3], self.shadow(x, y, deal)),
            triangle => (self.surface(triangle as usize, x, y, deal), 1.0),
        }
    }

    fn surface(&self, triangle: usize, x: usize, y: usize, deal: usize) -> [f32; 3] {
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
        let colour = Colour([0, 1, 2].map(|k| (0..3).map(|c| corners[c].colour.0[k] * share[c]).sum()));
        let (_, forward) = self.ray(x, y);
        let flat = (places[1] - places[0]).cross(&(places[2] - places[0]));
        let side = if flat.dot(&forward) > 0.0 { -1.0 } else { 1.0 };
        let mixed: Vector3<f32> = (0..3).map(|c| corners[c].normal * share[c]).sum();
        let normal = mixed.try_normalize(0.0).unwrap_or_else(Vector3::y) * side;
        let sky = self.occlusion.sky(&place, &normal, deal);
        let key = self.occlusion.key(&place, &normal, deal);
        self.lights.shade(colour, &normal, &-forward, sky, key)
    }

    /// How much of the background the shadow on the ground takes away.
    fn shadow(&self, x: usize, y: usize, deal: usize) -> f32 {
        let Some(height) = self.ground else { return 0.0 };
        let (origin, forward) = self.ray(x, y);
        if forward.y >= -1e-3 || origin.y <= height {
            return 0.0;
        }
        let place = origin + forward * ((height - origin.y) / forward.y);
        let up = Vector3::y();
        let (sky, key) = (self.occlusion.sky(&place, &up, deal), self.occlusion.key(&place, &up, deal));
        GROUND_SHADOW * self.lights.ground_shadow(sky, key) * self.inset(x, y)
    }

    /// 0 at the border of the picture, 1 from a little inside on: shadows end before the picture does.
    fn inset(&self, x: usize, y: usize) -> f32 {
        let (width, height) = (self.seen.width as f32, 2.0 * self.half);
        let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
        let border = x.min(width - x).min(y).min(height - y) / height;
        let share = (border / SHADOW_INSET).min(1.0);
        share * share * (3.0 - 2.0 * share)
    }

    fn ray(&self, x: usize, y: usize) -> (Point3<f32>, Vector3<f32>) {
        let middle = self.seen.width as f32 / 2.0;
        self.camera.ray((x as f32 + 0.5 - middle) / self.half, (self.half - y as f32 - 0.5) / self.half)
    }
}
