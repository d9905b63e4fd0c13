//! `shatterd check` of a scene that the page made.

use crate::daemon::ViewDaemon;
use crate::programs::{absent, daemon_program};
use crate::start::{DATABASE_ENDING, data_folder};
use serde_json::{Value, json};
use shatter_proto::{Error, ErrorKind};
use std::path::Path;
use std::process::Stdio;

/// Longest scene, bytes.
const SCENE_BYTES_MAX: usize = 1 << 20;

/// Checks the text of a scene, with a file `paint.ply` beside it if there is one, against the databases of `databases` (`None`: the
/// platform's folder).
///
/// # Errors
/// `configuration` for a scene that is too long, or if the program cannot be started; `output` if a temporary file cannot be written.
pub(crate) fn check(scene: &str, paint: Option<&str>, databases: Option<&Path>) -> Result<Value, Error> {
    if scene.len() > SCENE_BYTES_MAX {
        return Err(Error::new(ErrorKind::Configuration, "scene", "the scene is longer than 1 MiB"));
    }
    let failed = |error: std::io::Error| {
        Error::new(ErrorKind::Output, "scene", format!("cannot write a temporary file: {error}; check TMPDIR"))
    };
    let folder = tempfile::Builder::new().prefix("shatter-view-").tempdir().map_err(failed)?;
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, scene).map_err(failed)?;
    if let Some(paint) = paint {
        std::fs::write(folder.path().join("paint.ply"), paint).map_err(failed)?;
    }
    let mut command = daemon_program();
    command.arg("check").arg(&file).arg("--json").stdin(Stdio::null());
    if let Some(databases) = databases {
        command.arg("--databases").arg(databases);
    }
    let output = command.output().map_err(|error| absent(&error))?;
    // Messages name the files as they are saved, without the temporary folder.
    let text = String::from_utf8_lossy(&output.stdout).replace(&format!("{}/", folder.path().display()), "");
    let document: Value = serde_json::from_str(&text).unwrap_or(Value::Null);
    Ok(json!({ "reply": "scene", "accepted": output.status.success(), "document": document }))
}

/// The folder where the database of `object` lies, for the commands that serve the scene: `null` if the daemon is another program's and
/// the platform's folder has no such database.
pub(crate) fn folder(object: &str, daemon: &ViewDaemon) -> Value {
    let served = daemon.databases().map(Path::to_owned).or_else(data_folder);
    let file =
        served.as_ref().and_then(|folder| folder.join(format!("{object}.{DATABASE_ENDING}")).canonicalize().ok());
    let Some(path) = file.as_deref().and_then(Path::parent) else { return Value::Null };
    // A database that was given lies where it was, and the folder holds a link to it.
    let is_own = served.as_deref().and_then(|folder| folder.canonicalize().ok()).is_some_and(|folder| folder == path);
    json!({ "path": path.display().to_string(), "is_temporary": is_own && daemon.has_temporary_folder() })
}
