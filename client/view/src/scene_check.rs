//! `shatterd check` of a scene that the page made.

use crate::programs::{absent, daemon_program};
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
