//! Base meshes of the mesh fuzzer.

use super::simplify::simplified;
use nalgebra::Point3;
use shatter_fracture::surface::{self, LengthUnit, RawMesh, SurfaceError, UpAxis, shapes};
use std::path::{Path, PathBuf};

/// Maximum number of triangles of a base mesh, so that a mutant takes some tens of milliseconds.
pub const TRIANGLES_MAX: usize = 3000;

/// Size of base meshes and of the lattices in their mutants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshSize {
    /// Meshes simplified to [`TRIANGLES_MAX`] triangles, on coarse lattices.
    Small,
    /// Meshes as they are, on the lattices of the preset `game`.
    Full,
}

/// Named mesh.
#[derive(Clone, Debug)]
pub struct BaseMesh {
    /// Name without a slash; part of each mutant's name.
    pub name: String,
    /// The mesh.
    pub mesh: RawMesh,
}

/// Error of a folder of meshes.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The folder cannot be listed.
    #[error("cannot list {}: {source}", path.display())]
    Unreadable {
        /// The folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A mesh in it cannot be read.
    #[error("{}: {source}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// The defect.
        source: SurfaceError,
    },
}

impl BaseMesh {
    fn new(name: impl Into<String>, mesh: RawMesh, size: MeshSize) -> Self {
        let mesh = match size {
            MeshSize::Small => simplified(&mesh, TRIANGLES_MAX),
            MeshSize::Full => mesh,
        };
        Self { name: name.into(), mesh }
    }
}

/// Generated shapes.
pub fn generated(size: MeshSize) -> Vec<BaseMesh> {
    let base = |name: &str, mesh| BaseMesh::new(name, mesh, size);
    vec![
        base("sphere", shapes::sphere(0.5, 3)),
        base("cuboid", quartered(&quartered(&shapes::cuboid([0.6, 0.4, 0.3])))),
        base("ellipsoid", shapes::ellipsoid([0.5, 0.25, 0.2], 3)),
        base("torus", shapes::torus(0.4, 0.15, [36, 18])),
        base("dumbbell", shapes::dumbbell()),
        base("arch", shapes::arch()),
        base("horseshoe", shapes::horseshoe()),
        base("statue", shapes::statue()),
    ]
}

/// Meshes of a folder, sorted by name; ignores other files.
pub fn from_folder(folder: &Path, size: MeshSize) -> Result<Vec<BaseMesh>, FolderError> {
    let unreadable = |source| FolderError::Unreadable { path: folder.to_owned(), source };
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>).map_err(unreadable)?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).filter(|path| is_mesh(path)).collect();
    paths.sort();
    let base = |path: PathBuf| {
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        match surface::read(&path, LengthUnit::M, UpAxis::Y) {
            Ok(mesh) => Ok(BaseMesh::new(name, mesh, size)),
            Err(source) => Err(FolderError::Mesh { path, source }),
        }
    };
    paths.into_iter().map(base).collect()
}

fn is_mesh(path: &Path) -> bool {
    let known = ["obj", "ply", "stl", "gltf", "glb", "msh", "vtk", "mesh"];
    path.extension().and_then(|extension| extension.to_str()).is_some_and(|extension| known.contains(&extension))
}

/// Mesh with every triangle split in four at the midpoints of its sides.
fn quartered(mesh: &RawMesh) -> RawMesh {
    let mut finer = RawMesh::new(mesh.positions_m.clone(), Vec::new());
    let mut middles = std::collections::HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[from, to]| {
            *middles.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                let [from, to] = [from, to].map(|vertex| mesh.positions_m[vertex as usize].coords);
                finer.positions_m.push(Point3::from((from + to) * 0.5));
                finer.positions_m.len() as u32 - 1
            })
        });
        finer.triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    finer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generated_meshes_are_small_sound_and_named_once() {
        let all = generated(MeshSize::Small);
        for base in &all {
            assert!(base.mesh.triangles.len() <= TRIANGLES_MAX && base.mesh.check().is_ok(), "{}", base.name);
            assert_eq!(all.iter().filter(|other| other.name == base.name).count(), 1);
        }
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = from_folder(Path::new("nowhere"), MeshSize::Full).unwrap_err();
        assert!(error.to_string().contains("nowhere"));
    }
}
