//! From the arguments of `shatter view` to a daemon that serves the objects.

use crate::daemon::ViewDaemon;
use crate::programs::{absent, daemon_program};
use shatter_proto::{Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use tempfile::TempDir;

/// Ending of databases.
pub(crate) const DATABASE_ENDING: &str = "shatter";

/// Name of the generated object that is shown if there is no other.
const SAMPLE: &str = "mug";

/// Arguments of the bake of [`SAMPLE`]: those of `shatterd demo`, without examples, which take most of its time.
const SAMPLE_ARGUMENTS: [&str; 8] =
    ["bake", "--shape", SAMPLE, "--material", "ceramic", "--fragment-size", "0.018", "--restart"];

/// Objects to show.
pub struct ViewTargets {
    /// A daemon that serves them. Dropped before the folder.
    pub daemon: ViewDaemon,
    /// Folder with the databases of the arguments; removed when it is dropped.
    _folder: Option<TempDir>,
}

impl ViewTargets {
    /// The daemon, and a guard that removes the folder of its databases: drop the guard last.
    #[must_use]
    pub fn into_parts(self) -> (ViewDaemon, Option<TempDir>) {
        (self.daemon, self._folder)
    }
}

/// Finds or starts a daemon for `files`, databases or mesh files, which are baked first.
///
/// Without files the daemon of `service` is used, if one runs. If none runs, one is started for the databases of the platform's data
/// folder; if there are none either, a mug is baked for it. With files, a daemon of its own is started, for them alone.
///
/// # Errors
/// `database_folder` for a file that is not there, or without a data folder; `configuration` without `shatterd`; `failed` if a bake or
/// the daemon fails; those of the client for a running daemon that cannot be used.
pub fn prepare(service: &str, files: &[PathBuf]) -> Result<ViewTargets, Error> {
    if files.is_empty() {
        let daemon = match ViewDaemon::running(service) {
            Err(error) if error.kind == ErrorKind::NoDaemon => {
                ViewDaemon::start(service, &default_databases()?, false)?
            }
            running => running?,
        };
        return Ok(ViewTargets { daemon, _folder: None });
    }
    let folder = tempfile::Builder::new().prefix("shatter-view-").tempdir().map_err(|error| temporary(&error))?;
    for file in files {
        add(folder.path(), file)?;
    }
    // A daemon that runs under this name may be another one's.
    let own = match ViewDaemon::running(service) {
        Err(error) if error.kind == ErrorKind::NoDaemon => service.to_owned(),
        _ => format!("view-{}", std::process::id()),
    };
    let daemon = ViewDaemon::start(&own, folder.path(), true)?;
    Ok(ViewTargets { daemon, _folder: Some(folder) })
}

fn temporary(error: &std::io::Error) -> Error {
    Error::new(ErrorKind::Output, "TMPDIR", format!("cannot write to a temporary folder: {error}; check TMPDIR"))
}

/// Links a database into `folder`, or bakes a mesh there.
fn add(folder: &Path, file: &Path) -> Result<(), Error> {
    let shown = file.display();
    let at = || file.display().to_string();
    let absolute = file.canonicalize().map_err(|error| {
        Error::new(
            ErrorKind::DatabaseFolder,
            at(),
            format!("cannot read {shown}: {error}; give a database or a mesh file"),
        )
    })?;
    let stem = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    if file.extension().is_some_and(|ending| ending == DATABASE_ENDING) {
        let link = folder.join(format!("{stem}.{DATABASE_ENDING}"));
        return std::os::unix::fs::symlink(absolute, link).map_err(|error| temporary(&error));
    }
    let mut command = daemon_program();
    command.arg("bake").arg(absolute).args(["--restart", "--name", &stem, "--out"]).arg(folder);
    bake(command, &at())
}

/// Runs a bake, whose progress goes to stderr. It ends with this process.
fn bake(mut command: std::process::Command, at: &str) -> Result<(), Error> {
    command.arg("--end-with-stdin").stdin(Stdio::piped()).stdout(Stdio::null());
    let mut child = command.spawn().map_err(|error| absent(&error))?;
    // Waiting closes the pipe that the child still holds.
    let pipe = child.stdin.take();
    let status = child.wait().map_err(|error| absent(&error))?;
    drop(pipe);
    if status.success() {
        return Ok(());
    }
    let is_refused = status.code() == Some(shatter_proto::exit::REFUSED.into());
    let kind = if is_refused { ErrorKind::CorruptObject } else { ErrorKind::Failed };
    Err(Error::new(kind, at, format!("the bake of {at} failed ({status}); its message is above")))
}

/// The platform's data folder if it holds databases, else a folder with a generated object.
fn default_databases() -> Result<PathBuf, Error> {
    let folder = data_folder().ok_or_else(|| {
        let message = "no home folder, so no default folder for databases; give a database or a mesh file";
        Error::new(ErrorKind::DatabaseFolder, "HOME", message)
    })?;
    if has_database(&folder) {
        return Ok(folder);
    }
    let own = folder.join("view");
    if !has_database(&own) {
        let mut command = daemon_program();
        command.args(SAMPLE_ARGUMENTS).arg("--out").arg(&own);
        bake(command, SAMPLE)?;
    }
    Ok(own)
}

fn has_database(folder: &Path) -> bool {
    let Ok(entries) = std::fs::read_dir(folder) else { return false };
    entries.flatten().any(|entry| {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        !name.starts_with('.') && name.ends_with(&format!(".{DATABASE_ENDING}"))
    })
}

/// Folder where `shatterd bake` writes (XDG Base Directory Specification).
pub(crate) fn data_folder() -> Option<PathBuf> {
    let given = std::env::var_os("XDG_DATA_HOME").map(PathBuf::from).filter(|folder| folder.is_absolute());
    given
        .or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".local/share")))
        .map(|data| data.join("shatter"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn databases_are_found_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        assert!(!has_database(folder.path()) && !has_database(&folder.path().join("absent")));
        std::fs::write(folder.path().join(".a.shatter"), "").unwrap();
        std::fs::write(folder.path().join("a.toml"), "").unwrap();
        assert!(!has_database(folder.path()));
        std::fs::write(folder.path().join("a.shatter"), "").unwrap();
        assert!(has_database(folder.path()));
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = add(folder.path(), Path::new("no/such.obj")).unwrap_err();
        assert!(error.message.contains("no/such.obj"), "{error}");
        std::fs::write(folder.path().join("b.shatter"), "x").unwrap();
        let other = tempfile::tempdir().unwrap();
        add(other.path(), &folder.path().join("b.shatter")).unwrap();
        assert_eq!(std::fs::read(other.path().join("b.shatter")).unwrap(), b"x");
    }
}
