//! Results as files: always in meters, +Y up, right-handed and counter-clockwise, whatever the convention of the result.

use crate::fragment::fragments;
use crate::visible::{Appearance, VisibleMesh};
use crate::{Effect, Error, ErrorKind, FractureResult, Fragment, FragmentSkin, HullMesh};
use shatter_export::{
    ExportError, FragmentView, HullView, ObjectView, RunView, SourceMaterials, WriteReport, write_glb, write_glb_with,
    write_mjcf, write_obj,
};
use shatter_proto::result::{Bond, FragmentSurface};
use shatter_proto::view::ResultView;
use std::path::Path;

/// Reads the materials and textures of the mesh file (`.glb`, `.gltf`) that an object was baked from, for
/// [`FractureResult::write_glb_with`].
///
/// # Errors
/// `output`: the file, or one beside it that it names, cannot be read, is malformed, or requires an extension that a file of fragments
/// cannot have.
pub fn read_materials(path: &Path) -> Result<SourceMaterials, Error> {
    SourceMaterials::read(path).map_err(|error| failed(path, &error))
}

impl FractureResult {
    /// Writes the fragments to a `.glb` file, whole or not at all.
    ///
    /// # Errors
    /// `output` (folder not writable, the path is a folder, or the object stayed whole: there is no fragment to write), `bad_result`
    /// (the fragments make no valid file).
    pub fn write_glb(&self, path: &Path) -> Result<WriteReport, Error> {
        self.with_views(|views| write_glb(path, views)).map_err(|error| failed(path, &error))
    }

    /// As [`Self::write_glb`], with the materials and textures of the mesh file that the object was baked from. The request needs the
    /// effect `attributes`.
    ///
    /// # Errors
    /// Those of [`Self::write_glb`]; `effect` if the fragments have no materials, `output` if they have materials that the file does not
    /// have.
    pub fn write_glb_with(&self, path: &Path, materials: &SourceMaterials) -> Result<WriteReport, Error> {
        self.with_views(|views| write_glb_with(path, views, materials)).map_err(|error| failed(path, &error))
    }

    /// Writes the hulls of the fragments to a `.glb` file as [`Self::write_glb`] does the fragments: nodes of the same names at the
    /// same positions.
    ///
    /// # Errors
    /// Those of [`Self::write_glb`]; `output` as well without hulls.
    pub fn write_hulls_glb(&self, path: &Path) -> Result<WriteReport, Error> {
        hulls_glb(self.metric().raw_view(), path).map_err(|error| failed(path, &error))
    }

    /// Writes the visible surfaces of the fragments to a `.glb` file: their skins, and their crack faces, whose rims are moved to those
    /// of the skins; nodes of the same names at the same positions.
    ///
    /// # Errors
    /// Those of [`Self::write_glb`]; `output` as well without skins.
    pub fn write_skins_glb(&self, path: &Path) -> Result<WriteReport, Error> {
        with_skins(self.metric().raw_view(), |views| write_glb(path, views)).map_err(|error| failed(path, &error))
    }

    /// As [`Self::write_skins_glb`], with the materials and textures of the mesh file that the object was baked from.
    ///
    /// # Errors
    /// Those of [`Self::write_skins_glb`]; `effect` if the skins have no materials, `output` if they have materials that the file does
    /// not have.
    pub fn write_skins_glb_with(&self, path: &Path, materials: &SourceMaterials) -> Result<WriteReport, Error> {
        with_skins(self.metric().raw_view(), |views| write_glb_with(path, views, materials))
            .map_err(|error| failed(path, &error))
    }

    /// Writes the fragments as OBJ files into `folder`, which is made if it is not there: see [`write_obj`].
    ///
    /// # Errors
    /// Those of [`Self::write_glb`].
    pub fn write_obj(&self, folder: &Path) -> Result<WriteReport, Error> {
        self.with_object(|object| write_obj(folder, object)).map_err(|error| failed(folder, &error))
    }

    /// Writes the fragments as a model for MuJoCo, with the hulls and bonds that the result has: see [`write_mjcf`].
    ///
    /// # Errors
    /// Those of [`Self::write_glb`].
    pub fn write_mjcf(&self, path: &Path) -> Result<WriteReport, Error> {
        self.with_object(|object| write_mjcf(path, object)).map_err(|error| failed(path, &error))
    }

    /// Calls `read` with the whole result, as writers of models want it. Meshes are borrowed; those of a result in another convention
    /// are copied.
    pub fn with_object<R>(&self, read: impl FnOnce(&ObjectView<'_>) -> R) -> R {
        with_object(self.metric().raw_view(), read)
    }

    /// Calls `read` with all fragments, as writers of files want them. Meshes are borrowed; those of a result in another convention
    /// are copied.
    pub fn with_views<R>(&self, read: impl FnOnce(&[FragmentView<'_>]) -> R) -> R {
        with_views(self.metric().raw_view(), read)
    }
}

fn hulls_glb(view: ResultView<'_>, path: &Path) -> Result<WriteReport, ExportError> {
    let hulls: Vec<(Fragment<'_>, HullMesh<'_>, [RunView; 1])> = fragments(view)
        .filter_map(|fragment| {
            let hull = fragment.hull()?;
            let index_count = hull.indices.len() as u32;
            Some((fragment, hull, [RunView { crack: false, index_first: 0, index_count }]))
        })
        .collect();
    let plain = Appearance::default();
    let views: Vec<FragmentView<'_>> = hulls
        .iter()
        .map(|(fragment, hull, runs)| FragmentView {
            positions: hull.positions,
            indices: hull.indices,
            merges: &[],
            materials: &[],
            uvs2: &[],
            colors: &[],
            ..fragment_view(fragment, runs, &plain)
        })
        .collect();
    write_glb(path, &views)
}

/// Calls `read` with the visible surfaces of the fragments that have one.
fn with_skins<R>(view: ResultView<'_>, read: impl FnOnce(&[FragmentView<'_>]) -> R) -> R {
    let skinned: Vec<(Fragment<'_>, FragmentSkin<'_>)> =
        fragments(view).filter_map(|fragment| Some((fragment, fragment.skin()?))).collect();
    let meshes = VisibleMesh::all(&skinned, FragmentSurface::from_code(view.summary.surface));
    let visible = skinned.iter().zip(&meshes).filter(|(_, mesh)| !mesh.indices.is_empty());
    let views: Vec<FragmentView<'_>> = visible
        .map(|((fragment, _), mesh)| FragmentView {
            positions: &mesh.positions,
            indices: &mesh.indices,
            merges: &mesh.merges,
            materials: &mesh.materials,
            uvs2: &mesh.uvs2,
            colors: &mesh.colors,
            ..fragment_view(fragment, &mesh.runs, &mesh.appearance)
        })
        .collect();
    read(&views)
}

fn with_object<R>(view: ResultView<'_>, read: impl FnOnce(&ObjectView<'_>) -> R) -> R {
    let (name, has_hulls) = (view.summary.object(), !view.hulls.is_empty());
    let hulls: Vec<Option<HullView<'_>>> = fragments(view)
        .filter(|_| has_hulls)
        .map(|fragment| fragment.hull().map(|hull| HullView { positions: hull.positions, indices: hull.indices }))
        .collect();
    let bonds: Vec<Bond> = view.bonds.iter().map(Bond::from).collect();
    let (name, hulls, bonds) = (name.as_str(), hulls.as_slice(), bonds.as_slice());
    with_views(view, |fragments| read(&ObjectView { name, fragments, hulls, bonds }))
}

fn with_views<R>(view: ResultView<'_>, read: impl FnOnce(&[FragmentView<'_>]) -> R) -> R {
    let fragments: Vec<Fragment<'_>> = fragments(view).collect();
    let parts: Vec<(Vec<RunView>, Appearance)> =
        fragments.iter().map(|fragment| (runs(fragment), Appearance::of(fragment))).collect();
    let views: Vec<FragmentView<'_>> =
        fragments.iter().zip(&parts).map(|(fragment, (runs, own))| fragment_view(fragment, runs, own)).collect();
    read(&views)
}

fn runs(fragment: &Fragment<'_>) -> Vec<RunView> {
    let run = |run: crate::Run<'_>| RunView {
        crack: run.is_crack,
        index_first: run.index_first,
        index_count: run.indices.len() as u32,
    };
    fragment.runs().map(run).collect()
}

fn fragment_view<'a>(fragment: &Fragment<'a>, runs: &'a [RunView], appearance: &'a Appearance) -> FragmentView<'a> {
    FragmentView {
        id: fragment.id(),
        body: fragment.body(),
        positions: fragment.positions(),
        normals: &appearance.normals,
        uvs: &appearance.uvs,
        uvs2: fragment.outer_uvs2(),
        colors: fragment.outer_colors(),
        materials: fragment.materials(),
        indices: fragment.indices(),
        runs,
        merges: fragment.merges(),
        center_m: fragment.center_m(),
        volume_m3: fragment.volume_m3(),
        mass_kg: fragment.mass_kg(),
        inertia_kg_m2: fragment.inertia_kg_m2(),
    }
}

fn failed(path: &Path, error: &ExportError) -> Error {
    let message = error.to_string();
    if matches!(error, ExportError::NoMaterials { .. }) {
        return Error::new(ErrorKind::Effect, Effect::Attributes.name(), message);
    }
    let is_output = error.path().is_some() || matches!(error, ExportError::NoFragments);
    let kind = if is_output || error.materials_file().is_some() { ErrorKind::Output } else { ErrorKind::BadResult };
    Error::new(kind, error.materials_file().unwrap_or(path).display().to_string(), message)
}

#[cfg(test)]
mod tests;
