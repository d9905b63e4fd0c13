//! Mesh files: OBJ, PLY, STL, glTF and GLB.

mod accessor;
mod gltf;
mod obj;
mod obj_looks;
mod painted;
mod ply;
mod ply_ascii;
mod polygon;
mod stl;
#[cfg(test)]
mod tests;

pub use painted::read_painted;

use super::{LengthUnit, RawMesh, SurfaceError, UpAxis};
use crate::scene::brief;
use std::fmt::Display;
use std::path::Path;

/// What a PLY file has.
const PLY_EXPECTED: &str = "a PLY file has the elements `vertex` and `face`";

/// Vertices, and triangles, that a mesh may have.
const LIMIT: usize = 1 << 26;

/// Reads the bytes of a mesh file that lies in a folder.
type Parser = fn(&[u8], &Path) -> Result<RawMesh, SurfaceError>;

/// Reads a mesh file; the extension, in upper or lower case, tells the format.
///
/// Polygons are cut into triangles, which keep the file's normals, texture coordinates and materials; points and lines are left out; every node of a glTF scene is placed. Nothing is
/// mended. Buffers of a `.gltf` are read from its own folder and below; a URI that leads elsewhere is refused.
///
/// # Errors
/// Unreadable or unknown files, malformed ones (with line, byte or element), empty meshes, coordinates that are not finite or
/// beyond 1e36 m, indices that name no vertex, more than 2²⁶ vertices or triangles.
pub fn read(path: &Path, unit: LengthUnit, up: UpAxis) -> Result<RawMesh, SurfaceError> {
    let extension = path.extension().map(|word| word.to_string_lossy().to_lowercase()).unwrap_or_default();
    let (parse, expected): (Parser, _) = match extension.as_str() {
        "obj" => {
            (|bytes, _| obj::parse(bytes), "an OBJ file has vertices, lines `v X Y Z`, and faces, lines `f A B C`")
        }
        "ply" => (|bytes, _| ply::parse(bytes), PLY_EXPECTED),
        "stl" => (|bytes, _| stl::parse(bytes), "an STL file has facets of three vertices"),
        "gltf" | "glb" => (gltf::parse, "a glTF file has meshes of triangles in its scene"),
        _ => return Err(SurfaceError::UnknownFormat { path: path.to_owned(), extension }),
    };
    let bytes = load(path)?;
    let mut mesh = parse(&bytes, path.parent().unwrap_or(Path::new("")))?;
    mesh.place(unit, up);
    mesh.check_expected(expected)?;
    Ok(mesh)
}

fn load(path: &Path) -> Result<Vec<u8>, SurfaceError> {
    let unreadable = |source| SurfaceError::Unreadable { path: path.to_owned(), source };
    // Devices and pipes may never end.
    if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(unreadable(std::io::Error::other("not a regular file")));
    }
    std::fs::read(path).map_err(unreadable)
}

fn malformed(format: &'static str, place: impl Display, reason: impl Display) -> SurfaceError {
    SurfaceError::Malformed { format, place: brief(&place.to_string()), reason: brief(&reason.to_string()) }
}

/// Refuses to grow past [`LIMIT`].
fn within_limit(count: usize) -> Result<(), SurfaceError> {
    if count <= LIMIT { Ok(()) } else { Err(SurfaceError::TooLarge { limit: LIMIT as u64 }) }
}
