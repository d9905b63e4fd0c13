//! Atomic writes of files: to a temporary file in the same folder, then renamed.

use super::{ExportError, FragmentView, WriteReport, glb_bytes};
use std::fs::Permissions;
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// Permissions of a new file, before the umask of the process applies.
const FILE_MODE: u32 = 0o666;

/// Writes `fragments` to the `.glb` file `path`. On failure the folder is unchanged.
///
/// # Errors
/// [`ExportError`] by the figure that makes no valid file, or by the file that cannot be written.
pub fn write_glb(path: &Path, fragments: &[FragmentView<'_>]) -> Result<WriteReport, ExportError> {
    let (bytes, written) = glb_bytes(fragments)?;
    write_whole(path, &bytes)?;
    Ok(WriteReport { files: vec![path.to_owned()], ..written })
}

/// The file that `path` names, directly or through a link. Refuses anything else that exists, such as a device or a pipe, because replacing
/// it would lose it.
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

/// Writes `bytes` to `path`, and replaces a file of that name. A reader sees the old file or the new one, never a part. Creates missing
/// folders.
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

/// The system's reason without the name of the temporary file.
fn plain(error: io::Error) -> io::Error {
    error.kind().into()
}
