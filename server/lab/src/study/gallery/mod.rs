//! Gallery of effects: the same impact without and with each effect, side by side.

mod examples;
mod marks;
mod result;

use super::effects::EffectsError;
use crate::picture::{Backdrop, Camera, DrawnMesh, Image, PictureSize, Projection, RenderStyle, draw};
use crate::report::{ReportFigure, Section};
use nalgebra::Vector3;

use examples::EffectExample;
pub use examples::effect_examples;

pub(super) use marks::ball;
pub(super) use result::GalleryResult;
use shatter_fracture::pipeline::{FractureRequest, PreparedObject};

/// Size of one half of a picture.
const SIZE: PictureSize = PictureSize { width: 480, height: 400 };

/// Long lens, which hardly shortens distant objects.
const LENS: Projection = Projection::Perspective { fov_deg: 24.0 };

/// Meshes of one effect, off and on.
pub struct EffectComparison {
    /// Name of the effect.
    pub name: &'static str,
    /// Caption.
    pub caption: &'static str,
    /// Direction from the object to the camera.
    pub from: [f32; 3],
    /// Meshes without and with the effect, m.
    pub meshes: [DrawnMesh; 2],
}

/// Picture of one effect: off on the left, on on the right.
pub struct EffectPicture {
    /// Name of the effect.
    pub name: &'static str,
    /// Caption.
    pub caption: &'static str,
    /// Bytes of a PNG file.
    pub png: Vec<u8>,
}

impl EffectPicture {
    /// Name of the picture's file.
    pub fn file(&self) -> String {
        self.name.replace(": ", "-").replace(' ', "-") + ".png"
    }
}

/// Introduction to the pictures.
const LEAD: &str = "See what each effect does. Left: without it; right: with it. Object, impact and seed are the same.";

/// Draws all pairs; calls `progress` with the name of each.
pub fn shown(progress: &mut dyn FnMut(&str)) -> Result<Vec<EffectPicture>, EffectsError> {
    let draw = |scene: EffectExample| {
        let pair = scene.comparison()?;
        progress(pair.name);
        let png = Image::beside(&pair.meshes.each_ref().map(|mesh| side(mesh, &pair))).png()?;
        Ok(EffectPicture { name: pair.name, caption: pair.caption, png })
    };
    effect_examples().into_iter().map(draw).collect()
}

/// Section of a page with all pictures.
pub fn section(shown: &[EffectPicture]) -> Section {
    let figure = |own: &EffectPicture| ReportFigure {
        png: own.png.clone(),
        caption: format!("{}: {}", own.name, own.caption),
        scale: None,
    };
    Section {
        heading: "Pictures of effects".to_owned(),
        lead: vec![LEAD.to_owned()],
        figures: shown.iter().map(figure).collect(),
        ..Section::default()
    }
}

/// Markdown page with all pictures, for the folder of their files.
pub fn markdown(shown: &[EffectPicture]) -> String {
    let mut text = format!("# Pictures of effects\n\n{LEAD} Drawn by `shatterd study effects`.\n");
    for own in shown {
        text += &format!("\n## {}\n\n{}\n\n![{}]({})\n", own.name, own.caption, own.name, own.file());
    }
    text
}

/// Picture of the fragments of a request, moved apart; PNG.
pub fn portrait(prepared: &PreparedObject, strike: &FractureRequest) -> Result<Vec<u8>, EffectsError> {
    let mesh = GalleryResult::new(prepared, strike)?.mesh(marks::SPREAD);
    let pair = EffectComparison { name: "", caption: "", from: [0.6, 0.5, 1.0], meshes: [mesh, DrawnMesh::default()] };
    Ok(side(&pair.meshes[0], &pair).png()?)
}

/// Draws one half; both halves share a camera fitted to both.
fn side(mesh: &DrawnMesh, pair: &EffectComparison) -> Image {
    let points: Vec<_> = pair.meshes.iter().flat_map(|mesh| mesh.positions.iter().copied()).collect();
    let camera = Camera::fit(&points, Vector3::from(pair.from), LENS, SIZE.width as f32 / SIZE.height as f32);
    let ground = points.iter().fold(f32::INFINITY, |low, point| low.min(point.y));
    draw(mesh, &camera, SIZE, RenderStyle::STUDIO, Some(ground), Backdrop::Clear)
}
