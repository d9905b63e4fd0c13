//! Exclusive use of a folder while a set of files is written to it.

use super::ExportError;
use std::fs::{File, TryLockError};
use std::path::Path;

/// Lock on a folder, released when it is dropped or its process ends. It leaves no file behind.
#[derive(Debug)]
pub(super) struct FolderLock {
    /// The open folder, whose descriptor holds the lock; `None` where the system cannot lock folders.
    _folder: Option<File>,
}

impl FolderLock {
    /// Locks `folder`, which exists. Some network file systems lock no folders, and a folder without read permission cannot be opened.
    /// Writing goes on without a lock there.
    ///
    /// # Errors
    /// [`ExportError::FolderInUse`] while another lock on the folder exists, of this process or another one.
    pub(super) fn acquire(folder: &Path) -> Result<Self, ExportError> {
        let Ok(opened) = File::open(folder) else { return Ok(Self { _folder: None }) };
        match opened.try_lock() {
            Ok(()) => Ok(Self { _folder: Some(opened) }),
            Err(TryLockError::WouldBlock) => Err(ExportError::FolderInUse(folder.to_owned())),
            Err(TryLockError::Error(_)) => Ok(Self { _folder: None }),
        }
    }
}
