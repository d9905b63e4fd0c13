//! Fragments as files: binary glTF (`.glb`), Wavefront OBJ ([`write_obj`]), and MJCF for MuJoCo ([`write_mjcf`]).
//!
//! A `.glb` file opens in any viewer, and declares which meshes are closed. It has one node per fragment, named `fragment_000`, …,
//! whose translation is the center of mass. The node's mesh has one or two primitives: the outer faces and the crack faces. A
//! fragment from the inside has no outer faces. All primitives of a mesh share their vertex accessors and one buffer view of
//! indices.
//!
//! Second texture coordinates and colors of the input are attributes of the primitives of outer faces (`TEXCOORD_1`, `COLOR_0`).
//! The material `outer` is then white.
//!
//! The outer triangles of a fragment with materials make one primitive per material. [`write_glb_with`] gives the primitives the
//! materials and textures of a glTF file ([`SourceMaterials`]), so that the fragments look like the whole model.
//!
//! glTF stores translations in single precision. If that would displace fragments noticeably, because the object lies far from the
//! origin, their nodes are children of one node `object`. Its translation is the center of the fragments.
//!
//! The vendor extension `EXT_mesh_manifold` (Khronos glTF registry, draft by E. Lalish) declares which vertices are one point of
//! the closed surface. Readers without the extension see an ordinary mesh.
//!
//! A node's `extras` contain `fragment` (the id), `body`, `volume_m3`, `mass_kg`, `center_m` and `inertia_kg_m2`. The inertia is
//! the full tensor about the center of mass: xx, yy, zz, xy, xz, yz. It is along the axes of the file, because nodes are not
//! rotated.
//!
//! Units and axes: meters, +Y up, right-handed, counter-clockwise seen from outside. The v axis of texture coordinates points down
//! in glTF, so files contain (u, 1 − v). Equal fragments make equal bytes: a file contains no time, host name or path.

mod check;
pub mod contact;
mod container;
mod document;
mod file;
mod folder_lock;
mod inertia;
mod material_groups;
mod mjcf;
mod normals;
mod obj;
mod obj_folder;
mod placement;
mod source_materials;
mod stale;

pub use check::is_closed;
pub use file::{make_folder, write_glb, write_glb_with, write_whole};
pub use inertia::{PrincipalInertia, principal};
pub use mjcf::{MjcfModel, mjcf, write_mjcf};
pub use normals::smooth_normals;
pub use obj_folder::write_obj;
pub use source_materials::SourceMaterials;

use shatter_proto::result::Bond;
use std::io;
use std::path::{Path, PathBuf};

/// One fragment, borrowed from any storage.
#[derive(Clone, Copy, Debug)]
pub struct FragmentView<'a> {
    /// Index in the result; becomes the node's name and `extras.fragment`.
    pub id: u32,
    /// Body (component of the object) that the fragment comes from.
    pub body: u32,
    /// Vertices relative to the center of mass, m. Each run has its own set.
    pub positions: &'a [[f32; 3]],
    /// Normals, one per vertex; if empty, smooth ones are computed.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates, one per vertex, v upwards; may be empty.
    pub uvs: &'a [[f32; 2]],
    /// Second texture coordinates of outer faces, one per vertex, v upwards; may be empty. Those of cracks are not written.
    pub uvs2: &'a [[f32; 2]],
    /// Linear colors of outer faces, red, green, blue and alpha, one per vertex; may be empty. Those of cracks are not written.
    pub colors: &'a [[u8; 4]],
    /// Materials, one per triangle, as indices in the list of the mesh file; [`NO_MATERIAL`](shatter_proto::result::NO_MATERIAL) for
    /// none. Those of crack triangles are not read. Empty without materials.
    pub materials: &'a [u32],
    /// Indices of vertices, three per triangle, counter-clockwise seen from outside.
    pub indices: &'a [u32],
    /// Consecutive ranges of `indices`, the outer one first; together they cover all of it.
    pub runs: &'a [RunView],
    /// Pairs (from, to) of vertices at the same position that are one point of the closed surface.
    pub merges: &'a [[u32; 2]],
    /// Center of mass, m.
    pub center_m: [f64; 3],
    /// Volume, m³.
    pub volume_m3: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Inertia tensor about the center of mass, along the axes of the coordinates, kg·m²: xx, yy, zz, xy, xz, yz.
    pub inertia_kg_m2: [f64; 6],
}

impl FragmentView<'_> {
    /// Number of indices of outer triangles, which come before those of cracks.
    pub(crate) fn outer_indices(&self) -> usize {
        self.runs.iter().filter(|run| !run.crack).map(|run| run.index_count as usize).sum()
    }

    /// Values of vertices that are written for outer faces alone; none for a fragment without such faces.
    pub(crate) fn of_outer<'a, T>(&self, values: &'a [T]) -> &'a [T] {
        if self.outer_indices() == 0 { &[] } else { values }
    }
}

/// Convex proxy of a fragment for collisions.
#[derive(Clone, Copy, Debug)]
pub struct HullView<'a> {
    /// Corners relative to the fragment's center of mass, m.
    pub positions: &'a [[f32; 3]],
    /// Indices of corners, three per triangle, counter-clockwise seen from outside.
    pub indices: &'a [u32],
}

/// A broken object, borrowed from any storage.
#[derive(Clone, Copy, Debug)]
pub struct ObjectView<'a> {
    /// Name.
    pub name: &'a str,
    /// All fragments, in the order of their ids.
    pub fragments: &'a [FragmentView<'a>],
    /// Hulls, one per fragment, `None` for a fragment too flat for one; empty without hulls.
    pub hulls: &'a [Option<HullView<'a>>],
    /// Contacts between fragments; may be empty.
    pub bonds: &'a [Bond],
}

/// Triangles of one fragment on one side of a crack, or on the outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunView {
    /// True if the run is a side of a crack; else it is the outside.
    pub crack: bool,
    /// First entry in the fragment's `indices`.
    pub index_first: u32,
    /// Number of entries, a multiple of three.
    pub index_count: u32,
}

/// Summary of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WriteReport {
    /// Fragments in the file.
    pub fragments: usize,
    /// Number of closed fragments, which carry `EXT_mesh_manifold`; the others are written without it.
    pub closed: usize,
    /// Size of all files together, bytes.
    pub bytes: usize,
    /// Every file, the main one first: the `.glb` file, the table of OBJ files, the MuJoCo model. Empty if the bytes stay in memory.
    pub files: Vec<PathBuf>,
}

/// Error of an export.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// No meshes: the object stayed whole, or the effect that makes them was off.
    #[error(
        "there is nothing to write: an object that stayed whole has no fragments, and skin and hulls need their effects (`skin`, `hulls`)"
    )]
    NoFragments,
    /// A coordinate, center, volume or mass that is not a finite number.
    #[error("fragment {fragment}: {what} is not finite")]
    NonFinite {
        /// Id of the fragment.
        fragment: u32,
        /// Name of the number.
        what: &'static str,
    },
    /// An index that names no vertex.
    #[error("fragment {fragment}: index {position} names vertex {vertex}, but it has {vertices} vertices")]
    IndexOutOfRange {
        /// Id of the fragment.
        fragment: u32,
        /// Position in `indices`.
        position: usize,
        /// The index.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A run that does not begin at the end of the one before, has a part of a triangle, or is an outer run after a crack run.
    #[error("fragment {fragment}: run {run} is out of order")]
    RunOutOfOrder {
        /// Id of the fragment.
        fragment: u32,
        /// Position in `runs`.
        run: usize,
    },
    /// A merge pair that names no vertex or joins two different positions.
    #[error("fragment {fragment}: merge pair {pair} joins vertices that are not at one position")]
    MergeMoves {
        /// Id of the fragment.
        fragment: u32,
        /// Position in `merges`.
        pair: usize,
    },
    /// A list of materials that does not have one entry per triangle.
    #[error("fragment {fragment}: it has {materials} materials for {triangles} triangles")]
    MaterialCount {
        /// Id of the fragment.
        fragment: u32,
        /// Number of materials.
        materials: usize,
        /// Number of triangles.
        triangles: usize,
    },
    /// Fragments without materials, for which a file of materials was given.
    #[error(
        "the fragments have no materials for those of {}: the object must be baked from that file, and the request needs the effect `attributes`",
        .path.display()
    )]
    NoMaterials {
        /// The file of materials.
        path: PathBuf,
    },
    /// A material whose texture uses a set of texture coordinates that the fragments do not have.
    #[error(
        "material {material} of {} has a texture with the coordinates TEXCOORD_{set}, which the fragments do not have: {}",
        .path.display(),
        if *set < 2 { "bake the object from a mesh whose every corner has them" } else { "they have two sets at most, 0 and 1" }
    )]
    NoTextureCoordinates {
        /// The file of materials.
        path: PathBuf,
        /// Index of the material.
        material: u32,
        /// The set, from 0.
        set: usize,
    },
    /// A material that the file of materials does not have.
    #[error(
        "fragment {fragment} has the material {material}, but {} has {}: the object was baked from another file; give the one that it \
         was baked from",
        .path.display(),
        counted_materials(materials)
    )]
    MaterialOutOfRange {
        /// Id of the fragment.
        fragment: u32,
        /// Index of the material.
        material: u32,
        /// The file of materials.
        path: PathBuf,
        /// Number of materials in the file.
        materials: usize,
    },
    /// A file of materials, or a file that it names, that cannot be read.
    #[error(
        "cannot read {}: {source}; materials need the .glb or .gltf file that the object was baked from, and the files beside it \
         that it names",
        .unreadable.display()
    )]
    ReadMaterials {
        /// The file of materials.
        path: PathBuf,
        /// The file that cannot be read.
        unreadable: PathBuf,
        /// Reason of the system.
        source: io::Error,
    },
    /// A file of materials that is no valid glTF file.
    #[error("malformed glTF file {}, {place}: {reason}", .path.display())]
    MalformedMaterials {
        /// The file of materials.
        path: PathBuf,
        /// Part of the document.
        place: String,
        /// Defect, in words.
        reason: String,
    },
    /// A file of materials with a required extension that a file of fragments cannot have.
    #[error(
        "{} requires the extension `{extension}`, which cannot be written into a file of fragments; export the model without it",
        .path.display()
    )]
    RequiredExtension {
        /// The file of materials.
        path: PathBuf,
        /// Name of the extension.
        extension: String,
    },
    /// More bytes than a binary glTF file can hold (4 GiB).
    #[error(
        "the fragments need {bytes} bytes, but a .glb file holds less than 4 GiB; write OBJ files or fewer fragments"
    )]
    TooLarge {
        /// Size of the fragments, bytes.
        bytes: usize,
    },
    /// The path names a folder.
    #[error("{} is a folder, not a file", .0.display())]
    IsFolder(PathBuf),
    /// The path names a device, a pipe or the like.
    #[error("{} is not a regular file and cannot be replaced; choose another path", .0.display())]
    NoFile(PathBuf),
    /// A part of the path of a folder is a file, a device or the like.
    #[error("{}{} is {kind}, not a folder; choose another path", purpose(folder, part), .part.display())]
    NotAFolder {
        /// The folder.
        folder: PathBuf,
        /// Path of the part that is no folder.
        part: PathBuf,
        /// Kind of the part, in words.
        kind: &'static str,
    },
    /// A folder that the system does not make.
    #[error("cannot make the folder {}: {reason}; choose another path", .folder.display())]
    MakeFolder {
        /// The folder.
        folder: PathBuf,
        /// Reason of the system, in words.
        reason: String,
    },
    /// A folder without write access.
    #[error("cannot write into the folder {}: {source}; choose another path", .folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Reason of the system.
        source: io::Error,
    },
    /// A folder to which another command or thread is writing a set of files.
    #[error("another command is writing to the folder {}; wait for it, or use another folder", .0.display())]
    FolderInUse(PathBuf),
    /// Writing or renaming failed.
    #[error("cannot write {}: {source}", .path.display())]
    Write {
        /// The requested file.
        path: PathBuf,
        /// Reason of the system.
        source: io::Error,
    },
    /// Failure to serialize JSON.
    #[error("cannot write the JSON document: {0}")]
    Document(#[from] serde_json::Error),
    /// Failure to serialize XML.
    #[error("cannot write the XML document: {0}")]
    Xml(io::Error),
    /// A bond that names an unknown fragment.
    #[error("bond {bond} names fragment {fragment}, but there are {fragments} fragments")]
    BondOutOfRange {
        /// Position in the bonds.
        bond: usize,
        /// Id in the bond.
        fragment: u32,
        /// Number of fragments.
        fragments: usize,
    },
    /// A hull with an index that names no corner.
    #[error("the hull of fragment {fragment} names a corner that it does not have")]
    HullOutOfRange {
        /// Id of the fragment.
        fragment: u32,
    },
}

impl ExportError {
    /// The path that cannot be written; `None` for fragments that make no valid file.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::IsFolder(path) | Self::NoFile(path) | Self::FolderInUse(path) | Self::Write { path, .. } => {
                Some(path)
            }
            Self::NotAFolder { folder, .. } | Self::MakeFolder { folder, .. } | Self::Folder { folder, .. } => {
                Some(folder)
            }
            _ => None,
        }
    }

    /// The file of materials that does not fit or cannot be used; `None` for other errors.
    pub fn materials_file(&self) -> Option<&Path> {
        match self {
            Self::NoMaterials { path }
            | Self::MaterialOutOfRange { path, .. }
            | Self::NoTextureCoordinates { path, .. }
            | Self::ReadMaterials { path, .. }
            | Self::MalformedMaterials { path, .. }
            | Self::RequiredExtension { path, .. } => Some(path),
            _ => None,
        }
    }
}

/// Beginning of the message for a `part` of the path of `folder` that is no folder.
fn purpose(folder: &Path, part: &Path) -> String {
    if folder == part { String::new() } else { format!("cannot make the folder {}: ", folder.display()) }
}

/// A number of materials, in words; materials have the indices below it.
fn counted_materials(materials: &usize) -> String {
    match materials {
        0 => "none".to_owned(),
        1 => "only the material 0".to_owned(),
        _ => format!("the materials 0 to {}", materials - 1),
    }
}

/// Makes a `.glb` file of these fragments in memory; returns its bytes and a summary.
///
/// # Errors
/// [`ExportError`] by the figure that makes no valid file.
pub fn glb_bytes(fragments: &[FragmentView<'_>]) -> Result<(Vec<u8>, WriteReport), ExportError> {
    check::all(fragments)?;
    framed(document::build(fragments, None)?, fragments.len())
}

/// As [`glb_bytes`], with the materials and textures of the mesh file. The materials of the file are its own in their order, then
/// `outer` if an outer triangle has no material, then `crack`.
///
/// # Errors
/// Those of [`glb_bytes`]; fragments whose materials are not those of the file.
pub fn glb_bytes_with(
    fragments: &[FragmentView<'_>],
    materials: &SourceMaterials,
) -> Result<(Vec<u8>, WriteReport), ExportError> {
    check::all(fragments)?;
    check::source(fragments, materials)?;
    framed(document::build(fragments, Some(materials))?, fragments.len())
}

/// The file of a document, and its summary.
fn framed(document: document::Document<'_>, fragments: usize) -> Result<(Vec<u8>, WriteReport), ExportError> {
    let bytes = container::frame(&document.json()?, &document.binary)?;
    let written = WriteReport { fragments, closed: document.closed, bytes: bytes.len(), files: Vec::new() };
    Ok((bytes, written))
}

#[cfg(test)]
mod tests;
