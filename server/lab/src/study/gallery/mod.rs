//! A picture per effect: the same blow without it and with it, side by side.

mod broken;
mod cast;
mod marks;

use super::effects::EffectsError;
use crate::picture::{Backdrop, Camera, Image, Mesh, Projection, Size, Style, draw};
use crate::report::{Figure, Section};
use nalgebra::Vector3;

use cast::Show;
pub use cast::cast;

pub(super) use broken::Broken;
pub(super) use marks::ball;
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

/// A picture of one effect: off on the left, on on the right.
pub struct Shown {
    /// What it is called.
    pub name: &'static str,
    /// What is to be seen.
    pub caption: &'static str,
    /// Bytes of a PNG file.
    pub png: Vec<u8>,
}

impl Shown {
    /// A name for its file.
    pub fn file(&self) -> String {
        self.name.replace(": ", "-").replace(' ', "-") + ".png"
    }
}

/// What stands before all pictures.
const LEAD: &str = "Left without the effect, right with it; the same object, blow and seed.";

/// Draws all pairs; `progress` is told of each.
pub fn shown(progress: &mut dyn FnMut(&str)) -> Result<Vec<Shown>, EffectsError> {
    let draw = |scene: Show| {
        let pair = scene.pair()?;
        progress(pair.name);
        let png = Image::beside(&pair.meshes.each_ref().map(|mesh| side(mesh, &pair))).png()?;
        Ok(Shown { name: pair.name, caption: pair.caption, png })
    };
    cast().into_iter().map(draw).collect()
}

/// All pictures as a part of a page.
pub fn section(shown: &[Shown]) -> Section {
    let figure =
        |own: &Shown| Figure { png: own.png.clone(), caption: format!("{}: {}", own.name, own.caption), scale: None };
    Section {
        heading: "What effects look like".to_owned(),
        lead: vec![LEAD.to_owned()],
        figures: shown.iter().map(figure).collect(),
        ..Section::default()
    }
}

/// All pictures as a page of Markdown that lies beside their files.
pub fn markdown(shown: &[Shown]) -> String {
    let mut text = format!("# What effects look like\n\n{LEAD} Made by `shatterd study effects`.\n");
    for own in shown {
        text += &format!("\n## {}\n\n{}\n\n![{}]({})\n", own.name, own.caption, own.name, own.file());
    }
    text
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
