//! Output of commands: stdout, files and folders. Writing may fail and never panics.

use super::{CommandError, interrupt};
use shatter_cli_common as program;
use shatter_export::write_whole;
use shatter_proto::text;
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

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

/// Writes the file `path` whole or not at all, creates its folder if needed, and names the file on stderr.
///
/// # Errors
/// [`CommandError`] if standard output or the file cannot be written.
pub fn whole(path: &Path, bytes: &[u8]) -> Result<(), CommandError> {
    let _writing = interrupt::writing();
    write_whole(path, bytes).map_err(|error| CommandError::output(path, &error))?;
    eprintln!("wrote {}", text::message(&path.display().to_string()));
    Ok(())
}

/// Creates `folder` if needed and checks that it can be written, before the work begins.
///
/// # Errors
/// [`CommandError`] if standard output or the file cannot be written.
pub fn folder(folder: &Path) -> Result<(), CommandError> {
    let failed = |error: std::io::Error| CommandError::output(folder, &error);
    if let Some(other) = folder.ancestors().find(|path| path.exists()).filter(|path| !path.is_dir()) {
        let kind = kind(other);
        let message = match other == folder {
            true => format!("is {kind}, not a folder; nothing can be written there; name a folder"),
            false => format!("cannot be made: {} is {kind}, not a folder; name another folder", other.display()),
        };
        return Err(CommandError::output(folder, &message));
    }
    std::fs::create_dir_all(folder).map_err(failed)?;
    tempfile::tempfile_in(folder).map(drop).map_err(failed)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_folders_are_checked_before_the_work() {
        let place = tempfile::tempdir().unwrap();
        folder(&place.path().join("new/er")).unwrap();
        let refused = |path: &Path| folder(path).unwrap_err().message().to_owned();
        let device = refused(Path::new("/dev/full"));
        assert!(device.starts_with("/dev/full: is a device, not a folder; nothing can be written there"), "{device}");
        let below = refused(Path::new("/dev/full/a/b"));
        assert!(below.contains("cannot be made: /dev/full is a device, not a folder"), "{below}");
        let file = place.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(refused(&file).contains("is a file, not a folder"), "{}", refused(&file));
        assert!(refused(&file.join("below")).contains("file is a file, not a folder"));
        let pipe = place.path().join("pipe");
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, rustix::fs::Mode::RUSR, 0).unwrap();
        assert!(refused(&pipe).contains("is a pipe, not a folder"));
    }
}
