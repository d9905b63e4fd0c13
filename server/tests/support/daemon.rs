//! Daemons: in a thread of this process, as a child of the test's own binary with the toy engine, and the real program.

use super::{TestDirectory, loader};
use shatter_client::{Client, Deadline, Error};
use shatter_engine::object::Loader;
use shatter_server::config::Config;
use shatter_server::serve::{ServeOptions, run};
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::{Arc, Once};
use std::thread::JoinHandle;
use tokio::sync::Notify;

/// Environment variable with the role of a child of the test's own binary.
const ROLE: &str = "SHATTER_TEST_ROLE";
const CONFIG: &str = "SHATTER_TEST_CONFIG";
const DATABASES: &str = "SHATTER_TEST_DATABASES";

/// Time that a daemon gives its requests when it ends, s: toys may compute for a minute, which tests do not wait for.
const DRAIN_S: f64 = 0.5;

fn config(text: &str, databases: &Path) -> Config {
    let mut config = Config::parse(text, "test").unwrap();
    config.databases.folder = databases.to_owned();
    config.times.drain_s = config.times.drain_s.min(DRAIN_S);
    config
}

/// A daemon in a thread of this process.
pub struct InProcess {
    pub here: TestDirectory,
    settings: String,
    loader: Loader,
    stop: Arc<Notify>,
    thread: Option<JoinHandle<Result<(), Error>>>,
}

impl InProcess {
    /// Starts a daemon with the toy engine and `settings` over the default configuration; waits until it serves.
    pub fn start(here: TestDirectory, settings: &str) -> Self {
        Self::start_with(here, settings, loader())
    }

    /// Starts a daemon with another engine.
    pub fn start_with(here: TestDirectory, settings: &str, loader: Loader) -> Self {
        let mut daemon = Self { here, settings: settings.to_owned(), loader, stop: Arc::default(), thread: None };
        if !daemon.begin() {
            daemon.end().unwrap();
            panic!("the daemon ended before it was ready");
        }
        daemon
    }

    /// Error of a daemon that cannot be started with these settings.
    pub fn refused(here: TestDirectory, settings: &str) -> Error {
        let settings = settings.to_owned();
        let mut daemon = Self { here, settings, loader: loader(), stop: Arc::default(), thread: None };
        assert!(!daemon.begin(), "it was to be refused");
        daemon.end().unwrap_err()
    }

    /// Starts the daemon again at the same place, once it has ended.
    pub fn again(&mut self) {
        assert!(self.thread.is_none() && self.begin());
    }

    /// Starts the thread; returns whether the daemon came to serve.
    fn begin(&mut self) -> bool {
        let (ready, wait) = std::sync::mpsc::channel();
        let options = ServeOptions {
            paths: self.here.place.clone(),
            config: config(&self.settings, &self.here.databases()),
            loader: self.loader.clone(),
            only: None,
            ready: Box::new(move || {
                ready.send(()).unwrap();
                Ok(())
            }),
            stop: self.stop.clone(),
        };
        self.thread = Some(std::thread::spawn(move || run(options)));
        wait.recv().is_ok()
    }

    /// Opens a new connection.
    pub fn connect(&self) -> Client {
        Client::connect_at(&self.here.place, Deadline::ms(30_000)).unwrap()
    }

    /// Ends the daemon as SIGTERM does.
    pub fn end(&mut self) -> Result<(), Error> {
        self.stop.notify_one();
        self.thread.take().map_or(Ok(()), |thread| thread.join().unwrap())
    }
}

impl Drop for InProcess {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

/// A child process, killed on drop. Its stdout stays open for reading, so that writes to it succeed.
pub struct Child(std::process::Child, Option<BufReader<ChildStdout>>);

impl Child {
    /// Starts `command` and waits until it prints "ready"; shows its stderr if it ends before.
    pub fn start(command: &mut Command) -> Self {
        let mut stderr = tempfile::tempfile().unwrap();
        let child = command.stdout(Stdio::piped()).stderr(stderr.try_clone().unwrap()).spawn().unwrap();
        let mut child = Self(child, None);
        let mut out = BufReader::new(child.0.stdout.take().unwrap());
        if !out.by_ref().lines().map_while(Result::ok).any(|line| line.ends_with("ready")) {
            let (status, mut text) = (child.0.wait(), String::new());
            stderr.rewind().and_then(|()| stderr.read_to_string(&mut text)).unwrap();
            panic!("the child ended before it was ready: {status:?}\n{text}");
        }
        child.1 = Some(out);
        child
    }

    /// Starts `command` without a reader of its stderr.
    pub fn with_closed_output(command: &mut Command) -> Self {
        let mut child = Self(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap(), None);
        drop(child.0.stderr.take());
        let mut out = BufReader::new(child.0.stdout.take().unwrap());
        assert!(out.by_ref().lines().map_while(Result::ok).any(|line| line == "ready"));
        child.1 = Some(out);
        child
    }

    /// Starts `command` without waiting.
    pub fn begin(command: &mut Command) -> Self {
        Self(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap(), None)
    }

    /// Closes this end of a piped standard input.
    pub fn close_stdin(&mut self) {
        drop(self.0.stdin.take());
    }

    /// Sends a signal to the process.
    pub fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.0);
        rustix::process::kill_process(pid, signal).unwrap();
    }

    /// Kills the process at once.
    pub fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// Ends the process as a supervisor does.
    pub fn terminate(mut self) -> ExitStatus {
        self.signal(rustix::process::Signal::TERM);
        self.0.wait().unwrap()
    }

    /// Waits until the process ends by itself, with success.
    pub fn finish(mut self) {
        let status = self.0.wait().unwrap();
        assert!(status.success(), "it ended with {status}");
    }

    pub fn id(&self) -> u32 {
        self.0.id()
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Command of the real daemon.
pub fn shatterd(here: &TestDirectory) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut command);
    command.arg("serve");
    command
}

/// Runs the real command line; returns exit code and stdout.
pub fn shatter(here: &TestDirectory, arguments: &[&str]) -> (i32, String) {
    let mut child = shatter_program(here).args(arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut out = String::new();
    child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    (child.wait().unwrap().code().unwrap(), out)
}

/// Command of the real command line.
pub fn shatter_program(here: &TestDirectory) -> Command {
    let mut command = Command::new(program());
    here.aim(&mut command);
    command
}

/// Path of `shatter` beside `shatterd`. Builds it, once per test binary, if only this package was built, or was built later.
fn program() -> PathBuf {
    static BUILD: Once = Once::new();
    let daemon = Path::new(env!("CARGO_BIN_EXE_shatterd"));
    let beside = daemon.with_file_name("shatter");
    let age = |path: &Path| path.metadata().and_then(|data| data.modified()).ok();
    if age(&beside) < age(daemon) {
        let profile = if beside.parent().unwrap().ends_with("release") { "release" } else { "dev" };
        BUILD.call_once(|| {
            let mut build = Command::new(env!("CARGO"));
            assert!(build.args(["build", "--workspace", "--bins", "--profile", profile]).status().unwrap().success());
        });
    }
    beside
}

/// Command that runs this test binary as another process in `role`.
pub fn role(here: &TestDirectory, role: &str, settings: &str) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    here.aim(&mut command);
    command.args(["play_a_role", "--exact", "--nocapture", "--test-threads=1"]);
    command.env(ROLE, role).env(CONFIG, settings).env(DATABASES, here.databases());
    command
}

/// `command` behind `wrapper` (a program and its arguments) and a line of shell.
pub fn under(wrapper: &[&str], line: &str, command: Command) -> Command {
    let mut words = wrapper.iter().copied().chain(["sh", "-c"]);
    let mut wrapped = Command::new(words.next().unwrap());
    wrapped.args(words).arg(format!("{line} && exec \"$0\" \"$@\"")).arg(command.get_program());
    wrapped.args(command.get_args());
    for (key, value) in command.get_envs() {
        match value {
            Some(value) => wrapped.env(key, value),
            None => wrapped.env_remove(key),
        };
    }
    wrapped
}

/// Runs the role of this process, if [`role`] started it; else does nothing. Called by `play_a_role` of each test binary.
pub fn play(clients: impl FnOnce(&str)) {
    match std::env::var(ROLE).as_deref() {
        Err(_) => {}
        Ok("daemon") => {
            let databases = PathBuf::from(std::env::var_os(DATABASES).unwrap());
            run(ServeOptions {
                paths: shatter_client::service_paths(&std::env::var("SHATTER_SERVICE").unwrap()).unwrap(),
                config: config(&std::env::var(CONFIG).unwrap(), &databases),
                loader: loader(),
                only: None,
                ready: Box::new(|| {
                    println!("ready");
                    Ok(())
                }),
                stop: Arc::new(Notify::new()),
            })
            .unwrap();
        }
        Ok(role) => clients(role),
    }
}
