//! The daemon whose objects are struck: one that runs, or one of our own.

use crate::child_process::ChildProcess;
use crate::programs::{absent, daemon_program};
use shatter_client::{Client, Deadline};
use shatter_proto::{Error, ErrorKind};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Time for a daemon to start.
const START_TIMEOUT: Duration = Duration::from_secs(60);

/// Longest time after which a daemon that starts notices that it is not wanted any more.
const END_PAUSE: Duration = Duration::from_millis(20);

/// Longest wait for a reply of the service.
const REPLY_TIMEOUT: Duration = Duration::from_secs(5);

/// Configuration of an own daemon: results are kept for as long as someone looks at them.
const CONFIGURATION: &str = "[times]\nkept_s = 3600.0\n\n[results]\nkept_max = 64\n";

/// The daemon of the page.
pub struct ViewDaemon {
    service: String,
    own: Option<OwnDaemon>,
}

/// A daemon that this process started. It ends with this process, however that ends: its standard input is a pipe of this process.
struct OwnDaemon {
    folder: tempfile::TempDir,
    databases: PathBuf,
    /// Whether the folder is removed at the end.
    is_temporary: bool,
    /// Whether it is not to be started again.
    is_ended: AtomicBool,
    process: Mutex<Option<ChildProcess>>,
}

impl ViewDaemon {
    /// The daemon of another process that serves `service`, whether or not it runs yet.
    #[must_use]
    pub fn of_service(service: &str) -> Self {
        Self { service: service.to_owned(), own: None }
    }

    /// The daemon that serves `service` already.
    ///
    /// # Errors
    /// Those of [`Client::connect`]; `no_daemon` if none runs.
    pub fn running(service: &str) -> Result<Self, Error> {
        Client::connect(service, Deadline::after(REPLY_TIMEOUT))?;
        Ok(Self::of_service(service))
    }

    /// Starts a daemon for the databases of a folder, which `is_temporary` if it is removed at the end, and waits until it serves.
    /// [`Self::end`] or dropping the value ends it.
    ///
    /// # Errors
    /// `configuration` if the program cannot be started, `failed` if it ends, or does not serve in time.
    pub fn start(service: &str, databases: &Path, is_temporary: bool) -> Result<Self, Error> {
        let folder = tempfile::Builder::new().prefix("shatter-view-").tempdir();
        let folder = folder.map_err(|error| {
            Error::new(ErrorKind::Output, "daemon", format!("cannot make a temporary folder: {error}; check TMPDIR"))
        })?;
        let own = OwnDaemon {
            folder,
            databases: databases.to_owned(),
            is_temporary,
            is_ended: AtomicBool::new(false),
            process: Mutex::new(None),
        };
        *own.lock() = Some(own.launch(service)?);
        Ok(Self { service: service.to_owned(), own: Some(own) })
    }

    /// Name of the service.
    #[must_use]
    pub fn service(&self) -> &str {
        &self.service
    }

    /// Folder of the databases that an own daemon serves; `None` for another daemon.
    #[must_use]
    pub fn databases(&self) -> Option<&Path> {
        self.own.as_ref().map(|own| own.databases.as_path())
    }

    /// Whether the folder of the databases is removed at the end.
    #[must_use]
    pub fn has_temporary_folder(&self) -> bool {
        self.own.as_ref().is_some_and(|own| own.is_temporary)
    }

    /// Ends an own daemon for good, whether or not workers still use it; another daemon goes on.
    pub fn end(&self) {
        let Some(own) = &self.own else { return };
        // A start under way holds the lock until it reads this.
        own.is_ended.store(true, Ordering::Relaxed);
        drop(own.lock().take());
    }

    /// Starts an own daemon again if it ended by itself. Returns whether it did.
    ///
    /// # Errors
    /// Those of [`Self::start`].
    pub fn revive(&self) -> Result<bool, Error> {
        let Some(own) = &self.own else { return Ok(false) };
        let mut process = own.lock();
        if own.is_ended.load(Ordering::Relaxed) {
            return Ok(false);
        }
        if process.as_mut().is_some_and(|process| process.ended().is_none()) {
            return Ok(false);
        }
        *process = Some(own.launch(&self.service)?);
        Ok(true)
    }
}

impl OwnDaemon {
    fn lock(&self) -> MutexGuard<'_, Option<ChildProcess>> {
        // The process is whole after a panic elsewhere.
        self.process.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts the process and waits until it prints that it serves.
    fn launch(&self, service: &str) -> Result<ChildProcess, Error> {
        let configuration = self.folder.path().join("shatterd.toml");
        std::fs::write(&configuration, CONFIGURATION).map_err(|error| {
            let message = format!("cannot write {}: {error}", configuration.display());
            Error::new(ErrorKind::Output, configuration.display().to_string(), message)
        })?;
        let mut command = daemon_program();
        command
            .args(["serve", "--end-with-stdin", "--log", "warn", "--service", service, "--databases"])
            .arg(&self.databases);
        command.arg("--config").arg(&configuration).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut process = ChildProcess::start(&mut command).map_err(|error| absent(&error))?;
        wait_until_ready(&mut process, &self.is_ended)?;
        Ok(process)
    }
}

fn wait_until_ready(process: &mut ChildProcess, is_ended: &AtomicBool) -> Result<(), Error> {
    let failed = |what: String| Err(Error::new(ErrorKind::Failed, "daemon", what));
    let Some(stdout) = process.child().stdout.take() else { return failed("the daemon has no output".to_owned()) };
    let (sender, lines) = channel();
    // Reads to the end, so that the daemon never blocks on writing.
    std::thread::spawn(move || {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            // Once the daemon is ready there is no receiver.
            let _ = sender.send(line);
        }
    });
    let deadline = Deadline::after(START_TIMEOUT);
    loop {
        match lines.recv_timeout(deadline.left().min(END_PAUSE)) {
            Ok(line) if line.trim() == "ready" => return Ok(()),
            Ok(_) => {}
            Err(RecvTimeoutError::Timeout) if is_ended.load(Ordering::Relaxed) => {
                return failed("the command ended before the daemon served".to_owned());
            }
            Err(RecvTimeoutError::Timeout) if !deadline.passed() => {}
            Err(RecvTimeoutError::Timeout) => {
                return failed(format!("the daemon did not serve within {} s", START_TIMEOUT.as_secs()));
            }
            Err(RecvTimeoutError::Disconnected) => {
                return failed("the daemon ended before it served; its messages are above".to_owned());
            }
        }
    }
}
