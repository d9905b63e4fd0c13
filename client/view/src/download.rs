//! A result as one file for the browser to save.

use crate::impact_request::invalid;
use crate::zip::ZipArchive;
use shatter_client::{FractureResult, export};
use shatter_proto::{Error, ErrorKind};
use std::path::Path;

/// Format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Binary glTF.
    Glb,
    /// A ZIP archive of OBJ files.
    Obj,
    /// A ZIP archive of a model for MuJoCo and its meshes.
    Mjcf,
}

impl Format {
    /// The format of that name.
    ///
    /// # Errors
    /// `unknown_request` if there is none.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        match name {
            "glb" => Ok(Self::Glb),
            "obj" => Ok(Self::Obj),
            "mjcf" => Ok(Self::Mjcf),
            _ => Err(invalid("format", "must be `glb`, `obj` or `mjcf`")),
        }
    }
}

/// Name and contents of the file.
///
/// # Errors
/// Those of the writers of the client, `output` if a temporary folder cannot be used.
pub(crate) fn file(result: &FractureResult, format: Format) -> Result<(String, Vec<u8>), Error> {
    let object = result.summary().object;
    if format == Format::Glb {
        let bytes = result.with_views(export::glb_bytes);
        let (bytes, _) = bytes.map_err(|error| Error::new(ErrorKind::BadResult, "glb", error.to_string()))?;
        return Ok((format!("{object}-broken.glb"), bytes));
    }
    let failed = |error: std::io::Error| {
        Error::new(ErrorKind::Output, "download", format!("cannot write to a temporary folder: {error}; check TMPDIR"))
    };
    let folder = tempfile::Builder::new().prefix("shatter-view-").tempdir().map_err(failed)?;
    let name = format!("{object}-broken-{}.zip", if format == Format::Obj { "obj" } else { "mjcf" });
    match format {
        Format::Obj => drop(result.write_obj(&folder.path().join(&object))?),
        _ => drop(result.write_mjcf(&folder.path().join(format!("{object}.xml")))?),
    }
    let mut archive = ZipArchive::default();
    add(&mut archive, folder.path(), "").map_err(failed)?;
    Ok((name, archive.finish()))
}

/// Adds all files below `folder`, in the order of their names; hidden ones are not part of the result.
fn add(archive: &mut ZipArchive, folder: &Path, prefix: &str) -> std::io::Result<()> {
    let mut entries = std::fs::read_dir(folder)?.collect::<std::io::Result<Vec<_>>>()?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = format!("{prefix}{name}");
        if name.starts_with('.') {
            continue;
        }
        if entry.file_type()?.is_dir() {
            add(archive, &entry.path(), &format!("{path}/"))?;
        } else if !archive.add(&path, &std::fs::read(entry.path())?) {
            return Err(std::io::Error::other("the archive is larger than 4 GiB"));
        }
    }
    Ok(())
}
