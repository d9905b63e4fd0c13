//! Output of commands: stdout, stderr, files and folders. Writing may fail and never panics.

use super::{CommandError, interrupt};
use shatter_cli_common as program;
use shatter_export::{ExportError, make_folder, write_whole};
use shatter_proto::{Error, ErrorKind, text};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes `text` to stdout.
///
/// # Errors
/// [`CommandError`] if standard output or the file cannot be written.
pub fn print(text: &str) -> Result<(), CommandError> {
    Ok(program::print(format_args!("{text}"))?)
}

/// Writes `text` to stdout line by line, without control characters that come from files or names.
///
/// # Errors
/// [`CommandError`] if standard output or the file cannot be written.
pub fn lines(text: &str) -> Result<(), CommandError> {
    print(&text.lines().map(|line| text::escaped(line) + "\n").collect::<String>())
}

/// Writes a line to stderr, without control characters that come from files or names. If stderr is closed, the line is lost.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{}", text::message(line));
}

/// Writes the file `path` whole or not at all, creates its folder if needed, and names the file on stderr.
///
/// # Errors
/// [`CommandError`] if standard output or the file cannot be written.
pub fn whole(path: &Path, bytes: &[u8]) -> Result<(), CommandError> {
    let _writing = interrupt::writing();
    write_whole(path, bytes)?;
    note(&format!("wrote {}", path.display()));
    Ok(())
}

/// Creates `folder`, which `--out` names, if needed, and checks that it can be written, before the work begins.
///
/// # Errors
/// [`CommandError`] if standard output or the file cannot be written.
pub fn folder(folder: &Path) -> Result<(), CommandError> {
    let probe = || tempfile::tempfile_in(folder).map(drop);
    let in_folder = |source| ExportError::Folder { folder: folder.to_owned(), source };
    make_folder(folder).and_then(|()| probe().map_err(in_folder)).map_err(|error| {
        let message = format!("{error} (--out)");
        Error::new(ErrorKind::Output, folder.display().to_string(), message).into()
    })
}

/// Folders that do not exist yet. When this is dropped, those that were made since and are empty are removed.
pub struct EmptyFolders(Vec<PathBuf>);

impl EmptyFolders {
    /// `folder` and those above it, as far as they do not exist.
    pub fn before(folder: &Path) -> Self {
        let is_named = |own: &&Path| !own.as_os_str().is_empty();
        Self(folder.ancestors().filter(is_named).take_while(|own| !own.exists()).map(Path::to_owned).collect())
    }
}

impl Drop for EmptyFolders {
    fn drop(&mut self) {
        // Only empty folders can be removed.
        self.0.iter().all(|folder| std::fs::remove_dir(folder).is_ok());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_that_stay_empty_are_removed() {
        let place = tempfile::tempdir().unwrap();
        let (outer, inner) = (place.path().join("new"), place.path().join("new/er"));
        let made = EmptyFolders::before(&inner);
        folder(&inner).unwrap();
        drop(made);
        assert!(!outer.exists() && place.path().exists());
        let made = EmptyFolders::before(&inner);
        folder(&inner).unwrap();
        std::fs::write(outer.join("file"), "").unwrap();
        drop(made);
        assert!(outer.join("file").exists() && !inner.exists());
        drop(EmptyFolders::before(&outer));
        assert!(outer.exists());
    }

    #[test]
    fn output_folders_are_checked_before_the_work() {
        let place = tempfile::tempdir().unwrap();
        folder(&place.path().join("new/er")).unwrap();
        let refused = |path: &Path| folder(path).unwrap_err().message().to_owned();
        let device = refused(Path::new("/dev/full"));
        assert_eq!(device, "/dev/full is a device, not a folder; choose another path (--out)");
        let below = refused(Path::new("/dev/full/a/b"));
        assert!(below.starts_with("cannot make the folder /dev/full/a/b: /dev/full is a device"), "{below}");
        let fixed = refused(Path::new("/proc/shatter/a"));
        assert!(fixed.starts_with("cannot make the folder /proc/shatter/a: the file system there"), "{fixed}");
        assert!(fixed.ends_with("; choose another path (--out)"), "{fixed}");
        let file = place.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(refused(&file).contains("is a file, not a folder"), "{}", refused(&file));
        assert!(refused(&file.join("below")).contains("file is a file, not a folder"));
        let pipe = place.path().join("pipe");
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, rustix::fs::Mode::RUSR, 0).unwrap();
        assert!(refused(&pipe).contains("is a pipe, not a folder"));
    }
}
