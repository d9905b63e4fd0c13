//! Materials of a glTF file, with the textures, samplers and images that they use, for the file of its fragments.
//!
//! The JSON of each is kept as it is, with extensions and extras. Only images change: their bytes go into the buffer of the new file.

mod buffers;
mod extensions;
mod images;
mod references;
mod uri;

use super::ExportError;
use buffers::Buffers;
use serde_json::{Map, Value};
use shatter_proto::text::quoted;
use std::collections::BTreeSet;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

/// The materials of a `.glb` or `.gltf` file, with all that they need: textures, samplers and images.
///
/// Textures may use both sets of texture coordinates. Fragments have the second one if the object was baked with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceMaterials {
    path: PathBuf,
    pub(super) materials: Vec<Value>,
    pub(super) textures: Vec<Value>,
    pub(super) samplers: Vec<Value>,
    pub(super) images: Vec<SourceImage>,
    /// Extensions of these lists.
    pub(super) extensions_used: Vec<String>,
    /// Those of them without which no reader may show the materials.
    pub(super) extensions_required: Vec<String>,
}

/// An image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SourceImage {
    /// Its JSON, with `mimeType` and without the place of the bytes.
    pub members: Map<String, Value>,
    /// The encoded file.
    pub bytes: Vec<u8>,
}

impl SourceMaterials {
    /// Reads the mesh file that the object was baked from. Buffers and images of a `.gltf` are read from its own folder only.
    ///
    /// # Errors
    /// [`ExportError::ReadMaterials`], [`ExportError::MalformedMaterials`], or [`ExportError::RequiredExtension`].
    pub fn read(path: &Path) -> Result<Self, ExportError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let read = regular_file(path).and_then(|bytes| Self::parse(path, &bytes, folder));
        read.map_err(|defect| defect.of(path))
    }

    fn parse(path: &Path, bytes: &[u8], folder: &Path) -> Result<Self, Defect> {
        let (json, binary) = buffers::split(bytes)?;
        let root: Value = serde_json::from_slice(json)
            .map_err(|error| Defect::malformed("document", format!("{error}; give a .glb or .gltf file (glTF 2.0)")))?;
        check_version(&root)?;
        let [materials, textures, samplers, images] =
            ["materials", "textures", "samplers", "images"].map(|key| objects(&root, key));
        let (materials, textures, samplers) = (materials?, textures?, samplers?);
        let images = images?;
        references::check(&materials, &textures, samplers.len(), images.len())?;
        let lists = [&materials, &textures, &samplers, &images];
        let (extensions_used, extensions_required) = extensions::carried(&root, &lists)?;
        let images = images::read(images, &mut Buffers::new(&root, binary, folder), &extensions_used)?;
        let path = path.to_owned();
        Ok(Self { path, materials, textures, samplers, images, extensions_used, extensions_required })
    }

    /// Number of materials.
    pub fn count(&self) -> usize {
        self.materials.len()
    }

    /// Sets of texture coordinates that a material uses, which must exist.
    pub(super) fn texture_sets(&self, material: usize) -> BTreeSet<usize> {
        let mut sets = BTreeSet::new();
        references::texture_sets(&self.materials[material], &mut sets);
        sets
    }

    /// The file that was read.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Defect of a file of materials.
#[derive(Debug)]
enum Defect {
    /// A file that cannot be read: the glTF file itself or one beside it.
    Unreadable { path: PathBuf, source: io::Error },
    /// A part of the document that is invalid.
    Malformed { place: String, reason: String },
    /// A required extension that cannot be carried.
    Extension(String),
}

impl Defect {
    fn malformed(place: impl Display, reason: impl Display) -> Self {
        Self::Malformed { place: quoted(&place.to_string()), reason: reason.to_string() }
    }

    /// The error for the glTF file at `path`.
    fn of(self, path: &Path) -> ExportError {
        let path = path.to_owned();
        match self {
            Self::Unreadable { path: unreadable, source } => ExportError::ReadMaterials { path, unreadable, source },
            Self::Malformed { place, reason } => ExportError::MalformedMaterials { path, place, reason },
            Self::Extension(extension) => ExportError::RequiredExtension { path, extension: quoted(&extension) },
        }
    }
}

/// Bytes of a file. Refuses devices and pipes, which may never end.
fn regular_file(path: &Path) -> Result<Vec<u8>, Defect> {
    let unreadable = |source| Defect::Unreadable { path: path.to_owned(), source };
    if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(unreadable(io::Error::other("not a regular file")));
    }
    std::fs::read(path).map_err(unreadable)
}

fn check_version(root: &Value) -> Result<(), Defect> {
    match root["asset"]["version"].as_str() {
        Some(version) if version.starts_with("2.") => Ok(()),
        Some(version) => {
            let reason = format!("is {}; glTF 2.0 is needed: export it as that", quoted(version));
            Err(Defect::malformed("asset.version", reason))
        }
        None => Err(Defect::malformed("asset.version", "is missing; give a .glb or .gltf file (glTF 2.0)")),
    }
}

/// A list of objects of the document; empty if it is missing.
fn objects(root: &Value, key: &str) -> Result<Vec<Value>, Defect> {
    match root.get(key) {
        None => Ok(Vec::new()),
        Some(Value::Array(list)) if list.iter().all(Value::is_object) => Ok(list.clone()),
        Some(_) => Err(Defect::malformed(key, "is not a list of objects")),
    }
}

/// A number that is an index, an offset or a length; `None` if it is missing.
fn whole(object: &Value, key: &str, place: impl Display) -> Result<Option<usize>, Defect> {
    match object.get(key) {
        None => Ok(None),
        Some(value) => match value.as_u64().and_then(|number| usize::try_from(number).ok()) {
            Some(number) => Ok(Some(number)),
            None => Err(Defect::malformed(
                place,
                format!("its {key} is {}, not a whole number", quoted(&value.to_string())),
            )),
        },
    }
}

#[cfg(test)]
mod tests;
