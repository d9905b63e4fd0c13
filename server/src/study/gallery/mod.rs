//! A picture per effect: the same blow without it and with it, side by side.

mod broken;
mod cast;
mod marks;

use super::effects::EffectsError;
use crate::picture::{Backdrop, Camera, Image, Mesh, Projection, Size, Style, draw};
use crate::report::{Figure, Section};
use nalgebra::Vector3;

pub use cast::cast;

use broken::Broken;
use shatter_fracture::pipeline::{Prepared, Strike};

/// One half of a picture.
const SIZE: Size = Size { width: 480, height: 400 };

/// Long lens: things far apart keep their sizes.
const LENS: Projection = Projection::Perspective { fov_deg: 24.0 };

/// One effect, off and on.
pub struct Pair {
    /// What it is called.
    pub name: &'static str,
    /// What is to be seen.
    pub caption: &'static str,
    /// Where the camera is, seen from the object.
    pub from: [f32; 3],
    /// Without it, and with it; metres.
    pub meshes: [Mesh; 2],
}

/// Draws all pairs; `progress` is told of each.
pub fn section(progress: &mut dyn FnMut(&str)) -> Result<Section, EffectsError> {
    let mut figures = Vec::new();
    for scene in cast() {
        let pair = scene.pair()?;
        progress(pair.name);
        let png = Image::beside(&pair.meshes.each_ref().map(|mesh| side(mesh, &pair))).png()?;
        figures.push(Figure { png, caption: format!("{}: {}", pair.name, pair.caption), scale: None });
    }
    Ok(Section {
        heading: "What effects look like".to_owned(),
        lead: vec!["Left without the effect, right with it; the same object, blow and seed.".to_owned()],
        figures,
        ..Section::default()
    })
}

/// The pieces of a strike, moved apart: bytes of a PNG file.
pub fn portrait(prepared: &Prepared, strike: &Strike) -> Result<Vec<u8>, EffectsError> {
    let mesh = Broken::new(prepared, strike)?.mesh(marks::SPREAD);
    let pair = Pair { name: "", caption: "", from: [0.6, 0.5, 1.0], meshes: [mesh, Mesh::default()] };
    Ok(side(&pair.meshes[0], &pair).png()?)
}

/// Both halves are seen by the same camera, fitted to both.
fn side(mesh: &Mesh, pair: &Pair) -> Image {
    let points: Vec<_> = pair.meshes.iter().flat_map(|mesh| mesh.positions.iter().copied()).collect();
    let camera = Camera::fit(&points, Vector3::from(pair.from), LENS, SIZE.width as f32 / SIZE.height as f32);
    let ground = points.iter().fold(f32::INFINITY, |low, point| low.min(point.y));
    draw(mesh, &camera, SIZE, Style::STUDIO, Some(ground), Backdrop::Clear)
}
