//! Surface meshes: reading, repair and inside tests.
//!
//! [`read`] reads a mesh file unchanged. [`Surface::repair`] repairs it as far as possible and lists its defects.
//! [`InsideTest`] locates points and measures their distance from the surface. [`shapes`] generates closed meshes.

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
mod solids;
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
pub(crate) use repair::{DisjointSets, crossings, meet, meeting_point};
pub use repair::{ShellPart, Surface};
pub(crate) use solids::Solids;
use triangle_attributes::VertexLists;
pub use triangle_attributes::{NO_MATERIAL, TriangleAttributes, UV_MAX};
pub use width::{Width, WidthSide, Widths};
