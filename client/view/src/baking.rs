//! The bake of a mesh file of the page, by `shatterd bake` as a child process.

use crate::child_process::ChildProcess;
use crate::impact_request::invalid;
use crate::programs::{absent, daemon_program};
use crate::worker::{Reply, WorkerSetup};
use serde_json::{Value, json};
use shatter_proto::{Error, ErrorKind};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{ChildStderr, ChildStdout, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use tempfile::TempDir;
use tokio::sync::mpsc::Sender;

/// Endings of mesh files that the page may send: one file holds all.
const ENDINGS: [&str; 8] = ["obj", "ply", "stl", "glb", "gltf", "msh", "vtk", "mesh"];

/// Longest report of a bake, bytes.
const REPORT_BYTES_MAX: u64 = 16 << 20;

/// A bake under way: its process, then the folder of its mesh. Empty once it ended.
type RunningBake = Mutex<Option<(ChildProcess, TempDir)>>;

/// Ends a bake, if it still runs. Returns whether it did.
fn end(bake: &RunningBake) -> bool {
    let running = bake.lock().unwrap_or_else(PoisonError::into_inner).take();
    // The process ends before its folder is removed.
    running.map(|(process, folder)| (drop(process), drop(folder))).is_some()
}

/// A bake of a page. Dropping it ends the process.
pub(crate) struct BakeJob(Arc<RunningBake>);

impl Drop for BakeJob {
    fn drop(&mut self) {
        end(&self.0);
    }
}

/// Bakes of all pages.
pub(crate) struct Bakes {
    /// `None` once all were ended: no other may start.
    running: Mutex<Option<Vec<Weak<RunningBake>>>>,
}

impl Bakes {
    /// Bakes that may start.
    pub fn open() -> Self {
        Self { running: Mutex::new(Some(Vec::new())) }
    }

    /// Ends all bakes, and lets no other start.
    pub fn end(&self) {
        let running = self.running.lock().unwrap_or_else(PoisonError::into_inner).take();
        for bake in running.into_iter().flatten().filter_map(|bake| bake.upgrade()) {
            end(&bake);
        }
    }

    /// Starts `command`, which reads the mesh in `folder`.
    fn start(&self, command: &mut Command, folder: TempDir) -> Result<(Arc<RunningBake>, BakeOutput), Error> {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        let canceled = || Error::new(ErrorKind::Canceled, "bake", "shatter view is ending");
        let running = running.as_mut().ok_or_else(canceled)?;
        running.retain(|bake| bake.strong_count() > 0);
        let mut process = ChildProcess::start(command).map_err(|error| absent(&error))?;
        let output = BakeOutput { report: process.child().stdout.take(), progress: process.child().stderr.take() };
        let bake = Arc::new(Mutex::new(Some((process, folder))));
        running.push(Arc::downgrade(&bake));
        Ok((bake, output))
    }
}

/// Output of a bake.
struct BakeOutput {
    report: Option<ChildStdout>,
    progress: Option<ChildStderr>,
}

/// Starts the bake of `contents` into the folder of the databases. Progress and the report go to `replies`.
///
/// # Errors
/// `unknown_request` for a name or an option that does not fit, `output` if the file cannot be written, `configuration` if the program
/// cannot be started, `canceled` while the server ends.
pub(crate) fn start(
    id: u64,
    head: &Value,
    contents: &[u8],
    setup: &WorkerSetup,
    replies: Sender<Reply>,
) -> Result<BakeJob, Error> {
    let (temporary, mut command) = command(head, contents, setup.daemon.databases())?;
    let names = FileNames::new(temporary.path(), head["file"].as_str().unwrap_or_default());
    let (bake, output) = setup.bakes.start(&mut command, temporary)?;
    let shared = bake.clone();
    std::thread::spawn(move || {
        let (Some(stdout), Some(stderr)) = (output.report, output.progress) else { return };
        let report = std::thread::spawn(move || {
            let mut text = String::new();
            // A report that cannot be read is empty.
            let _ = stdout.take(REPORT_BYTES_MAX).read_to_string(&mut text);
            text
        });
        for line in BufReader::new(stderr).lines().map_while(Result::ok) {
            let line = names.given(line.strip_prefix("shatterd: ").unwrap_or(&line));
            let message = json!({ "id": id, "reply": "progress", "line": line });
            if replies.blocking_send(Reply::Text(message.to_string())).is_err() {
                // The page went away: the job is dropped with its worker.
                return;
            }
        }
        let report = names.given(&report.join().unwrap_or_default());
        let was_canceled = !end(&shared);
        let _ = replies.blocking_send(Reply::Text(outcome(id, &report, was_canceled).to_string()));
    });
    Ok(BakeJob(bake))
}

/// The path of the mesh in texts of the bake, and the name that the user gave it.
struct FileNames {
    own: String,
    given: String,
}

impl FileNames {
    fn new(folder: &Path, given: &str) -> Self {
        let own = mesh_path(folder, &ending(given)).display().to_string();
        // Quotes and backslashes, which would end a text of the report, are left out.
        Self { own, given: given.replace(|letter: char| letter.is_control() || "\"\\".contains(letter), "") }
    }

    /// The text with the name that the user knows.
    fn given(&self, text: &str) -> String {
        text.replace(&self.own, &self.given)
    }
}

/// Path of the mesh of a bake.
fn mesh_path(folder: &Path, ending: &str) -> PathBuf {
    folder.join(format!("mesh.{ending}"))
}

/// Ending of the name of a file, in small letters.
fn ending(name: &str) -> String {
    name.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase()).unwrap_or_default()
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
    let ending = ending(given);
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
    let file = mesh_path(temporary.path(), &ending);
    std::fs::write(&file, contents).map_err(failed)?;
    let mut command = daemon_program();
    command.arg("bake").arg(&file).args(["--json", "--restart", "--end-with-stdin"]);
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
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    Ok((temporary, command))
}
