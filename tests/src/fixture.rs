//! A test folder for both real programs: short runtime directory, own databases, own service name.

use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex, OnceLock};
use tempfile::TempDir;

/// A test folder. On drop it ends its daemon, and leaves nothing in shared memory.
pub struct Fixture {
    root: TempDir,
    programs: Option<PathBuf>,
    daemon: Option<Child>,
}

/// Path of a program of this workspace, or of the C library, which cargo puts beside the test's own binary. `cargo test --test NAME` alone
/// does not build it, so this function builds it once per process; after `cargo test --workspace` that does nothing.
pub fn program(name: &str) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let build = || {
        let own = std::env::current_exe().unwrap();
        let folder = own.parent().and_then(Path::parent).unwrap();
        let profile = if folder.ends_with("release") { "release" } else { "dev" };
        let arguments = ["build", "--quiet", "--workspace", "--bins", "--lib", "--profile", profile];
        assert!(Command::new(env!("CARGO")).args(arguments).status().unwrap().success());
        folder.to_owned()
    };
    FOLDER.get_or_init(build).join(name)
}

impl Fixture {
    /// An empty test folder.
    pub fn new() -> Self {
        // Short, so that sockets fit into their paths.
        Self { root: tempfile::Builder::new().prefix("st").tempdir_in("/tmp").unwrap(), programs: None, daemon: None }
    }

    /// A test folder with the programs of another build, which are in this folder.
    pub fn with_programs(folder: PathBuf) -> Self {
        let mut fixture = Self::new();
        fixture.programs = Some(folder);
        fixture
    }

    /// Path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    /// Folder in which both programs find databases.
    pub fn databases(&self) -> PathBuf {
        self.path("data/shatter")
    }

    /// Command of a program with the environment of this folder, for runs that a test ends early.
    pub fn command(&self, name: &str) -> Command {
        self.foreign(self.programs.as_ref().map_or_else(|| program(name), |folder| folder.join(name)))
    }

    /// Command of a program of the system, with the same environment.
    pub fn foreign(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(program);
        command.env("XDG_RUNTIME_DIR", self.root.path()).env("XDG_DATA_HOME", self.path("data"));
        command.env_remove("SHATTER_SERVICE").env_remove("NOTIFY_SOCKET").env_remove("WATCHDOG_USEC");
        command
    }

    /// Runs a program to its end.
    pub fn run(&self, name: &str, arguments: &[&str]) -> Output {
        self.command(name).args(arguments).output().unwrap()
    }

    /// Runs a program with `--json`; returns exit code and its document.
    #[track_caller]
    pub fn json(&self, name: &str, arguments: &[&str]) -> (i32, Value) {
        let output = self.run(name, &[arguments, &["--json"]].concat());
        let text = String::from_utf8_lossy(&output.stdout);
        let document = serde_json::from_str(&text).unwrap_or_else(|error| {
            let stderr = String::from_utf8_lossy(&output.stderr);
            panic!("{name} {arguments:?}, {}: {error} in {text:?}; {stderr}", output.status)
        });
        (output.status.code().unwrap(), document)
    }

    /// Runs a program with `--json` and expects success.
    #[track_caller]
    pub fn ok(&self, name: &str, arguments: &[&str]) -> Value {
        let (code, document) = self.json(name, arguments);
        assert_eq!(code, 0, "{name} {arguments:?}: {document}");
        document
    }

    /// Puts a database here that `shatterd bake` makes of this mesh file with these further arguments. The same once more, in this
    /// process, takes no second bake.
    #[track_caller]
    pub fn bake_once(&self, mesh: &Path, name: &str, more: &[&str]) {
        static BAKED: Mutex<BTreeMap<String, Arc<OnceLock<Vec<u8>>>>> = Mutex::new(BTreeMap::new());
        let key = format!("{} {name} {more:?}", blake3::hash(&std::fs::read(mesh).unwrap()));
        let own = BAKED.lock().unwrap().entry(key).or_default().clone();
        let file = self.databases().join(format!("{name}.shatter"));
        let bytes = own.get_or_init(|| {
            self.ok("shatterd", &[&["bake", mesh.to_str().unwrap(), "--name", name], more].concat());
            std::fs::read(&file).unwrap()
        });
        std::fs::create_dir_all(self.databases()).unwrap();
        std::fs::write(file, bytes).unwrap();
    }

    /// Starts the daemon with these further arguments and waits until it serves.
    pub fn serve(&mut self, arguments: &[&str]) {
        let mut command = self.command("shatterd");
        command.arg("serve").args(arguments).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.is_ok_and(|line| line == "ready")), "the daemon ended before it was ready");
        self.daemon = Some(child);
    }

    /// Ends the daemon as a supervisor does; returns its exit code.
    pub fn end(&mut self) -> Option<i32> {
        let mut child = self.daemon.take()?;
        rustix::process::kill_process(rustix::process::Pid::from_child(&child), rustix::process::Signal::TERM).unwrap();
        child.wait().unwrap().code()
    }

    /// Resident memory of the daemon, bytes.
    pub fn daemon_memory_bytes(&self) -> Option<u64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.daemon.as_ref()?.id())).ok()?;
        let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
        Some(1024 * line.split_whitespace().nth(1)?.parse::<u64>().ok()?)
    }
}

impl Default for Fixture {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Fixture {
    fn drop(&mut self) {
        self.end();
    }
}
