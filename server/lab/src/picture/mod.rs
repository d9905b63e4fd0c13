//! Software renderer: a z-buffered triangle rasterizer with supersampling, two lights, ambient occlusion, soft shadows and color maps,
//! and a camera that fits its scene.
//!
//! A picture takes three steps: color and join [`DrawnMesh`]es, fit a [`Camera`] to them, and [`draw`] an [`Image`]. Light is summed in
//! linear color. The same input gives the same bytes for any number of threads.

mod animation;
mod camera;
mod color;
mod image;
mod light;
mod marker;
mod mesh;
mod occlusion;
mod pieces;
mod raster;
mod render;
mod shadow;

pub use animation::{AnimationFrame, animated_png};
pub use camera::{Camera, Projection};
pub use color::{Color, ENERGY, Ramp, crack_color, fragment_color};
pub use image::{Image, PictureError};
pub use light::{Finish, RenderStyle};
pub use marker::arrow;
pub use mesh::{DrawnCorner, DrawnMesh};
pub use pieces::{CREASE_DEG, Spread, pieces};
pub use render::{Texture, draw, draw_textured};

/// Size of a picture in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureSize {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
}

/// Background of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backdrop {
    /// Transparent, with a translucent ground shadow, so that the color of the page shows through.
    Clear,
    /// Vertical gradient from the top color to the bottom one.
    Gradient(Color, Color),
}

#[cfg(test)]
mod tests;
