//! Atomic writes of files: to a temporary file in the same folder, then renamed.

use super::{ExportError, FragmentView, SourceMaterials, WriteReport, glb_bytes, glb_bytes_with};
use std::fs::Permissions;
use std::io::{self, Write};
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
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

/// As [`write_glb`], with the materials and textures of the mesh file.
///
/// # Errors
/// Those of [`write_glb`]; fragments whose materials are not those of the file.
pub fn write_glb_with(
    path: &Path,
    fragments: &[FragmentView<'_>],
    materials: &SourceMaterials,
) -> Result<WriteReport, ExportError> {
    let (bytes, written) = glb_bytes_with(fragments, materials)?;
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

/// Removes the table of an earlier result, so that it never lies beside files of another one. Returns the path of the new table: the file
/// itself if `path` is a link, which stays.
///
/// # Errors
/// Anything but a regular file lies there, or it cannot be removed.
pub(super) fn remove_table(path: &Path) -> Result<PathBuf, ExportError> {
    let table = target(path)?;
    match std::fs::remove_file(&table) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            Err(ExportError::Write { path: path.to_owned(), source })
        }
        _ => Ok(table),
    }
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
    make_folder(folder)?;
    let mut aside = tempfile::Builder::new()
        .prefix(".shatter-")
        .permissions(Permissions::from_mode(FILE_MODE))
        .tempfile_in(folder)
        .map_err(|error| in_folder(in_existing_folder(plain(error))))?;
    let failed = |source: io::Error| ExportError::Write { path: path.to_owned(), source };
    aside.write_all(bytes).map_err(failed)?;
    aside.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Creates `folder`, with the folders above it, if it does not exist.
///
/// # Errors
/// [`ExportError::NotAFolder`] if a part of the path is a file, a device or the like; [`ExportError::MakeFolder`] if the system refuses.
pub fn make_folder(folder: &Path) -> Result<(), ExportError> {
    if let Some(part) = folder.ancestors().find(|part| part.exists()).filter(|part| !part.is_dir()) {
        return Err(ExportError::NotAFolder { folder: folder.to_owned(), part: part.to_owned(), kind: kind(part) });
    }
    std::fs::create_dir_all(folder).map_err(|error| {
        let reason = match error.kind() {
            // Only the missing folders are made, so nothing that is needed is missing.
            io::ErrorKind::NotFound => format!("the file system there makes no folders ({error})"),
            _ => error.to_string(),
        };
        ExportError::MakeFolder { folder: folder.to_owned(), reason }
    })
}

/// Explains the failure to create a file in a folder that exists.
fn in_existing_folder(error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::NotFound => io::Error::other("the file system there makes no files"),
        _ => error,
    }
}

/// Kind of what exists at `path` other than a folder, in words.
fn kind(path: &Path) -> &'static str {
    match std::fs::metadata(path).map(|data| data.file_type()) {
        Ok(kind) if kind.is_file() => "a file",
        Ok(kind) if kind.is_char_device() || kind.is_block_device() => "a device",
        Ok(kind) if kind.is_fifo() => "a pipe",
        Ok(kind) if kind.is_socket() => "a socket",
        _ => "no regular file",
    }
}

/// The system's reason without the name of the temporary file.
fn plain(error: io::Error) -> io::Error {
    error.kind().into()
}
