//! From a mesh file to a surface with an inside.
//!
//! [`read`] takes the file as it is, [`Surface::repair`] mends what can be mended and names what was wrong, [`InsideTest`]
//! answers where a point lies and how far from the surface. [`shapes`] generates closed meshes.

mod closest;
mod crack_sheets;
mod defect;
mod error;
mod frame;
mod inside;
mod nearest;
mod open_edges;
mod raw;
mod read;
mod repair;
mod shape;
pub mod shapes;
mod tree;
mod triangle_attributes;
mod volume;
mod width;
mod winding;

#[cfg(test)]
mod tests;

pub use crack_sheets::CrackSheets;
pub use defect::{Defect, DefectKind};
pub use error::SurfaceError;
pub(crate) use frame::DIAGONAL_RANGE_M;
pub use frame::LocalFrame;
pub use inside::InsideTest;
pub(crate) use nearest::barycentric;
pub use nearest::{NearestPoints, NearestTriangles};
pub use raw::{DOUBLE, LengthUnit, RawMesh, SINGLE, UnknownUnit, UnknownUpAxis, UpAxis};
pub use read::{read, read_painted};
pub use repair::{ShellPart, Surface};
pub(crate) use repair::{crossings, meet};
pub use triangle_attributes::{NO_MATERIAL, TriangleAttributes, UV_MAX};
pub use width::{Width, WidthSide, Widths};
