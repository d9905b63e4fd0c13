//! Output of commands: stdout, files and folders. Writing may fail and never panics.

use super::{CommandError, interrupt};
use shatter_cli_common as program;
use shatter_export::write_whole;
use shatter_proto::text;
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
    if folder.is_file() {
        return Err(CommandError::output(folder, &"is a file; name a folder"));
    }
    std::fs::create_dir_all(folder).map_err(failed)?;
    tempfile::tempfile_in(folder).map(drop).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_folders_are_checked_before_the_work() {
        let place = tempfile::tempdir().unwrap();
        folder(&place.path().join("new/er")).unwrap();
        assert!(folder(Path::new("/dev/null/below")).is_err());
    }
}
