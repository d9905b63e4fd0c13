//! The shown pieces as one file for the browser to save.

use crate::impact_request::invalid;
use crate::shown_pieces::{ShownPieces, with_object};
use crate::zip::ZipArchive;
use shatter_client::export::{self, ExportError};
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

/// Name and contents of the file with the pieces `shown` of `object`; `is_whole`: they are the object as it was.
///
/// # Errors
/// `bad_result` for pieces that make no valid file, `output` if a temporary folder cannot be used.
pub(crate) fn file(
    object: &str,
    shown: &[ShownPieces],
    is_whole: bool,
    format: Format,
) -> Result<(String, Vec<u8>), Error> {
    let stem = if is_whole { object.to_owned() } else { format!("{object}-broken") };
    let wrong = |error: ExportError| Error::new(ErrorKind::BadResult, "download", error.to_string());
    if format == Format::Glb {
        let (bytes, _) = with_object(object, shown, &mut |view| export::glb_bytes(view.fragments)).map_err(wrong)?;
        return Ok((format!("{stem}.glb"), bytes));
    }
    let failed = |error: std::io::Error| {
        Error::new(ErrorKind::Output, "download", format!("cannot write to a temporary folder: {error}; check TMPDIR"))
    };
    let folder = tempfile::Builder::new().prefix("shatter-view-").tempdir().map_err(failed)?;
    let name = format!("{stem}-{}.zip", if format == Format::Obj { "obj" } else { "mjcf" });
    let mut write = |view: &export::ObjectView<'_>| match format {
        Format::Obj => export::write_obj(&folder.path().join(object), view),
        _ => export::write_mjcf(&folder.path().join(format!("{object}.xml")), view),
    };
    with_object(object, shown, &mut write).map_err(wrong)?;
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
