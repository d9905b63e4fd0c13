//! Fragments as a model for MuJoCo (MJCF): an `.xml` file, and a folder of meshes beside it.
//!
//! Based on: *XML Reference*, MuJoCo documentation (E. Todorov, T. Erez & Y. Tassa, *MuJoCo*, IROS 2012).
//!
//! Each fragment is a body with a free joint at its center of mass, with the mass and inertia of the result. Fragments that share a
//! bond are welded by an `equality` named `bond_…`, in the order of the result's bonds. The numeric `bond_area_m2` lists the areas
//! of the bonds. The object stays whole until the simulation switches welds off. An anchored fragment is welded to the world.
//! Welded neighbors never collide, even after separation: MuJoCo applies exclusions when it compiles the model.
//!
//! Meters, kilograms, +Z up, right-handed: (x, y, z) of the mesh file is (x, −z, y) here.

mod document;
mod shapes;

use super::document::fragment_name;
use super::file::{remove_table, target};
use super::folder_lock::FolderLock;
use super::{ExportError, ObjectView, WriteReport, check, make_folder, stale, write_whole};
use std::ffi::OsStr;
use std::path::Path;

/// A model in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MjcfModel {
    /// The document.
    pub xml: String,
    /// Names and texts of the mesh files, in the folder that the document names.
    pub meshes: Vec<(String, String)>,
}

/// Makes a model of `object`, whose meshes go into the folder `meshes` beside the document.
///
/// # Errors
/// [`ExportError`] by the figure that makes no valid model.
pub fn mjcf(object: &ObjectView<'_>, meshes: &str) -> Result<MjcfModel, ExportError> {
    check::object(object)?;
    let name = |id: u32| fragment_name(id, object.fragments.len());
    let shapes: Vec<shapes::Shape> = object
        .fragments
        .iter()
        .enumerate()
        .map(|(place, fragment)| shapes::shape(&name(fragment.id), fragment, object.hulls.get(place)))
        .collect();
    let xml = document::xml(object, &shapes, meshes).map_err(ExportError::Xml)?;
    Ok(MjcfModel { xml, meshes: shapes.into_iter().flat_map(|shape| shape.files).collect() })
}

/// Writes a model of `object` to `path`, and its meshes into the folder `STEM_assets` beside it, which is created if necessary. Each file
/// appears whole or not at all. Files of the same names are replaced. Meshes that the replaced model names and the new one does not are
/// removed; all other files stay.
///
/// An earlier document is removed first, and the new one is written last. A document therefore never lies beside meshes of another
/// result, even if the process is killed.
///
/// # Errors
/// Those of [`mjcf`], and a file that cannot be written; [`ExportError::FolderInUse`] while another process or thread writes meshes into
/// `STEM_assets`.
pub fn write_mjcf(path: &Path, object: &ObjectView<'_>) -> Result<WriteReport, ExportError> {
    let stem = path.file_stem().unwrap_or(OsStr::new("object")).to_string_lossy();
    let meshes = format!("{stem}_assets");
    let folder = path.with_file_name(&meshes);
    let model = mjcf(object, &meshes)?;
    target(path)?;
    make_folder(&folder)?;
    let _lock = FolderLock::acquire(&folder)?;
    let earlier = stale::in_model(path, &meshes);
    let document = remove_table(path)?;
    stale::remove(&folder, &earlier, model.meshes.iter().map(|(name, _)| name.as_str()))?;
    for (name, text) in &model.meshes {
        write_whole(&folder.join(name), text.as_bytes())?;
    }
    write_whole(&document, model.xml.as_bytes())?;
    let bytes = model.xml.len() + model.meshes.iter().map(|(_, text)| text.len()).sum::<usize>();
    let closed = object.fragments.iter().filter(|fragment| super::is_closed(fragment)).count();
    let meshes = model.meshes.iter().map(|(name, _)| folder.join(name));
    let files = std::iter::once(path.to_owned()).chain(meshes).collect();
    Ok(WriteReport { fragments: object.fragments.len(), closed, bytes, files })
}

/// Rotates from +Y up to +Z up: a quarter turn about x.
fn z_up<N: Copy + std::ops::Neg<Output = N>>([x, y, z]: [N; 3]) -> [N; 3] {
    [x, -z, y]
}

/// Rotates a tensor (xx, yy, zz, xy, xz, yz) likewise.
fn tensor_z_up([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> [f64; 6] {
    [xx, zz, yy, -xz, xy, -yz]
}

#[cfg(test)]
mod tests;
