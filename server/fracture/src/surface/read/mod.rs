//! Readers of mesh files: OBJ, PLY, STL, glTF and GLB; of tetrahedral meshes: Gmsh, VTK and Medit.

mod accessor;
mod common;
mod format;
mod gltf;
mod medit;
mod msh;
mod obj;
mod obj_attributes;
mod painted;
mod ply;
mod ply_ascii;
mod ply_header;
mod polygon;
mod stl;
mod tetrahedral;
mod vtk;
mod words;

pub use painted::read_painted;

use super::{LengthUnit, RawMesh, SurfaceError, UpAxis};
use common::{PLY_EXPECTED, load};
use std::path::Path;

/// Parser of the bytes of a mesh file that lies in a folder.
type Parser = fn(&[u8], &Path) -> Result<RawMesh, SurfaceError>;

/// Reads a mesh file. The extension, in upper or lower case, selects the format.
///
/// Polygons are cut into triangles, which keep the file's attributes and materials. Points and lines
/// are dropped. Every node of a glTF scene is transformed to scene coordinates. Of a tetrahedral mesh (Gmsh, VTK, Medit;
/// ASCII) the boundary is read, with the vertices that it uses. Nothing is repaired. Buffers of a `.gltf` are read only
/// from its own folder and below; other URIs are rejected.
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
        "msh" => (|bytes, _| msh::parse(bytes), "a Gmsh file has nodes, and tetrahedra or triangles"),
        "vtk" => (|bytes, _| vtk::parse(bytes), "a VTK file has points, and cells that are tetrahedra or triangles"),
        "mesh" => (|bytes, _| medit::parse(bytes), "a Medit file has `Vertices`, and `Tetrahedra` or `Triangles`"),
        _ => return Err(SurfaceError::UnknownFormat { path: path.to_owned(), extension }),
    };
    let bytes = load(path)?;
    let read = parse(&bytes, path.parent().unwrap_or(Path::new("")));
    let checked = read.and_then(|mut mesh| {
        mesh.convert_to_meters(unit, up);
        mesh.check_expected(expected).map(|()| mesh)
    });
    checked.map_err(|error| format::misnamed(&bytes, &extension).unwrap_or(error))
}
