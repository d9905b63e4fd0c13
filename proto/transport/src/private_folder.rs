//! A folder that belongs to one user alone, held open: another one that takes its place under the same name is found out, and nothing is
//! ever written into that.

use crate::paths::trusted;
use rustix::fs::{AtFlags, Mode, OFlags, fstat, open, openat, renameat, unlinkat};
use rustix::io::Errno;
use shatter_proto::{Error, ErrorKind};
use std::fs::File;
use std::io::{self, Write};
use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// A folder that was its owner's alone when it was opened.
#[derive(Debug)]
pub struct PrivateFolder {
    path: PathBuf,
    uid: u32,
    handle: OwnedFd,
    /// Device and number of the folder, by which it is known again.
    identity: (u64, u64),
}

impl PrivateFolder {
    /// Opens the folder `path` of user `uid`.
    ///
    /// # Errors
    /// `runtime_folder`: it is not there, not a folder, another user's, or open to others.
    pub fn open(path: &Path, uid: u32) -> Result<Self, Error> {
        let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let handle = open(path, flags, Mode::empty()).map_err(|error| changed(path, &error.to_string()))?;
        let data = fstat(&handle).map_err(|error| changed(path, &error.to_string()))?;
        let folder = Self { path: path.to_owned(), uid, handle, identity: (data.st_dev, data.st_ino) };
        folder.check()?;
        Ok(folder)
    }

    /// Refuses a folder that was removed or replaced since, or that others can change now.
    ///
    /// # Errors
    /// `runtime_folder`.
    pub fn check(&self) -> Result<(), Error> {
        trusted(&self.path, self.uid)?;
        match self.path.symlink_metadata() {
            Ok(data) if (data.dev(), data.ino()) == self.identity => Ok(()),
            Ok(_) => Err(changed(&self.path, "another folder lies in its place")),
            Err(error) => Err(changed(&self.path, &error.to_string())),
        }
    }

    /// Writes a file of the folder: readers see the old contents or the new ones. It goes into the folder that was opened, whatever its
    /// path names now, and through no link.
    ///
    /// # Errors
    /// Those of the file system; the folder is gone.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let aside = format!("{name}.new");
        match unlinkat(&self.handle, aside.as_str(), AtFlags::empty()) {
            Ok(()) | Err(Errno::NOENT) => {}
            Err(error) => return Err(error.into()),
        }
        let flags = OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::WRONLY | OFlags::CLOEXEC;
        let file = openat(&self.handle, aside.as_str(), flags, Mode::RUSR | Mode::WUSR)?;
        File::from(file).write_all(bytes)?;
        Ok(renameat(&self.handle, aside.as_str(), &self.handle, name)?)
    }
}

fn changed(path: &Path, why: &str) -> Error {
    let message = format!("the runtime folder {} cannot be used: {why}", path.display());
    Error::new(ErrorKind::RuntimeFolder, path.display().to_string(), message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{DirBuilderExt, symlink};

    fn make(path: &Path) {
        std::fs::DirBuilder::new().mode(0o700).create(path).unwrap();
    }

    #[test]
    fn a_replaced_folder_is_detected_and_not_written_to() {
        let root = tempfile::tempdir().unwrap();
        let (path, precious) = (root.path().join("own"), root.path().join("precious"));
        std::fs::write(&precious, "precious").unwrap();
        make(&path);
        let folder = PrivateFolder::open(&path, rustix::process::geteuid().as_raw()).unwrap();
        folder.write("a", b"1").unwrap();
        folder.write("a", b"2").unwrap();
        assert_eq!(std::fs::read(path.join("a")).unwrap(), b"2");
        symlink(&precious, path.join("a.new")).unwrap();
        folder.write("a", b"3").unwrap();
        assert_eq!(std::fs::read(path.join("a")).unwrap(), b"3");
        folder.check().unwrap();
        std::fs::remove_dir_all(&path).unwrap();
        assert!(folder.check().is_err() && folder.write("a", b"4").is_err());
        make(&path);
        symlink(&precious, path.join("a.new")).unwrap();
        assert!(folder.check().unwrap_err().message.contains("another folder"));
        assert!(folder.write("a", b"5").is_err() && !path.join("a").exists());
        assert_eq!(std::fs::read(&precious).unwrap(), b"precious");
    }

    #[test]
    fn links_and_open_folders_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let uid = rustix::process::geteuid().as_raw();
        let path = root.path().join("own");
        make(&path);
        symlink(&path, root.path().join("link")).unwrap();
        assert!(PrivateFolder::open(&root.path().join("link"), uid).is_err());
        assert!(PrivateFolder::open(&path, uid.wrapping_add(1)).is_err());
        std::fs::DirBuilder::new().mode(0o755).create(root.path().join("open")).unwrap();
        assert!(PrivateFolder::open(&root.path().join("open"), uid).is_err());
    }
}
