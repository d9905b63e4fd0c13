//! Pictures without a graphics card: a z-buffered triangle rasteriser with supersampling, two lights, ambient occlusion
//! and soft shadows, color maps, and a camera that fits what it looks at.
//!
//! A picture is drawn in three steps: [`DrawnMesh`]es are painted and put together, a [`Camera`] is fitted to them, and
//! [`draw`] returns an [`Image`]. Light is added up in linear color; the same input gives the same bytes for any number
//! of threads.

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

pub use camera::{Camera, Projection};
pub use color::{Color, ENERGY, Ramp, crack_color, fragment_color};
pub use image::{Image, PictureError};
pub use light::RenderStyle;
pub use marker::arrow;
pub use mesh::{DrawnCorner, DrawnMesh};
pub use pieces::{CREASE_DEG, Spread, pieces};
pub use render::draw;

/// Size of a picture in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureSize {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
}

/// What lies behind the meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backdrop {
    /// Nothing: transparent, with the shadow on the ground as a veil, so that the page's own color shows.
    Clear,
    /// A vertical gradient, from the top color to the bottom one.
    Gradient(Color, Color),
}

#[cfg(test)]
mod tests;
