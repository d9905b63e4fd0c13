//! Reading of small files that another process of the user may have replaced, by a pipe for example.

use rustix::fs::{Mode, OFlags, open as open_file};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Longest file that is read, bytes.
const BYTES_MAX: u64 = 1 << 20;

/// Opens `path` for reading. Never waits: opening a pipe would wait for a writer.
///
/// # Errors
/// Those of the system; `InvalidInput` if it is not a regular file.
pub fn open(path: &Path) -> io::Result<File> {
    let file = File::from(open_file(path, OFlags::RDONLY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())?);
    if !file.metadata()?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
    }
    Ok(file)
}

/// Text of the file `path`, of which a long one is cut.
///
/// # Errors
/// Those of [`open`] and of reading.
pub fn read(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.take(BYTES_MAX).read_to_string(&mut text)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::fs::{CWD, FileType, mknodat};

    #[test]
    fn files_are_read_and_pipes_are_refused_without_waiting() {
        let folder = tempfile::tempdir().unwrap();
        let [file, pipe] = ["file", "pipe"].map(|name| folder.path().join(name));
        std::fs::write(&file, "text").unwrap();
        assert_eq!(read(&file).unwrap(), "text");
        mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        assert_eq!(read(&pipe).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        assert!(open(folder.path()).is_err() && open(&folder.path().join("none")).is_err());
    }
}
