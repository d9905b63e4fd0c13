//! Fragments as files: binary glTF (`.glb`), Wavefront OBJ ([`write_obj`]), and MJCF for MuJoCo ([`write_mjcf`]).
//!
//! A `.glb` file is one that any viewer opens and a solid modeller can trust. One node per fragment, named `fragment_000`, …, whose translation is the center of mass and whose mesh has one or
//! two primitives: the outer faces, and the crack faces (a fragment from the inside has no outer ones). All primitives
//! of a mesh share their vertex accessors and one buffer view of indices, and the vendor extension
//! `EXT_mesh_manifold` (Khronos glTF registry, draft by E. Lalish) says which vertices are one point of the closed
//! surface. Readers that do not know the extension see an ordinary mesh. A node's `extras` hold `fragment` (the id), `body`,
//! `volume_m3`, `mass_kg`, `center_m` and `inertia_kg_m2`: the whole tensor about the center of mass, xx, yy, zz, xy, xz, yz, along
//! the axes of the node, which are those of the file, since nodes are not turned.
//!
//! Meters, +Y up, right-handed, counter-clockwise seen from outside. Texture coordinates, whose v goes up everywhere else, go down
//! here: (u, 1 − v). Equal fragments give equal bytes: the file holds
//! no time, host or path.

mod check;
pub mod contact;
mod container;
mod document;
mod file;
mod inertia;
mod mjcf;
mod normals;
mod obj;
mod obj_folder;
mod stale;

pub use check::is_closed;
pub use file::{write_glb, write_whole};
pub use inertia::{PrincipalInertia, principal};
pub use mjcf::{MjcfModel, mjcf, write_mjcf};
pub use normals::smooth_normals;
pub use obj_folder::write_obj;

use shatter_proto::result::Bond;
use std::io;
use std::path::PathBuf;

/// One fragment, borrowed from wherever it lies.
#[derive(Clone, Copy, Debug)]
pub struct FragmentView<'a> {
    /// Its number in the answer; becomes the node's name and `extras.fragment`.
    pub id: u32,
    /// The body (component of the object) it comes from.
    pub body: u32,
    /// Vertices relative to the center of mass, meters. Each run has its own set.
    pub positions: &'a [[f32; 3]],
    /// Normals, one per vertex; none: smooth ones are made.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates, one per vertex, v upwards, or none.
    pub uvs: &'a [[f32; 2]],
    /// Triangles, three vertex numbers each, counter-clockwise seen from outside.
    pub indices: &'a [u32],
    /// Consecutive stretches of `indices`, the outer one first; together they cover all of it.
    pub runs: &'a [RunView],
    /// Pairs (from, to) of vertices at the same position that are one point of the closed surface.
    pub merges: &'a [[u32; 2]],
    /// Center of mass, meters.
    pub center_m: [f64; 3],
    /// Volume, m³.
    pub volume_m3: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Inertia tensor about the center of mass, along the axes of the coordinates, kg·m²: xx, yy, zz, xy, xz, yz.
    pub inertia_kg_m2: [f64; 6],
}

impl FragmentView<'_> {
    /// How many of the indices are of outer triangles; those of cracks follow.
    pub(crate) fn outer_indices(&self) -> usize {
        self.runs.iter().filter(|run| !run.crack).map(|run| run.index_count as usize).sum()
    }
}

/// A convex body that stands for a fragment in collisions.
#[derive(Clone, Copy, Debug)]
pub struct HullView<'a> {
    /// Corners relative to the fragment's center of mass, meters.
    pub positions: &'a [[f32; 3]],
    /// Triangles, three corner numbers each, counter-clockwise seen from outside.
    pub indices: &'a [u32],
}

/// A broken object, borrowed from wherever it lies.
#[derive(Clone, Copy, Debug)]
pub struct ObjectView<'a> {
    /// Its name.
    pub name: &'a str,
    /// All of its fragments; ids are places.
    pub fragments: &'a [FragmentView<'a>],
    /// One per fragment, `None` for one too flat for a hull; empty without hulls.
    pub hulls: &'a [Option<HullView<'a>>],
    /// Which fragments hold together; may be empty.
    pub bonds: &'a [Bond],
}

/// Triangles of one fragment on one side of a crack, or on the outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunView {
    /// Whether it is a side of a crack; else the outside.
    pub crack: bool,
    /// First entry in the fragment's `indices`.
    pub index_first: u32,
    /// Number of entries, a multiple of three.
    pub index_count: u32,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WriteReport {
    /// Nodes in the file.
    pub fragments: usize,
    /// How many of them are closed and carry `EXT_mesh_manifold`; the others are written without that claim.
    pub closed: usize,
    /// Size of all files together.
    pub bytes: usize,
    /// Every file, the main one first: the `.glb` file, the table of OBJ files, the model for MuJoCo. Empty where the bytes stay in memory.
    pub files: Vec<PathBuf>,
}

/// Why no file was written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The list is empty: the object stayed whole.
    #[error("there is no fragment to write")]
    NoFragments,
    /// A coordinate, center, volume or mass that is not a finite number.
    #[error("fragment {fragment}: {what} is not finite")]
    NonFinite {
        /// The fragment's id.
        fragment: u32,
        /// Which figure.
        what: &'static str,
    },
    /// An index that names no vertex.
    #[error("fragment {fragment}: index {position} names vertex {vertex}, it has {vertices}")]
    IndexOutOfRange {
        /// The fragment's id.
        fragment: u32,
        /// Place in `indices`.
        position: usize,
        /// What stands there.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A run that does not begin where the one before it ends, is no whole number of triangles, or is an outer run
    /// after a crack run.
    #[error("fragment {fragment}: run {run} is out of order")]
    RunOutOfOrder {
        /// The fragment's id.
        fragment: u32,
        /// Place in `runs`.
        run: usize,
    },
    /// A merge pair that names no vertex or joins two different positions.
    #[error("fragment {fragment}: merge pair {pair} joins vertices that are not at one position")]
    MergeMoves {
        /// The fragment's id.
        fragment: u32,
        /// Place in `merges`.
        pair: usize,
    },
    /// More than a binary glTF file can hold (4 GiB).
    #[error("the fragments need {bytes} bytes, a .glb file holds less than 4 GiB")]
    TooLarge {
        /// What they need.
        bytes: usize,
    },
    /// The path names a folder.
    #[error("{} is a folder, not a file", .0.display())]
    IsFolder(PathBuf),
    /// What has the file's name is a device, a pipe or the like.
    #[error("{} is no file that could be replaced", .0.display())]
    NoFile(PathBuf),
    /// The folder does not take files.
    #[error("cannot write into the folder {}: {source}", .folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Writing or renaming failed.
    #[error("cannot write {}: {source}", .path.display())]
    Write {
        /// The file asked for.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A document could not be turned into JSON.
    #[error("cannot write the JSON document: {0}")]
    Document(#[from] serde_json::Error),
    /// A document could not be turned into XML.
    #[error("cannot write the XML document: {0}")]
    Xml(io::Error),
    /// A bond that names no fragment.
    #[error("bond {bond} names fragment {fragment}, there are {fragments}")]
    BondOutOfRange {
        /// Place in the bonds.
        bond: usize,
        /// What stands there.
        fragment: u32,
        /// Number of fragments.
        fragments: usize,
    },
    /// A hull whose index names no corner.
    #[error("the hull of fragment {fragment} names a corner that it does not have")]
    HullOutOfRange {
        /// The fragment's id.
        fragment: u32,
    },
}

/// The bytes of a `.glb` file with these fragments, and what they hold.
///
/// # Errors
/// [`ExportError`] by the figure that makes no valid file.
pub fn glb_bytes(fragments: &[FragmentView<'_>]) -> Result<(Vec<u8>, WriteReport), ExportError> {
    check::all(fragments)?;
    let document = document::build(fragments)?;
    let bytes = container::frame(&document.root.to_vec()?, &document.binary)?;
    let written =
        WriteReport { fragments: fragments.len(), closed: document.closed, bytes: bytes.len(), files: Vec::new() };
    Ok((bytes, written))
}

#[cfg(test)]
mod tests;
