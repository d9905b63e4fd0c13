//! Files appear whole or not at all: written aside in the same folder, then renamed.

use super::{ExportError, FragmentView, WriteReport, glb_bytes};
use std::fs::Permissions;
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// What a new file may be, before the process's mask is taken off.
const FILE_MODE: u32 = 0o666;

/// Writes `fragments` to `path`. On failure the folder is as it was.
///
/// # Errors
/// [`ExportError`] by the figure that makes no valid file, or by the file that cannot be written.
pub fn write_glb(path: &Path, fragments: &[FragmentView<'_>]) -> Result<WriteReport, ExportError> {
    let (bytes, written) = glb_bytes(fragments)?;
    write_whole(path, &bytes)?;
    Ok(WriteReport { files: vec![path.to_owned()], ..written })
}

/// Where `path` leads: itself, or the file that a link of that name stands for. What is neither a file nor new would be lost if a file
/// took its place: a device, a pipe.
pub(super) fn target(path: &Path) -> Result<PathBuf, ExportError> {
    let failed = |source: io::Error| ExportError::Write { path: path.to_owned(), source };
    let target = if path.is_symlink() { std::fs::canonicalize(path).map_err(failed)? } else { path.to_owned() };
    if target.is_dir() {
        return Err(ExportError::IsFolder(path.to_owned()));
    }
    if target.exists() && !target.is_file() {
        return Err(ExportError::NoFile(path.to_owned()));
    }
    Ok(target)
}

/// Writes `bytes` to `path`, replacing a file of that name; a reader sees the old file or the new one, never a part. Its folder is
/// made if it is not there, with those above it.
///
/// # Errors
/// The folder or the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    let path = &target(path)?;
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let in_folder = |source: io::Error| ExportError::Folder { folder: folder.to_owned(), source };
    std::fs::create_dir_all(folder).map_err(in_folder)?;
    let mut aside = tempfile::Builder::new()
        .prefix(".shatter-")
        .permissions(Permissions::from_mode(FILE_MODE))
        .tempfile_in(folder)
        .map_err(|error| in_folder(plain(error)))?;
    let failed = |source: io::Error| ExportError::Write { path: path.to_owned(), source };
    aside.write_all(bytes).map_err(failed)?;
    aside.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// The system's reason without the name of the file aside, which says nothing to anyone.
fn plain(error: io::Error) -> io::Error {
    error.kind().into()
}
