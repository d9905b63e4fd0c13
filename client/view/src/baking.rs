//! The bake of a mesh file of the page, by `shatterd bake` as a child process.

use crate::child_process::ChildProcess;
use crate::impact_request::invalid;
use crate::programs::{absent, daemon_program};
use crate::worker::Reply;
use serde_json::{Value, json};
use shatter_proto::{Error, ErrorKind};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use tempfile::TempDir;
use tokio::sync::mpsc::Sender;

/// Endings of mesh files that the page may send: one file holds all.
const ENDINGS: [&str; 8] = ["obj", "ply", "stl", "glb", "gltf", "msh", "vtk", "mesh"];

/// Longest report of a bake, bytes.
const REPORT_BYTES_MAX: u64 = 16 << 20;

/// A bake under way. Dropping it ends the process.
pub(crate) struct BakeJob {
    process: Arc<Mutex<Option<ChildProcess>>>,
}

impl Drop for BakeJob {
    fn drop(&mut self) {
        drop(self.process.lock().unwrap_or_else(PoisonError::into_inner).take());
    }
}

/// Starts the bake of `contents` into `folder` (`None`: the platform's). Progress and the report go to `replies`.
///
/// # Errors
/// `unknown_request` for a name or an option that does not fit, `output` if the file cannot be written, `configuration` if the program
/// cannot be started.
pub(crate) fn start(
    id: u64,
    head: &Value,
    contents: &[u8],
    folder: Option<&Path>,
    replies: Sender<Reply>,
) -> Result<BakeJob, Error> {
    let (temporary, mut command) = command(head, contents, folder)?;
    let mut process = ChildProcess::start(&mut command).map_err(|error| absent(&error))?;
    let outputs = (process.child().stdout.take(), process.child().stderr.take());
    let process = Arc::new(Mutex::new(Some(process)));
    let shared = process.clone();
    std::thread::spawn(move || {
        let (Some(stdout), Some(stderr)) = outputs else { return };
        let report = std::thread::spawn(move || {
            let mut text = String::new();
            // A report that cannot be read is empty.
            let _ = stdout.take(REPORT_BYTES_MAX).read_to_string(&mut text);
            text
        });
        for line in BufReader::new(stderr).lines().map_while(Result::ok) {
            let line = line.strip_prefix("shatterd: ").unwrap_or(&line).to_owned();
            let message = json!({ "id": id, "reply": "progress", "line": line });
            if replies.blocking_send(Reply::Text(message.to_string())).is_err() {
                // The page went away: the job is dropped with its worker.
                return;
            }
        }
        let report = report.join().unwrap_or_default();
        let was_canceled = shared.lock().unwrap_or_else(PoisonError::into_inner).take().is_none();
        drop(temporary);
        let _ = replies.blocking_send(Reply::Text(outcome(id, &report, was_canceled).to_string()));
    });
    Ok(BakeJob { process })
}

/// The document for the page: the report of the bake, or its error.
fn outcome(id: u64, report: &str, was_canceled: bool) -> Value {
    let error = |error: Error| {
        let mut document = error.document();
        document["id"] = json!(id);
        document
    };
    if was_canceled {
        return error(Error::new(ErrorKind::Canceled, "bake", "the bake was canceled"));
    }
    match serde_json::from_str::<Value>(report) {
        Ok(mut document) if document.get("error").is_some() => {
            document["id"] = json!(id);
            document
        }
        Ok(document) => json!({ "id": id, "reply": "baked", "report": document }),
        Err(_) => error(Error::new(ErrorKind::Failed, "bake", "the bake ended without a report")),
    }
}

/// The command, and the folder of the mesh file.
fn command(head: &Value, contents: &[u8], folder: Option<&Path>) -> Result<(TempDir, Command), Error> {
    let given = head["file"].as_str().ok_or_else(|| invalid("file", "must be the name of a file"))?;
    let ending = given.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase()).unwrap_or_default();
    if !ENDINGS.contains(&ending.as_str()) {
        return Err(invalid("file", format!("a mesh file ends with one of .{}", ENDINGS.join(", ."))));
    }
    let failed = |error: std::io::Error| {
        Error::new(
            ErrorKind::Output,
            "mesh",
            format!("cannot write the mesh to a temporary folder: {error}; check TMPDIR"),
        )
    };
    let temporary = tempfile::Builder::new().prefix("shatter-view-").tempdir().map_err(failed)?;
    let file = temporary.path().join(format!("mesh.{ending}"));
    std::fs::write(&file, contents).map_err(failed)?;
    let mut command = daemon_program();
    command.arg("bake").arg(&file).args(["--json", "--restart"]);
    for (key, option) in [
        ("name", "--name"),
        ("material", "--material"),
        ("unit", "--unit"),
        ("up", "--up"),
        ("quality", "--quality"),
        ("fragment_size_m", "--fragment-size"),
    ] {
        let value = match &head[key] {
            Value::Null => continue,
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        command.arg(format!("{option}={value}"));
    }
    if let Some(folder) = folder {
        command.arg("--out").arg(folder);
    }
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    Ok((temporary, command))
}
